"""Compute masses and contact stiffness from radii and, in SI units, from materials."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..collision import HERTZ_EXPONENT, Array, hertz_stiffness
from ..errors import InputError
from ..units import unit_of_stiffness
from .materials import Material, Materials, contact_moduli, contact_modulus, sphere_stiffness
from .walls import Wall, material_of_wall


def sphere_masses(radii: Array, materials: Materials, *, scaled: bool) -> Array:
    r"""Masses of spheres.

    .. math:: m_k = R_k^3, \qquad m_k = \tfrac{4}{3} \pi \rho_k R_k^3

    in scaled variables (Eq. (3) of the paper) and in SI units.
    """
    if scaled:
        return radii**3
    densities = np.array([each.density for each in _required(materials, "masses")])
    with np.errstate(over="ignore", under="ignore"):
        return 4.0 / 3.0 * math.pi * densities * radii**3


def _shape_with(exponent: float) -> str:
    """Bodies of known stiffness whose contacts have an exponent, for a message."""
    calls = {1.0: "Pad(stiffness)", 2.0: "Cone(half_angle)"}
    call = calls.get(exponent)
    return "" if call is None else f", or set with_contacts({call}) for the chain of exponent 1.5"


def contact_stiffness(
    radii: Array, materials: Materials, exponents: Array, *, scaled: bool
) -> Array:
    r"""Stiffness of Hertz contacts of neighbouring spheres.

    .. math:: r_k = \sqrt{\frac{2 R_k R_{k+1}}{R_k + R_{k+1}}}

    in scaled variables (below Eq. (4) of the paper); for SI units, see
    `hertzchain.chain.materials.sphere_stiffness`.
    """
    if scaled:
        return hertz_stiffness(radii[:-1], radii[1:])
    known = _required(materials, "stiffness")
    others = exponents[exponents != HERTZ_EXPONENT]
    if len(others):
        p = float(others[0])
        raise InputError(
            f"materials determine the stiffness of Hertz contacts (exponent 1.5) only, not of p = "
            f"{p:g}; give stiffness in {unit_of_stiffness(p)}{_shape_with(p)}"
        )
    return sphere_stiffness(radii[:-1], radii[1:], contact_moduli(known))


def wall_stiffness(
    wall: Wall,
    radius: float,
    material: Material | None,
    *,
    scaled: bool,
    given: bool,
    exponent: float,
) -> float:
    r"""Stiffness of the contact of a bead with a flat wall.

    In scaled variables it is :math:`\sqrt{2R}` for a wall of the bead's own material and twice as
    much for a rigid wall.  The argument ``given`` states whether the stiffness of the contacts of
    the beads is given; ``exponent`` is that of the contact with the wall.
    """
    known = not scaled and material is not None
    if wall.material is not None and math.isfinite(wall.material.young) and not known:
        raise InputError(
            f"a wall of {wall.material.name} requires a chain with materials "
            "(Chain.from_materials); for a scaled chain use Wall(), Wall.rigid() or "
            "Wall(stiffness=...)"
        )
    if wall.stiffness is not None:
        return wall.stiffness
    if exponent != HERTZ_EXPONENT:
        raise InputError(
            "the stiffness of a wall follows from materials only for Hertz contacts (exponent "
            f"1.5), not for p = {exponent:g}; give Wall(stiffness=...)"
        )
    if math.isinf(radius):
        raise InputError(
            "a flat striker or cap has no Hertz contact with a wall: give the stiffness of the "
            "wall, such as Wall('5 kN/mm', exponent=1) for a load cell, or omit the wall behind a "
            "free body"
        )
    if given and (scaled or material is None):
        raise InputError(
            "the stiffness of a wall follows from the material of the beads, which is unknown in "
            "a chain with given stiffness; give Wall(stiffness=...), which is sqrt(2) times the "
            "stiffness of the contacts for equal beads and a wall of their material"
        )
    if not scaled and material is not None:
        modulus = contact_modulus(material, material_of_wall(wall, material))
        return float(sphere_stiffness(radius, math.inf, modulus))
    return math.sqrt(2.0 * radius) * (1.0 if wall.material is None else 2.0)


def _required(materials: Materials, needed: str) -> Sequence[Material]:
    if materials is None:
        raise InputError(
            f"a chain in SI units requires {needed} or materials; Chain.from_materials builds "
            "one from radii and materials"
        )
    return materials
