"""A whole trajectory, and what it tells: the pulse, forces as sensors see them, the budget."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
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
from hertzchain.simulation.equations import transit_times
from hertzchain.simulation.fronts import Fronts, fronts_of
from hertzchain.simulation.leading_pulse import LeadingPulse, leading_pulse_of
from hertzchain.simulation.run_pulse import pulse_of, residence_of
from hertzchain.simulation.sensor_force import SensorForce, sensor_force_of
from hertzchain.simulation.state import State, ledger_units, records_units
from hertzchain.simulation.velocity_peaks import VelocityPeaks, velocity_peaks
from hertzchain.simulation.wall_force import (
    SIDES,
    Side,
    WallForce,
    incomplete_peak,
    wall_force_of,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

    from hertzchain.chain.scales import Scales
    from hertzchain.simulation.energy_flux import EnergyFlux
    from hertzchain.simulation.horizon import Horizon
    from hertzchain.simulation.reflection import Reflection
    from hertzchain.simulation.waves import Waves

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

# Transits of a pulse after which a run between walls may have become unpredictable.
LONG_RUN: Final = 3.0


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
    def _reached(self) -> bool:
        """Whether any contact between two beads has been seen compressed beyond its rest."""
        gaps = equilibrium(self.chain).gaps[1:-1]
        moved = self.state.arrays["y"][: self.chain.beads]
        compressed = moved[:-1] - moved[1:] > np.maximum(gaps, 0.0)
        seen = self.largest_overlaps[1:-1] > np.maximum(-gaps, 0.0) * (1.0 + 1e-9)
        return bool(np.any(seen | compressed))

    def pulse(self) -> Pulse:
        """The leading pulse: first velocity maxima, arrivals and largest overlaps.

        Of a driven chain, too: the first maximum of bead 1 is then found as that of any other
        bead, its arrival is 0, the start of the drive, and it has no residence time.

        Returns
        -------
        Pulse
            Found between the steps while integrating, not among the saved times.  What the run
            has not seen, or what is not defined, is NaN; ``pulse.notes`` says where and why.

        Raises
        ------
        SimulationError
            If the run stopped before any contact was reached.

        Examples
        --------
        >>> import hertzchain as hc
        >>> float(hc.simulate(hc.Chain.uniform(30)).pulse().velocity[1].round(9))
        0.751471736

        A chain that a piezoelectric actuator drives:

        >>> burst = hc.SineBurst(0.3, 0.1, cycles=2.0)
        >>> pulse = hc.simulate(hc.Chain.uniform(30).replace(drive=burst), until=60.0).pulse()
        >>> pulse.arrival[[0, 10, 20]].round(3)
        array([ 0.   , 21.03 , 38.853])
        >>> pulse.notes["residence"].partition(";")[0]
        'bead 1: not struck, so that no pulse arrives there'
        """
        if not self._reached:
            raise SimulationError(
                f"no pulse: {self.message}, and no contact was reached; simulate for longer"
            )
        return pulse_of(self.chain, self._peaks, self._crossings)

    def leading_pulse(self) -> LeadingPulse:
        """The leading pulse as a whole: its length, momentum and kinetic energy.

        A `Pulse` has the momentum of one bead; this has that of all beads that the pulse covers.

        Returns
        -------
        LeadingPulse
            Found between the steps while integrating, not among the saved times.

        Examples
        --------
        The momentum of the solitary wave of equal beads, struck with momentum 1:

        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(60), times=0)
        >>> round(float(run.leading_pulse().momentum[40]), 5)
        1.13831
        """
        from hertzchain.kernels import records

        turned_back = float(self._walls[records.TURNED_BACK, 1])
        return leading_pulse_of(self.chain, self._crossings, turned_back)

    def fronts(self) -> Fronts:
        """When the front of what runs along the chain reached each contact, and its speed.

        Fronts are for chains that are driven: they exist in shocks, where the force has no
        maximum, and a slow drive does not shift them as it shifts crests.

        Returns
        -------
        Fronts
            From the saved times.

        Raises
        ------
        InputError
            If fewer than two times were saved.

        Examples
        --------
        A piston that pushes on for ever, with losses: a shock without a crest.  Its speed is 1
        bead per time, by the balance of mass and momentum:

        >>> import hertzchain as hc
        >>> piston = hc.Table([0.0, 200.0], [0.0, 200.0], of="displacement")
        >>> chain = hc.Chain.uniform(40).replace(
        ...     drive=piston, left_wall=hc.Wall(stiffness=1.0), loss=hc.Viscoelastic(0.5)
        ... )
        >>> fronts = hc.simulate(chain, until=28.0, times=1000).fronts()
        >>> f"{5 / (fronts.times[14] - fronts.times[9]):.2f}"
        '1.01'
        >>> fronts.notes["times"]
        'contacts 24 to 39: not reached, or still being loaded, at the end of the run'
        """
        return fronts_of(self.chain, self.times, self.forces, self._crossings)

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

    def waves(self, *, threshold: float = 0.01, min_contacts: int = 3) -> Waves:
        """The travelling waves, in both directions: pulses, trains, reflections.

        A wave is what passes one contact after another as a maximum of the force; see
        `hertzchain.simulation.waves` for how they are found.

        Parameters
        ----------
        threshold : float
            Least force of a wave, in parts of the largest force of the run.
        min_contacts : int
            Least number of contacts that a wave passes.

        Returns
        -------
        Waves
            A sequence of `Wave`, by the time of their first contact.

        Raises
        ------
        InputError
            If fewer than 8 times were saved during the passage of the strongest wave.

        Warns
        -----
        InputWarning
            If some weaker waves are not resolved; they are marked.

        Examples
        --------
        A striker of four times the mass sends a train of waves, each half as strong as the one
        before it:

        >>> import hertzchain as hc
        >>> import numpy as np
        >>> chain = hc.Chain.uniform(80).replace(masses=np.append(4.0, np.ones(79)))
        >>> train = hc.simulate(chain, until=110.0, times=2200).waves().passing(60)
        >>> [round(wave.amplitude, 3) for wave in train][:4]
        [1.277, 0.495, 0.207, 0.089]
        """
        from hertzchain.simulation.waves import find_waves

        return find_waves(self, threshold, min_contacts)

    def reflection(
        self, before: int, after: int, *, since: float = 0.0, until: float | None = None
    ) -> Reflection:
        """Reflection and transmission of a wave by what is between two contacts.

        Parameters
        ----------
        before, after : int
            Contacts on both sides of an interface or defect, at least a pulse's width (5
            contacts) from it, in the direction of the wave.  N, or 0, for ``after`` is the wall
            or free end.
        since : float
            Time from which to look for the incident wave [scaled, or s].
        until : float, optional
            Time up to which to count [scaled, or s].  Counting stops earlier if another wave
            enters from outside.

        Returns
        -------
        Reflection
            Coefficients of energy, momentum and force, and the waves themselves.

        Raises
        ------
        InputError
            If there are no such contacts, or fewer than 8 times were saved during the passage
            of one of the waves.
        SimulationError
            If no wave towards ``after`` passes the contact ``before``, or another wave enters
            before it has passed.

        Warns
        -----
        InputWarning
            If other waves take part, or the wave has not come out yet: when more than 5% of the
            incident energy is missing from the balance or, without losses, still between the
            contacts.

        Examples
        --------
        The last 60 beads have twice the radius of the first:

        >>> import hertzchain as hc
        >>> import numpy as np
        >>> chain = hc.Chain.from_radii(np.where(np.arange(120) < 60, 1.0, 2.0))
        >>> found = hc.simulate(chain, until=140.0, times=1500).reflection(50, 75)
        >>> f"R = {found.reflected_energy:.3f}, T = {found.transmitted_energy:.3f}"
        'R = 0.523, T = 0.476'
        """
        from hertzchain.simulation.reflection import reflection_of

        return reflection_of(self, before, after, since, until)

    def energy_flux(self) -> EnergyFlux:
        """Energy that passed each contact, to the right and to the left.

        It describes strongly disordered chains, in which waves last for a few contacts only.

        Returns
        -------
        EnergyFlux

        Raises
        ------
        InputError
            If fewer than 8 times were saved during the passage of the strongest wave.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(30).replace(right_wall=hc.Wall.rigid())
        >>> flux = hc.simulate(chain, until=60.0, times=600).energy_flux()
        >>> f"{flux.right[19]:.3f} to the right, {flux.left[19]:.3f} to the left"
        '0.497 to the right, 0.497 to the left'
        """
        from hertzchain.simulation.energy_flux import energy_flux_of

        return energy_flux_of(self)

    def velocity_peaks(self, bead: int) -> VelocityPeaks:
        """Peaks of one bead's velocity, forwards and backwards.

        Parameters
        ----------
        bead : int
            Number k of the bead, 2 or more.

        Returns
        -------
        VelocityPeaks
            Their times, velocities and widths, from the saved times.

        Raises
        ------
        InputError
            If there is no such bead, or fewer than two times were saved.

        Examples
        --------
        A wave and its reflection from a rigid wall:

        >>> import hertzchain as hc
        >>> chain = hc.Chain.uniform(40).replace(right_wall=hc.Wall.rigid())
        >>> run = hc.simulate(chain, until=80.0, times=1600)
        >>> run.velocity_peaks(25).velocities[:2].round(3)
        array([ 0.682, -0.681])
        """
        k = whole_number("bead", bead, least=2, most=self.chain.beads)
        net = self.forces[:, k - 1] - self.forces[:, k] + equilibrium(self.chain).body_forces[k - 1]
        acceleration = net / self.chain.masses[k - 1]
        return velocity_peaks(k, self.times, self.velocity(k), acceleration)

    def pulse_width(self, bead: int) -> float:
        r"""Width of the leading pulse where it passes a bead, in beads.

        .. math:: w_k = \frac{\Delta t_k}{T_k}

        with the full width at half maximum :math:`\Delta t_k` of the bead's velocity in
        time, and the residence time :math:`T_k`, in which the pulse moves on by one bead.
        The solitary wave of equal beads has 1.57914 (p = 3/2).  The time itself is
        ``run.velocity_peaks(bead).widths[0]``.

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
        residence = residence_of(self.chain, self._crossings)[k - 1]
        if np.isnan(residence):
            raise SimulationError(
                f"no width of the pulse at bead {k}: it is one of several beads that move from the "
                "start, on which a pulse has no residence time"
            )
        peaks = self.velocity_peaks(k)
        width = np.nan
        if len(peaks):
            leading = int(np.argmin(np.abs(peaks.times - self._peaks[0, k - 1])))
            width = peaks.widths[leading] / residence
        if not np.isfinite(width):
            raise SimulationError(
                f"no width of the pulse at bead {k}: among the {len(self.times)} saved times its "
                "velocity is not seen to fall to half of its maximum on both sides; save more "
                "times, or let the run go on for longer (until)"
            )
        return float(width)

    def budget(self) -> Budget:
        """Energy and momentum at every saved time, by where they are and where they came from.

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
            self._ledger, self.leading_pulse().weights(self.times, self.velocities),
            self.state.start,
        )  # fmt: skip

    def horizon(
        self, *, within: float = 0.01, progress: Callable[[int, int], None] | None = None
    ) -> Horizon:
        """How far the velocities can be predicted, from a second integration.

        The chain is integrated again with ten times the tolerance (with a tenth of it from
        rtol = 1e-7 on), which takes about as long as the run itself.  The result is kept: the
        run's repr then tells it, and a further call takes no time.

        Parameters
        ----------
        within : float
            Error of the velocities up to which they count as predicted, in parts of the largest
            velocity.
        progress : callable, optional
            Called as ``progress(beads_passed, beads)`` a few times a second.

        Returns
        -------
        Horizon

        Raises
        ------
        InputError
            If no times were saved, or the run started from a reversed state.
        SimulationError
            If the second integration fails.

        Examples
        --------
        A pulse that runs to and fro between two walls becomes unpredictable:

        >>> import hertzchain as hc
        >>> wall = hc.Wall()
        >>> chain = hc.Chain.uniform(20).replace(left_wall=wall, right_wall=wall)
        >>> horizon = hc.simulate(chain, until=400.0).horizon()
        >>> 60.0 < horizon.time < 400.0
        True
        """
        from hertzchain.simulation.horizon import horizon_of

        found = horizon_of(self, within, progress)
        self.__dict__["_horizon"] = found
        return found

    @property
    def known_horizon(self) -> Horizon | None:
        """What `horizon` found, `None` while it has not been called."""
        return self.__dict__.get("_horizon")

    @property
    def prediction(self) -> str:
        """How far the run can be predicted, in a few words; empty where that is no question.

        Names `horizon` where the run is long and its chain traps waves: without losses, with a
        wall, and beyond three transits of a pulse.
        """
        if self.known_horizon is not None:
            return self.known_horizon.message
        transits = transits_between_walls(self.chain, self.end_time)
        if transits <= LONG_RUN:
            return ""
        return f"{transits:.0f} transits long: run.horizon() tells how far it can be predicted"

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
        said = self.message, self.prediction
        return f"Run({self.chain.description}: {'; '.join(filter(None, said))})"


def transits_between_walls(chain: Chain, time: float) -> float:
    """How often a pulse crosses a chain that traps it, without losses and with a wall.

    Parameters
    ----------
    chain : Chain
        The chain.
    time : float
        Length of the run [scaled, or s].

    Returns
    -------
    float
        0 for other chains.  Beyond `LONG_RUN` a run may have become unpredictable.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(20)
    >>> walled = chain.replace(right_wall=hc.Wall())
    >>> transits_between_walls(chain, 100.0), round(transits_between_walls(walled, 100.0))
    (0.0, 4)
    """
    trapped = chain.loss is None and any(chain.wall_stiffness)
    return time / float(transit_times(chain).sum()) if trapped else 0.0


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
