"""Largest overlaps between the saved times of a run, and contacts that still act."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..collision import Array

# An interpolated maximum counts if it exceeds the saved overlaps next to it by at most this
# fraction: if four times or more are saved during a contact.  Between fewer, it may be far from
# any overlap of the motion.
RESOLVED: Final = 0.1
# Overlap, relative to its maximum, below which a contact is regarded as open.
OPEN: Final = 1e-9


def still_closed(overlaps: Array, largest: Array, forces: Array | None) -> Array:
    """Whether contacts act, from their overlaps and, if these are known, their forces."""
    closed = np.asarray(overlaps > OPEN * largest)
    # Contacts with losses that do not attract are released before their overlap vanishes.
    return closed if forces is None else closed & (forces != 0.0)


def largest_between(times: Array, overlaps: Array, velocities: Array) -> Array:
    """Largest overlaps by contact, by cubic Hermite interpolation between the saved times.

    Contacts with walls are not interpolated; the compiled loop records their largest forces.
    """
    found = np.max(overlaps, axis=0, initial=0.0)
    if len(times) < 2:
        return found
    rates = -np.diff(np.pad(velocities, ((0, 0), (1, 1))), axis=1)
    turns = (rates[:-1] > 0.0) & (rates[1:] < 0.0) & (np.minimum(overlaps[:-1], overlaps[1:]) > 0.0)
    turns[:, [0, -1]] = False
    rows, contacts = np.nonzero(turns)
    h, low = np.diff(times)[rows], overlaps[rows, contacts]
    c1, end = h * rates[rows, contacts], h * rates[rows + 1, contacts]
    rise = overlaps[rows + 1, contacts] - low
    c2, c3 = 3.0 * rise - 2.0 * c1 - end, c1 + end - 2.0 * rise
    root = np.sqrt(np.maximum(c2 * c2 - 3.0 * c1 * c3, 0.0))
    # Both formulas give the maximum; each avoids cancellation for one sign of c2.
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.where(c2 > 0.0, -(c2 + root) / (3.0 * c3), c1 / (root - c2))
    # Squares of the numbers at the foot of a pulse may underflow, and rounding errors of the rise
    # may contradict the rates.
    s = np.nan_to_num(np.clip(s, 0.0, 1.0))
    peaks, seen = low + s * (c1 + s * (c2 + s * c3)), np.maximum(low, low + rise)
    np.maximum.at(found, contacts, np.where(peaks <= (1.0 + RESOLVED) * seen, peaks, seen))
    return found
