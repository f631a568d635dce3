"""Constants of materials by name: those of beads, walls and pairs of materials."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from ..chain.chain import Chain
from ..chain.materials import Material
from ..chain.random_materials import named_materials, with_changed_materials
from ..errors import unknown_name_error
from .names import Name


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
    if not changes:
        return chain

    def changed(each: Material) -> Material:
        own: dict[str, Any] = changes.get(each.name, {})
        return dataclasses.replace(each, **own) if own else each

    return with_changed_materials(chain, changed)
