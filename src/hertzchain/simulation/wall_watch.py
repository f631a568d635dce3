"""Criterion for a complete peak of the force on a wall, which also ends a run.

If motion can escape at the other end of the chain, the peak is complete as soon as the bound of
`hertzchain.simulation.wall_bound` proves that no later force exceeds it.

The impact on a wall has ended when the contact with it opens for the first time since the motion
towards the wall cannot exceed the peak (the estimate of the same module).  A contact that carries a
static force need not open; its force must fall to 0.1% of the peak, without the static force.
If motion cannot escape, the peak is complete when the impact has ended and the estimate has not
exceeded the peak for half a transit since then, where a transit is the time that the pulse took to
pass the chain.  Under gravity towards the wall, it suffices that the first beads have rebounded
from the row (`hertzchain.simulation.rebounds`), and a peak that is complete remains so while they
fall back.  These rules are empirical, and they start again if a larger force follows.

Without a given end, a run continues until the peak is complete and half a transit has passed since
the end of the impact, or until `WallWatch.last`: ten transits, or 20 if motion can escape, or, if
this is longer, the first transit and twice the time in which all beads, as one body with the
momentum of the impact, would rebound from the row and its wall.  It is longer if the wall is soft,
or if the striker is heavy and the beads are soft.

Walls are watched from the end of the first transit on, or from the end of the drive or of a fall
from rest, at fixed times between the calls of the compiled loop.  The array ``completion`` of the
state stores the result; a resumed run therefore gives the same result.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..kernels import state_layout
from ..kernels.wall_rule import (
    CHECKS,
    HELD,
    MAX_REBOUNDS,
    ROUNDING,
    has_released,
    longest_watch,
    time_between_checks,
)
from .budget import overlaps_of, stored_energy
from .time_scales import impact_momentum, rebound_time, transit_times
from .wall_bound import RIGHT, Approach, Target, motion_can_escape, wall_targets

# Checks per transit of a run by fixed steps to a given time, which may be very long, or to a proven
# peak: in chains of ten beads, a check takes longer than the integration between two of them.
FEW_CHECKS: Final = 2
SMALLEST: Final = float(np.finfo(float).tiny)


class WallWatch:
    """The walls of a chain during a run; ``arrays`` are the arrays of its state.

    Steps are ``fixed``, or adapted to the motion.
    """

    def __init__(
        self, chain: Chain, arrays: dict[str, Array], checks: int = CHECKS, *, fixed: bool = False
    ) -> None:
        self.targets = wall_targets(chain)
        self.chain, self.arrays, self.rest = chain, arrays, chain.static_state.positions
        self.clock, self.walls = arrays["clock"], arrays["walls"]
        self.completion, self.checks, self.fixed = arrays["completion"], checks, fixed

    @property
    def time(self) -> float:
        """Time of the run."""
        return float(self.clock[state_layout.TIME])

    @property
    def start(self) -> float:
        """Time from which walls are watched; 0 as long as it is not known."""
        return float(self.completion[state_layout.WATCH_START, 0])

    @property
    def transit(self) -> float:
        """Time that the pulse takes to pass the chain."""
        return float(self.completion[state_layout.TRANSIT, 0])

    @property
    def started(self) -> bool:
        """Whether the time from which walls are watched is known."""
        return self.start > 0.0

    @property
    def driven(self) -> bool:
        """Whether the drive has not ended."""
        return self.chain.drive is not None and self.time < self.chain.drive.end

    @property
    def closed(self) -> bool:
        """Whether nothing more can happen."""
        return self.started and self.transit == 0.0

    @property
    def hit(self) -> bool:
        """Whether any wall has been compressed so far."""
        return bool(self.walls[state_layout.WALL_PEAK].any())

    def start_after_pulse(self) -> None:
        """Watch from now on: every bead has passed its first velocity maximum."""
        peaks, crossings = self.arrays["peaks"], self.arrays["crossings"]
        transit = max(
            peaks[state_layout.PEAK_TIME].max(), crossings[state_layout.CROSSING_TIME].max()
        )
        self._start(float(transit) + self._flight(), float(transit))

    def start_at(self, time: float) -> None:
        """Watch from a time on, with a transit estimated from the largest energy in motion."""
        energy = float(self.clock[state_layout.ENERGY_UNIT])
        self._start(time + self._flight(), float(transit_times(self.chain, energy).sum()))

    def start_after_fall(self, time: float) -> None:
        """Watch from the end of a fall on, perhaps before the step that contains it."""
        self._start(time, float(transit_times(self.chain).sum()))

    def _start(self, time: float, transit: float) -> None:
        self.completion[state_layout.WATCH_START] = time
        self.completion[state_layout.TRANSIT] = transit
        self._set_due()

    def _flight(self) -> float:
        """Time in which the last bead reaches a right wall at a distance."""
        beads, y = self.chain.beads, self.arrays["y"]
        if self.chain.right_wall is None or y[2 * beads - 1] <= 0.0:
            return 0.0
        return max(0.0, -float(self._overlaps()[-1])) / float(y[2 * beads - 1])

    def _overlaps(self) -> Array:
        positions = self.arrays["y"][: self.chain.beads] + self.rest
        return overlaps_of(self.chain, self.clock[[state_layout.TIME]], positions[None])[0]

    @property
    def due(self) -> float:
        """Time of the next check."""
        return float(self.completion[state_layout.DUE, 0])

    def _set_due(self) -> None:
        """Set the next check to the first one after the next step."""
        spacing = time_between_checks(self.time - self.start, self.transit, self.checks)
        if not self.fixed:
            # After free flight the predicted step may be longer than many transits.  It would be
            # reduced at the next collision, but the next check would remain late.
            self.clock[state_layout.STEP] = min(self.clock[state_layout.STEP], spacing)
        time = self.time + float(self.clock[state_layout.STEP])
        number = max(0, math.floor((time - self.start) / spacing)) + 1
        self.completion[state_layout.DUE] = max(
            self.start + number * spacing, math.nextafter(time, math.inf)
        )

    @cached_property
    def _struck(self) -> bool:
        return bool(self.chain.velocities.any())

    @cached_property
    def _rebound(self) -> float:
        """Time of the rebound at the right end with the momentum towards it at time 0."""
        return rebound_time(self.chain, impact_momentum(self.chain))

    def _rebound_by_force(self) -> float:
        """The same with the momentum that a drive or gravity has given."""
        momentum = float(self.chain.masses @ self._velocities + self._impulse(RIGHT))
        return rebound_time(self.chain, momentum)

    @property
    def last(self) -> float:
        """Time at which a run without a given end stops at the latest."""
        rebounds = MAX_REBOUNDS * (self._rebound if self._struck else self._rebound_by_force())
        can_escape = motion_can_escape(self.chain, RIGHT)
        return self.start + longest_watch(self.transit, rebounds, can_escape)

    @property
    def expired(self) -> bool:
        """Whether the longest run has ended, and half a transit since the end of the impact."""
        late = self.time >= self.last
        return late and (self.completion[state_layout.SINCE, RIGHT] == 0.0 or self.held(RIGHT))

    def check(self, forces: Array) -> None:
        """Compare the bound of each wall with its peak so far."""
        self._set_due()
        self._restart()
        overlaps = self._overlaps()
        self.close_if_apart(overlaps)
        if self.closed:
            return
        stored = self._stored(overlaps, forces)
        for target in self.targets:
            side = target.side
            peak = float(self.walls[state_layout.WALL_PEAK, side])
            if peak == 0.0 or not self.over(target, overlaps, stored):
                self.completion[state_layout.BOUNDED :, side] = 0.0
            else:
                self._note_if_released(target, forces)

    def _note_if_released(self, target: Target, forces: Array) -> None:
        """Note the end of the impact if the wall has been released since the bound is low."""
        side, walls = target.side, self.walls
        if self.completion[state_layout.BOUNDED, side] == 0.0:
            self.completion[state_layout.BOUNDED, side] = self._mark
        peak = float(walls[state_layout.WALL_PEAK, side])
        last = float(walls[state_layout.LAST_END, side])
        if last > self.completion[state_layout.BOUNDED, side]:
            touches = walls[state_layout.TOUCHES, side] - walls[state_layout.TOUCHING, side]
            self._note_at(side, last, float(walls[state_layout.LAST_IMPULSE, side]), touches)
        elif has_released(self.force_on(target, forces), float(target.forces[-1]), peak):
            self._note(side)

    def force_on(self, target: Target, forces: Array) -> float:
        """Force on a wall, given the forces of all contacts."""
        return float(forces[-1 if target.side == RIGHT else 0])

    def bounded(self, side: int, approach: Approach) -> bool:
        """Whether the motion towards a wall cannot exceed the peak so far."""
        peak = float(self.walls[state_layout.WALL_PEAK, side])
        return approach.bound <= (1.0 + ROUNDING) * peak

    def over(self, target: Target, overlaps: Array, stored: Array) -> bool:
        """Whether the present motion towards a wall is not expected to exceed the peak so far."""
        return (
            self.bounded(target.side, self.approach(target, overlaps, stored))
            or target.rebounded(overlaps, stored, self._velocities)
            or (target.may_rebound and self.held(target.side))
        )

    def _note(self, side: int) -> None:
        """Record that the impact on a wall has ended, unless it had before."""
        touches = float(self.walls[state_layout.TOUCHES, side])
        self._note_at(side, self._mark, self._impulse(side), touches)

    def _note_at(self, side: int, time: float, impulse: float, touches: float) -> None:
        if self.completion[state_layout.SINCE, side] == 0.0:
            self.completion[state_layout.SINCE :, side] = time, impulse, touches
        if self.completion[state_layout.BOUNDED, side] == 0.0:
            self.completion[state_layout.BOUNDED, side] = self._mark

    def _impulse(self, side: int) -> float:
        """Impulse on a wall so far."""
        from ..kernels.forces import LEFT_IMPULSE

        return float(self.arrays["y"][2 * self.chain.beads + LEFT_IMPULSE + side])

    def _restart(self) -> None:
        """Forget ends of impacts that a larger force has followed."""
        risen = self.walls[state_layout.WALL_PEAK_TIME] > self.completion[state_layout.BOUNDED]
        self.completion[state_layout.BOUNDED :, risen] = 0.0

    def close_if_apart(self, overlaps: Array) -> None:
        """Close if no contact is closed or closing and no force acts on the beads."""
        if self.closed or self.driven or self.chain.static_state.body_forces.any():
            return
        padded = np.concatenate(([0.0], self._velocities, [0.0]))
        meeting = (overlaps > 0.0) | (padded[:-1] > padded[1:])
        if not meeting[self.targets[0].contacts].any():
            self.close()

    @property
    def _mark(self) -> float:
        """The time or, at time 0, the smallest positive number, because 0 means "not yet"."""
        return max(self.time, SMALLEST)

    def close(self) -> None:
        """Record that nothing more can happen: every peak is complete."""
        self.completion[state_layout.WATCH_START] = self._mark
        self.completion[[state_layout.TRANSIT, state_layout.DUE]] = 0.0
        self._restart()
        for target in self.targets:
            self._note(target.side)

    def held(self, side: int) -> bool:
        """Whether half a transit has passed since the end of the impact on a wall."""
        since = float(self.completion[state_layout.SINCE, side])
        return since > 0.0 and self._mark - since >= HELD * self.transit

    def ends_run(self, forces: Array, *, at_peak: bool = False) -> bool:
        """Whether the peak on the right wall is complete, and enough time has passed.

        A peak that is proven needs no more time, if only it is needed.
        """
        target = self.targets[-1]
        # The bound takes time; the estimate is smaller.
        likely = at_peak and target.can_escape and self.completion[state_layout.BOUNDED, RIGHT]
        if not (self.held(RIGHT) or self.expired or likely):
            return False
        overlaps = self._overlaps()
        return self.complete(target, self.reach(target, overlaps, self._stored(overlaps, forces)))

    def complete(self, target: Target, reach: Approach) -> bool:
        """Whether the peak on a wall is complete, given the motion that can reach it."""
        if not target.can_escape:
            low = target.may_rebound or self.bounded(target.side, reach)
            return self.held(target.side) and low
        known = self.closed or float(self.walls[state_layout.WALL_PEAK, target.side]) > 0.0
        return known and not self.driven and self.bounded(target.side, reach)

    def reaches(self, forces: Array) -> list[Approach]:
        """The motion that can reach each wall; close if there is none, and note ends of impacts."""
        self._restart()
        overlaps = self._overlaps()
        self.close_if_apart(overlaps)
        stored, found = self._stored(overlaps, forces), []
        for target in self.targets:
            side = target.side
            hit = self.started and self.walls[state_layout.WALL_PEAK, side] > 0.0
            if hit and self.over(target, overlaps, stored):
                self._note_if_released(target, forces)
            found.append(self.reach(target, overlaps, stored))
        return found

    def approach(self, target: Target, overlaps: Array, stored: Array) -> Approach:
        """The motion towards a wall now."""
        return target.approach(overlaps, stored, self._velocities)

    def reach(self, target: Target, overlaps: Array, stored: Array) -> Approach:
        """The motion that can reach a wall; none if nothing more can happen."""
        if self.closed:
            return self.approach(target, overlaps, stored)
        return target.reach(overlaps, stored, self._velocities)

    @property
    def _velocities(self) -> Array:
        beads = self.chain.beads
        return self.arrays["y"][beads : 2 * beads]

    def _stored(self, overlaps: Array, forces: Array) -> Array:
        overlaps, forces = overlaps[np.newaxis], forces[np.newaxis]
        return stored_energy(self.chain, overlaps, forces, may_close=True)[0]
