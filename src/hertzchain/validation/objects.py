"""Check names, files, lists, objects and callbacks."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ..errors import InputError, short_repr, unknown_name_error

# A function that is called with the amount done and the total.
Progress: TypeAlias = Callable[[int, int], None]


def check_choice(what: str, name: object, known: Iterable[str]) -> str:
    """Check that a name is one of the known names."""
    choices = list(known)
    if isinstance(name, str) and name in choices:
        return name
    raise unknown_name_error(what, name, choices)


def check_type(what: str, value: object, kind: type[Any], hint: str = "") -> None:
    """Check the type of an object."""
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        advice = f"; {hint}" if hint else ""
        raise InputError(
            f"{what} must be {article} {kind.__name__}, got {short_repr(value)}{advice}"
        )


def check_bool(what: str, value: object) -> bool:
    """Check that a value is a boolean, not 0, 1 or another object with a truth value."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{what} must be True or False, got {short_repr(value)}")
    return bool(value)


def text(what: str, value: object) -> str:
    """Check that a value is text and not empty."""
    if not isinstance(value, str) or not value:
        raise InputError(f"{what} must be text, got {short_repr(value)}")
    return value


def check_list(what: str, value: object, of: str) -> list[Any]:
    """Convert any iterable other than text, bytes and mappings to a list."""
    try:
        if not isinstance(value, str | bytes | Mapping):
            return list(value)  # type: ignore[call-overload]
    except TypeError:
        pass
    raise InputError(f"{what} must be a list of {of}, got {short_repr(value)}")


def file_path(what: str, value: object) -> Path:
    """Check that a value can be the path of a file or folder."""
    if not isinstance(value, str | os.PathLike) or not _names_a_file(os.fspath(value)):
        raise InputError(f"{what} must be a path, such as 'name', got {short_repr(value)}")
    return Path(value)


def shown_path(path: str | os.PathLike[str]) -> str:
    """A path for a message: unchanged if it can be printed on one line."""
    name = os.fspath(path)
    return name if name.isprintable() else repr(name)


def _names_a_file(text: str) -> bool:
    try:
        return bool(text) and b"\0" not in os.fsencode(text)
    except UnicodeEncodeError:
        return False


def callback(what: str, value: object) -> None:
    """Check that a value can be called or is None."""
    if value is not None and not callable(value):
        raise InputError(
            f"{what} must be a function of two numbers or None, got {short_repr(value)}"
        )
