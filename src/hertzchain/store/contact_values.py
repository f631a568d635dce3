"""Laws of loss and exponents in chain files: of all contacts, of each, or of pairs of materials."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from operator import itemgetter
from typing import Any, TypeAlias

from ..chain.laws import LAWS, Loss
from ..chain.per_contact import OTHERS
from ..errors import InputError
from .schema_checks import has_tables

# Materials of a file by their names.
MaterialsNamed: TypeAlias = Callable[[Any], Any]


def law_from(entry: Mapping[str, Any]) -> Loss:
    """The law of a table."""
    values = {key: value for key, value in entry.items() if key not in ("law", "between")}
    return LAWS[entry["law"]](**values)


def losses_from(given: Any, materials: MaterialsNamed) -> Any:
    """A law of all contacts, a list with one for each, or a mapping from pairs of materials."""
    listed = [given] if isinstance(given, Mapping) else given
    if len(listed) == 1 and "between" not in listed[0]:
        return law_from(listed[0])
    if not any("between" in each for each in listed):
        return [law_from(each) for each in listed]
    return _by_pairs("loss", listed, law_from, materials)


def exponent_from(given: Any, materials: MaterialsNamed) -> Any:
    """An exponent of all contacts, a list with one for each, or a mapping from pairs."""
    if not has_tables(given):
        return given
    listed = [given] if isinstance(given, Mapping) else given
    if not any("between" in each for each in listed):
        raise InputError(
            "[chain.exponent] requires between, two materials; for all contacts, write "
            f"exponent = {listed[0]['value']:g}"
        )
    return _by_pairs("exponent", listed, itemgetter("value"), materials)


def _by_pairs(
    name: str,
    listed: Sequence[Mapping[str, Any]],
    value: Callable[[Mapping[str, Any]], Any],
    materials: MaterialsNamed,
) -> dict[Any, Any]:
    """Values by pairs of materials; that of a table without between is for all other pairs."""
    found: dict[Any, Any] = {}
    for each in listed:
        pair: Any = OTHERS
        if "between" in each:
            names = each["between"]
            if len(names) != 2:
                raise InputError(
                    f"between of [chain.{name}] must have two materials, got {names!r}; a table "
                    "without between is for all other pairs"
                )
            pair = frozenset(materials(names))
        if pair in found:
            same = "are without between" if pair == OTHERS else "have the same between"
            raise InputError(f"two tables of [[chain.{name}]] {same}: omit one")
        found[pair] = value(each)
    return found
