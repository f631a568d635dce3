"""Reasons for missing values, with the numbers of the beads or contacts."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

# More runs of consecutive numbers than this are not listed; the numbers are counted instead.
LISTED = 3


def reason(place: str, absent: ArrayLike, why: str) -> str:
    """Describe where values are missing and why; empty if none is missing."""
    numbers = np.flatnonzero(absent) + 1
    if not len(numbers):
        return ""
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
    where = ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)
    if len(runs) > LISTED:
        where = f"{numbers[0]} to {numbers[-1]}, {len(numbers)} of them"
    return f"{place}{'s' * (len(numbers) > 1)} {where}: {why}"


def together(*reasons: str) -> str:
    """Join reasons, without empty ones."""
    return "; ".join(text for text in reasons if text)
