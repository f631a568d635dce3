"""A whole trajectory, and what it tells: the pulse, forces as sensors see them, the budget."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from hertzchain import __version__
from hertzchain.arguments import one_of
from hertzchain.chain.chain import Chain
from hertzchain.chain.equilibrium import equilibrium
from hertzchain.checks import whole_number
from hertzchain.contacts import Array
from hertzchain.errors import IncompleteWarning, InputError, SimulationError
from hertzchain.pulse.pulse import Pulse
from hertzchain.simulation._run_end import Status
from hertzchain.simulation._wall_watch import MAX_TRANSITS
from hertzchain.simulation.budget import Budget, budget_of, overlaps_of
from hertzchain.simulation.sensor_force import SensorForce, sensor_force_of
from hertzchain.simulation.state import State, ledger_units, records_units
from hertzchain.simulation.wall_force import (
    SIDES,
    Side,
    WallForce,
    incomplete_peak,
    wall_force_of,
)
from hertzchain.simulation.waves import Waves, waves_at

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

    from hertzchain.chain.scales import Scales

# Units by the chain's: time, length, velocity, force, mass.
UNITS: Final = {"scaled": ("1",) * 5, "SI": ("s", "m", "m/s", "N", "kg")}

# What may make the motion of a chain stiff, by its features, and what to try.
MILDER: Final = {
    "loss": "a weaker loss",
    "precompression": "less precompression",
    "gravity": "less gravity",
    "left wall": "a softer left wall",
    "right wall": "a softer right wall",
    "drive": "a slower drive",
    "masses": "less unequal masses",
    "stiffness": "less unequal stiffness",
}


@dataclass(frozen=True, eq=False)
class Run:
    r"""A whole trajectory of a chain.

    Attributes
    ----------
    chain : Chain
        The chain that was struck.
    times : ndarray, shape (T,)
        Saved times [scaled, or s].
    positions : ndarray, shape (T, N)
        Displacements :math:`x_k` of the beads from where they touched [scaled, or m].
    velocities : ndarray, shape (T, N)
        Velocities [scaled, or m/s].
    status : str
        Why the run ended.  Without ``until``: ``"wall force complete"`` or, after ten transits,
        ``"transit limit"`` (with a right wall), ``"pulse left"`` (without), ``"nothing more
        happens"`` if all beads are in free flight before.  With it: ``"time reached"``.
        ``"step limit"``, ``"step too small"`` and ``"underflow"`` are failures that `simulate`
        raises unless told not to.
    end_time : float
        Time at which the integration stopped [scaled, or s].
    energy_drift : float
        Largest departure from the balance of energy over all steps, relative to the
        largest kinetic energy.
    momentum_drift : float
        Largest departure from the balance of momentum over all steps, relative to the
        largest sum of the beads' absolute momenta.
    steps, evaluations : int
        Accepted steps, and evaluations of the force on the whole chain.
    rtol : float
        Tolerance of a step.
    state : State
        Where a longer run would go on.

    Examples
    --------
    >>> import hertzchain as hc
    >>> run = hc.simulate(hc.Chain.uniform(20), until=10.0, times=101)
    >>> run.velocities.shape, run.status
    ((101, 20), 'time reached')
    """

    chain: Chain
    times: Array
    positions: Array
    velocities: Array
    status: Status
    end_time: float
    energy_drift: float
    momentum_drift: float
    steps: int
    evaluations: int
    rtol: float
    state: State
    _forces: Array | None
    _ledger: Array
    _peaks: Array
    _crossings: Array
    _walls: Array
    _impulses: Array
    _completion: Array
    _approaches: Array
    _complete: Array

    def factors(self, scales: Scales) -> Mapping[str, float | Array]:
        """Units of everything saved, for `hertzchain.Scales`.

        Parameters
        ----------
        scales : Scales
            The units.

        Returns
        -------
        dict

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20, velocity=0.3)
        >>> scales = hc.Scales.of(chain)
        >>> run = scales.to_si(hc.simulate(scales.to_scaled(chain)))
        >>> f"{run.force(10).max():.0f} N after {1e6 * run.pulse().arrival[10]:.0f} us"
        '49 N after 191 us'
        """
        records = {f"_{name}": unit for name, unit in records_units(scales).items()}
        return records | {
            "times": scales.time,
            "positions": scales.length,
            "velocities": scales.velocity,
            "end_time": scales.time,
            "_forces": scales.force,
            "_ledger": ledger_units(scales),
            "_impulses": scales.momentum,
            "_approaches": np.array([[scales.momentum], [scales.energy], [scales.force]]),
        }

    @cached_property
    def forces(self) -> Array:
        """Forces in the contacts at the saved times, shape (T, N + 1) [scaled, or N].

        Counted with the walls: 0 is the left wall's, 1..N-1 those of bead k with bead k + 1,
        N the right wall's.
        """
        if self._forces is not None:
            return self._forces
        overlap = np.maximum(self.positions[:, :-1] - self.positions[:, 1:], 0.0)
        return np.pad(self.chain.stiffness * overlap**self.chain.exponent, ((0, 0), (1, 1)))

    @cached_property
    def largest_overlaps(self) -> Array:
        """Largest overlap of each contact, shape (N + 1,) [scaled, or m].

        Counted with the walls, as `forces`.  Of the leading pulse and of walls it is found
        between the steps, of what comes later among the saved times.  A wall's is the overlap
        that bears its largest force :math:`F` without losses, :math:`(F/k)^{1/p}`.

        Examples
        --------
        How far a run has gone beyond the range of Hertz' law:

        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials(5e-3, "steel-52100", beads=20, velocity=0.3)
        >>> print(hc.hertz_range(chain, hc.simulate(chain).largest_overlaps))
        overlap / radius  0.0016 at contact 1 (limit 0.01)
        pressure / yield  0.868 at contact 1 (limit 1)
        speed / sound  5.9e-05 (limit 0.01)
        """
        from hertzchain.kernels import records

        stiffness = np.array(self.chain.wall_stiffness)
        peak = self._walls[records.WALL_PEAK]
        bearing = np.divide(peak, stiffness, out=np.zeros(2), where=stiffness > 0.0)
        walls = bearing ** (1.0 / self.chain.exponent)
        passed = np.concatenate((walls[:1], self._crossings[records.OVERLAP], walls[1:]))
        saved = overlaps_of(self.chain, self.times, self.positions)
        saved[:, [0, -1]] = np.where(stiffness > 0.0, saved[:, [0, -1]], 0.0)
        return np.asarray(np.maximum(passed, np.max(saved, axis=0, initial=0.0)))

    @property
    def success(self) -> bool:
        """Whether the run reached what it was asked to reach."""
        return self.status not in ("step limit", "step too small", "underflow")

    @property
    def message(self) -> str:
        """The status in a sentence."""
        passed = f"the pulse had passed {self.beads_passed} of {self.chain.beads} beads"
        unit = " s" if self.chain.units == "SI" else ""
        at = f"at t = {self.end_time:g}{unit}, after {self.steps} steps"
        return {
            "pulse left": f"the pulse left the chain {at}",
            "wall force complete": f"the force on the right wall is complete {at}",
            "transit limit": (
                f"stopped after {MAX_TRANSITS} transits of the pulse {at}; the force on the right "
                "wall is not complete"
            ),
            "nothing more happens": f"all beads fly freely and apart {at}; {passed}",
            "time reached": f"stopped as requested {at}; {passed}",
            "step limit": (
                f"stopped by the step limit {at}; {passed}; raise max_steps, or use "
                f"{self._milder} if the time hardly moves"
            ),
            "underflow": (
                f"the motion became too small to represent {at}; {passed}; use {self._milder}"
            ),
            "step too small": (
                f"the steps became too short for the clock {at}; {passed}; use {self._milder}"
            ),
        }[self.status]

    @property
    def _milder(self) -> str:
        """What of this chain may make its motion stiff, made less so."""
        found = [advice for name, advice in MILDER.items() if name in self.chain.features]
        even = np.ptp(self.chain.radii) == 0.0
        return " or ".join(found or ["fewer beads" if even else "fewer beads or a weaker taper"])

    @property
    def beads_passed(self) -> int:
        """Number of beads that the pulse has passed, the striker among them."""
        # Those of which peak and both contacts are recorded.
        return 1 + int(np.count_nonzero((self._peaks[0, 1:] != 0) & (self._crossings[0] > 0)))

    @property
    def _residence(self) -> Array:
        """Times between successive crossings; by difference where they came out of order."""
        times, _, since_last = self._crossings
        between = np.diff(times, prepend=0.0)
        return np.where(since_last > 0.0, since_last, between)

    def pulse(self) -> Pulse:
        """The leading pulse: first velocity maxima, arrivals and largest overlaps.

        Returns
        -------
        Pulse
            Found between the steps while integrating, not among the saved times.

        Raises
        ------
        SimulationError
            If the run stopped before the pulse had passed every bead.

        Examples
        --------
        >>> import hertzchain as hc
        >>> float(hc.simulate(hc.Chain.uniform(30)).pulse().velocity[1].round(9))
        0.751471736
        """
        if self.beads_passed < self.chain.beads:
            raise SimulationError(f"no pulse of all beads: {self.message}; simulate for longer")
        return Pulse(
            chain=self.chain,
            method="simulation",
            velocity=self._peaks[1],
            peak_time=np.maximum(self._peaks[0], 0.0),
            arrival=np.concatenate(([0.0], self._crossings[0])),
            peak_overlap=self._crossings[1],
            residence=self._residence,
        )

    def force(self, contact: int) -> Array:
        """Force in one contact at the saved times.

        Parameters
        ----------
        contact : int
            Number of the contact: k joins beads k and k + 1; 0 is the left wall's and N the
            right one's.

        Returns
        -------
        ndarray, shape (T,)

        Raises
        ------
        InputError
            If there is no such contact.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(30), until=20.0)
        >>> bool(0.63 < run.force(10).max() < 0.65)
        True
        """
        return self.forces[:, whole_number("contact", contact, least=0, most=self.chain.beads)]

    def sensor(self, bead: int) -> Array:
        r"""What a force sensor embedded in a bead shows: :math:`(F_{k-1} + F_k)/2`.

        The usual sensor is a thin piezoelectric disc between the two halves of a bead; the
        mean of the forces on both halves is what it bears if its own mass is small.

        Parameters
        ----------
        bead : int
            Number k of the bead.

        Returns
        -------
        ndarray, shape (T,)

        Raises
        ------
        InputError
            If there is no such bead.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(30), until=20.0)
        >>> bool(run.sensor(10).max() < run.force(10).max())
        True
        """
        k = whole_number("bead", bead, least=1, most=self.chain.beads)
        return 0.5 * (self.forces[:, k - 1] + self.forces[:, k])

    def sensor_force(self, bead: int) -> SensorForce:
        """The force in a sensor with its first maximum and its largest value so far.

        Parameters
        ----------
        bead : int
            Number k of the bead.

        Returns
        -------
        SensorForce

        Raises
        ------
        InputError
            If there is no such bead, or no times were saved.

        Warns
        -----
        IncompleteWarning
            If the force has had no maximum yet; ``first_maximum`` is then NaN.

        Examples
        --------
        The pulse passes bead 10 and returns from the wall:

        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
        >>> sensor = hc.simulate(chain, until=60.0, times=2000).sensor_force(10)
        >>> sensor.first_maximum_time < 15.0 and sensor.largest_so_far >= sensor.first_maximum
        True
        """
        force = self.sensor(bead)
        if not len(self.times):
            raise InputError("the run has saved no times: give simulate times of at least 2")
        at_rest = 0.5 * float(equilibrium(self.chain).forces[bead - 1 : bead + 1].sum())
        sensor = sensor_force_of(bead, self.times, force, at_rest)
        if math.isnan(sensor.first_maximum):
            warnings.warn(
                f"the force in bead {bead} had no maximum before t = {self.times[-1]:g}: simulate "
                "for longer, or save more times",
                IncompleteWarning, stacklevel=2,
            )  # fmt: skip
        return sensor

    def velocity(self, bead: int) -> Array:
        """Velocity of one bead at the saved times.

        Parameters
        ----------
        bead : int
            Number k of the bead.

        Returns
        -------
        ndarray, shape (T,)

        Raises
        ------
        InputError
            If there is no such bead.

        Examples
        --------
        >>> import hertzchain as hc
        >>> float(hc.simulate(hc.Chain.uniform(5), until=1.0).velocity(1)[0])
        1.0
        """
        return self.velocities[:, whole_number("bead", bead, least=1, most=self.chain.beads) - 1]

    def wall_force(self, side: Side = "right") -> WallForce:
        """The force on a wall: its course, its peak, and impulses.

        Parameters
        ----------
        side : str
            ``"left"`` or ``"right"``.

        Returns
        -------
        WallForce

        Raises
        ------
        InputError
            If the chain has no such wall.

        Warns
        -----
        IncompleteWarning
            If the run ended before the peak was complete; ``peak`` is then NaN.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
        >>> wall = hc.simulate(chain).wall_force()
        >>> wall.complete, round(wall.peak, 4), round(wall.impulse_of_impact, 4)
        (True, 1.2432, 2.3454)
        """
        one_of("side of a wall", side, SIDES)
        if f"{side} wall" not in self.chain.features:
            raise InputError(f"the {side} end of this chain is free: give it a {side}_wall")
        trace = self.times, self.forces[:, 0 if side == "left" else -1]
        wall = wall_force_of(
            side, trace, self._walls, self._completion, self._approaches, self._complete,
            self._impulses,
        )  # fmt: skip
        if not wall.complete:
            units = (" s", " N") if self.chain.units == "SI" else ("", "")
            told = incomplete_peak(wall, self.end_time, units)
            warnings.warn(told, IncompleteWarning, stacklevel=2)
        return wall

    def open_contacts(self) -> Array:
        """Which contacts do not touch, at the saved times.

        Returns
        -------
        ndarray of bool, shape (T, N - 1)
            Runs of closed contacts between open ones are the fragments of the chain.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.tapered("backward-exponential", 0.1, beads=20))
        >>> bool(run.open_contacts()[-1, :10].all())
        True
        """
        gaps = equilibrium(self.chain).gaps[1:-1]
        apart: Array = self.positions[:, :-1] - self.positions[:, 1:] - gaps < 0.0
        return apart

    def waves(self, bead: int) -> Waves:
        """The waves that pass one bead, such as the train that a heavy striker sends.

        Parameters
        ----------
        bead : int
            Number k of the bead, 2 or more.

        Returns
        -------
        Waves
            Their number, times, amplitudes and widths, from the saved times.

        Raises
        ------
        InputError
            If there is no such bead, or fewer than two times were saved.

        Examples
        --------
        A striker of four times the mass; the fourth wave is a tenth of the first:

        >>> import hertzchain as hc
        >>> import numpy as np
        >>> chain = hc.Chain.uniform(80).replace(masses=np.append(4.0, np.ones(79)))
        >>> hc.simulate(chain, until=110.0, times=2200).waves(60).amplitudes[:4].round(4)
        array([1.2131, 0.5505, 0.2658, 0.1324])
        """
        k = whole_number("bead", bead, least=2, most=self.chain.beads)
        net = self.forces[:, k - 1] - self.forces[:, k] + equilibrium(self.chain).body_forces[k - 1]
        return waves_at(k, self.times, self.velocity(k), net / self.chain.masses[k - 1])

    def pulse_width(self, bead: int) -> float:
        r"""Width of the leading pulse where it passes a bead, in beads.

        .. math:: w_k = \frac{\Delta t_k}{T_k}

        with the full width at half maximum :math:`\Delta t_k` of the bead's velocity in
        time, and the residence time :math:`T_k`, in which the pulse moves on by one bead.
        The solitary wave of equal beads has 1.57914 (p = 3/2).  The time itself is
        ``run.waves(bead).widths[0]``.

        Parameters
        ----------
        bead : int
            Number k of the bead, 2 to N - 1.

        Returns
        -------
        float
            From the saved times [beads].

        Raises
        ------
        InputError
            If there is no such bead, or fewer than two times were saved.
        SimulationError
            If the pulse had not passed the bead when the run stopped, or the velocity is not
            seen to fall to half of its maximum on both sides.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(60), times=2000)
        >>> round(run.pulse_width(40), 3)
        1.579
        """
        k = whole_number("bead", bead, least=2, most=self.chain.beads - 1)
        if self._peaks[0, k - 1] == 0.0 or np.any(self._crossings[0, k - 2 : k] == 0.0):
            raise SimulationError(
                f"no width of the pulse at bead {k}: {self.message}; simulate for longer"
            )
        waves = self.waves(k)
        width = np.nan
        if len(waves):
            leading = int(np.argmin(np.abs(waves.times - self._peaks[0, k - 1])))
            width = waves.widths[leading] / self._residence[k - 1]
        if not np.isfinite(width):
            raise SimulationError(
                f"no width of the pulse at bead {k}: among the {len(self.times)} saved times its "
                "velocity is not seen to fall to half of its maximum on both sides; save more "
                "times, or let the run go on for longer (until)"
            )
        return float(width)

    def budget(self) -> Budget:
        """Energy and momentum at every saved time, by where they are and whence they came.

        Returns
        -------
        Budget

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
        if not len(self.times):
            raise InputError("the run has saved no times: give simulate times of at least 2")
        return budget_of(
            self.chain, self.times, self.positions, self.velocities, self.forces,
            self._ledger, self._peaks[0], self.state.start,
        )  # fmt: skip

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset with coordinates ``time``, ``bead`` = 1..N and ``contact`` = 0..N.

        Returns
        -------
        xarray.Dataset
            ``position`` and ``velocity``, both (time, bead), ``force`` (time, contact),
            ``radius`` and ``mass``, with their units ("1": scaled).

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(9), until=2.0, times=5)
        >>> dict(run.to_xarray().sizes)
        {'time': 5, 'bead': 9, 'contact': 10}
        """
        import xarray as xr

        time, length, speed, newton, kilogram = UNITS[self.chain.units]

        def labelled(values: Array, name: str, unit: str, *dims: str) -> tuple[object, ...]:
            return dims, values, {"units": unit, "long_name": name}

        moving, pushing = ("time", "bead"), ("time", "contact")
        return xr.Dataset(
            {
                "position": labelled(self.positions, "displacement of the bead", length, *moving),
                "velocity": labelled(self.velocities, "velocity of the bead", speed, *moving),
                "force": labelled(self.forces, "force in the contact", newton, *pushing),
                "radius": labelled(self.chain.radii, "radius", length, "bead"),
                "mass": labelled(self.chain.masses, "mass", kilogram, "bead"),
            },
            coords={
                "time": ("time", self.times, {"units": time, "long_name": "time"}),
                "bead": np.arange(1, self.chain.beads + 1),
                "contact": np.arange(self.chain.beads + 1),
            },
            attrs={
                "hertzchain_version": __version__,
                "chain": self.chain.description,
                "taper": self.chain.taper or "",
                "rate": self.chain.rate or 0.0,
                "exponent": self.chain.exponent,
                "status": self.status,
                "energy_drift": self.energy_drift,
                "momentum_drift": self.momentum_drift,
                "rtol": self.rtol,
            },
        )

    def plot(
        self, quantity: Literal["velocity", "force"] = "velocity", *, ax: Axes | None = None
    ) -> Axes:
        """Draw the velocity of every bead, or the force in every contact, as a map.

        Parameters
        ----------
        quantity : str
            ``"velocity"`` or ``"force"``.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; a new figure's if not given.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.simulate(hc.Chain.uniform(9)).plot().get_ylabel()
        'bead $k$'
        """
        from hertzchain.plotting.runs import plot_run

        return plot_run(self, quantity, ax=ax)

    def plot_forces(self, beads: Sequence[int], *, ax: Axes | None = None) -> Axes:
        """Draw what sensors in some beads, and on the walls, show in time.

        Parameters
        ----------
        beads : sequence of int
            Numbers of the beads with a sensor; N + 1 is the right wall, 0 the left one.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; a new figure's if not given.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(9))
        >>> run.plot_forces([3, 6]).get_ylabel()
        'force $F$'
        """
        from hertzchain.plotting.runs import plot_forces

        return plot_forces(self, beads, ax=ax)

    def __repr__(self) -> str:
        return f"Run({self.chain.description}: {self.message})"


def beginning_of(run: Run, count: int) -> Run:
    """The run with its first saved times only.

    Parameters
    ----------
    run : Run
        A run.
    count : int
        How many times to keep.

    Returns
    -------
    Run

    Examples
    --------
    >>> import hertzchain as hc
    >>> beginning_of(hc.simulate(hc.Chain.uniform(5), times=[0.0, 1.0, 2.0]), 2).times
    array([0., 1.])
    """
    return replace(
        run,
        times=run.times[:count],
        positions=run.positions[:count],
        velocities=run.velocities[:count],
        _forces=None if run._forces is None else run._forces[:count],
        _ledger=run._ledger[:count],
    )
