"""Columns that are probably exchanged, from the differences of all signals at the best offset."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from ..collision import Array
from ..traces.signals import Shot
from .time_offsets import coarse_offset

# An exchange is mentioned if it reduces the rms difference to less than this part.
MUCH_BETTER: Final = 0.5


def exchange_notes(shot: Shot, columns: Sequence[Array], spacing: float) -> list[str]:
    """A note if exchanging two columns reduces the differences to less than a half.

    The amplitude of each signal is free within a factor, as for the time offset.  Samples beyond
    the run, which neither order explains, do not count.
    """
    signals = shot.signals
    if len(signals) < 2:
        return []
    pairs = itertools.combinations(range(len(signals)), 2)
    found = [(*coarse_offset(_exchanged(shot, *pair), columns, spacing), pair) for pair in pairs]
    _, offset, (i, j) = min(found)
    covered = _until(shot, offset + spacing * (len(columns[0]) - 1))
    own, _ = coarse_offset(covered, columns, spacing)
    best, _ = coarse_offset(_exchanged(covered, i, j), columns, spacing)
    if not best < MUCH_BETTER * own:
        return []
    return [
        f"with the columns of {signals[i].name} and {signals[j].name} exchanged, the rms "
        f"difference falls to {best / own:.0%} of its value: check the names of these columns"
    ]


def _exchanged(shot: Shot, i: int, j: int) -> Shot:
    """The shot in which two places have each other's samples."""
    signals = list(shot.signals)
    signals[i] = replace(shot.signals[j], place=shot.signals[i].place)
    signals[j] = replace(shot.signals[i], place=shot.signals[j].place)
    return replace(shot, signals=tuple(signals))


def _until(shot: Shot, end: float) -> Shot:
    """The shot until a time."""
    part = slice(0, int((shot.times <= end).sum()))
    signals = tuple(
        replace(each, values=each.values[part], valid=each.valid[part]) for each in shot.signals
    )
    return replace(shot, times=shot.times[part], signals=signals)
