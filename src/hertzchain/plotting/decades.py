"""Scales of values that extend over decades."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..pulse.pulse import Pulse
from ..simulation.run import Run

# Quantities of a bead that grow or decay exponentially in a taper.
GROWING: Final = ("velocity", "momentum", "energy", "peak_force", "peak_overlap")
# Ratio of the largest to the smallest value from which small ones lie on a linear axis of zero.
DECADES: Final = 50.0
# Ratio of the largest velocity to the median of all beads from which most beads are pale in a map.
PALE: Final = 5.0
# Least velocity of a bead that a wave has reached, relative to the bead before it.
REACHED: Final = 1e-2


def extends_over_decades(pulses: Sequence[Pulse], quantity: str) -> bool:
    """Whether a linear axis would show most values of a quantity as zero."""
    if quantity not in GROWING:
        return False
    values = np.concatenate([each._predicted(quantity)[1:] for each in pulses])
    values = values[np.isfinite(values)]
    if not values.size or values.min() <= 0.0:
        return False
    return bool(values.max() >= DECADES * values.min())


def is_pale(run: Run) -> bool:
    """Whether a map of velocities would show most beads, all reached by the wave, as at rest."""
    largest = np.abs(run.velocities).max(axis=0)
    if (largest[1:] <= REACHED * largest[:-1]).any():
        return False
    return bool(largest.max() >= PALE * np.median(largest))
