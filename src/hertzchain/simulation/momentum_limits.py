"""Limits of the momentum of beads 1 to c, whose contacts push and pull at most as an attraction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..kernels.law_kinds import DAMPED

# Parts below this share of the mass are differences of sums that are mainly rounding errors.
SMALL_PART: Final = 1e-12


def minorant(masses: Array, momenta: Array) -> list[tuple[float, float]]:
    """Mass and momentum of each part of the greatest convex minorant of the limits of momentum.

    ``momenta[c - 1]`` is the limit for the first c beads, as a function of their mass; infinite
    entries set no limit.  The smallest parts are omitted, which lowers a sum of their energies.
    """
    hull = [(0.0, 0.0)]
    for mass, momentum in zip(np.cumsum(masses).tolist(), momenta.tolist(), strict=True):
        if momentum == math.inf:
            continue
        while len(hull) > 1:
            (m0, p0), (m1, p1) = hull[-2:]
            if (p1 - p0) * (mass - m0) < (momentum - p0) * (m1 - m0):
                break
            hull.pop()
        hull.append((mass, momentum))
    least = SMALL_PART * hull[-1][0]
    parts = ((m1 - m0, p1 - p0) for (m0, p0), (m1, p1) in pairwise(hull))
    return [(mass, momentum) for mass, momentum in parts if mass > least]


@dataclass(frozen=True)
class Attraction:
    """Impulses with which damped contacts can pull: ``strength`` times a power of the overlap."""

    strength: Array
    powers: Array

    def impulses(self, overlaps: Array) -> Array:
        """Largest impulse that is left; infinite for nonlinear laws, also of open contacts."""
        found = np.where(np.isinf(self.strength), np.inf, 0.0)
        some = (overlaps > 0.0) & ~np.isinf(self.strength)
        found[some] = self.strength[some] * overlaps[some] ** self.powers[some]
        return found


def attraction_of(chain: Chain, equation: Any, exists: Array) -> Attraction:
    """The attraction of all contacts; an equation without damping forces has no factors of them."""
    strength, powers = np.zeros(chain.beads + 1), np.ones(chain.beads + 1)
    for group in chain.contact_groups:
        row, at = group.law.row(group.contacts.exponent), group.index
        if row.kind == DAMPED and row.attractive:
            powers[at] = row.overlap_power + 1.0
            linear = row.speed_power == 1.0
            strength[at] = equation.damping[at] / powers[at] if linear else np.inf
    return Attraction(np.where(exists, strength, 0.0), powers)
