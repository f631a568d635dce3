"""Recognise tapers with small beads between their beads, for descriptions of chains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..collision import Array
from .tapers import ROUNDING

# Small beads between two large ones, and large beads, of the rows that are searched for.
MOST_BETWEEN, MIN_LARGE = 6, 3


@dataclass(frozen=True)
class Decoration:
    """Large beads whose radii grow or shrink, and the small beads between them.

    The small beads have a ratio to the geometric mean of their large neighbours.
    """

    large: Array
    ratio: float
    between: int

    @property
    def words(self) -> str:
        """Such as ``decorated (ratio 0.4)`` or ``decorated (2 of ratio 0.4)``, without commas."""
        several = f"{self.between} of " if self.between > 1 else ""
        return f"decorated ({several}ratio {self.ratio:.4g})"


def decoration_of(radii: Array) -> Decoration | None:
    """The decoration of a row with ascending or descending large beads, if it is one."""
    for between in range(1, MOST_BETWEEN + 1):
        cell = between + 1
        large = radii[::cell]
        if (len(radii) - 1) % cell or len(large) < MIN_LARGE:
            continue
        steps = np.diff(large)
        if not (np.all(steps > 0.0) or np.all(steps < 0.0)):
            continue
        mean = np.sqrt(large[:-1]) * np.sqrt(large[1:])
        ratios = radii[:-1].reshape(-1, cell)[:, 1:] / mean[:, np.newaxis]
        equal = np.allclose(ratios, ratios[0, 0], rtol=ROUNDING, atol=0.0)
        if equal and np.all(radii[1::cell] < np.minimum(large[:-1], large[1:])):
            return Decoration(large, float(ratios[0, 0]), between)
    return None
