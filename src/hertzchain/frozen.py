"""Objects whose arrays cannot be written to, and neither can those of their copies."""

from __future__ import annotations

from typing import Any

import numpy as np


class Frozen:
    """Keeps the arrays of a frozen dataclass read-only in copies and after unpickling.

    NumPy forgets that an array was read-only when it is copied or pickled, so that the radii of a
    copied chain could be changed while its masses stayed.
    """

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
        self.__dict__.update(state)
