"""Constants of materials by name: those of beads, walls and pairs of materials."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from ..chain.chain import Chain
from ..chain.materials import RIGID, Material
from ..chain.per_contact import MaterialPairs
from ..chain.walls import Wall
from ..errors import unknown_name_error
from .names import ENDS, Name


def named_materials(chain: Chain) -> dict[str, Material]:
    """Materials of beads and of walls by name; a wall and beads with one name have one material."""
    if chain.materials is None:
        return {}
    walls: list[Wall | None] = [getattr(chain, end) for end in ENDS]
    of_walls = [wall.material for wall in walls if wall is not None]
    found: dict[str, Material] = {}
    for each in (*chain.materials, *of_walls):
        if each is not None and each != RIGID:
            found.setdefault(each.name, each)
    return found


def constant_of(chain: Chain, name: Name) -> float:
    """Value of a constant such as ``materials[steel-304].young``."""
    known = named_materials(chain)
    if name.item not in known:
        raise unknown_name_error("material of this chain", name.item, known)
    return float(getattr(known[name.item], name.key.split(".")[1]))


def with_constants(chain: Chain, values: Mapping[Name, float]) -> Chain:
    """The chain with other constants of the materials of beads, walls and pairs."""
    changes: dict[str, dict[str, float]] = {}
    for name, value in values.items():
        changes.setdefault(name.item, {})[name.key.split(".")[1]] = value
    if not changes or chain.materials is None:
        return chain

    def changed(each: Material) -> Material:
        own: dict[str, Any] = changes.get(each.name, {})
        return dataclasses.replace(each, **own) if own and each != RIGID else each

    fields: dict[str, Any] = {"materials": tuple(map(changed, chain.materials))}
    for end in ENDS:
        wall: Wall | None = getattr(chain, end)
        if wall is not None and wall.material is not None:
            fields[end] = dataclasses.replace(wall, material=changed(wall.material))
    for field in ("loss", "exponent"):
        pairs = getattr(chain, field)
        if isinstance(pairs, MaterialPairs):
            fields[field] = dataclasses.replace(pairs, values={
                frozenset(map(changed, pair)): value for pair, value in pairs.values.items()
            })  # fmt: skip
    return chain.replace(**fields)
