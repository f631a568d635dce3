"""Change one value in the document of a chain, at the place that the name of an axis gives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..chain.materials import material
from ..errors import InputError
from ..store.schema_paths import is_material_constant, is_place
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
    """Copy a document with one value, or a range of items, changed; the other values are shared.

    ``above`` is the path of the document itself, for messages.
    """
    key, rest, here = path[0], path[1:], (*above, path[0])
    if isinstance(document, list):
        if len(document) == 1 and isinstance(document[0], Mapping) and not is_place(key):
            # The only table of a list, such as [[chain.struck_by]], needs no number.
            return [with_value(document[0], path, value, above)]
        changed = list(document)
        for i in _indices(document, path, above):
            changed[i] = with_value(changed[i], rest, value, here) if rest else value
        return changed
    if is_place(key):
        one = "none" if document is None else f"one value, {document!r}, for all"
        raise InputError(f"value {key} can only vary in a list, and [chain] has {one}: give a list")
    if document is not None and not isinstance(document, Mapping):
        raise InputError(f"cannot set {'.'.join(path)} of {document!r}: it is not a table")
    table = dict(document or {})
    table[key] = with_value(table.get(key), rest, value, here) if rest else value
    return table


def _indices(listed: list[Any], path: tuple[str, ...], above: tuple[str, ...]) -> range:
    """Indices of the item or the range of items, such as 39-41, with which a path begins."""
    first, dash, last = path[0].partition("-")
    if not is_place(path[0]):
        raise _unknown_item(listed, path, above)
    if dash and int(first) >= int(last):
        raise InputError(f"the range {path[0]} of items must begin with the smaller number")
    if not 1 <= int(first) <= int(last or first) <= len(listed):
        raise _unknown_item(listed, path, above)
    return range(int(first) - 1, int(last or first))


def _unknown_item(listed: list[Any], path: tuple[str, ...], above: tuple[str, ...]) -> InputError:
    """Error for a path into a list without the number of one of its items."""
    key, items, name = path[0], len(listed), ".".join(above[1:])
    if is_place(key):
        there, s = ("there are", "s") if "-" in key else ("there is", "")
        return InputError(f"{there} no item{s} {key} in {name}, a list of {items}")
    first = f"write {'.'.join((name, '1', *path))!r} for its first item"
    return InputError(f"{name} is a list of {items}, so the name needs a number: {first}")
