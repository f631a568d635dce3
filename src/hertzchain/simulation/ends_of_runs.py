"""Quantities of sensors and of the last body of a free end, as columns of tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..collision import Array
from ..pulse.quantities import BODY_QUANTITIES, SENSOR_QUANTITIES
from .body_force import body_force
from .run import Run
from .sensor_force import sensor_maxima

# Why a chain with a right wall has no force on a body.
ON_WALL: Final = (
    "body_force is that on the last body of a free right end, and this chain has a right wall: use "
    "wall_force.peak"
)


def sensors_of_run(run: Run, beads: Sequence[int]) -> dict[str, Array]:
    """Quantities of sensors."""
    rows = []
    for bead in beads:
        found = sensor_maxima(run, bead)
        first = found.first_maximum, found.first_maximum_time
        largest = found.largest_so_far, found.largest_so_far_time
        rows.append((*first, *largest, float(np.trapezoid(found.force, run.times))))
    return dict(zip(SENSOR_QUANTITIES, np.array(rows).reshape(len(beads), -1).T, strict=True))


def body_of_run(run: Run) -> dict[str, float]:
    """Quantities of the last body of a free end; NaN before the force has had a maximum."""
    body = body_force(run)
    return {
        name: np.nan if body is None else getattr(body, each.attribute)
        for name, each in BODY_QUANTITIES.items()
    }
