"""Relative differences of pulses, and whether they are visible beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..collision import Array
from ..pulse.pulse import Pulse

# Differences below this fraction of the largest ones are not visible on a linear axis.
HIDDEN: Final = 0.02
# ... and a curve, of at least this many beads, of which half are below this part of its largest.
DOMINATED: Final = 0.03
MIN_BEADS: Final = 8


def hidden_difference(differences: Sequence[Array]) -> float:
    """Size of differences that would not be visible beside others, otherwise 0.

    They are the largest of a curve, or the median of one in which a few beads exceed the others.
    """
    sizes = [np.abs(each[np.isfinite(each) & (each != 0.0)]) for each in differences]
    present = [float(each.max()) for each in sizes if len(each)]
    hidden = [each for each in present if each < HIDDEN * max(present)]
    medians = [float(np.median(each)) for each in sizes if len(each) >= MIN_BEADS]
    largest = [float(each.max()) for each in sizes if len(each) >= MIN_BEADS]
    pairs = zip(medians, largest, strict=True)
    hidden += [median for median, most in pairs if median < DOMINATED * most]
    return min(hidden, default=0.0)


def relative_difference(pulse: Pulse, reference: Pulse, quantity: str) -> Array:
    """Relative difference of two pulses in percent, at the beads that both have."""
    first, other = reference._predicted(quantity), pulse._predicted(quantity)
    both = min(len(first), len(other))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(100.0 * (other[:both] / first[:both] - 1.0))
