"""Chains at several speeds of the impact, or from several heights of fall."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

import click

from .chain_options import ChainOptions, chains_from, with_height

if TYPE_CHECKING:
    from ..chain.chain import Chain


@dataclass(frozen=True)
class Impacts:
    """Names of the chains at each of several speeds or heights, by the names of their files.

    Without several speeds or heights, it has no names, and is false.
    """

    kind: Literal["speed", "height"] = "speed"
    names: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.names)


def chains_at_impacts(options: ChainOptions) -> tuple[dict[str, Chain], Impacts]:
    """The chains of all files at all speeds or heights, and their names at each of several."""
    if not options.others:
        return chains_from(options), Impacts()
    kind: Literal["speed", "height"] = "speed" if options.height is None else "height"
    chains: dict[str, Chain] = {}
    names: dict[str, dict[str, str]] = {}
    for value in (getattr(options, kind), *options.others):
        given = with_height(value) if kind == "height" else {"speed": value}
        found = chains_from(replace(options, **given, others=()))
        for name, chain in found.items():
            label = _label(chain, kind)
            own = f"{name}, {label}" if name else label
            if own in chains:
                raise click.UsageError(f"--{kind} is {label} twice; keep one")
            chains[own] = chain
            names.setdefault(label, {})[name] = own
    return chains, Impacts(kind, names)


def value_of_impact(chain: Chain, kind: Literal["speed", "height"]) -> float:
    """The speed of the impact, or the height from which a body falls to reach it."""
    from ..units import STANDARD_GRAVITY

    speed = float(chain.velocities.max())
    return speed if kind == "speed" else speed**2 / (2.0 * STANDARD_GRAVITY)


def _label(chain: Chain, kind: Literal["speed", "height"]) -> str:
    from ..representation import measure

    value = value_of_impact(chain, kind)
    if kind == "height":
        # Heights of a metre and more are in metres, not 2e+04 mm.
        return f"{value:.4g} m" if value >= 1.0 - 1e-9 else f"{1e3 * value:.4g} mm"
    return measure(value, "m/s", chain.units, 4).strip()
