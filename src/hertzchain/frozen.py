"""Objects with read-only arrays, also in copies."""

from __future__ import annotations

from typing import Any

import numpy as np


class Frozen:
    """Keeps the arrays of a frozen dataclass read-only in copies and after unpickling.

    Copies and unpickled arrays of NumPy are writable, even if the original is read-only.  The
    radii of a copied chain could then be changed without changing its masses.
    """

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
        self.__dict__.update(state)
