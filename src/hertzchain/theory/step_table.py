"""The table of the effects of steps and odd beads, which `tools/step_tables.py` writes."""

from __future__ import annotations

import functools
import math
from typing import Final

import numpy as np

from ..collision import Array
from .table_files import stored_arrays
from .table_weights import spline_weights

# Rates on both sides, and logarithms of the ratio of radii.
RATES: Final = (-0.06, -0.03, -0.012, 0.0, 0.012, 0.03, 0.06)
LOG_RATIOS: Final = tuple(math.log(2.0) * n / 8 for n in range(-9, 10))
# Contacts before the step, the step included, and after it, that the table describes.
BEFORE, AFTER = 6, 34


@functools.cache
def step_table() -> dict[str, Array]:
    """Changes of ln v and ln d and ratios of T, of ``step`` and ``odd`` bead.

    Each has the shape (rates before, rates after, ratios, 3, contacts).
    """
    return stored_arrays("step_table.npz")


def jump_effect(kind: str, rates: tuple[float, float], log_ratio: float) -> Array:
    """Effect of a ``"step"`` or an ``"odd"`` bead between two rates, shape (3, contacts)."""
    values = step_table()[kind]
    for nodes, x in ((RATES, rates[0]), (RATES, rates[1]), (LOG_RATIOS, log_ratio)):
        values = np.tensordot(spline_weights(nodes, x), values, axes=1)
    return np.asarray(values)
