"""Bisection of several intervals side by side."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..collision import Array


def bisected(below: Callable[[Array], Array], low: Array, high: Array, halvings: int) -> Array:
    """Find where a condition that is true at ``low`` becomes false, in each interval."""
    low, high = np.broadcast_arrays(low, high)
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        inside = below(middle)
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return np.asarray(0.5 * (low + high))
