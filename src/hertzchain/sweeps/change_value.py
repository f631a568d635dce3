"""Change one value in the document of a chain, at the place that the name of an axis gives."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..chain.materials import material
from ..errors import InputError
from ..store.chain_schema import is_material_constant
from .axes import Axis

if TYPE_CHECKING:
    from .specification import Specification


def path_in_document(axis: Axis) -> tuple[str, ...]:
    """Path of a parameter in the document of a specification."""
    outside_chain = axis.path[0] == "method" or is_material_constant(axis.path)
    return axis.path if outside_chain else ("chain", *axis.path)


def document_to_change(spec: Specification) -> dict[str, Any]:
    """Tables ``chain``, ``materials`` and ``method``, with the materials whose constants vary."""
    names = {axis.path[1] for axis in spec.axes if is_material_constant(axis.path)}
    materials = {name: _constants(name) for name in sorted(names - spec.materials.keys())}
    materials |= spec.materials
    return {"chain": spec.chain, "materials": materials, "method": spec.options}


def _constants(name: str) -> dict[str, Any]:
    """A material of the catalogue as a table of a chain file."""
    items = vars(material(name)).items()
    return {key: value for key, value in items if key != "name" and value is not None}


def with_value(
    document: Any, path: tuple[str, ...], value: Any, above: tuple[str, ...] = ()
) -> Any:
    """Copy a document with one value changed; the other values are shared.

    ``above`` is the path of the document itself, for messages.
    """
    key, rest, here = path[0], path[1:], (*above, path[0])
    if re.fullmatch(r"\d+-\d+", key):
        raise _several_items(key, above)
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


def _several_items(key: str, above: tuple[str, ...]) -> InputError:
    """Error for a range of the items of a list."""
    first, last = (".".join((*above[1:], number)) for number in key.split("-"))
    return InputError(
        f"an axis changes one item of a list, not {key}: give one axis with the same values for "
        f"each item, {first} to {last}, and combine = 'zip' in [sweep]"
    )


def _unknown_item(listed: list[Any], path: tuple[str, ...], above: tuple[str, ...]) -> InputError:
    """Error for a path into a list without the number of one of its items."""
    key, items, name = path[0], len(listed), ".".join(above[1:])
    if key.isdigit():
        return InputError(f"there is no item {key} in {name}, a list of {items}")
    first = f"write {'.'.join((name, '1', *path))!r} for its first item"
    return InputError(f"{name} is a list of {items}, so the name needs a number: {first}")
