"""Keys of [chain] to which a path leads, such as ``materials.rubber.young`` or ``radii.3``."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from .chain_schema import SECTIONS, TABLES
from .schema_keys import Key


def is_place(word: str) -> bool:
    """Whether a word of a path is the number of an item of a list, or a range such as 39-41."""
    first, dash, last = word.partition("-")
    return first.isdigit() and (last.isdigit() or not dash)


def dimensions_of(path: Sequence[str]) -> set[str]:
    """Dimensions that the value at a path within [chain] can have; ``""`` for a plain number."""
    found = _keys_at(path)
    dimensions = {key.dimension for key in found}
    dimensions |= {key.dimension_if_displacement for key in found if key.dimension_if_displacement}
    return dimensions or {""}


def names_beside(path: Sequence[str]) -> list[str]:
    """Names of all keys of a table within [chain], if a path leads to none of them."""
    words = [word for word in path if not is_place(word)]
    if len(words) != 2 or words[0] not in TABLES or _keys_at(path):
        return []
    section = SECTIONS[f"chain.{words[0]}"]
    keys = itertools.chain(section.keys, *section.variants.values())
    return [*dict.fromkeys(key.name for key in keys)]


def is_fraction(path: Sequence[str]) -> bool:
    """Whether the value at a path within [chain] may be a percentage."""
    return any(key.fraction for key in _keys_at(path))


def is_count(path: Sequence[str]) -> bool:
    """Whether the value at a path within [chain] must be a whole number."""
    return {key.kind for key in _keys_at(path)} == {"integer"}


def is_material_constant(path: Sequence[str]) -> bool:
    """Whether a path leads to a constant of a material, such as ``materials.rubber.young``."""
    return len(path) == 3 and path[0] == "materials" and not is_place(path[1])


def _keys_at(path: Sequence[str]) -> list[Key]:
    """Keys to which a path within [chain] can lead: several if they belong to variants."""
    words = [word for word in path if not is_place(word)]
    section = SECTIONS["chain"]
    if is_material_constant(path):
        section, words = SECTIONS["materials.NAME"], words[-1:]
    if words and words[0] in TABLES:
        section, words = SECTIONS[f"chain.{words[0]}"], words[1:]
    if len(words) > 1 and any(key.name == words[0] and key.kind == "law" for key in section.keys):
        section, words = SECTIONS["chain.loss"], words[1:]
    keys = itertools.chain(section.keys, *section.variants.values())
    return [key for key in keys if [key.name] == words]
