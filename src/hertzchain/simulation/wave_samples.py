"""How many times a run must save so that its waves are resolved."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from ..collision import Array
from .trajectory import Trajectory

# Saved times within impulse/amplitude, the duration of a wave.
MIN_SAMPLES: Final = 8.0
# Contacts that the shortest listed wave passes.
SHORTEST: Final = 3
# Estimated durations over those of simulated waves were at most 1.04 for waves, and 1.14 at single
# contacts, both under precompression; the rest covers the rounding of the number of times.
SPARE: Final = 1.2


def times_to_save(run: Trajectory, samples: float, least: float = MIN_SAMPLES) -> int:
    """Approximate number of times to save to resolve a wave with these samples."""
    return _rounded(1.1 * _kept(run) * len(run.times) * least / samples)


def enough_times(run: Trajectory, contacts: Sequence[int] | None = None) -> int:
    """Number of times that resolves all waves of a run, or those at some contacts.

    Waves that few saved times do not show are included, because the number follows from the largest
    overlaps, which do not depend on these times; 0 if no contact was compressed.
    """
    durations = _shortest_durations(run)
    # The samples of a wave are the median along its track.
    groups = np.lib.stride_tricks.sliding_window_view(durations, min(SHORTEST, len(durations)))
    each = np.median(groups, axis=1) if contacts is None else durations[list(contacts)]
    shortest = float(np.min(each, initial=np.inf))
    if not 0.0 < shortest < np.inf:
        return 0
    whole = float(run.times[-1] - run.times[0])
    return _rounded(SPARE * _kept(run) * MIN_SAMPLES * whole / shortest)


def _shortest_durations(run: Trajectory) -> Array:
    r"""Shortest duration, impulse over largest force, of waves at each contact, shape (N + 1,).

    That of a half sine with the frequency of one bead between its neighbours at rest, with the
    stiffness of both contacts at their largest overlaps, is :math:`2\sqrt{m/(K_{k-1} + K_k)}`.
    """
    chain, overlaps = run.chain, np.nan_to_num(run.largest_overlaps)
    p, stiffness = chain.contact_exponents, chain.contact_stiffness
    closed = (overlaps > 0.0) & (stiffness > 0.0)
    slopes = np.where(closed, p * stiffness * np.where(closed, overlaps, 1.0) ** (p - 1.0), 0.0)
    around = slopes[:-1] + slopes[1:]
    moved = around > 0.0
    beads = np.where(moved, 2.0 * np.sqrt(chain.masses / np.where(moved, around, 1.0)), np.inf)
    ends = np.array([np.inf])
    return np.minimum(np.concatenate((ends, beads)), np.concatenate((beads, ends)))


def _kept(run: Trajectory) -> float:
    """Requested over saved times: without a given end, a run keeps between half and all of them."""
    return 1.0 if run.status == "time reached" else 2.0


def _rounded(needed: float) -> int:
    """The number, rounded upwards to two digits."""
    step = 10.0 ** (math.floor(math.log10(needed)) - 1)
    return int(math.ceil(needed / step) * step)
