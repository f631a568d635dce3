"""Short description of a chain: its beads, bodies at the ends and features."""

from __future__ import annotations

from .description import (
    beads_description,
    cells_in_words,
    features_in_words,
    implied_features,
    law_in_words,
    mass_in_words,
    strikers_in_words,
    taper_behind,
)
from .fields import ChainFields
from .scattered_radii import ScatteredRadii


def chain_description(chain: ChainFields) -> str:
    """Such as ``20 brass beads, diameter 10 mm, and a cap (5 g), right wall``."""
    law, own = law_in_words(chain.exponents), chain._balls
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
    others = [each for each in (first, cap_in_words(chain)) if each]
    beads += f", {'and ' * (len(others) == 1)}{' and '.join(others)}" if others else ""
    rest = features_in_words(chain.features, implied, chain.velocities, chain.strikers)
    still = chain._at_rest_by_default and chain.drive is None and not chain.velocities.any()
    return f"{beads}{law}{rest}{', at rest' * still}"


def cap_in_words(chain: ChainFields) -> str:
    """Such as ``a cap (5 g)``, with its material if the last ball has another one."""
    if chain.cap is None:
        return ""
    mass = float(chain.masses[-1])
    words = f"mass {mass:.4g}" if chain.scaled else mass_in_words(mass)
    kinds = list(dict.fromkeys(each.name for each in (chain.materials or ())[-2:]))
    return f"a cap ({', '.join([words, *kinds[1:]])})"
