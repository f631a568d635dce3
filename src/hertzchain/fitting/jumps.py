"""Samples next to jumps of a simulated force.

A sample between the old and the new time of a jump changes by the whole jump, so that chi-squared
is not a smooth function of the parameters, and its derivatives say nothing about their errors.
Fits therefore end without the samples next to a jump.
"""

from __future__ import annotations

import numpy as np

from ..collision import Array

# Samples on each side of a jump that are not used, and points of the grid within which a spline
# through the signal differs from it because of the jump (by a factor of 0.27 per point).
BESIDE, POINTS = 2, 8


def next_to_jumps(times: Array, signal: Array, spacing: float, least: float) -> Array:
    """Mask of the times next to jumps by more than a limit, of a signal on an even grid from 0."""
    second = np.diff(signal, 2)
    # A jump gives two successive second differences of opposite sign, a smooth signal does not.
    smaller = np.minimum(np.abs(second[1:]), np.abs(second[:-1]))
    there = (second[1:] * second[:-1] < 0.0) & (smaller > least)
    jumps = spacing * (np.flatnonzero(there) + 1.5)
    inside = (jumps > times[0]) & (jumps < times[-1])
    mask = np.zeros(len(times), bool)
    for jump in jumps[inside].tolist():
        after = int(np.searchsorted(times, jump))
        mask[max(after - BESIDE, 0) : after + BESIDE] = True
        mask |= np.abs(times - jump) < POINTS * spacing
    return mask
