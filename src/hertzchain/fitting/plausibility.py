"""Fitted moduli that no material has."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ..chain.chain import Chain
from ..chain.random_materials import named_materials
from .names import Name
from .parameters import Parameter

# Moduli of all materials, from the softest rubber to diamond [Pa].  A nominal modulus may be beyond
# them, such as that of a gel; a fitted one is implausible if it also differs by a factor from it.
SOFTEST, STIFFEST, FACTOR = 1e6, 2e12, 10.0


def implausible_values(
    parameters: Sequence[Parameter], chain: Chain, values: Mapping[Name, float]
) -> str:
    """A clause on moduli, fitted or implied by the stiffness, of no material; empty without any."""
    materials = named_materials(chain)
    for each in parameters:
        name, value = each.name, values[each.name]
        if name.key == "materials.young" and name.item in materials:
            nominal = materials[name.item].young
            if _beyond(value, nominal):
                return f"{each} = {_shown(value)} is beyond the moduli of all materials"
        if name.key == "stiffness" and not name.item and chain.materials is not None:
            nominal = chain.materials[chain._balls][-1].young
            if _beyond(value * nominal, nominal):
                return (
                    f"stiffness = {value:.3g} would require a modulus of "
                    f"{_shown(value * nominal)}, beyond those of all materials"
                )
    return ""


def _beyond(young: float, nominal: float) -> bool:
    if not math.isfinite(nominal):
        return False
    return young < min(SOFTEST, nominal / FACTOR) or young > max(STIFFEST, nominal * FACTOR)


def _shown(young: float) -> str:
    for factor, unit in ((1e9, "GPa"), (1e6, "MPa")):
        if young >= factor:
            return f"{young / factor:.3g} {unit}"
    return f"{young:.3g} Pa"
