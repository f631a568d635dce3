"""TOML: files read with errors of one sentence, and values written."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from typing import Any, Final

from hertzchain.arguments import file_path
from hertzchain.errors import InputError

# What a basic string escapes by a letter.
_LETTERS: Final = {'"': '\\"', "\\": "\\\\", "\b": "\\b", "\t": "\\t", "\n": "\\n", "\f": "\\f",
                   "\r": "\\r"}  # fmt: skip


def read_toml(what: str, path: str | os.PathLike[str], hint: str) -> dict[str, Any]:
    r"""Read a TOML file.

    Parameters
    ----------
    what : str
        What it is, such as ``"chain file"``.
    path : path-like
        The file.
    hint : str
        What to give if it cannot be read.

    Returns
    -------
    dict

    Raises
    ------
    InputError
        If it is missing, unreadable or not TOML; the file is named.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "chain.toml"
    ...     _ = file.write_text("[chain]\nbeads = 20\n")
    ...     read_toml("chain file", file, "give the path of a TOML file")
    {'chain': {'beads': 20}}
    """
    file, name = file_path(what, path), os.fspath(path)
    try:
        return tomllib.loads(file.read_text("utf-8-sig"))
    except OSError as error:
        raise InputError(f"cannot read {what} {name!r} ({error.strerror}); {hint}") from None
    except UnicodeDecodeError:
        raise InputError(f"{what} {name!r} is not UTF-8 text; write it as TOML in UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{what} {name!r} is not valid TOML: {error}") from None
    except RecursionError:
        raise InputError(f"{what} {name!r} is nested too deeply") from None
    except ValueError:
        # The only one left: Python reads no whole number of more than 4300 digits.
        raise InputError(f"{what} {name!r} has a whole number of thousands of digits") from None


def toml_text(value: Any) -> str:
    """A value as TOML writes it.

    Parameters
    ----------
    value : object
        Text, number, truth value, list or table of them.

    Returns
    -------
    str

    Examples
    --------
    >>> toml_text({"rigid": True, "gaps": [0.0, 1e-6], "a b": 'steel "hard"'})
    '{rigid = true, gaps = [0.0, 1e-06], "a b" = "steel \\\\"hard\\\\""}'
    """
    if isinstance(value, Mapping):
        items = (f"{toml_key(key)} = {toml_text(item)}" for key, item in value.items())
        return "{" + ", ".join(items) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml_text, value)) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    return _quoted(value) if isinstance(value, str) else repr(value)


def toml_key(name: str) -> str:
    """The name of a key or table, in quotation marks if it needs them.

    Parameters
    ----------
    name : str
        The name.

    Returns
    -------
    str

    Examples
    --------
    >>> toml_key("gap"), toml_key("my steel")
    ('gap', '"my steel"')
    """
    bare = name.isascii() and name.replace("-", "").replace("_", "").isalnum()
    return name if bare else _quoted(name)


def _quoted(text: str) -> str:
    return '"' + "".join(map(_escaped, text)) + '"'


def _escaped(character: str) -> str:
    if character in _LETTERS:
        return _LETTERS[character]
    if ord(character) < 0x20 or ord(character) == 0x7F:
        return f"\\u{ord(character):04x}"
    return character
