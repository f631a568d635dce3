"""Find the cell of beads that a chain repeats."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

# Beads of the longest cell that is searched for.
MAX_CELL: Final = 12


def smallest_cell(
    *properties: NDArray[Any], least: int = 2, most: int = MAX_CELL, rtol: float = 0.0
) -> int | None:
    """Beads of the smallest cell, from ``least`` to ``most``, after which all properties repeat.

    The first property has one value per bead.  The last cell may be incomplete; `None` if there
    are fewer than two cells.
    """
    for size in range(least, min(most, len(properties[0]) // 2) + 1):
        if cell_repeats(size, *properties, rtol=rtol):
            return size
    return None


def cell_repeats(size: int, *properties: NDArray[Any], rtol: float = 0.0) -> bool:
    """Whether all values repeat after a cell of this size, exactly or to a relative tolerance."""
    pairs = ((values[size:], values[:-size]) for values in properties)
    if rtol:
        return all(np.allclose(*pair, rtol=rtol, atol=0.0) for pair in pairs)
    return all(np.array_equal(*pair) for pair in pairs)
