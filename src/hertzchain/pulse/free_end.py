"""Last beads at free ends, whose values do not continue those of the beads before them."""

from __future__ import annotations

from typing import Final

from ..collision import Array
from .pulse import Pulse

# Quantities of a bead whose values at a free end are larger than those before it.
FREE: Final = ("velocity", "momentum", "energy")
# Smallest factor by which the last value exceeds the continuation of those before it.
JUMP: Final = 1.2


def ends_free(pulse: Pulse, quantity: str) -> bool:
    """Whether the last bead is much faster than the others, because nothing decelerates it."""
    return pulse.chain.right_wall is None and jumps_at_end(pulse.columns()[quantity], quantity)


def jumps_at_end(values: Array, quantity: str) -> bool:
    """Whether the last of the values at successive beads is far above the curve of the others."""
    if quantity not in FREE or len(values) < 3:
        return False
    return bool(values[-1] * values[-3] > JUMP * values[-2] ** 2)
