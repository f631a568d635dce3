"""Arguments that are no numbers: names, files, lists, objects, functions to call back."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hertzchain.errors import InputError, shown, unknown_name


def one_of(what: str, name: object, known: Iterable[str]) -> str:
    """A name, if it is one of those that exist.

    Parameters
    ----------
    what : str
        What kind of name it is.
    name : str
        What was given.
    known : iterable of str
        The names that exist.

    Returns
    -------
    str

    Raises
    ------
    InputError
        If it is none of them.

    Examples
    --------
    >>> one_of("colour", "red", ["red", "green"])
    'red'
    """
    choices = list(known)
    if isinstance(name, str) and name in choices:
        return name
    raise unknown_name(what, name, choices)


def instance(what: str, value: object, kind: type[Any], hint: str = "") -> None:
    """Refuse an object of another type.

    Parameters
    ----------
    what : str
        What it is.
    value : object
        What was given.
    kind : type
        What it must be.
    hint : str
        What to try instead.

    Raises
    ------
    InputError
        If it is of another type.

    Examples
    --------
    >>> instance("text", "a", str)
    """
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        advice = f"; {hint}" if hint else ""
        raise InputError(f"{what} must be {article} {kind.__name__}, got {shown(value)}{advice}")


def truth(what: str, value: object) -> bool:
    """A truth value: True or False, and nothing that could pass for one.

    Parameters
    ----------
    what : str
        What it decides.
    value : bool
        What was given.

    Returns
    -------
    bool

    Raises
    ------
    InputError
        If it is anything else.

    Examples
    --------
    >>> truth("check", True)
    True
    """
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{what} must be True or False, got {shown(value)}")
    return bool(value)


def text(what: str, value: object) -> str:
    """Text that is not empty.

    Parameters
    ----------
    what : str
        What it says.
    value : str
        What was given.

    Returns
    -------
    str

    Raises
    ------
    InputError
        If it is no text, or empty.

    Examples
    --------
    >>> text("name", "steel")
    'steel'
    """
    if not isinstance(value, str) or not value:
        raise InputError(f"{what} must be text, got {shown(value)}")
    return value


def listed(what: str, value: object, of: str) -> list[Any]:
    """The items of a list, or of anything else with items in a row.

    Parameters
    ----------
    what : str
        What the list is.
    value : iterable
        What was given; text and mappings are no lists.
    of : str
        What its items are.

    Returns
    -------
    list

    Raises
    ------
    InputError
        If it is no list.

    Examples
    --------
    >>> listed("beads", range(3), "bead numbers")
    [0, 1, 2]
    """
    try:
        if not isinstance(value, str | bytes | Mapping):
            return list(value)  # type: ignore[call-overload]
    except TypeError:
        pass
    raise InputError(f"{what} must be a list of {of}, got {shown(value)}")


def file_path(what: str, value: object) -> Path:
    """The path of a file or folder.

    Parameters
    ----------
    what : str
        What is there, or shall be.
    value : path-like
        What was given.

    Returns
    -------
    pathlib.Path

    Raises
    ------
    InputError
        If it is no path.

    Examples
    --------
    >>> file_path("chain file", "chain.toml").suffix
    '.toml'
    """
    if not isinstance(value, str | os.PathLike) or not _names_a_file(os.fspath(value)):
        raise InputError(f"{what} must be a path, such as 'name', got {shown(value)}")
    return Path(value)


def shown_path(path: str | os.PathLike[str]) -> str:
    """A path at the beginning of an error: as it is, if it can be printed on one line.

    Parameters
    ----------
    path : path-like
        The path.

    Returns
    -------
    str

    Examples
    --------
    >>> print(shown_path("chain.toml"), shown_path("two lines\\n.toml"))
    chain.toml 'two lines\\n.toml'
    """
    name = os.fspath(path)
    return name if name.isprintable() else repr(name)


def _names_a_file(text: str) -> bool:
    try:
        return bool(text) and b"\0" not in os.fsencode(text)
    except UnicodeEncodeError:
        return False


def callback(what: str, value: object) -> None:
    """Refuse what cannot be called, unless it is left out.

    Parameters
    ----------
    what : str
        What it is.
    value : callable or None
        What was given.

    Raises
    ------
    InputError
        If it cannot be called.

    Examples
    --------
    >>> callback("progress", print)
    """
    if value is not None and not callable(value):
        raise InputError(f"{what} must be a function of two numbers or None, got {shown(value)}")
