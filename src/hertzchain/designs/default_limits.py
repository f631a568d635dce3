"""Limits that are added to a problem: the range in which forces are a prediction."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.hertz_ratios import NO_PREDICTION, bodies_of, given_contacts, linear_springs
from .ball_space import BallSpace
from .measures import Measure, measure_of
from .requirements import Requirement
from .size_space import SizeSpace

# Part of the limit that a bound must not exceed: a scatter changes the sizes.
MARGIN: Final = 0.8
OVERLAP: Final = "overlap_ratio"


def default_requirements(
    chain: Chain, measures: Iterable[Measure], model: str, space: SizeSpace | BallSpace
) -> tuple[Requirement, ...]:
    """The largest overlap / radius, unless it has a given limit or no chain can exceed it.

    Without this limit, searches prefer soft balls with overlaps or dents as large as the balls.
    """
    found = list(measures)
    simulated = model == "simulation" and not all(each.of_chain for each in found)
    limited = any(each.key == OVERLAP for each in found)
    if not simulated or limited or chain.units != "SI" or chain.materials is None:
        return ()
    yields = any(law.yields for law in chain.contact_losses)
    if not yields and largest_overlap_bound(space) <= MARGIN * NO_PREDICTION:
        return ()
    measure = measure_of(chain, OVERLAP)
    return (Requirement(measure, NO_PREDICTION, 1, chain.units, default=True),)


def largest_overlap_bound(space: SizeSpace | BallSpace) -> float:
    r"""Upper bound of overlap / radius of elastic contacts in all chains; infinite if unknown.

    A contact stores at most the energy :math:`E` of the impact.  With
    :math:`E = \tfrac25 k d^{5/2}` and :math:`k = \tfrac43 E^*\sqrt{R}`,

    .. math:: d/R \le \left(\frac{15 E}{8 E^* R^3}\right)^{2/5} .
    """
    chain = space.chain
    if chain.drive is not None or chain.gravity or chain.precompression > 0.0:
        return np.inf
    if (given_contacts(chain) & ~linear_springs(chain)).any():
        return np.inf
    radii, masses, bodies = chain.face_radii.copy(), chain.masses.copy(), list(bodies_of(chain))
    if isinstance(space, SizeSpace):
        for block in space.blocks:
            if block.field == "radii":
                masses[block.places] *= (block.high / chain.radii[block.places]) ** 3
                radii[block.places] = block.low
        for block in space.blocks:
            if block.field == "masses":
                masses[block.places] = block.high
    elif not space.order:
        volumes = [4.0 / 3.0 * np.pi * ball.radius**3 for ball in space.balls]
        heaviest = (
            ball.material.density * each for ball, each in zip(space.balls, volumes, strict=True)
        )
        masses[space.places] = max(heaviest)
        radii[space.places] = min(ball.radius for ball in space.balls)
        bodies += [ball.material for ball in space.balls]
    energy = 0.5 * float(masses @ chain.velocities**2)
    # Of two bodies of the softest material, and of two of the smallest balls.
    modulus = 0.5 / max(each.compliance for each in bodies)
    radius = 0.5 * float(radii.min())
    return float((15.0 * energy / (8.0 * modulus * radius**3)) ** 0.4)
