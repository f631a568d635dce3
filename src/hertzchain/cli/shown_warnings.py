"""Warnings on standard error, each text once, and again in JSON documents."""

from __future__ import annotations

from typing import Final

from .wording import on_command_line
from .wrapped_text import show_text

_shown: Final[dict[str, None]] = {}


def show_warning(message: Warning | str, *_: object, **__: object) -> None:
    """Show a warning on standard error unless it was shown before.

    A command may create a chain again, and every chain warns.
    """
    text = on_command_line(str(message))
    if text not in _shown:
        show_text(f"Warning: {text}", err=True)
    _shown[text] = None


def with_warnings(document: dict[str, object]) -> dict[str, object]:
    """Add the warnings so far to a JSON document, before those that it has."""
    own = document.get("warnings", [])
    assert isinstance(own, list)
    return document | {"warnings": list(dict.fromkeys([*_shown, *map(on_command_line, own)]))}


def forget_warnings() -> None:
    """Begin the list again."""
    _shown.clear()
