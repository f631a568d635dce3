"""What people give as a specification, in the types that JSON has, or refused with its place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from hertzchain.errors import InputError, shown

# Tables and lists within each other, at most.
DEPTH: Final = 20


def plain_json(given: Any, place: str = "") -> Any:
    """The same in tables, lists, numbers, text and truth values; arrays become lists.

    Parameters
    ----------
    given : object
        Nested tables, lists, arrays, numbers and text.
    place : str
        Where it is, for the error.

    Returns
    -------
    object

    Raises
    ------
    InputError
        If there is anything else in it, a number is not finite, or a whole one has more than
        63 bits.

    Examples
    --------
    >>> plain_json({"beads": (20, 40), "rates": np.array([0.5])})
    {'beads': [20, 40], 'rates': [0.5]}
    """
    return _plain(given, place, 0)


def _plain(given: Any, place: str, depth: int) -> Any:
    if depth > DEPTH:
        raise InputError(f"{place} is nested too deeply: at most {DEPTH} tables and lists")
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
        if not math.isfinite(given):
            raise InputError(f"{place} is {given:g}: it must be finite".strip())
        return float(given)
    if isinstance(given, str):
        return _text(given, place)
    raise InputError(
        f"{place} is {shown(given)}, which cannot stand in a specification: give numbers, text, "
        "lists or tables".strip()
    )


def _key(key: object, place: str) -> str:
    if not isinstance(key, str | int) or isinstance(key, bool):
        raise InputError(f"{place} has the key {shown(key)}: it must be text".strip())
    return _text(str(key), place)


def _text(given: str, place: str) -> str:
    try:
        given.encode()
    except UnicodeEncodeError:
        raise InputError(f"{place} is {shown(given)}, which is not valid text".strip()) from None
    return str(given)
