"""Largest overlaps of an impact as a sequence of isolated collisions."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..collision import Array, collision_overlap
from .bisection import bisected
from .contact_groups import reduced_masses
from .fields import ChainFields

# Halvings of an interval of overlaps, to rounding.
BISECTIONS: Final = 53


def impact_overlaps(chain: ChainFields, static: Array) -> Array:
    """Overlaps if each bead hits the next one in an isolated, lossless collision."""
    masses, speeds = chain.masses, chain.velocities.copy()
    closing = np.zeros(chain.beads + 1)
    for k in range(chain.beads - 1):
        closing[k + 1] = max(speeds[k] - speeds[k + 1], 0.0)
        speeds[k + 1] += 2.0 * masses[k] / (masses[k] + masses[k + 1]) * closing[k + 1]
    if chain.right_wall is not None:
        closing[-1] = max(float(speeds[-1]), 0.0)
    found = static.copy()
    struck = closing > 0.0
    found[struck] = _overlap_under_load(
        static[struck], reduced_masses(masses)[struck], chain.contact_stiffness[struck],
        closing[struck], chain.contact_exponents[struck],
    )  # fmt: skip
    return found


def _overlap_under_load(
    static: Array, reduced: Array, stiffness: Array, speed: Array, exponent: Array
) -> Array:
    """Largest overlap of a collision under the constant force of the static overlap."""
    # k (d^q - d0^q)/q - k d0^p (d - d0) = m v^2/2 with q = p + 1, in units of d0 + free.
    free = collision_overlap(reduced, stiffness, speed, exponent)
    if not static.any():
        return free
    unit, q = static + free, exponent + 1.0
    rest, energy = static / unit, (free / unit) ** q

    def below(d: Array) -> Array:
        return np.asarray(d**q - rest**q - q * rest**exponent * (d - rest) < energy)

    return np.asarray(unit * bisected(below, rest, np.ones_like(rest), BISECTIONS))
