"""Materials of a chain by name, and chains whose moduli or yield strengths deviate at random."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from ..collision import Array
from ..errors import InputError, unknown_name_error
from ..validation.objects import text
from .chain import Chain
from .impact_speed import relative_deviation
from .laws.elastic_plastic import ElasticPlastic
from .materials import RIGID, Material
from .per_contact import OTHERS, MaterialPairs
from .walls import Wall

ENDS: Final = ("left_wall", "right_wall")
# In words, by the field of `Material`.
CONSTANTS: Final = {"young": "Young's moduli", "yield_strength": "yield strengths"}
Spread = float | dict[str, float]


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


def spread_from(what: str, given: object) -> Spread:
    """Check the scatter of a constant, of all materials or by their names."""
    if not isinstance(given, Mapping):
        return relative_deviation(what, given)
    if not given:
        raise InputError(f"{what} names no material: give one, such as {{'nylon': '20%'}}")
    found = {text(f"material of {what}", name): value for name, value in given.items()}
    return {name: relative_deviation(f"{what} of {name}" if name != OTHERS else what, value)
            for name, value in found.items()}  # fmt: skip


def spread_in_words(spread: Spread) -> str:
    """Such as ``+-5%`` or ``+-1% (nylon +-20%)``."""
    if isinstance(spread, float):
        return f"+-{100.0 * spread:.3g}%"
    named = ", ".join(f"{name} +-{100.0 * value:.3g}%"
                      for name, value in spread.items() if name != OTHERS)  # fmt: skip
    if not named or OTHERS not in spread:
        return named or spread_in_words(spread[OTHERS])
    return f"{spread_in_words(spread[OTHERS])} ({named})"


def _spread_of(spread: Spread, material: str) -> float:
    if isinstance(spread, float):
        return spread
    return spread.get(material, spread.get(OTHERS, 0.0))


def check_random_materials(chain: Chain, constant: str, spread: Spread) -> None:
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
    known = sorted(named_materials(chain))
    for name in spread if isinstance(spread, dict) else ():
        if name not in (*known, OTHERS):
            raise unknown_name_error(f"material of a scatter of {words}", name, known)
    laws = chain.contact_losses
    if constant == "yield_strength" and not any(
        isinstance(law, ElasticPlastic) and law.needs_yield_strength for law in laws
    ):
        raise InputError(
            f"a scatter of {words} changes only contacts that yield at a multiple of the yield "
            "strength, and this chain has none: use loss=ElasticPlastic(), or omit this scatter"
        )


def with_random_materials(
    chains: Sequence[Chain], spreads: Mapping[str, Spread], draws: Array
) -> list[Chain]:
    """The chains with log-normal constants, one factor per material; draws have shape (S, M, F)."""
    return [_with_factors(*each, spreads) for each in zip(chains, draws, strict=True)]


def _with_factors(chain: Chain, draws: Array, spreads: Mapping[str, Spread]) -> Chain:
    # In alphabetical order, random numbers do not depend on the order of the balls.
    places = {name: i for i, name in enumerate(sorted(named_materials(chain)))}

    def changed(each: Material) -> Material:
        own = zip(spreads.items(), draws[places[each.name]].tolist(), strict=True)
        return replace(each, **{
            field: value * math.exp(draw * _spread_of(spread, each.name))
            for (field, spread), draw in own if (value := getattr(each, field)) is not None
        })  # fmt: skip

    return with_changed_materials(chain, changed)
