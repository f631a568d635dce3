"""The yield pressure that `ElasticPlastic` assumes, and chains that yield at another one."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from .laws.elastic_plastic import ElasticPlastic
from .materials import FIRST_YIELD, FULLY_PLASTIC
from .per_contact import MaterialPairs

if TYPE_CHECKING:
    from ..collision import Array
    from .chain import Chain

BETWEEN: Final = f"{FIRST_YIELD:g} to {FULLY_PLASTIC:g} times the yield strength"
ASSUMED_PRESSURE: Final = (
    f"the yield pressure is assumed to be {FIRST_YIELD:g} times the yield strength; "
    f"up to {FULLY_PLASTIC:g} times is possible"
)
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
