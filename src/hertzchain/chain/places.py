"""Places of a chain by number: ``"2:"``, ``"2::2"`` or a list."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, short_repr
from ..validation.numbers import whole_number
from ..validation.objects import check_list
from .fields import ChainFields


def places_from(
    given: Any, count: int, noun: str, *, end: int | None = None, advice: str = ""
) -> NDArray[np.int64]:  # fmt: skip
    """Indices, from 0, of beads or contacts; numbers are from 1, both ends included.

    A range without an end, such as ``"2:"``, ends at the number ``end``, by default the last one.
    The ``advice`` is added if a range is outside these numbers.
    """
    if isinstance(given, str):
        numbers = _range_of(given, count, noun, count if end is None else end, advice)
    else:
        listed = check_list(f"{noun}s", given, "numbers")
        numbers = [whole_number(f"{noun} number", k, least=1, most=count) for k in listed]
    if not numbers or len(set(numbers)) != len(numbers):
        reason = "names no" if not numbers else "repeats a"
        raise InputError(f"{noun}s = {short_repr(given)} {reason} {noun}: there are 1 to {count}")
    return np.array(sorted(numbers)) - 1


def _range_of(text: str, count: int, noun: str, end: int, advice: str) -> list[int]:
    parts = text.split(":")
    try:
        if not 1 <= len(parts) <= 3:
            raise ValueError
        first = int(parts[0]) if parts[0] else 1
        last = (int(parts[1]) if parts[1] else end) if len(parts) > 1 else first
        step = int(parts[2]) if len(parts) > 2 and parts[2] else 1
        if step < 1:
            raise ValueError
    except ValueError:
        raise InputError(
            f"{noun}s must be selected by number, as in '2', '2:', '2:20' or '2::2', where "
            f"strikers count, got {short_repr(text)}"
        ) from None
    if not 1 <= first <= last <= count:
        raise InputError(f"{noun}s = {text!r} is outside 1 to {count}{advice}")
    return list(range(first, last + 1, step))


def ball_places(chain: ChainFields, given: Any) -> NDArray[np.int64]:
    """Indices of beads, where a range without an end does not include a cap."""
    advice = ""
    if strikers := chain.strikers:
        which = "bead 1 is the striker" if strikers == 1 else f"beads 1 to {strikers} are strikers"
        first, last = strikers + 1, chain._balls.stop
        advice = f"; {which}, and the balls are beads {first} to {last}, or 'ball 1:'"
    return places_from(given, chain.beads, "bead", end=chain._balls.stop, advice=advice)
