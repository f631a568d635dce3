"""Constants of a chain that are not free, as causes of residuals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

from ..errors import InputError
from ..representation import listed
from .causes import Cause, Refit, fixed_ends, is_free, try_further
from .chain_parameters import known_names
from .names import Name
from .parameters import ELASTIC
from .result import FitResult

# Starts of a mass: a fit from the mass of the other balls can end there, because a heavier ball
# reflects the pulse and a lighter one leaves its neighbour.
MASS_STARTS: Final = (1.05, 0.95)


def with_exponent(result: FitResult, _: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The fit with the exponent of all contacts, if they have one that is not free."""
    name = Name("exponent")
    if not is_free(name.key, result.model) and str(name) in known_names(result.chain):
        cause = try_further(result, (name,), refit)
        moduli = [f"'{each}'" for each in result.model.names if each.key in ELASTIC]
        if cause is not None and moduli:
            advice = f"free 'stiffness' and 'exponent' instead of {listed(moduli)}"
            yield replace(cause, advice=advice)
        elif cause is not None:
            yield cause


def with_cap(result: FitResult, start: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The fits with the mass of a cap, and with the stiffness of the walls behind it."""
    if result.chain.cap is not None:
        yield from _ends(result, start, refit)


def with_walls(result: FitResult, start: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The fits with the stiffness of the walls of a chain without a cap."""
    if result.chain.cap is None:
        yield from _ends(result, start, refit)


def _ends(result: FitResult, _: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The fits with the stiffness of each wall that is not free, and with the mass of a cap."""
    for name in fixed_ends(result.model):
        # Its error includes those of others, which only priors determine, as in `_clear_cause`.
        cause = try_further(result, (name,), refit, least=0.0)
        if cause is not None:
            yield cause


def with_moduli(result: FitResult, _: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The fits with the modulus of each material of the balls, if they have several."""
    kinds = dict.fromkeys(each.name for each in result.chain.materials or ())
    free = {replace(each, shot="") for each in result.model.names}
    for name in (Name("materials.young", kind) for kind in kinds):
        if len(kinds) > 1 and name not in free:
            cause = try_further(result, (name,), refit)
            if cause is not None:
                yield cause


def with_masses(result: FitResult, _: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The fit with one mass of the balls that contain sensors, if they are equal."""
    model = result.model
    inside = {
        signal.place.bead(result.chain) - result.chain.strikers
        for _, signal in model.traces if signal.place.body in ("ball", "bead")
    }  # fmt: skip
    balls = sorted(each for each in inside if each > 0)
    if not balls or any(name.key == "mass" for name in model.names):
        return
    name = Name("mass", ",".join(map(str, balls)))
    for factor in MASS_STARTS:
        try:
            cause = try_further(result, (name,), refit, factor=factor)
        except InputError:
            # The balls have several masses.
            return
        if cause is not None:
            yield replace(cause, what=f"another mass of the balls with sensors, {cause.what}")
