"""Rows that are missing in a record whose samples are otherwise evenly spaced."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ..collision import Array
from ..representation import counted, listed, measure
from .signals import Shot, Signal

# Steps are even if they differ from the usual one by less than this part of it, which allows for
# rounded times; those above the multiple LONG are gaps.
EVEN, LONG = 0.1, 1.9
# Largest part of the steps that are gaps; otherwise, the record is sampled unevenly on purpose.
FEW: Final = 0.1
# Largest number of gaps that a note lists.
LISTED: Final = 3


@dataclass(frozen=True)
class Gap:
    """Successive rows that are missing.

    Attributes
    ----------
    before : int
        Index of the last sample before the gap.
    rows : int
        Number of missing rows.
    first, last : float
        Times of the first and last of them [s].
    """

    before: int
    rows: int
    first: float
    last: float

    def __str__(self) -> str:
        first, last = (measure(each, "s", digits=6) for each in (self.first, self.last))
        return f"at {first}" if self.rows == 1 else f"from {first} to {last}"


def gaps_between(times: Array) -> list[Gap]:
    """Gaps between times that are otherwise evenly spaced; none if the spacing varies."""
    steps = np.diff(times)
    usual = float(np.median(steps))
    long = steps > LONG * usual
    even = np.abs(steps - usual) < EVEN * usual
    if not np.all(long | even) or np.mean(long) > FEW:
        return []
    return [
        Gap(
            int(at), max(round(steps[at] / usual) - 1, 1),
            float(times[at] + usual), float(times[at + 1] - usual),
        )
        for at in np.flatnonzero(long)
    ]  # fmt: skip


def gap_notes(gaps: Sequence[Gap], number: int | None = None) -> list[str]:
    """A note on missing rows, with the number of the shot if there may be several."""
    if not gaps:
        return []
    rows = sum(each.rows for each in gaps)
    where = [str(each) for each in gaps[:LISTED]]
    if len(gaps) > LISTED:
        where.append(f"in {counted(len(gaps) - LISTED, 'further gap')}")
    shot = "" if number is None else f" in shot {number}"
    verb = "is" if rows == 1 else "are"
    return [f"{counted(rows, 'row')} of the data {verb} missing{shot} {listed(where)}"]


def with_missing_samples(shot: Shot) -> Shot:
    """The shot with missing samples in place of rows that are missing.

    A long gap has at most as many samples as the record.
    """
    gaps, times = gaps_between(shot.times), shot.times
    if not gaps:
        return shot
    filled = [np.linspace(each.first, each.last, min(each.rows, len(times))) for each in gaps]
    at = np.repeat([each.before + 1 for each in gaps], list(map(len, filled)))
    return replace(
        shot,
        times=np.insert(times, at, np.concatenate(filled)),
        signals=tuple(_with_missing(each, at) for each in shot.signals),
    )


def _with_missing(signal: Signal, at: Array) -> Signal:
    """The signal with missing samples at these indices."""
    return replace(
        signal,
        values=np.insert(signal.values, at, np.nan),
        valid=np.insert(signal.valid, at, False),
        before=signal.before + int(np.sum(at < signal.before)),
        spikes=tuple(i + int(np.sum(at <= i)) for i in signal.spikes),
    )
