"""Level, largest value and sign of a signal."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..collision import Array
from .signals import Signal

# A signal has arrived at this fraction of its largest value.
ARRIVED: Final = 0.5


def level_of(signal: Signal) -> float:
    """Level of a signal before the pulse; 0 if it is not known."""
    return signal.level if np.isfinite(signal.level) else 0.0


def from_level(signal: Signal) -> Array:
    """Samples from the level before the pulse; 0 where they are missing."""
    return np.where(np.isfinite(signal.values), signal.values - level_of(signal), 0.0)


def polarity_of(signal: Signal) -> float:
    """-1 for a force whose largest value is negative, which contacts cannot exert; otherwise 1."""
    return -1.0 if signal.place.quantity == "force" and extreme(from_level(signal)) < 0.0 else 1.0


def first_sign(values: Array) -> float:
    """Sign of the first value beyond half of the largest; waves that return may have another."""
    size = np.abs(values)
    return math.copysign(1.0, values[np.argmax(size > ARRIVED * size.max())])


def extreme(values: Array) -> float:
    """The value that is largest without its sign."""
    return float(values[np.argmax(np.abs(values))])
