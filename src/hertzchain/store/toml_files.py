"""Read TOML files, with errors of one sentence, and write values as TOML."""

from __future__ import annotations

import json
import os
import re
import tomllib
from collections.abc import Mapping
from typing import Any, Final

from ..errors import InputError
from ..units import quantity
from ..validation.objects import file_path

# Place of an error; a number and its key before this place, and a unit after it.
_PLACE: Final = re.compile(r"at line (\d+), column (\d+)")
_NUMBER: Final = re.compile(r"(?<![\w.+-])((?:[\w.-]+ *= *)?)([+-]?\d[\w.+-]*?) *$")
_TRUTH: Final = re.compile(r"(?:(yes|on|true)|no|off|false)\b", re.IGNORECASE)
# Most characters of a line that a message quotes.
LONGEST: Final = 60
_UNIT: Final = re.compile(r"[^\W\d_][^\s,\]}#\"']*|%")


def read_toml(what: str, path: str | os.PathLike[str], hint: str) -> dict[str, Any]:
    r"""Read a TOML file."""
    file, name = file_path(what, path), os.fspath(path)
    try:
        text = file.read_text("utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot read {what} {name!r} ({error.strerror}); {hint}") from None
    except UnicodeDecodeError:
        raise InputError(f"{what} {name!r} is not UTF-8 text; write it as TOML in UTF-8") from None
    return parse_toml(f"{what} {name!r}", text)


def parse_toml(what: str, text: str, hint: str = "") -> dict[str, Any]:
    r"""Parse the text of a TOML file; a hint at a remedy begins with a semicolon."""
    try:
        return tomllib.loads(text.removeprefix("\ufeff"))
    except tomllib.TOMLDecodeError as error:
        reason = str(error).replace("Cannot overwrite a value", "the same key is given twice")
        remedy = _quotation_marks(text, reason) or _truth_value(text, reason) or hint
        raise InputError(f"{what} is not valid TOML: {reason}{remedy}") from None
    except RecursionError:
        raise InputError(f"{what} is nested too deeply") from None
    except ValueError:
        # The only remaining reason: Python does not read whole numbers of more than 4300 digits.
        raise InputError(f"{what} has a whole number of thousands of digits") from None


def _line_of(text: str, reason: str) -> tuple[str, int]:
    """The line of an error, and its place in this line; an empty line if it is not known."""
    place = _PLACE.search(reason)
    if place is None:
        return "", 0
    return text.removeprefix("\ufeff").split("\n")[int(place[1]) - 1], int(place[2]) - 1


def _truth_value(text: str, reason: str) -> str:
    """The line of an invalid value, with a hint at true and false for a word such as yes."""
    line, column = _line_of(text, reason)
    if not line or not reason.startswith("Invalid value"):
        return ""
    word = _TRUTH.match(line[column:])
    hint = "" if word is None else f"; write {'true' if word[1] else 'false'}"
    shown = line.strip()
    return f" in {shown if len(shown) <= LONGEST else shown[:LONGEST] + '...'}{hint}"


def _quotation_marks(text: str, reason: str) -> str:
    """A hint at the quotation marks of a number with a unit, if the error is at this unit."""
    line, column = _line_of(text, reason)
    before, unit = _NUMBER.search(line[:column]), _UNIT.match(line[column:])
    if before is None or unit is None or quantity(f"{before[2]} {unit[0]}") is None:
        return ""
    return f'; text with a unit needs quotation marks: {before[1]}"{before[2]} {unit[0]}"'


def toml_text(value: Any) -> str:
    """Convert a value to TOML text."""
    if isinstance(value, Mapping):
        items = (f"{toml_key(key)} = {toml_text(item)}" for key, item in value.items())
        return "{" + ", ".join(items) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml_text, value)) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    return _quoted(value) if isinstance(value, str) else repr(value)


def toml_key(name: str) -> str:
    """Name of a key or table, in quotation marks if necessary."""
    bare = name.isascii() and name.replace("-", "").replace("_", "").isalnum()
    return name if bare else _quoted(name)


def _quoted(text: str) -> str:
    # A string of JSON is one of TOML, except that TOML also escapes the character DEL.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", r"\u007f")
