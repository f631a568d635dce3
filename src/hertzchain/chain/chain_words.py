"""Short description of a chain: its beads, bodies at the ends and features."""

from __future__ import annotations

from .description import (
    beads_description,
    cells_in_words,
    implied_features,
    law_in_words,
    mass_in_words,
    shown_features,
    strikers_in_words,
    taper_behind,
)
from .fields import ChainFields
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
    masses = None if chain.strikers_are_spheres else chain.masses
    before = None if chain.materials is None else chain.materials[: own.stop]
    first = strikers_in_words(chain.strikers, shape.radii, masses, chain.units, before)
    taper = shape.taper, shape.taper_parameters
    if (chain.strikers or chain.cap) and chain.scaled:
        taper = taper_behind(shape.radii[own])
    materials = chain.materials[own] if chain.materials else None
    kind = shape.radii[own], materials, *taper, cells, scatter, balls
    beads = beads_description(*kind, strikers=chain.strikers, scaled=chain.scaled)
    equal = bool((chain.stiffness[: own.stop - 1] == 1.0).all())
    implied = implied_features(beads, scaled=chain.scaled, equal_contacts=equal)
    named = shown_features(chain.features, implied, chain.velocities, chain.strikers)
    still = chain._at_rest_by_default and chain.drive is None and not chain.velocities.any()
    features = [law_in_words(chain.exponents), *named, "at rest" if still else ""]
    return (
        beads.split(", "),
        [each for each in (first, cap_in_words(chain)) if each],
        [each for each in features if each],
    )


def cap_in_words(chain: ChainFields) -> str:
    """Such as ``a cap (5 g, glass)``, or without a material if the chain has none."""
    if chain.cap is None:
        return ""
    mass = float(chain.masses[-1])
    words = f"mass {mass:.4g}" if chain.scaled else mass_in_words(mass)
    kind = [each.name for each in (chain.materials or ())[-1:]]
    return f"a cap ({', '.join([words, *kind])})"
