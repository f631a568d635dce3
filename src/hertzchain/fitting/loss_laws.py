"""Loss laws with typical values, for chains whose losses are not known."""

from __future__ import annotations

from typing import Final

from ..chain.chain import Chain
from ..chain.laws import LAWS, Loss
from ..errors import InputError, short_repr, unknown_name_error
from .law_parameters import TYPICAL
from .symmetry import units_of

ONE_LAW: Final = (
    "only one loss law was fitted, and others may describe the data equally well: compare_losses "
    "compares them"
)


def typical_law(given: str | Loss, chain: Chain) -> Loss:
    """A law with typical values for a chain."""
    if isinstance(given, Loss):
        return given
    if not isinstance(given, str):
        raise InputError(f"a law must be a name or a Loss, got {short_repr(given)}")
    if given not in LAWS:
        raise unknown_name_error("law", given, LAWS)
    kind = LAWS[given]
    scales = units_of(chain).scales
    values = TYPICAL.get(kind, {})
    units = {
        "time": "time", "yield_overlap": "length",
        "gamma": f"force/velocity^{values.get('alpha', 1.0)}",
    }  # fmt: skip
    return kind(**{
        name: value * scales.unit(units[name]) if name in units else value
        for name, value in values.items()
    })  # fmt: skip
