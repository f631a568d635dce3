"""Diameters of balls as they are given: a list, or a range of a catalogue."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..errors import InputError, short_repr
from ..validation.numbers import number, real_numbers
from .balls import SAME, Ball

EXAMPLES: Final = "a list such as ['4 mm', '6 mm'], or a range such as '4 mm to 16 mm'"
RANGE: Final = re.compile(r"(.+?)\s+to\s+(.+)")


@dataclass(frozen=True)
class SizeRange:
    """All diameters of a catalogue from ``low`` to ``high`` [m], both included."""

    low: float
    high: float

    def sizes(self, balls: Sequence[Ball], catalogue: str) -> tuple[float, ...]:
        """The diameters of these balls within the range, apart from rounding in catalogues."""
        known = sorted({each.diameter for each in balls})
        found = tuple(
            each for each in known if self.low * (1.0 - SAME) <= each <= self.high * (1.0 + SAME)
        )
        if found:
            return found
        low, high, first, last = (f"{1e3 * x:g} mm" for x in (self.low, self.high, known[0],
                                                              known[-1]))  # fmt: skip
        raise InputError(
            f"the catalogue {catalogue} has no diameters from {low} to {high}; its balls have "
            f"{first} to {last}"
        )


def given_diameters(given: Any) -> tuple[float, ...] | SizeRange:
    """A list of diameters [m], or a range."""
    if isinstance(given, str):
        return _range(given)
    if isinstance(given, Mapping | bytes) or not hasattr(given, "__iter__"):
        raise InputError(f"diameters must be {EXAMPLES}; got {short_repr(given)}")
    values = real_numbers("diameter", list(given), "ball", unit="m")
    return tuple(np.atleast_1d(values).tolist())


def _range(text: str) -> SizeRange:
    """The range of a text such as ``4 mm to 16 mm``, whose first unit can be omitted."""
    ends = RANGE.fullmatch(text.strip())
    if ends is None:
        raise InputError(f"diameters must be {EXAMPLES}; got {short_repr(text)}")
    unit = re.sub(r"^[\d.]+\s*", "", ends[2])
    first = f"{ends[1]} {unit}" if re.fullmatch(r"[\d.]+", ends[1]) else ends[1]
    low, high = (
        number(f"{which} diameter of the range {text!r}", each, unit="m", above=0.0)
        for which, each in (("smallest", first), ("largest", ends[2]))
    )
    if low > high:
        raise InputError(f"diameters = {text!r} begins above its end: exchange both")
    return SizeRange(low, high)
