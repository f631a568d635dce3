"""Find the cell of beads that a chain repeats."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

# Beads of the longest cell that is searched for.
MAX_CELL: Final = 12


def smallest_cell(*properties: NDArray[Any]) -> int | None:
    """Beads of the smallest cell, of at least two, after which all properties repeat exactly.

    Each property has one value per bead.  The last cell may be incomplete; `None` if there are
    fewer than two cells.
    """
    for size in range(2, min(MAX_CELL, len(properties[0]) // 2) + 1):
        if all(np.array_equal(values[size:], values[:-size]) for values in properties):
            return size
    return None
