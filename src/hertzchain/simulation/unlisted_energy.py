"""Energy flux of contacts that is in no listed wave."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..collision import Array

# Part of the energy in no wave that is announced at more than this number of contacts in a row.
UNLISTED, MEETING = 0.5, 5
NO_WAVE: Final = "{:.0%} of the energy flux at contact {} is in no listed wave"
ADVICE: Final = "; use run.energy_flux() or waves.at(k)"


def unlisted_in_words(parts: Array) -> str:
    """Sentence on contacts where most of the energy is in no listed wave, or nothing."""
    missed = np.concatenate(([False], parts > UNLISTED, [False]))
    begin, end = np.flatnonzero(np.diff(missed.astype(int))).reshape(-1, 2).T
    # Where waves meet, or a wall reflects one, a few contacts have maxima without a direction.
    long = end - begin > min(MEETING, len(parts) - 1)
    if not long.any():
        return ""
    longest = zip(begin[long], end[long], strict=True)
    contacts = np.concatenate([np.arange(*each) for each in longest])
    worst = int(contacts[np.argmax(parts[contacts])])
    most = NO_WAVE.format(parts[worst], worst + 1)
    count = f"{len(contacts)} of {len(parts)} contacts"
    return f"{most}, and more than half at {count}{ADVICE}"
