"""Whether a simulation agrees much better with data in which two columns are exchanged."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from ..collision import Array
from ..traces.signals import Shot
from .time_offsets import difference_at_best_offset

# An exchange is mentioned if it reduces the rms difference to less than this part.
MUCH_BETTER: Final = 0.5


def exchange_notes(shot: Shot, columns: Sequence[Array], spacing: float) -> list[str]:
    """A note if exchanging two columns reduces the differences to less than a half.

    The amplitude of each signal is free within a factor, as for the time offset.
    """
    signals = shot.signals
    if len(signals) < 2:
        return []
    own = difference_at_best_offset(shot, columns, spacing)
    found = {}
    for i, j in itertools.combinations(range(len(signals)), 2):
        exchanged = list(signals)
        exchanged[i] = replace(signals[j], place=signals[i].place)
        exchanged[j] = replace(signals[i], place=signals[j].place)
        found[i, j] = difference_at_best_offset(
            replace(shot, signals=tuple(exchanged)), columns, spacing
        )
    i, j = min(found, key=lambda pair: found[pair])
    if not found[i, j] < MUCH_BETTER * own:
        return []
    return [
        f"with the columns of {signals[i].name} and {signals[j].name} exchanged, the rms "
        f"difference falls to {found[i, j] / own:.0%}: check the names of these columns"
    ]
