"""Criteria for the end of a run, and for the end of the next call of the compiled loop.

Without ``until``, a chain with a right wall runs until the largest force on the wall is complete
(`hertzchain.simulation.wall_watch`), or to a longest time.  A chain with a cap behind the row and
no right wall runs until the largest force on the cap is complete
(`hertzchain.simulation.body_watch`); any other chain runs until the pulse has left.  With
``until``, the run stops at that time, and walls are watched in the same way.
"""

from __future__ import annotations

import math
from typing import Any, Final, Literal

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..kernels import state_layout
from ..kernels.wall_rule import CHECKS
from .body_watch import STEPS_PER_CHECK, BodyWatch
from .time_scales import fall_time
from .wall_bound import RIGHT, motion_can_escape
from .wall_watch import FEW_CHECKS, WallWatch

Status = Literal[
    "pulse left", "time reached", "wall force complete", "transit limit", "nothing more happens",
    "step limit", "step too small", "unstable steps", "underflow",
]  # fmt: skip
# Of runs that end by themselves although contacts may still act.
NATURAL_ENDS: Final[tuple[Status, ...]] = ("pulse left", "wall force complete")

# Steps between two checks whether a wall was hit, if neither an impact, a drive nor a fall
# determines when to begin watching.
STEPS_PER_LOOK = 64
# Row of the bound in `RunEnd.assess`.
BOUND: Final = 2


class RunEnd:
    """The end of a run; ``arrays`` are those of its state, one of which the wall watch changes."""

    def __init__(
        self,
        chain: Chain,
        arrays: dict[str, Array],
        until: float | None,
        *,
        fixed: bool = False,
        at_peak: bool = False,
    ) -> None:
        self.chain, self.counts = chain, arrays["counts"]
        # Whether the run ends without a given time.
        self.by_itself = until is None
        self.until = math.inf if until is None else until
        self.struck = bool(chain.velocities[0] > 0.0) and chain.drive is None
        # Duration of a fall from rest, after which walls are watched; 0 without one.
        self.fall = fall_time(chain)
        # Whether the run ends at once if no larger force on the right wall can follow.
        self.at_peak = at_peak
        self.body: BodyWatch | None = None
        if chain.right_wall is None and chain.beads > 1:
            self.body = BodyWatch(chain, arrays)
        self.watch: WallWatch | None = None
        if any(chain.wall_stiffness):
            few = (fixed and until is not None) or (at_peak and motion_can_escape(chain, RIGHT))
            checks = FEW_CHECKS if few else CHECKS
            self.watch = WallWatch(chain, arrays, checks, fixed=fixed)

    def goal(self) -> tuple[float, bool]:
        """Time at which the next call ends, and whether it ends earlier if the pulse has left."""
        watch = self.watch
        if self.body is not None and self.body.left:
            return self.until, False
        if watch is None or watch.closed:
            return self.until, self.by_itself
        if watch.started:
            to_the_wall = not self.by_itself or self.chain.right_wall is not None
            return (min(self.until, watch.due), False) if to_the_wall else (self.until, True)
        if self.chain.drive is not None:
            return min(self.until, self.chain.drive.end), False
        return (min(self.until, self.fall), False) if self.fall else (self.until, self.struck)

    @property
    def steps(self) -> int:
        """Steps until the next check whether a wall was hit; very many if none is needed."""
        if self.body is not None and self.body.left:
            return STEPS_PER_CHECK
        looking = self.watch is not None and not self.watch.started
        if not looking or self.struck or self.fall or self.chain.drive is not None:
            return int(np.iinfo(np.int64).max)
        return STEPS_PER_LOOK - int(self.counts[state_layout.STEPS]) % STEPS_PER_LOOK

    def after(self, code: int, kernel: Any, forces: Array) -> Status | None:
        """Status of the run after a call of the loop returned a code; `None` if it continues."""
        endings: dict[int, Status] = {
            kernel.PULSE_LEFT: "pulse left",
            kernel.PULSE_LOST: "nothing more happens",
            kernel.TIME_REACHED: "time reached",
            kernel.STEP_TOO_SMALL: "step too small",
        }
        if (
            self.body is not None
            and self.chain._free_cap
            and self.by_itself
            and (self.body.left or code == kernel.PULSE_LEFT)
        ):
            return self._after_pulse(self.body, code, kernel, forces)
        if self.watch is None or code in (kernel.TIME_REACHED, kernel.STEP_TOO_SMALL):
            return endings.get(code)
        if code == kernel.PULSE_LOST:
            self.watch.close()
            return endings[code] if self.by_itself else None
        if code == kernel.PULSE_LEFT:
            if not self.watch.started:
                self.watch.start_after_pulse()
            return endings[code] if self.by_itself and self.chain.right_wall is None else None
        if code == kernel.LAST_STEP:
            return self._after_check(self.watch, forces)
        if self.steps == STEPS_PER_LOOK and self.watch.hit:
            self.watch.start_at(self.watch.time)
        return None

    def _after_pulse(self, body: BodyWatch, code: int, kernel: Any, forces: Array) -> Status | None:
        """Continue after the pulse has left until the force on the cap is complete."""
        body.left = True
        if code == kernel.STEP_TOO_SMALL:
            return "step too small"
        if body.complete(body.later(forces)) or code == kernel.PULSE_LOST or not body.bound.known:
            return "pulse left"
        return "transit limit" if body.expired else None

    def _after_check(self, watch: WallWatch, forces: Array) -> Status | None:
        """Start to watch walls after a drive or a fall, or check whether the peak is complete."""
        if not watch.started:
            if self.chain.drive is not None and self.chain.drive.end <= self.until:
                watch.start_at(self.chain.drive.end)
            elif 0.0 < self.fall <= self.until:
                watch.start_after_fall(self.fall)
            return None
        if watch.closed or watch.due > self.until:
            return None
        watch.check(forces)
        if not self.by_itself:
            return None
        if watch.closed:
            return "nothing more happens"
        if watch.ends_run(forces, at_peak=self.at_peak):
            return "wall force complete"
        return "transit limit" if watch.expired else None

    def assess(self, forces: Array) -> tuple[Array, Array]:
        """Motion that can reach each wall, its bound, the force, and whether the peak is complete.

        The first array, (5, 2), has the rows momentum, energy, bound and force at the end of the
        run, and the latest end of a run without a given end; the second one is (2,).  The left wall
        is first; NaN and false without a wall.  Without a right wall, its place has the bound of
        later forces on the last body, and whether the largest is complete.
        """
        approaches, complete = np.full((5, 2), np.nan), np.zeros(2, bool)
        if self.body is not None:
            with np.errstate(over="ignore", invalid="ignore"):
                later = self.body.later(forces)
            approaches[BOUND, RIGHT], complete[RIGHT] = later, self.body.complete(later)
        if self.watch is None:
            return approaches, complete
        with np.errstate(over="ignore", invalid="ignore"):  # with unstable steps
            reaching = self.watch.reaches(forces)
        for target, found in zip(self.watch.targets, reaching, strict=True):
            force = self.watch.force_on(target, forces)
            last = self.watch.last if self.watch.started else math.nan
            approaches[:, target.side] = found.momentum, found.energy, found.bound, force, last
            complete[target.side] = self.watch.complete(target, found)
        return approaches, complete
