"""Samples next to jumps of a simulated force.

A sample between the old and the new time of a jump changes by the whole jump: chi-squared is
not a smooth function of the parameters, and its derivatives do not determine their errors.
The last search of a fit therefore omits the samples next to jumps.
"""

from __future__ import annotations

import numpy as np

from ..collision import Array

# Samples on each side of a jump that are not used, and points of the grid within which a spline
# through the signal differs from it because of the jump (by a factor of 0.27 per point).
BESIDE, POINTS = 2, 8


def next_to_jumps(times: Array, signal: Array, spacing: float, least: float) -> Array:
    """Mask of the times next to jumps above a limit, of a signal on an even grid from 0."""
    # Two jumps within two intervals are one jump on a grid with every second point.
    grids = ((0, 1), (0, 2), (1, 2))
    jumps = np.concatenate([
        spacing * (begin + step * _jumps(signal[begin::step], least)) for begin, step in grids
    ])  # fmt: skip
    mask = np.zeros(len(times), bool)
    for jump in jumps[(jumps > times[0]) & (jumps < times[-1])].tolist():
        after = int(np.searchsorted(times, jump))
        mask[max(after - BESIDE, 0) : after + BESIDE] = True
        mask |= np.abs(times - jump) < POINTS * spacing
    return mask


def _jumps(signal: Array, least: float) -> Array:
    """Places of jumps in units of the spacing."""
    second = np.diff(signal, 2)
    # A jump gives two successive second differences of opposite sign; next to an inflection of a
    # smooth signal, these are at most a third of their larger neighbour.
    size = np.concatenate(([0.0], np.abs(second), [0.0]))
    smaller = np.minimum(size[2:-1], size[1:-2])
    neighbours = np.maximum(size[3:], size[:-3])
    there = (second[1:] * second[:-1] < 0.0) & (smaller > np.maximum(least, 0.5 * neighbours))
    return np.flatnonzero(there) + 1.5
