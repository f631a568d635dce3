"""Comparison of a parsed chain file with the schema, before anything is built."""

from __future__ import annotations

import numbers
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from ..errors import InputError, short_repr, similar_names, unknown_name_error
from ..units import PERCENT, UNITS, comma_advice, converted, quantity
from ..validation.json_types import FLAT_FACES
from ..validation.numbers import whole_hint
from .chain_schema import KEYS, SECTIONS, TABLES
from .schema_keys import Key, Section

# Tables of a chain file; the last two are read only by `hertzchain.fit` and `hertzchain.design`.
TOP: Final = ("chain", "materials", "fit", "design")
# Advice for unknown laws: those of a script are known only once its module is imported.
OWN_LAW: Final = "; if it is a law of your own, import the module that defines it first"


def check_document(document: Mapping[str, Any], *, complete: bool = True) -> Iterator[str]:
    """Compare a parsed chain file with the schema.

    Parameters
    ----------
    document : mapping
        Tables ``chain`` and, optionally, ``materials``.
    complete : bool
        Whether required keys must be present; not in a sweep, whose axes may give them.

    Yields
    ------
    str
        One sentence per error.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.store.schema_checks import check_document
    >>> document = {"chain": {"beads": 2.5, "right_wall": {"rigid": "false"}}}
    >>> [*check_document(document)][1]
    "rigid of [chain.right_wall] must be true or false, got 'false'; omit the quotation marks"
    """
    for name in document:
        if name in TABLES:
            yield f"unknown table or key {name!r}; did you mean [chain.{name}]?"
        elif name == "title":
            yield "only specifications of sweeps have a title; write it as a comment, after #"
        elif name not in TOP:
            yield str(unknown_name_error("table or key", name, TOP))
    table = document.get("chain")
    if not isinstance(table, Mapping):
        yield "a chain file needs a table [chain]"
        return
    tables = {
        name: value for name, value in table.items()
        if name in TABLES and (name != "exponent" or has_tables(value))
    }  # fmt: skip
    values = {name: value for name, value in table.items() if name not in tables}
    yield from _check_keys(values, "[chain]", SECTIONS["chain"].keys, KEYS, complete=complete)
    for name in TABLES:
        if name in tables:
            yield from _check_tables(tables[name], SECTIONS[f"chain.{name}"], complete)
    materials = document.get("materials", {})
    if not isinstance(materials, Mapping):
        yield f"[materials] must be a table of tables, got {short_repr(materials)}"
        return
    for name, entry in materials.items():
        if isinstance(entry, Mapping):
            keys = SECTIONS["materials.NAME"].keys
            yield from _check_keys(entry, f"[materials.{name}]", keys, complete=complete)
        else:
            yield f"[materials.{name}] must be a table, got {short_repr(entry)}"


def has_tables(value: Any) -> bool:
    """Whether a value is a table or a list that has one."""
    listed = value if isinstance(value, list | tuple) else [value]
    return any(isinstance(item, Mapping) for item in listed)


def _check_tables(entry: Any, section: Section, complete: bool, place: str = "") -> Iterator[str]:
    """Check a table or, if the section may be repeated, a list of tables."""
    several = section.repeated and not place and isinstance(entry, list | tuple)
    place = place or f"[{section.name}]"
    for table in entry if several else [entry]:
        if not isinstance(table, Mapping):
            yield f"{place} must be a table{_example(section)}, got {short_repr(entry)}"
            return
        keys, chosen = section.keys, table.get(section.variant_key)
        if section.variant_key:
            if chosen is None and not complete:
                continue
            if chosen is None:
                names = ", ".join(section.variants)
                yield f"{place} has no {section.variant_key}: choose from {names}"
                continue
            if not isinstance(chosen, str) or chosen not in section.variants:
                what = f"{section.variant_key} of {place}"
                more = OWN_LAW if section.variant_key == "law" else ""
                yield str(unknown_name_error(what, chosen, section.variants, more=more))
                continue
            keys = (*section.keys, *section.variants[chosen])
        values, known = dict(table), [key.name for key in keys]
        if section.variant_key:
            del values[section.variant_key]
            known.insert(0, section.variant_key)
        yield from _check_keys(values, place, keys, known, complete=complete)


def _example(section: Section) -> str:
    """Tables to suggest instead of a single value."""
    wall = ', such as {rigid = true}, {material = "brass"} or {}, or text such as "same"'
    examples = {
        "chain.left_wall": wall,
        "chain.right_wall": wall,
        "chain.cap": ', such as {mass = "5 g"}, or text such as "5 g"',
        "chain.loss": ', such as {law = "restitution", coefficient = 0.95}',
        "chain.drive": ', such as {kind = "step", amplitude = 10.0}',
        "chain.exponent": ', such as {between = ["brass", "ptfe"], value = 1.5}',
        "chain.with_contacts": ', such as {shape = "cone", half_angle = 70.0}',
    }
    return examples.get(section.name, "")


def _check_keys(
    table: Mapping[str, Any],
    place: str,
    keys: Sequence[Key],
    known: Sequence[str] | None = None,
    *,
    complete: bool,
) -> Iterator[str]:
    own = {key.name: key for key in keys}
    for name, value in table.items():
        if name in own:
            yield from problems_of(own[name], value, f"{name} of {place}")
    yield from unknown_keys([name for name in table if name not in own], place, known or [*own])
    if complete:
        for key in keys:
            if key.required and table.keys().isdisjoint((key.name, key.unless)):
                either = f"{key.name} or {key.unless}" if key.unless else key.name
                yield f"{place} requires {either} ({key.description})"


def unknown_keys(names: Sequence[str], place: str, known: Sequence[str]) -> Iterator[str]:
    """Describe all unknown keys of a table by one sentence, which lists the known ones once."""
    if not names:
        return
    described = []
    for name in names:
        meant = _MEANT.get(name)
        near = repr(meant) if meant in known else similar_names(name, known)
        hint = f" (did you mean {near}?)" if near else ""
        if name == "flat" and "radius" in known:
            hint = ' (for a flat face, write radius = "flat")'
        described.append(f"{name!r}{hint}")
    keys = "keys" if len(names) > 1 else "key"
    yield f"unknown {keys} of {place} {', '.join(described)}: choose from {', '.join(known)}"


# Names of options, or of the same things elsewhere, for the keys of chain files.
_MEANT: Final[Mapping[str, str]] = MappingProxyType(
    {
        "kind": "taper",
        "speed": "velocity",
        "wall": "right_wall",
        "material": "materials",
        "striker": "struck_by",
        "number": "beads",
        "balls": "beads",
    }
)


def problems_of(key: Key, value: Any, what: str) -> Iterator[str]:
    """Describe by a sentence why a value is not of the type of a key."""
    if not key.per:
        yield from _problem_of_one(key, value, what)
    elif isinstance(value, Mapping):
        yield from _problem_of_list_with_unit(key, value, what)
    elif isinstance(value, list | tuple | np.ndarray):
        noun = "names" if key.kind == "material" else "numbers"
        if not len(value) and key.dimension == "length" and key.name != "gaps":
            yield f"{what} must have at least one number, got none; give one for each bead"
        for place, item in enumerate(value, start=1):
            if isinstance(item, list | tuple | Mapping | np.ndarray):
                yield f"{what} must be a list of {noun}, got {short_repr(value)}"
                return
            yield from _problem_of_one(key, item, f"value {place} of {what}")
    elif key.one_for_all:
        yield from _problem_of_one(key, value, what, several=True)
    else:
        yield f"{what} must be a list, got {short_repr(value)}"


# Kinds other than numbers and choices: Python's types and their description.
_TYPES: Final[Mapping[str, tuple[tuple[type, ...], str]]] = MappingProxyType(
    {
        "boolean": ((bool, np.bool_), "true or false"),
        "text": ((str,), "text"),
        "material": ((str,), "a name"),
        "file": ((str,), "a path"),
        "signal": ((str,), "text"),
    }
)


def _problem_of_one(key: Key, value: Any, what: str, *, several: bool = False) -> Iterator[str]:
    if key.kind == "law":
        yield from _check_tables(value, SECTIONS["chain.loss"], complete=True, place=what)
    elif key.kind in _TYPES:
        types, allowed = _TYPES[key.kind]
        if not isinstance(value, types) or (value == "" and key.kind != "text"):
            quoted = (
                isinstance(value, str) and value in ("true", "false") and allowed == "true or false"
            )
            hint = "; omit the quotation marks" if quoted else ""
            yield f"{what} must be {allowed}, got {short_repr(value)}{hint}"
    elif key.kind == "choice":
        if not isinstance(value, str) or value not in key.choices:
            yield str(unknown_name_error(what, value, key.choices, more=key.other))
    elif key.kind == "integer":
        if isinstance(value, bool) or not isinstance(value, numbers.Integral):
            given = f"{short_repr(value)} ({key.description}){whole_hint(value)}"
            yield f"{what} must be a whole number, got {given}"
    elif isinstance(value, str) and _is_number_as_text(key, value):
        yield from _problem_of_unit(key, value, what)
    elif isinstance(value, bool) or not isinstance(value, numbers.Real):
        units = UNITS[key.dimension] if key.dimension else ()
        with_unit = f", or text with a unit such as '5 {units[:3][-1]}'" if units else ""
        with_unit = " or a percentage such as '5%'" if key.fraction else with_unit
        quoted = isinstance(value, str) and value.strip().lower() in ("inf", "infinity")
        hint = "; write inf without quotation marks" if quoted else ""
        fixed = units and key.dimension != "stiffness" and not key.dimension_if_displacement
        hint = hint or comma_advice(value, several=several, si=units[0] if fixed else "")
        yield f"{what} must be a number{with_unit}, got {short_repr(value)}{hint}"


def _is_number_as_text(key: Key, value: str) -> bool:
    """Whether text is a number with a unit, a percentage, or the size of a flat striker."""
    if key.name in ("radius", "diameter") and value in FLAT_FACES:
        return True
    return _may_be_text(key) and quantity(value) is not None


def _problem_of_unit(key: Key, value: str, what: str) -> Iterator[str]:
    """Check the unit of text, unless it depends on the exponent or on what a drive prescribes."""
    found = quantity(value)
    # A range such as "20 mm:8 mm" has its own message.
    if (
        found is None
        or ":" in value
        or key.dimension in ("", "stiffness")
        or key.dimension_if_displacement
    ):
        return
    if key.dimension not in UNITS or (key.fraction and found[1] == PERCENT):
        return
    try:
        converted(what, *found, UNITS[key.dimension][0])
    except InputError as error:
        yield str(error)


def _may_be_text(key: Key) -> bool:
    return bool(key.dimension) or key.fraction


def _problem_of_list_with_unit(key: Key, value: Mapping[str, Any], what: str) -> Iterator[str]:
    """Check ``{list = [4, 5], unit = "mm"}``."""
    if not key.dimension:
        noun = "names" if key.kind == "material" else "numbers"
        yield f"{what} must be a list of {noun}, got {short_repr(value)}"
    elif set(value) != {"list", "unit"} or not isinstance(value["list"], list | tuple):
        yield (
            f'{what} must be a list, or a table such as {{list = [4, 5], unit = "mm"}}, got '
            f"{short_repr(value)}"
        )
    elif not isinstance(value["unit"], str):
        yield f"unit of {what} must be text, got {short_repr(value['unit'])}"
    else:
        for item in value["list"]:
            if isinstance(item, bool) or not isinstance(item, numbers.Real):
                yield (
                    f"{what} must be a list of plain numbers next to its unit, "
                    f"got {short_repr(item)}"
                )
                return
