"""Materials of a chain by name, and chains whose moduli or yield strengths deviate at random."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from ..collision import Array
from ..errors import InputError
from .chain import Chain
from .laws.elastic_plastic import ElasticPlastic
from .materials import RIGID, Material
from .per_contact import MaterialPairs
from .walls import Wall

ENDS: Final = ("left_wall", "right_wall")
# In words, by the field of `Material`.
CONSTANTS: Final = {"young": "Young's moduli", "yield_strength": "yield strengths"}


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


def with_changed_materials(chain: Chain, change: Callable[[Material], Material]) -> Chain:
    """The chain with changed materials of beads, walls and pairs; rigid ones stay."""
    if chain.materials is None:
        return chain

    def changed(each: Material) -> Material:
        return each if each == RIGID else change(each)

    fields: dict[str, Any] = {"materials": tuple(map(changed, chain.materials))}
    for end in ENDS:
        wall: Wall | None = getattr(chain, end)
        if wall is not None and wall.material is not None:
            fields[end] = replace(wall, material=changed(wall.material))
    for field in ("loss", "exponent"):
        pairs = getattr(chain, field)
        if isinstance(pairs, MaterialPairs):
            fields[field] = replace(pairs, values={
                frozenset(map(changed, pair)): value for pair, value in pairs.values.items()
            })  # fmt: skip
    return chain.replace(**fields)


def check_random_materials(chain: Chain, constant: str) -> None:
    """Raise `InputError` unless the forces of a chain depend on a constant of its materials."""
    words = CONSTANTS[constant]
    if chain.materials is None:
        raise InputError(
            f"a scatter of {words} requires a chain with materials, which this chain does not "
            "have: give it materials, or omit this scatter"
        )
    if constant == "young" and "stiffness" in chain.given:
        raise InputError(
            f"a scatter of {words} does not change the stiffness of the contacts, which this chain "
            "gives: omit the stiffness, or this scatter"
        )
    laws = chain.contact_losses
    if constant == "yield_strength" and not any(
        isinstance(law, ElasticPlastic) and law.needs_yield_strength for law in laws
    ):
        raise InputError(
            f"a scatter of {words} changes only contacts that yield at a multiple of the yield "
            "strength, and this chain has none: use loss=ElasticPlastic(), or omit this scatter"
        )


def with_random_materials(
    chains: Sequence[Chain], spreads: Mapping[str, float], draws: Array
) -> list[Chain]:
    """The chains with log-normal constants, one factor per material; draws have shape (S, M, F)."""
    return [_with_factors(*each, spreads) for each in zip(chains, draws, strict=True)]


def _with_factors(chain: Chain, draws: Array, spreads: Mapping[str, float]) -> Chain:
    # In alphabetical order, random numbers do not depend on the order of the balls.
    places = {name: i for i, name in enumerate(sorted(named_materials(chain)))}
    factors = np.exp(draws * np.array([*spreads.values()]))

    def changed(each: Material) -> Material:
        own = zip(spreads, factors[places[each.name]].tolist(), strict=True)
        values = {field: (getattr(each, field), factor) for field, factor in own}
        return replace(each, **{
            field: value * factor for field, (value, factor) in values.items() if value is not None
        })  # fmt: skip

    return with_changed_materials(chain, changed)
