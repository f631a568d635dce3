"""Conversion of chains and results for scaled methods, which accept chains in any units.

Theories compute in the paper's scaled variables.  `for_any_units` makes such a function accept
chains in SI units and return results in SI units; it also checks that the method supports the
chain.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Sequence
from typing import Any, Final, TypeVar

import numpy as np

from ..chain.chain import Chain
from ..chain.conversion import ROUNDING
from ..chain.feature_support import Alternative, require_chain, require_struck, require_supported
from ..chain.hertz_warnings import warn_outside_hertz
from ..chain.scales import Scales
from ..errors import InputError, ModelRangeWarning
from ..recorded_warnings import ObserveWarnings
from .notes import WARNING
from .pulse import Pulse
from .quantities import QUANTITIES

F = TypeVar("F", bound=Callable[..., Any])
P = TypeVar("P", bound=Pulse)
# Features that a chain in SI units may lose, or gain, when it is scaled.
UNIT_FEATURES: Final = ("SI units", "masses", "stiffness")


def for_any_units(
    method: str, *, supported: Sequence[str] = (), alternative: Alternative = ""
) -> Callable[[F], F]:
    """Decorate a function of a scaled chain that returns a `Pulse`.

    ``supported`` are the features of a chain (`Chain.features`) that the function supports, and
    ``alternative`` is the advice for a chain that has others.
    """

    def decorate(function: F) -> F:
        @functools.wraps(function)
        def convert(chain: Chain, *args: Any, **options: Any) -> Any:
            scaled = scaled_chain(chain, method, supported, alternative)
            with ObserveWarnings(ModelRangeWarning) as warned:
                pulse = function(scaled, *args, **options)
                if scaled is not chain:
                    pulse = in_units_of(chain, pulse)
                    if pulse.peak_overlap is not None:
                        warn_outside_hertz(chain, pulse.peak_overlap, method=pulse.method)
            return with_warnings(pulse, warned)

        return convert  # type: ignore[return-value]

    return decorate


def with_warnings(pulse: Pulse, warned: Sequence[str]) -> Pulse:
    """A pulse that keeps the warnings of its method in its notes."""
    if not warned:
        return pulse
    texts = "; ".join(dict.fromkeys(warned))
    return dataclasses.replace(pulse, notes={**pulse.notes, WARNING: texts})


def scaled_chain(
    chain: Chain, method: str, supported: Sequence[str] = (), alternative: Alternative = ""
) -> Chain:
    """The chain in scaled variables, after checking that a method supports it."""
    require_chain(method, chain)
    # Theories of a struck chain have one body that moves at time 0.
    if "strikers" in supported and chain.strikers > 1:
        raise InputError(
            f"{method} supports one striker, but the chain has {chain.strikers}; use simulate "
            f"(chain: {chain.description})"
        )
    if chain.units == "scaled":
        require_supported(chain, method, supported=supported, alternative=alternative)
        return chain
    require_supported(
        chain, method, supported=(*supported, *UNIT_FEATURES), alternative=alternative
    )
    require_struck(method, chain)
    scaled = Scales.of(chain).to_scaled(chain)
    # Messages describe the chain as it was given.
    scaled._set("_described_as", chain.description)
    require_supported(scaled, method, supported=supported, alternative=alternative)
    return scaled


def in_units_of(chain: Chain, pulse: P) -> P:
    """Convert a scaled pulse to the units of its chain."""
    if chain.units == pulse.chain.units:
        return pulse
    return dataclasses.replace(Scales.of(chain).to_si(pulse), chain=chain)


def in_same_units(pulse: P, reference: P) -> tuple[P, P]:
    """Convert two pulses of one chain to the same units: SI if one of them is in SI units."""
    ours, theirs = pulse.chain, reference.chain
    if ours.units == theirs.units or not np.array_equal(ours.exponents, theirs.exponents):
        return pulse, reference
    if ours.units == "SI":
        return pulse, Scales.of(ours).to_si(reference)
    return Scales.of(theirs).to_si(pulse), reference


def same_beads(one: Chain, other: Chain) -> bool:
    """Whether two chains have the same beads and contacts, except for rounding."""
    if one.units != other.units or not np.array_equal(one.exponents, other.exponents):
        return False
    if one.beads != other.beads:
        return False
    return all(
        np.allclose(getattr(one, name), getattr(other, name), rtol=ROUNDING, atol=0.0)
        for name in ("radii", "masses", "stiffness")
    )


def unit_of(chain: Chain, quantity: str) -> float:
    """Unit of a quantity in the scaled variables of a chain; 1 for a scaled chain."""
    scale = "radius" if quantity == "radii" else QUANTITIES[quantity].scale
    return 1.0 if chain.units == "scaled" else float(Scales.of(chain).unit(scale))
