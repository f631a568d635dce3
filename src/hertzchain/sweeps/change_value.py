"""Change one value in the document of a chain, at the place that the name of an axis gives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import InputError
from .axes import Axis


def path_in_document(axis: Axis) -> tuple[str, ...]:
    """Path of a parameter in a document with the tables ``chain`` and ``method``."""
    return axis.path if axis.path[0] == "method" else ("chain", *axis.path)


def with_value(
    document: Any, path: tuple[str, ...], value: Any, above: tuple[str, ...] = ()
) -> Any:
    """Copy a document with one value changed; the other values are shared.

    ``above`` is the path of the document itself, for messages.
    """
    key, rest, here = path[0], path[1:], (*above, path[0])
    if isinstance(document, list):
        if not (key.isdigit() and 1 <= int(key) <= len(document)):
            raise _unknown_item(document, path, above)
        changed = list(document)
        old = changed[int(key) - 1]
        changed[int(key) - 1] = with_value(old, rest, value, here) if rest else value
        return changed
    if key.isdigit():
        one = "none" if document is None else f"one value, {document!r}, for all"
        raise InputError(f"value {key} can only vary in a list, and [chain] has {one}: give a list")
    if document is not None and not isinstance(document, Mapping):
        raise InputError(f"cannot set {'.'.join(path)} of {document!r}: it is not a table")
    table = dict(document or {})
    table[key] = with_value(table.get(key), rest, value, here) if rest else value
    return table


def _unknown_item(listed: list[Any], path: tuple[str, ...], above: tuple[str, ...]) -> InputError:
    """Error for a path into a list without the number of one of its items."""
    key, items, name = path[0], len(listed), ".".join(above[1:])
    if key.isdigit():
        return InputError(f"there is no item {key} in {name}, a list of {items}")
    first = f"write {'.'.join((name, '1', *path))!r} for its first item"
    return InputError(f"{name} is a list of {items}, so the name needs a number: {first}")
