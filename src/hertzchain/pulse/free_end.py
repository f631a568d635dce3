"""Last beads at free ends, whose values do not continue those of the beads before them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..collision import Array
from .pulse import Pulse

# Quantities of a bead whose values at a free end are larger than those before it.
FREE: Final = ("velocity", "momentum", "energy")
# Smallest factor by which the last value exceeds the continuation of those before it.
JUMP: Final = 1.2


def ends_free(pulse: Pulse, quantity: str) -> bool:
    """Whether the last bead is much faster than the others, because nothing decelerates it."""
    values = pulse.column(quantity)
    return pulse.chain.right_wall is None and values is not None and jumps_at_end(values, quantity)


def split_free_ends(
    values: Array, beads: Array, quantity: str, percentiles: Sequence[float]
) -> tuple[Array, dict[int, Array]]:
    """Values of several chains without those of free ends, and the percentiles of the latter.

    ``values`` has one row per chain, ``beads`` their numbers of beads; the percentiles are by the
    number of the last bead.
    """
    values, ends = values.copy(), {}
    for count in map(int, np.unique(beads)):
        last = values[:, max(0, count - 3) : count]
        rows = np.flatnonzero((beads == count) & np.isfinite(last).all(axis=1))
        if len(rows) and jumps_at_end(np.median(last[rows], axis=0), quantity):
            ends[count] = np.percentile(last[rows, -1], percentiles)
            values[rows, count - 1] = np.nan
    return values, ends


def jumps_at_end(values: Array, quantity: str) -> bool:
    """Whether the last of the values at successive beads is far above the curve of the others."""
    if quantity not in FREE or len(values) < 3:
        return False
    return bool(values[-1] * values[-3] > JUMP * values[-2] ** 2)
