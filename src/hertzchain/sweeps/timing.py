"""Time that the points of a sweep take, from a sample of them."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Final, NamedTuple

from .batches import Stopped, run_planned
from .plan import Plan
from .specification import Specification

# Batches of about the second time are timed for the first one [s].
SAMPLE_SECONDS, BATCH_SECONDS = 5.0, 0.2
# Time of a batch [s] that is measured again.
SUSPICIOUS: Final = 1.0
# Time of a point [s] after which it is not finished, and longest time between two calls that is
# not compiling.
LONGEST: Final = 10.0
CALLED: Final = 1.0
GOLDEN: Final = 0.5 * (5.0**0.5 - 1.0)


class PointTime(NamedTuple):
    """Mean time of a point [s]; a lower bound if a timed point was not finished."""

    seconds: float
    unfinished: bool = False


def time_per_point(spec: Specification) -> PointTime:
    """Mean time of a point, from small batches that are spread over the whole grid.

    Points at the ends of axes, such as long chains, may take ten times as long as others.  The
    golden section avoids that all samples have the same place along the last axes.
    """
    # The first point compiles the kernels.
    alone = Plan(replace(spec, batch=1))
    if time_of_batch(alone, 0) == math.inf:
        return PointTime(LONGEST, unfinished=True)
    each = time_after_compiling(alone, alone.batches // 2)
    most = sum(1 for _ in Plan(spec).indices(0))
    small = Plan(replace(spec, batch=max(1, min(most, int(BATCH_SECONDS / max(each, 1e-9))))))
    spent, points, unfinished = 0.0, 0, False
    for i in range(small.batches):
        if spent >= SAMPLE_SECONDS:
            break
        batch = int(small.batches * ((0.5 + i * GOLDEN) % 1.0))
        seconds = time_after_compiling(small, batch)
        unfinished = unfinished or seconds == math.inf
        spent += min(seconds, LONGEST)
        points += sum(1 for _ in small.indices(batch))
    return PointTime(spent / points, unfinished)


def time_after_compiling(plan: Plan, batch: int) -> float:
    """Time of a batch [s], measured again if it is so long that kernels were probably compiled.

    Other points, such as those without losses, may need other kernels than the first one.
    """
    first = time_of_batch(plan, batch)
    return first if not SUSPICIOUS <= first < math.inf else min(first, time_of_batch(plan, batch))


def time_of_batch(plan: Plan, batch: int) -> float:
    """Time in which a batch is computed [s]; infinite if it takes longer than `LONGEST`."""
    begun = time.perf_counter()
    try:
        run_planned(plan, batch, _Limit())
    except Stopped:
        return math.inf
    return time.perf_counter() - begun


class _Limit:
    """Whether `LONGEST` has passed since the first call, without the time for compiling."""

    def __init__(self) -> None:
        self.spent, self.last = 0.0, time.perf_counter()

    def __call__(self) -> bool:
        now = time.perf_counter()
        # Kernels are asked several times a second whether to stop, the compiler is not.
        self.spent += min(now - self.last, CALLED)
        self.last = now
        return self.spent > LONGEST
