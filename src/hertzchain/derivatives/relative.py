"""Units of quantities and parameters of a gradient, and values of the parameters."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import HERTZ_EXPONENT, Array
from ..pulse.quantities import QUANTITIES
from .names import Name
from .parameters import MATERIAL

_PARAMETERS: Final = {
    "radii": "m", "masses": "kg", "gaps": "m", "velocities": "m/s", "young": "Pa", "poisson": "1",
    "yield_strength": "Pa", "density": "kg/m^3", "left_wall.gap": "m", "right_wall.gap": "m",
    "precompression": "N", "gravity": "m/s^2", "loss.time": "s", "loss.coefficient": "1",
    "loss.gamma": "kg/s",
}  # fmt: skip
_FINAL: Final = {"velocity": "m/s", "position": "m"}


def unit_of_quantity(chain: Chain, name: Name) -> str:
    """Unit of a quantity; empty in a scaled chain."""
    if chain.scaled:
        return ""
    if name.group in ("pulse", "bead"):
        return QUANTITIES[name.quantity].unit
    if name.group == "energy":
        return "J"
    if name.group == "final":
        return _FINAL[name.item]
    if name.item == "acceleration":
        return "m/s^2"
    if "impulse" in name.item:
        return "N s"
    return "s" if name.item.endswith(("time", "duration")) else "N"


def unit_of_parameter(chain: Chain, name: str) -> str:
    """Unit of a parameter; empty in a scaled chain, or if it depends on another parameter."""
    if chain.scaled:
        return ""
    if name.endswith("stiffness"):
        hertz = bool((chain.contact_exponents == HERTZ_EXPONENT).all())
        return "N/m^1.5" if hertz else "N/m^p"
    return _PARAMETERS.get(name, "")


def value_of_parameter(chain: Chain, name: str) -> Array:
    """Values of a parameter; NaN if laws of contacts have several."""
    if name in MATERIAL:
        return np.array([getattr(each, name) for each in chain.materials or ()], float)
    if name.startswith("loss."):
        item = name.removeprefix("loss.")
        values = {getattr(each, item) for each in chain.contact_losses if hasattr(each, item)}
        return np.array(values.pop() if len(values) == 1 else math.nan)
    if name.endswith("_wall.stiffness"):
        return np.array(chain.contact_stiffness[0 if name.startswith("left") else -1])
    if name.endswith("_wall.gap"):
        wall = chain.left_wall if name.startswith("left") else chain.right_wall
        return np.array(0.0 if wall is None else wall.gap)
    return np.array(getattr(chain, name), float)


def per_unit(above: str, below: str) -> str:
    """Unit of a derivative, such as ``N/m``."""
    if not above or not below:
        return ""
    if below == "1":
        return above
    above = f"({above})" if "/" in above else above
    return f"{above}/({below})" if "/" in below else f"{above}/{below}"
