"""Read TOML files, with errors of one sentence, and write values as TOML."""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Mapping
from typing import Any

from ..errors import InputError
from ..validation.objects import file_path


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
        raise InputError(f"{what} is not valid TOML: {reason}{hint}") from None
    except RecursionError:
        raise InputError(f"{what} is nested too deeply") from None
    except ValueError:
        # The only remaining reason: Python does not read whole numbers of more than 4300 digits.
        raise InputError(f"{what} has a whole number of thousands of digits") from None


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
