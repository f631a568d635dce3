"""The yield pressure that `ElasticPlastic` assumes, and chains that yield at another one."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from ..representation import listed
from .laws.elastic_plastic import ElasticPlastic
from .materials import FIRST_YIELD, FULLY_PLASTIC, is_of_annealed_bar
from .per_contact import MaterialPairs

if TYPE_CHECKING:
    from ..collision import Array
    from .chain import Chain

BETWEEN: Final = f"{FIRST_YIELD:g} to {FULLY_PLASTIC:g} times the yield strength"
ASSUMED_PRESSURE: Final = (
    f"the yield pressure is assumed to be {FIRST_YIELD:g} times the yield strength; "
    f"up to {FULLY_PLASTIC:g} times is possible"
)
# The same in figures and tables.
LOW: Final = f"at {FIRST_YIELD:g} Y"
YIELD_ASSUMED: Final = f"contacts yield {LOW}"
DEFINED: Final = "(Y: yield strength)"
YIELD_STATED: Final = f"{YIELD_ASSUMED} {DEFINED}"
OTHER_PRESSURE: Final = f"use loss=ElasticPlastic(factor={FULLY_PLASTIC:g})"
# Beside values of many chains, which share the assumption.
ASSUMED_FOR_ALL: Final = (
    f"{ASSUMED_PRESSURE}, which changes all values and can change their order ({OTHER_PRESSURE})"
)


def _assumes(law: Any) -> bool:
    return isinstance(law, ElasticPlastic) and law.needs_yield_strength and law.factor is None


def assumes_pressure(chain: Chain) -> bool:
    """Whether the law of any contact has no yield pressure of its own."""
    return any(map(_assumes, chain.contact_losses))


def assumed_for_all(chain: Chain) -> str:
    """A note beside values of many chains; empty if the yield pressure is given."""
    return ASSUMED_FOR_ALL if assumes_pressure(chain) else ""


def note_on_soft_balls(chain: Chain, *, yielding: bool = False) -> str:
    """A note on balls with the yield strength of annealed bars; empty if it is not used.

    With ``yielding``, values with contacts that yield are shown beside those of elastic ones.
    """
    used = yielding or any(law.needs_yield_strength for law in chain.contact_losses)
    if not used or chain.materials is None:
        return ""
    balls = chain.materials[: -1 if chain.cap is not None else None]
    soft = {each.name: each for each in balls if is_of_annealed_bar(each)}
    if not soft:
        return ""
    strength = min(each.yield_strength or 0.0 for each in soft.values())
    return (
        f"the yield strength of {listed(list(soft))}, {strength / 1e6:g} MPa, is the minimum of "
        "annealed bars; cold-headed balls are harder, with larger forces: give the strength of "
        "your balls in a custom material"
    )


def yields_at_assumed_pressure(chain: Chain, overlaps: Array) -> bool:
    """Whether any contact has yielded at an assumed pressure, from the overlaps of all contacts."""
    return any(
        bool((group.law.yield_ratio(overlaps[group.index], group.contacts) >= 1.0).any())
        for group in chain.contact_groups
        if _assumes(group.law)
    )


def with_factor(chain: Chain, factor: float) -> Chain:
    """The chain with this yield pressure over the yield strength where one is assumed."""

    def changed(law: Any) -> Any:
        if isinstance(law, tuple):
            return tuple(map(changed, law))
        if isinstance(law, MaterialPairs):
            return replace(law, values={pair: changed(each) for pair, each in law.values.items()})
        return ElasticPlastic(factor=factor) if _assumes(law) else law

    walls = {
        name: replace(wall, loss=changed(wall.loss))
        for name in ("left_wall", "right_wall")
        if (wall := getattr(chain, name)) is not None
    }
    return chain.replace(loss=changed(chain.loss), **walls)
