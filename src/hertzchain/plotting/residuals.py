"""Relative differences of pulses, and whether they are visible beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..collision import Array
from ..pulse.pulse import Pulse

# Differences below this fraction of the largest ones are not visible on a linear axis.
HIDDEN: Final = 0.02


def hidden_difference(differences: Sequence[Array]) -> float:
    """Largest difference of the curve that would not be visible beside others, otherwise 0."""
    largest = [float(np.nanmax(np.abs(each), initial=0.0)) for each in differences]
    present = [each for each in largest if each > 0.0]
    return min(present) if present and min(present) < HIDDEN * max(present) else 0.0


def relative_difference(pulse: Pulse, reference: Pulse, quantity: str) -> Array:
    """Relative difference of two pulses in percent, at the beads that both have."""
    first, other = reference._predicted(quantity), pulse._predicted(quantity)
    both = min(len(first), len(other))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(100.0 * (other[:both] / first[:both] - 1.0))
