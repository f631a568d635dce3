"""Reasons for values that do not exist, with the beads or contacts that they are missing at."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

# More runs of consecutive numbers than this are counted instead of listed.
LISTED = 3


def reason(place: str, absent: ArrayLike, why: str) -> str:
    """Where something is absent and why, or nothing if it is absent nowhere.

    Parameters
    ----------
    place : str
        ``"bead"`` or ``"contact"``.
    absent : array_like of bool
        Where, counted from 1.
    why : str
        Why.

    Returns
    -------
    str

    Examples
    --------
    >>> reason("bead", [False, True, False, True, True, True], "not reached")
    'beads 2, 4 to 6: not reached'
    """
    numbers = np.flatnonzero(absent) + 1
    if not len(numbers):
        return ""
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
    where = ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)
    if len(runs) > LISTED:
        where = f"{numbers[0]} to {numbers[-1]}, {len(numbers)} of them"
    return f"{place}{'s' * (len(numbers) > 1)} {where}: {why}"


def together(*reasons: str) -> str:
    """Several reasons as one, without the empty ones.

    Parameters
    ----------
    *reasons : str
        What `reason` gave.

    Returns
    -------
    str

    Examples
    --------
    >>> together("bead 1: not struck", "", "bead 9: not reached")
    'bead 1: not struck; bead 9: not reached'
    """
    return "; ".join(text for text in reasons if text)
