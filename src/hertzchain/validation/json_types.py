"""Convert specifications, whose errors name the path of a value, and results to JSON types."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from ..errors import InputError, short_repr

# Largest number of nested tables and lists.
MAX_DEPTH: Final = 20
# The infinite radius of a flat striker, which JSON cannot represent as a number.
FLAT: Final = "inf"
# Text for this radius or diameter in files and calls.
FLAT_FACES: Final = (FLAT, "flat")


def to_json_types(given: Any, place: str = "") -> Any:
    """Convert to tables, lists, numbers, text and truth values; arrays become lists."""
    return _plain(given, place, 0)


def finite(item: Any) -> Any:
    """The item with plain numbers, and None instead of those that JSON cannot represent."""
    if isinstance(item, Mapping):
        return {key: finite(value) for key, value in item.items()}
    if isinstance(item, list | tuple):
        return [finite(value) for value in item]
    if isinstance(item, np.generic):
        return finite(item.item())
    return item if not isinstance(item, float) or math.isfinite(item) else None


def _plain(given: Any, place: str, depth: int) -> Any:
    if depth > MAX_DEPTH:
        raise InputError(f"{place} is nested too deeply: at most {MAX_DEPTH} tables and lists")
    if isinstance(given, np.ndarray | np.generic):
        given = given.tolist()
    elif hasattr(given, "to_numpy"):
        given = given.to_numpy().tolist()
    if isinstance(given, Mapping):
        return {_key(key, place): _plain(value, f"{place}.{key}" if place else str(key), depth + 1)
                for key, value in given.items()}  # fmt: skip
    if isinstance(given, list | tuple):
        return [_plain(value, f"{place} value {number}".strip(), depth + 1)
                for number, value in enumerate(given, start=1)]  # fmt: skip
    if isinstance(given, bool):
        return given
    if isinstance(given, int):
        if abs(given) >= 2**63:
            raise InputError(f"{place} is too large: whole numbers have at most 63 bits".strip())
        return int(given)
    if isinstance(given, float):
        if given == math.inf and place.endswith((".radius", ".diameter")):
            return FLAT
        if not math.isfinite(given):
            hint = "; infinite lengths are text, such as 'inf mm'" if math.isinf(given) else ""
            raise InputError(f"{place} is {given:g}: it must be finite{hint}".strip())
        return float(given)
    if isinstance(given, str):
        return _text(given, place)
    raise InputError(
        f"{place} is {short_repr(given)}, which a specification cannot hold: "
        "give numbers, text, lists or tables"
    )


def _key(key: object, place: str) -> str:
    if not isinstance(key, str | int) or isinstance(key, bool):
        raise InputError(f"{place} has the key {short_repr(key)}: it must be text".strip())
    return _text(str(key), place)


def _text(given: str, place: str) -> str:
    try:
        given.encode()
    except UnicodeEncodeError:
        raise InputError(
            f"{place} is {short_repr(given)}, which is not valid text".strip()
        ) from None
    return str(given)
