"""Time that the points of a sweep take, from a sample of them."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Final

from .batches import run_planned
from .plan import Plan
from .specification import Specification

# Batches of about the second time are timed for the first one [s].
SAMPLE_SECONDS, BATCH_SECONDS = 5.0, 0.2
# Time of a batch [s] that is measured again.
SUSPICIOUS: Final = 1.0
GOLDEN: Final = 0.5 * (5.0**0.5 - 1.0)


def time_per_point(spec: Specification) -> float:
    """Mean time of a point [s], from small batches that are spread over the whole grid.

    Points at the ends of axes, such as long chains, may take ten times as long as others.  The
    golden section avoids that all samples have the same place along the last axes.
    """
    # The first point compiles the kernels.
    alone = Plan(replace(spec, batch=1))
    time_of_batch(alone, 0)
    each = time_after_compiling(alone, alone.batches // 2)
    most = sum(1 for _ in Plan(spec).indices(0))
    small = Plan(replace(spec, batch=max(1, min(most, int(BATCH_SECONDS / max(each, 1e-9))))))
    spent, points = 0.0, 0
    for i in range(small.batches):
        if spent >= SAMPLE_SECONDS:
            break
        batch = int(small.batches * ((0.5 + i * GOLDEN) % 1.0))
        spent += time_after_compiling(small, batch)
        points += sum(1 for _ in small.indices(batch))
    return spent / points


def time_after_compiling(plan: Plan, batch: int) -> float:
    """Time of a batch [s], measured again if it is so long that kernels were probably compiled.

    Other points, such as those without losses, may need other kernels than the first one.
    """
    first = time_of_batch(plan, batch)
    return first if first < SUSPICIOUS else min(first, time_of_batch(plan, batch))


def time_of_batch(plan: Plan, batch: int) -> float:
    """Time in which a batch is computed [s]."""
    begun = time.perf_counter()
    run_planned(plan, batch, lambda: False)
    return time.perf_counter() - begun
