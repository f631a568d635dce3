"""The motion of a chain, and methods that evaluate it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from ..chain.bead_names import Side
from ..errors import IncompleteWarning, InputError, SimulationError, warn_user
from ..pulse.pulse import Pulse
from ..representation import short
from ..validation.keywords import checked_methods
from ..validation.objects import Progress, check_choice
from .budget import Budget, budget_of
from .contact_history import ContactHistory
from .energy_flux import energy_flux_of
from .find_reflection import reflection_of
from .find_waves import find_waves
from .force_table import save_forces_of
from .fronts import fronts_of
from .leading_pulse import LeadingPulse, leading_pulse_of
from .not_yielded import elastic_in_words
from .pulse_width import pulse_width_of
from .run_message import recommended_horizon
from .run_pulse import pulse_of
from .sensor_force import sensor_force_of
from .velocity_peaks import velocity_peaks_of
from .wall_force import SIDES, WallForce, incomplete_peak, later_ends, wall_force_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..fitting.trace_comparison import TraceComparison
    from ..traces.traces import Traces
    from .horizon import Horizon

# Number of beads up to which a run is regarded as a collision.
FEW: Final = 3


@checked_methods
@dataclass(frozen=True, eq=False)
class Run(ContactHistory):
    r"""The motion of a chain; the result of `hertzchain.simulate`.

    Beads have numbers from 1, arrays start at 0: :doc:`/reference/numbering`.

    Attributes
    ----------
    chain : Chain
        The chain.
    times : ndarray, shape (T,)
        Saved times [scaled, or s].
    positions : ndarray, shape (T, N)
        Displacements :math:`x_k` from where neighbours touch, or are a gap apart [scaled, or m].
    velocities : ndarray, shape (T, N)
        Velocities [scaled, or m/s].
    status : str
        Reason for the end of the run.  With ``until`` it is ``"time reached"``.  Without, it is
        ``"pulse left"`` (see `closed_contacts`); for a chain with a right wall, ``"wall force
        complete"`` or, after the longest such run, ``"transit limit"``; and ``"nothing more
        happens"`` if all beads are in free flight earlier.  ``"step limit"``, ``"step too small"``,
        ``"unstable steps"`` and ``"underflow"`` are failures, which `simulate` raises by default.
    end_time : float
        Time at which the simulation stopped [scaled, or s].
    energy_drift : float
        Largest error of the energy balance over all steps, relative to the largest kinetic
        energy or to the energy at the start (including that of compressed contacts), whichever is
        larger.
    momentum_drift : float
        Largest error of the momentum balance over all steps, relative to the largest sum of the
        absolute momenta of the beads.
    steps, evaluations : int
        Accepted steps, and evaluations of the force on the whole chain.
    rtol : float
        Relative tolerance per step; NaN if the steps were fixed.
    method : str
        ``"RKN8(6)"``, with losses ``"DOP853"`` or, if damping is very strong, ``"Radau IIA"``; or
        the splitting method of a symplectic run, ``"verlet"`` or ``"forward-4"``.
    state : State
        State from which a longer run resumes.

    Examples
    --------
    >>> import hertzchain as hc
    >>> run = hc.simulate(hc.Chain.uniform(20), until=10.0, times=101)
    >>> run.velocities.shape, run.status
    ((101, 20), 'time reached')
    """

    sensor_force = sensor_force_of
    fronts = fronts_of
    waves = find_waves
    reflection = reflection_of
    energy_flux = energy_flux_of
    velocity_peaks = velocity_peaks_of
    pulse_width = pulse_width_of
    save_forces = save_forces_of

    def pulse(self) -> Pulse:
        """The leading pulse: first velocity maxima, arrivals and largest overlaps.

        In a driven chain, the first maximum of bead 1 is found like that of any other bead, its
        arrival is 0, the start of the drive, and it has no residence time.

        Returns
        -------
        Pulse
            Located within the steps of the simulation, not among the saved times.  A value that
            the run did not reach, or that is not defined, is NaN; ``pulse.notes`` has the reason.

        Raises
        ------
        SimulationError
            If the run stopped before any contact was reached.

        Examples
        --------
        >>> import hertzchain as hc
        >>> float(hc.simulate(hc.Chain.uniform(30)).pulse().velocity[1].round(9))
        0.751471736

        A chain that is driven by a piezoelectric actuator:

        >>> burst = hc.SineBurst(0.3, 0.1, cycles=2.0)
        >>> pulse = hc.simulate(hc.Chain.uniform(30).replace(drive=burst), until=60.0).pulse()
        >>> pulse.arrival[[0, 10, 20]].round(3)
        array([ 0.   , 21.03 , 38.853])
        >>> pulse.notes["residence"].partition(";")[0]
        'bead 1: not struck, and no pulse arrives there'
        """
        if not self._reached:
            raise SimulationError(
                f"no pulse: {self.message}, and no contact was reached; simulate for longer"
            )
        return pulse_of(self.chain, self._peaks, self._crossings)

    def leading_pulse(self) -> LeadingPulse:
        """The leading pulse as a whole: its length, momentum and kinetic energy.

        A `Pulse` has the momentum of single beads, a `LeadingPulse` that of all beads in the pulse.

        Returns
        -------
        LeadingPulse
            Located within the steps of the simulation, not among the saved times.

        Examples
        --------
        The momentum of the solitary wave of equal beads, struck with momentum 1:

        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(60), times=0)
        >>> round(float(run.leading_pulse().momentum[40]), 5)
        1.13831
        """
        from ..kernels import state_layout

        turned_back = float(self._walls[state_layout.TURNED_BACK, 1])
        return leading_pulse_of(self.chain, self._crossings, turned_back)

    def wall_force(self, side: Side = "right") -> WallForce:
        """The force on a wall over time, its peak and its impulse.

        Use ``wall_force().peak`` for the largest force; ``wall_force().force.max()`` is that of the
        saved times only.

        Parameters
        ----------
        side : str
            ``"left"`` or ``"right"``.

        Raises
        ------
        InputError
            If the chain has no such wall.

        Warns
        -----
        IncompleteWarning
            If the run ended before the peak was complete; ``peak`` is then NaN.  Each run warns
            once for each wall.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
        >>> wall = hc.simulate(chain).wall_force()
        >>> wall.complete, round(wall.peak, 4), round(wall.impulse_of_impact, 4)
        (True, 1.2432, 2.3454)
        """
        wall = self._wall_force(side)
        if not wall.complete and side not in self._reported:
            self._reported.add(side)
            ends = later_ends(side, self._completion, self._approaches, self.chain)
            warn_user(incomplete_peak(wall, self.end_time, ends, self.chain), IncompleteWarning)
        return wall

    def _wall_force(self, side: Side) -> WallForce:
        check_choice("side of a wall", side, SIDES)
        if f"{side} wall" not in self.chain.features:
            raise InputError(f"the {side} end of this chain is free; add a {side}_wall")
        trace = self.times, self.forces[:, 0 if side == "left" else -1]
        return wall_force_of(
            side, trace, self._walls, self._completion, self._approaches, self._complete,
            self._impulses, self.chain,
        )  # fmt: skip

    def budget(self) -> Budget:
        """Energy and momentum at every saved time, by location and by origin.

        Raises
        ------
        InputError
            If no times were saved.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(20).replace(loss=hc.Restitution(0.9))
        >>> budget = hc.simulate(chain).budget()
        >>> bool(abs(budget.residual("energy")).max() < 1e-9)
        True
        """
        self._require_times()
        return budget_of(
            self.chain, self.times, self.positions, self.velocities, self.forces,
            self._accumulators, self.leading_pulse().weights(self.times, self.velocities),
            self.state.start,
        )  # fmt: skip

    def horizon(self, *, within: float = 0.01, progress: Progress | None = None) -> Horizon:
        """Time up to which the velocities are predictable, from a second integration.

        The chain is integrated again with ten times the tolerance (with a tenth of it if
        rtol > 1e-7), which takes about as long as the run itself, or with half the step if steps
        are fixed, which takes twice as long.  The result is stored: the repr of the run shows it,
        and further calls take no time.

        Parameters
        ----------
        within : float
            Error up to which velocities are taken as predictable, relative to the largest velocity.
        progress : callable, optional
            Called as ``progress(beads_passed, beads)`` a few times per second.

        Raises
        ------
        InputError
            If no times were saved, or the run started from a reversed state.
        SimulationError
            If the second integration fails.

        Examples
        --------
        A pulse that bounces between two walls becomes unpredictable:

        >>> import hertzchain as hc
        >>> wall = hc.Wall()
        >>> chain = hc.Chain.uniform(20).replace(left_wall=wall, right_wall=wall)
        >>> horizon = hc.simulate(chain, until=400.0).horizon()
        >>> 60.0 < horizon.time < 400.0
        True
        """
        from .find_horizon import horizon_of

        found = horizon_of(self, within, progress)
        self.__dict__["_horizon"] = found
        return found

    @property
    def known_horizon(self) -> Horizon | None:
        """The result of `horizon`; `None` if it has not been called."""
        return self.__dict__.get("_horizon")

    @property
    def prediction(self) -> str:
        """Short description of how long the run is predictable; empty for short runs.

        It recommends `horizon` for a chain without losses if the largest force on a wall does not
        occur in the first contact with it, or if the run is longer than three transits of a pulse
        and the chain traps waves: between two walls or, with precompression or gravity or if
        unequal beads have returned to the wall, at one.
        """
        if self.known_horizon is not None:
            return self.known_horizon.message
        return recommended_horizon(self.chain, self._walls, self.end_time)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Save the trajectories: ``.nc`` (netCDF) or ``.csv``, by the file's extension.

        `hertzchain.load_run` reads a netCDF file as the same run again.  `save_forces` saves forces
        on walls and in sensors, one row per time.  `hertzchain.save_state` saves
        ``run.state``, from which a longer run resumes.

        Parameters
        ----------
        path : path-like
            File to write; an existing file is replaced when the new one is complete.

        Raises
        ------
        InputError
            For another extension, or if no times were saved or the file cannot be written.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> from pathlib import Path
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     hc.simulate(hc.Chain.uniform(3), times=10).save(Path(folder) / "run.csv")
        """
        from ..store.results import save_run

        save_run(self, path)

    def plot(
        self, quantity: Literal["velocity", "force"] = "velocity", *, relative: bool = False,
        ax: Axes | None = None) -> Axes:  # fmt: skip
        """Plot the velocity of every bead, or the force in every contact, as a map.

        Parameters
        ----------
        quantity : str
            ``"velocity"`` or ``"force"``.
        relative : bool
            Whether to divide the values of each bead or contact by the largest one there.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; by default those of a new figure.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.simulate(hc.Chain.uniform(9)).plot().get_ylabel()
        'bead $k$'
        """
        from ..plotting.runs import plot_run

        return plot_run(self, quantity, relative=relative, ax=ax)

    def plot_forces(
        self, beads: Sequence[int | str], *, label: str = "", legend: bool = True,
        ax: Axes | None = None,
    ) -> Axes:  # fmt: skip
        """Plot the force in sensors in beads, and on walls, over time.

        Parameters
        ----------
        beads : sequence of int or str
            Beads with a sensor, such as 6 or ``"ball 5"``; N + 1 is the right wall, 0 the left one.
        label : str
            Name of the run in the legend.
        legend : bool
            Whether the axes have a legend.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; by default those of a new figure.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(9))
        >>> run.plot_forces([3, 6]).get_ylabel()
        'force $F$'
        """
        from ..plotting.runs import plot_forces

        return plot_forces(self, beads, label=label, legend=legend, ax=ax)

    def animate(self, path: str | os.PathLike[str], **options: Any) -> Path:
        """Write an animation of the beads as GIF or MP4, and show it in a notebook.

        Parameters
        ----------
        path : path-like
            File to write, ``.gif``, or ``.mp4``, which requires the program ffmpeg.
        **options
            ``frames``, ``seconds``, ``magnify``, ``sensors``, ``progress``: `hertzchain.animate`.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> from pathlib import Path
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     run = hc.simulate(hc.Chain.uniform(9), until=12.0, times=20)
        ...     run.animate(Path(folder) / "beads.gif", frames=5).name
        'beads.gif'
        """
        from ..plotting.animation import animate

        return animate(self, path, **options)

    def compare(
        self, traces: Traces | str | os.PathLike[str], *, time_offset: float | None = None
    ) -> TraceComparison:
        """Compare the run with measured traces, without any fit.

        The static force is subtracted for sensors with AC coupling, which are 0 before the pulse.
        Peaks of both signals are those at the times of the samples.

        Parameters
        ----------
        traces : Traces or path
            Data of one shot; a path is read by `load_traces`, and `Traces.between` selects a part.
        time_offset : float, optional
            Time of the data at which the run begins [s]; by default, that of the least squares
            of the differences, with a free amplitude of each signal, unless the traces have one.

        Returns
        -------
        TraceComparison

        Raises
        ------
        InputError
            If the run is in scaled variables, saved few times or ends before the pulse, for several
            shots or unknown sensors, and if the times of the data are in another unit.

        Examples
        --------
        >>> import hertzchain as hc
        >>> traces, chain = hc.example_experiment()
        >>> compared = hc.simulate(hc.load_chain(chain), until=6e-4, times=1201).compare(traces)
        >>> f"{compared.differences['ball 6']:.1%}"
        '4.0%'
        """
        from ..fitting.compare_traces import compare_traces
        from ..traces.files import load_traces

        if isinstance(traces, Run):
            raise InputError(
                "compare takes measured traces; to compare two runs, use "
                "run.pulse().compare(other.pulse()), or plot_forces with label and ax"
            )
        if isinstance(traces, str | os.PathLike):
            traces = load_traces(traces)
        return compare_traces(self, traces, time_offset=time_offset)

    def __repr__(self) -> str:
        saved = f"{len(self.times)} saved times, energy drift {self.energy_drift:.1e}"
        unfinished = self._unfinished if self.chain.beads <= FEW else ""
        notes = unfinished, elastic_in_words(self.chain, self._furthest_overlaps), self.prediction
        return short("Run", self.chain.description, self.message, *notes, saved)

    def _repr_html_(self) -> str:
        from ..notebook.runs import run_html

        return run_html(self)
