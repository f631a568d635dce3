"""Short description of a chain: its beads, bodies at the ends and features."""

from __future__ import annotations

import math

import numpy as np

from .changed_tapers import taper_behind
from .description import (
    beads_description,
    cells_in_words,
    implied_features,
    law_in_words,
    mass_in_words,
    shown_features,
    stiffness_in_words,
    strikers_in_words,
)
from .fields import ChainFields
from .laws.elastic import Elastic
from .laws.given_numbers import law_with_value
from .materials import RIGID
from .scattered_radii import ScatteredRadii


def chain_description(chain: ChainFields) -> str:
    """Such as ``20 brass beads, diameter 10 mm, and a cap (5 g, brass), right wall``."""
    beads, bodies, features = _parts(chain)
    joined = [f"{'and ' * (len(bodies) == 1)}{' and '.join(bodies)}"] if bodies else []
    return ", ".join((*beads, *joined, *features))


def description_parts(chain: ChainFields) -> list[str]:
    """The parts of a description; those of strikers and caps are separate, and may have commas."""
    beads, bodies, features = _parts(chain)
    return [*beads, *bodies, *features]


def _parts(chain: ChainFields) -> tuple[list[str], list[str], list[str]]:
    """Words for the beads, for strikers and a cap, and for the law and further features."""
    own = chain._balls
    shape: ChainFields | ScatteredRadii = chain.scatter or chain
    scatter = chain.scatter.words(chain.radii, own) if chain.scatter else ""
    balls = chain.masses[own] if "masses" in chain.given else None
    cells = cells_in_words(shape.radii[own], balls)
    first = described_strikers(chain)
    taper = shape.taper, shape.taper_parameters
    if (chain.strikers or chain.cap) and chain.scaled:
        taper = taper_behind(shape.radii[own])
    materials = chain.materials[own] if chain.materials else None
    kind = shape.radii[own], materials, *taper, cells, scatter, balls
    beads = beads_description(*kind, strikers=chain.strikers, scaled=chain.scaled)
    equal = bool((chain.stiffness[: own.stop - 1] == 1.0).all())
    implied = implied_features(beads, scaled=chain.scaled, equal_contacts=equal)
    if not _mixed_between(chain):
        implied.append("mixed exponents")
    named = shown_features(chain.features, implied, chain.velocities, chain.strikers)
    walls = {f"{side} wall": described_wall(chain, side) for side in ("left", "right")}
    named = [described_loss(chain) if "loss" in name else walls.get(name, name) for name in named]
    still = chain._at_rest_by_default and chain.drive is None and not chain.velocities.any()
    features = [law_in_words(chain.exponents), *named, "at rest" if still else ""]
    return (
        beads.split(", "),
        [each for each in (first, cap_in_words(chain)) if each],
        [each for each in features if each],
    )


def described_strikers(chain: ChainFields) -> str:
    """Such as ``1 striker (mass 5 g, flat)``; empty without strikers."""
    spheres, count = chain.strikers_are_spheres, chain.strikers
    known = spheres and count == 1 and not chain.scaled
    return strikers_in_words(
        count, (chain.scatter or chain).radii, None if spheres else chain.masses, chain.units,
        None if chain.materials is None else chain.materials[: chain._balls.stop],
        flat=any(each.flat for each in chain.striker_properties),
        mass=float(chain.masses[0]) if known else math.nan,
    )  # fmt: skip


def cap_in_words(chain: ChainFields) -> str:
    """Such as ``a cap (5 g, glass, pad of 1 kN/mm)``, without a material if the chain has none."""
    if chain.cap is None:
        return ""
    mass = float(chain.masses[-1])
    words = f"mass {mass:.4g}" if chain.scaled else mass_in_words(mass)
    kind = [each.name for each in (chain.materials or ())[-1:]]
    k = float(chain.stiffness[-1])
    pad = [f"pad of {stiffness_in_words(k, 1.0)}"] if _on_pad(chain) and not chain.scaled else []
    return f"a cap ({', '.join([words, *kind, *pad])})"


def _on_pad(chain: ChainFields) -> bool:
    """Whether a linear spring is between the last ball and the cap, and not between others."""
    p = chain.contact_exponents[1:-1]
    return chain.cap is not None and bool(p[-1] == 1.0 and (p[:-1] != 1.0).all())


def described_wall(chain: ChainFields, side: str) -> str:
    """Such as ``right wall of brass`` or ``right wall of 20 kN/mm``; empty at a free end.

    A wall of the material of the bead next to it is a ``right wall``.
    """
    wall, end = (chain.left_wall, 0) if side == "left" else (chain.right_wall, -1)
    if wall is None:
        return ""
    name = f"{side} wall"
    p = float(chain.contact_exponents[end])
    if wall.stiffness is not None and not chain.scaled:
        return f"{name} of {stiffness_in_words(wall.stiffness, p)}"
    usual = wall.exponent is None or bool(np.all(chain.exponents == wall.exponent))
    law = "" if usual else f" (p = {p:g})"
    if wall.stiffness is not None:
        return f"{name} of stiffness {wall.stiffness:.4g}{law}"
    if wall.material == RIGID:
        return f"rigid {name}{law}"
    own = None if chain.materials is None else chain.materials[end]
    return f"{name}{'' if wall.material in (None, own) else f' of {wall.material.name}'}{law}"


def described_loss(chain: ChainFields) -> str:
    """Such as ``restitution 0.95``; ``restitution 0.95 between beads`` if walls have other laws."""
    row = chain.contact_losses[1] if chain.beads > 1 else chain.contact_losses[-1]
    words = law_with_value(row, chain.units)
    if "loss" in chain.features:
        return words
    one = len({*chain.contact_losses[1:-1]}) == 1 and not isinstance(row, Elastic)
    return f"{words} between beads" if one else "mixed losses"


def _mixed_between(chain: ChainFields) -> bool:
    """Whether exponents differ apart from those of walls and pads, which their words show."""
    p = chain.contact_exponents
    left, right = (
        wall is not None and wall.exponent is not None
        for wall in (chain.left_wall, chain.right_wall)
    )
    shown = {0: left, -1: right, -2: _on_pad(chain) and not chain.scaled}
    return len({*np.delete(p, [i for i, told in shown.items() if told])}) > 1
