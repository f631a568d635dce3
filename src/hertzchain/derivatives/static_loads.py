"""Derivatives with respect to static loads, through overlaps and forces at time 0."""

from __future__ import annotations

import numpy as np

from ..collision import Array
from .backward_pass import Slopes
from .equation import Equation


def add_static_loads(equation: Equation, slopes: Slopes) -> tuple[Slopes, float, float]:
    """Slopes that include the static state, and those by precompression and gravity.

    At rest the overlaps are :math:`d_c = (F_c/k_c)^{1/p}`, where the force of a contact is the
    precompression plus the weight of the beads that it carries.
    """
    chain, static = equation.chain, equation.chain.static_state
    by_gravity = float(slopes.body.sum())
    if not static.forces.any():
        return slopes, 0.0, by_gravity
    first, g, forces = chain.strikers, chain.gravity, static.forces
    loaded = forces > 0.0
    # Strikers touch the chain without overlap.
    loaded[1 : first + 1] = False
    loaded &= equation.stiffness > 0.0
    p, k = equation.exponents[loaded], equation.stiffness[loaded]
    overlap = (forces[loaded] / k) ** (1.0 / p)
    by_force = np.zeros(len(forces))
    by_force[loaded] = slopes.overlaps[loaded] * overlap / (p * forces[loaded])
    by_stiffness = slopes.stiffness.copy()
    by_stiffness[loaded] -= slopes.overlaps[loaded] * overlap / (p * k)
    by_mass = slopes.masses.copy()
    if chain.precompression > 0.0:
        for bead, contact, sign, wall in (
            (first, first, 1.0, chain.left_wall), (-1, -1, -1.0, chain.right_wall)
        ):  # fmt: skip
            if wall is None:
                mass = equation.masses[bead]
                by_force[contact] += sign * slopes.body[bead] / mass
                by_mass[bead] -= sign * slopes.body[bead] * forces[contact] / mass**2
    by_mass[first:] += abs(g) * _carried_by(by_force[first:], g)
    weights = equation.masses[first:]
    above = np.concatenate(([0.0], np.cumsum(weights if g >= 0.0 else weights[::-1])))
    above = above if g >= 0.0 else -above[::-1]
    by_gravity += float(by_force[first:] @ above)
    by_load = float(by_force[first:].sum())
    full = Slopes(by_mass, by_stiffness, slopes.overlaps, slopes.velocities, slopes.body,
                  slopes.damping)  # fmt: skip
    return full, by_load, by_gravity


def _carried_by(by_force: Array, gravity: float) -> Array:
    """Sum, for each bead, over the contacts that carry its weight."""
    if gravity >= 0.0:
        return np.asarray(np.cumsum(by_force[::-1])[::-1][1:])
    return np.asarray(np.cumsum(by_force)[:-1])
