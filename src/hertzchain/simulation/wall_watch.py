"""Criterion for a complete peak of the force on a wall, which also ends a run.

The peak is complete when the force on the wall has fallen to 0.1% of it, without the static force,
and since then the bound of `hertzchain.simulation.wall_bound` has not exceeded it for half a
transit, where a transit is the time that the pulse took to pass the chain.  The contact with the
wall need not have opened.  The bound is exact for motion towards the wall.  The half transit
accounts for motion that is reversed later and is empirical: with it, no complete peak of 600 random
chains was exceeded within ten transits.

Walls are watched from the end of the first transit on, or from the end of the drive, at fixed
times between the calls of the compiled loop.  The array ``completion`` of the state stores the
result; a resumed run therefore gives the same result.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..kernels import state_layout
from .budget import overlaps_of, stored_energy
from .time_scales import transit_times
from .wall_bound import RIGHT, Approach, Target, wall_targets

# Time for which the bound must have been below the peak, and maximum length of a run, in transits;
# number of checks per transit.
HELD: Final = 0.5
MAX_TRANSITS: Final = 10
CHECKS: Final = 16
# Checks per transit of a run by fixed steps to a given time, which may be very long.
FEW_CHECKS: Final = 2
SMALLEST: Final = float(np.finfo(float).tiny)
# Relative rounding of the bound; fraction of the peak below which the force has left the wall.
ROUNDING, RELEASED = 1e-9, 1e-3


class WallWatch:
    """The walls of a chain during a run; ``arrays`` are the arrays of its state."""

    def __init__(self, chain: Chain, arrays: dict[str, Array], checks: int = CHECKS) -> None:
        self.targets = wall_targets(chain)
        self.chain, self.arrays, self.rest = chain, arrays, chain.static_state.positions
        self.clock, self.walls = arrays["clock"], arrays["walls"]
        self.completion, self.checks = arrays["completion"], checks

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
        self._start(float(transit), float(transit))

    def start_at(self, time: float) -> None:
        """Watch from a time on, with a transit estimated from the largest energy in motion."""
        energy = float(self.clock[state_layout.ENERGY_UNIT])
        self._start(time, float(transit_times(self.chain, energy).sum()))

    def _start(self, time: float, transit: float) -> None:
        self.completion[state_layout.WATCH_START] = time + self._flight()
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
        time, spacing = self.time + float(self.clock[state_layout.STEP]), self.transit / self.checks
        number = max(0, math.floor((time - self.start) / spacing)) + 1
        self.completion[state_layout.DUE] = max(
            self.start + number * spacing, math.nextafter(time, math.inf)
        )

    @property
    def expired(self) -> bool:
        """Whether MAX_TRANSITS have passed and the bound is not below the right wall's peak."""
        late = self.time >= self.start + (MAX_TRANSITS - 1) * self.transit
        return late and self.completion[state_layout.SINCE, RIGHT] == 0.0

    def check(self, forces: Array) -> None:
        """Compare the bound of each wall with its peak so far."""
        self._set_due()
        overlaps = self._overlaps()
        self.close_if_apart(overlaps)
        if self.closed:
            return
        stored = self._stored(overlaps, forces)
        for target in self.targets:
            side, peak = target.side, float(self.walls[state_layout.WALL_PEAK, target.side])
            if peak == 0.0 or not self.bounded(side, self.approach(target, overlaps, stored)):
                self.completion[state_layout.SINCE :, side] = 0.0
                continue
            static, force = float(target.forces[-1]), float(forces[-1 if side == RIGHT else 0])
            if force - static <= RELEASED * (peak - static):
                self._note(side)

    def bounded(self, side: int, approach: Approach) -> bool:
        """Whether the motion towards a wall cannot exceed the peak so far."""
        peak = float(self.walls[state_layout.WALL_PEAK, side])
        return approach.bound <= (1.0 + ROUNDING) * peak

    def _note(self, side: int) -> None:
        """Record that a peak is complete from now on, unless it was before."""
        from ..kernels.forces import LEFT_IMPULSE

        if self.completion[state_layout.SINCE, side] == 0.0:
            impulse = self.arrays["y"][2 * self.chain.beads + LEFT_IMPULSE + side]
            touches = self.walls[state_layout.TOUCHES, side]
            self.completion[state_layout.SINCE :, side] = self._mark, impulse, touches

    def close_if_apart(self, overlaps: Array) -> None:
        """Close if no contact is closed or closing and no force acts on the beads."""
        driven = self.chain.drive is not None and self.time < self.chain.drive.end
        if self.closed or driven or self.chain.static_state.body_forces.any():
            return
        beads = self.chain.beads
        velocities = self.arrays["y"][beads : 2 * beads]
        padded = np.concatenate(([0.0], velocities, [0.0]))
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
        for target in self.targets:
            self._note(target.side)

    def complete(self, side: int) -> bool:
        """Whether the peak of a wall has been complete for half a transit."""
        since = float(self.completion[state_layout.SINCE, side])
        return since > 0.0 and self._mark - since >= HELD * self.transit

    def approaches(self, forces: Array) -> list[Approach]:
        """The motion towards each wall now; close if there is none."""
        overlaps = self._overlaps()
        self.close_if_apart(overlaps)
        stored = self._stored(overlaps, forces)
        return [self.approach(target, overlaps, stored) for target in self.targets]

    def approach(self, target: Target, overlaps: Array, stored: Array) -> Approach:
        """The motion towards a wall now."""
        beads = self.chain.beads
        return target.approach(overlaps, stored, self.arrays["y"][beads : 2 * beads])

    def _stored(self, overlaps: Array, forces: Array) -> Array:
        return stored_energy(self.chain, overlaps[np.newaxis], forces[np.newaxis])[0]
