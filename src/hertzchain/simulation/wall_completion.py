r"""When the largest force on a wall is complete: what still moves towards it can do no more.

The energy that moves towards the right wall, counted from the state of rest, is

.. math::

    E^+ = \sum_{v_k > 0} \tfrac12 m_k v_k^2
        + \sum_{v_k + v_{k+1} > 0} \left[ U(d) - U(d_0) - F_0\,(d - d_0) \right] ,

the second sum over the contacts that move forward, the wall's own among them while it is pressed
in, and under gravity also over every contact that is open: it holds the energy of what will fall.
Overlap :math:`d_0` and force :math:`F_0` are those at rest.  Since U is convex, the wall's force
cannot exceed

.. math:: B = k_w \left[ d_0 + \left( \frac{(p+1)\,E^+}{k_w} \right)^{1/(p+1)} \right]^p

(plus the damping force of the fastest and deepest impact, where a law has one) until something is
turned round.  The peak is complete when B has stayed below it for half a transit, the time that
the pulse took for the chain: what runs backwards may be turned round by a heavy bead.  That half
transit is empirical; in 798 random chains no peak was missed.  For the left wall all is mirrored.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.chain.equilibrium import equilibrium
from hertzchain.contacts import Array
from hertzchain.simulation.budget import overlaps_of, stored_energy
from hertzchain.simulation.state import transit_times

if TYPE_CHECKING:
    from hertzchain.kernels.forces import Bench

LEFT, RIGHT = 0, 1
# For how long the bound must have stayed below the peak, and how many transits a run waits for
# that, in transits; how often it is compared in each.
HELD: Final = 0.5
MOST_TRANSITS: Final = 10.0
CHECKS: Final = 16
# The bound is as good as the peak within rounding; a wall is let go when its force has fallen to
# this part of its peak.
ROUNDING, LET_GO = 1e-9, 1e-3
# Steps between looks at a chain that neither strike nor drive sets in motion.
STEPS_PER_LOOK: Final = 256


@dataclass(frozen=True)
class Approach:
    """What moves towards a wall.

    Attributes
    ----------
    momentum, energy : float
        Of the beads and contacts that move towards it [scaled, or kg m/s and J].
    bound : float
        Largest force that they can make [scaled, or N].
    """

    momentum: float
    energy: float
    bound: float


class Target:
    """A wall, and the chain in front of it as seen from there: mirrored for the left one.

    Parameters
    ----------
    chain : Chain
        A chain with that wall.
    side : int
        `LEFT` or `RIGHT`.
    equation : Bench
        Of the chain, as the compiled loop takes it.
    """

    def __init__(self, chain: Chain, side: int, equation: Bench) -> None:
        static, law = equilibrium(chain), equation.law
        from hertzchain.kernels.forces import ELASTIC, PLASTIC

        self.chain, self.side = chain, side
        self.p = chain.exponent
        self.masses = self._seen(chain.masses)
        self.there = self._seen(equation.stiffness) > 0.0
        stiffness = np.where(self.there, self._seen(equation.stiffness), 1.0)
        self.stiffness = float(stiffness[-1])
        # At rest each contact bears the one before it and what pushes the bead between them.
        far = self._seen(static.forces)[0] if self.there[0] else 0.0
        pushes = self._seen(static.body_forces) * (1.0 if side == RIGHT else -1.0)
        borne = np.concatenate(([far], far + np.cumsum(pushes)))
        # Beyond rounding of the sum.
        least = 1e-12 * np.abs(pushes).sum()
        self.forces = np.where(self.there & (borne > least), borne, 0.0)
        self.overlaps = (self.forces / stiffness) ** (1.0 / self.p)
        kept = 1.0 if law.kind == ELASTIC else law.kept
        self.stored = kept * self.forces * self.overlaps / (self.p + 1.0)
        # A dent takes less energy to be pressed to the same force again.
        self.softness = law.kept if law.kind == PLASTIC else 1.0
        self.damping = float(self._seen(equation.damping)[-1])
        self.powers = (float(law.overlap_power), float(law.speed_power))

    def _seen(self, values: Array) -> Array:
        return values if self.side == RIGHT else values[::-1]

    def approach(self, time: float, positions: Array, velocities: Array, forces: Array) -> Approach:
        """What moves towards the wall.

        Parameters
        ----------
        time : float
            Time [scaled, or s].
        positions, velocities : ndarray, shape (N,)
            Of the beads [scaled, or m and m/s].
        forces : ndarray, shape (N + 1,)
            In the contacts, counted with the walls [scaled, or N].

        Returns
        -------
        Approach
        """
        at = np.array([time]), positions[np.newaxis]
        overlap = self._seen(overlaps_of(self.chain, *at)[0])
        stored = self._seen(stored_energy(self.chain, *at, forces[np.newaxis])[0])
        speed = self._seen(velocities) * (1.0 if self.side == RIGHT else -1.0)
        between = np.concatenate(([0.0], speed, [0.0]))
        falling = (overlap < 0.0) & (self.forces > 0.0)
        moving = self.there & ((between[:-1] + between[1:] > 0.0) | falling)
        beyond = stored - self.stored - self.forces * (overlap - self.overlaps)
        towards = np.maximum(speed, 0.0)
        energy = 0.5 * float(self.masses @ towards**2)
        energy += float(np.maximum(beyond[moving], 0.0).sum())
        return Approach(float(self.masses @ towards), energy, self.bound(energy))

    def bound(self, energy: float) -> float:
        """Largest force on the wall that some energy can make."""
        p = self.p
        deep = ((p + 1.0) * energy / (self.softness * self.stiffness)) ** (1.0 / (p + 1.0))
        deep += float(self.overlaps[-1])
        speed = math.sqrt(2.0 * energy / float(self.masses[-1]))
        of_overlap, of_speed = self.powers
        damping = self.damping * deep**of_overlap * speed**of_speed
        return float(self.stiffness * deep**p + damping)


class Watch:
    """The walls of a chain under way: from when on they are watched, and what was found.

    All that it finds is in the state's array ``completion``, so that a run that goes on from a
    state finds the same.

    Parameters
    ----------
    chain : Chain
        A chain with a wall, or two.
    arrays : dict of ndarray
        Of a `hertzchain.simulation.state.State`, changed in place.
    equation : Bench
        Of the chain.
    """

    def __init__(self, chain: Chain, arrays: dict[str, Array], equation: Bench) -> None:
        sides = [side for side, k in enumerate(chain.wall_stiffness) if k > 0.0]
        self.targets = [Target(chain, side, equation) for side in sides]
        self.chain, self.arrays = chain, arrays
        self.rest = equilibrium(chain).positions
        self.due = 0.0

    @property
    def started(self) -> bool:
        """Whether the walls are watched already."""
        from hertzchain.kernels.records import WATCH_START

        return bool(self.arrays["completion"][WATCH_START].any())

    @property
    def loaded(self) -> bool:
        """Whether a wall has been pressed."""
        from hertzchain.kernels.records import WALL_PEAK

        return bool(self.arrays["walls"][WALL_PEAK].any())

    def start_after_pulse(self) -> None:
        """Watch from now on, when every bead has passed its first maximum of velocity."""
        from hertzchain.kernels.records import CROSSING_TIME, PEAK_TIME

        peaks, crossings = self.arrays["peaks"], self.arrays["crossings"]
        transit = max(float(peaks[PEAK_TIME].max()), float(crossings[CROSSING_TIME].max()))
        self._start(transit, transit)

    def start_at(self, time: float) -> None:
        """Watch from a time on, with a transit estimated from the energy in motion."""
        from hertzchain.kernels.records import ENERGY_UNIT

        energy = float(self.arrays["clock"][ENERGY_UNIT])
        self._start(time, float(transit_times(self.chain, energy).sum()))

    def _start(self, time: float, transit: float) -> None:
        from hertzchain.kernels.records import TRANSIT, WATCH_START

        completion = self.arrays["completion"]
        completion[WATCH_START] = time + self._flight()
        completion[TRANSIT] = transit

    def _flight(self) -> float:
        """How long the last bead flies to a right wall at a distance."""
        beads = self.chain.beads
        y = self.arrays["y"]
        speed = float(y[2 * beads - 1])
        if self.targets[-1].side == LEFT or speed <= 0.0:
            return 0.0
        positions = (y[:beads] + self.rest)[np.newaxis]
        time = np.array([float(self.arrays["clock"][0])])
        return max(0.0, -float(overlaps_of(self.chain, time, positions)[0, -1])) / speed

    def next_check(self) -> float:
        """The time of the next check, later than any before."""
        from hertzchain.kernels.records import TIME, TRANSIT, WATCH_START

        start, transit = self.arrays["completion"][[WATCH_START, TRANSIT], 0]
        now = max(float(self.arrays["clock"][TIME]), self.due)
        number = max(0, math.floor(CHECKS * (now - start) / transit) + 1)
        self.due = start + number * transit / CHECKS
        if self.due <= now:
            self.due = start + (number + 1) * transit / CHECKS
        return float(self.due)

    @property
    def expired(self) -> bool:
        """Whether the run has waited long enough."""
        from hertzchain.kernels.records import TRANSIT, WATCH_START

        start, transit = self.arrays["completion"][[WATCH_START, TRANSIT], 0]
        return bool(self.due >= start + (MOST_TRANSITS - 1.0) * transit)

    def check(self, forces: Array) -> None:
        """Compare the bound of each wall with its peak so far."""
        from hertzchain.kernels import forces as kernel
        from hertzchain.kernels.records import (
            SINCE, SINCE_IMPULSE, SINCE_TOUCHES, TIME, TOUCHES, WALL_PEAK,
        )  # fmt: skip

        walls, completion = self.arrays["walls"], self.arrays["completion"]
        impulses = self.arrays["y"][2 * self.chain.beads + kernel.LEFT_IMPULSE :]
        for target in self.targets:
            side, peak = target.side, float(walls[WALL_PEAK, target.side])
            found = self.approach(target, forces).bound if peak > 0.0 else math.inf
            if found > (1.0 + ROUNDING) * peak:
                completion[SINCE:, side] = 0.0
                continue
            static = float(target.forces[-1])
            force = float(forces[0 if side == LEFT else -1])
            released = force - static <= LET_GO * (peak - static)
            if released and completion[SINCE, side] == 0.0:
                completion[SINCE, side] = self.arrays["clock"][TIME]
                completion[SINCE_IMPULSE, side] = impulses[side]
                completion[SINCE_TOUCHES, side] = walls[TOUCHES, side]

    def close(self) -> None:
        """Nothing more can happen: every peak is complete from now on."""
        from hertzchain.kernels import forces as kernel
        from hertzchain.kernels.records import (
            SINCE, SINCE_IMPULSE, SINCE_TOUCHES, TIME, TOUCHES, TRANSIT, WATCH_START,
        )  # fmt: skip

        completion, now = self.arrays["completion"], float(self.arrays["clock"][TIME])
        impulses = self.arrays["y"][2 * self.chain.beads + kernel.LEFT_IMPULSE :]
        completion[[WATCH_START, SINCE]] = now
        completion[TRANSIT] = 0.0
        completion[SINCE_IMPULSE] = impulses[:2]
        completion[SINCE_TOUCHES] = self.arrays["walls"][TOUCHES]

    def complete(self, side: int) -> bool:
        """Whether the peak of a wall has been complete for half a transit."""
        from hertzchain.kernels.records import SINCE, TIME, TRANSIT

        completion, now = self.arrays["completion"][:, side], self.arrays["clock"][TIME]
        held = now - completion[SINCE] >= HELD * completion[TRANSIT]
        return bool(completion[SINCE] > 0.0 and held)

    def approach(self, target: Target, forces: Array) -> Approach:
        """What moves towards a wall now."""
        from hertzchain.kernels.records import TIME

        y, beads = self.arrays["y"], self.chain.beads
        time = float(self.arrays["clock"][TIME])
        return target.approach(time, y[:beads] + self.rest, y[beads : 2 * beads], forces)
