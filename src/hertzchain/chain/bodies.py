"""Masses and stiffness that follow from radii, and in SI units from materials."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from hertzchain.chain.materials import Material, contact_modulus, sphere_stiffness
from hertzchain.contacts import HERTZ_EXPONENT, Array, hertz_stiffness
from hertzchain.errors import InputError

if TYPE_CHECKING:
    from hertzchain.chain.chain import Chain
    from hertzchain.chain.walls import Wall


def masses_of(chain: Chain) -> Array:
    r"""Masses of spheres.

    .. math:: m_k = R_k^3, \qquad m_k = \tfrac{4}{3} \pi \rho_k R_k^3

    scaled (Eq. (3) of the paper) and in SI units.

    Parameters
    ----------
    chain : Chain
        A chain, of which only radii, units and materials are looked at.

    Returns
    -------
    ndarray, shape (N,)
        Masses [scaled, or kg].

    Raises
    ------
    InputError
        If there are SI units without materials.

    Examples
    --------
    >>> import hertzchain as hc
    >>> masses_of(hc.Chain.from_radii([1.0, 2.0]))
    array([1., 8.])
    """
    if chain.units == "scaled":
        return chain.radii**3
    densities = np.array([each.density for each in _materials(chain, "masses")])
    with np.errstate(over="ignore", under="ignore"):
        return 4.0 / 3.0 * math.pi * densities * chain.radii**3


def stiffness_of(chain: Chain) -> Array:
    r"""Stiffness of Hertz contacts of neighbouring spheres.

    .. math:: r_k = \sqrt{\frac{2 R_k R_{k+1}}{R_k + R_{k+1}}}

    scaled (below Eq. (4) of the paper); in SI units
    `hertzchain.chain.materials.sphere_stiffness`.

    Parameters
    ----------
    chain : Chain
        A chain, of which only radii, units, exponent and materials are looked at.

    Returns
    -------
    ndarray, shape (N - 1,)
        Stiffness [scaled, or N/m^p].

    Raises
    ------
    InputError
        If there are SI units without materials, or with another exponent than Hertz'.

    Examples
    --------
    >>> import hertzchain as hc
    >>> stiffness_of(hc.Chain.uniform(3))
    array([1., 1.])
    """
    radii = chain.radii
    if chain.units == "scaled":
        return hertz_stiffness(radii[:-1], radii[1:])
    materials = _materials(chain, "stiffness")
    if chain.exponent != HERTZ_EXPONENT:
        raise InputError(
            f"materials give the stiffness of Hertz contacts (exponent 1.5), not of p = "
            f"{chain.exponent:g}: give stiffness, in N/m^{chain.exponent:g}"
        )
    compliance = np.array([each.compliance for each in materials])
    with np.errstate(divide="ignore", over="ignore"):
        modulus = 1.0 / (compliance[:-1] + compliance[1:])
    return np.asarray(sphere_stiffness(radii[:-1], radii[1:], modulus))


def wall_stiffness_of(chain: Chain, wall: Wall | None, bead: int) -> float:
    r"""Stiffness of the contact of a bead with a flat wall; 0 without one.

    Scaled, a wall of the bead's own material has :math:`\sqrt{2R}`, a rigid one twice as much.

    Parameters
    ----------
    chain : Chain
        The chain.
    wall : Wall or None
        The wall.
    bead : int
        Index of the bead, from 0.

    Returns
    -------
    float
        Stiffness [scaled, or N/m^p].

    Raises
    ------
    InputError
        If it does not follow from what is known of the materials.

    Examples
    --------
    >>> import hertzchain as hc
    >>> round(wall_stiffness_of(hc.Chain.uniform(3), hc.Wall.rigid(), 2), 6)
    2.828427
    """
    if wall is None:
        return 0.0
    if wall.stiffness is not None:
        return wall.stiffness
    # In SI units the materials decide, whatever the other contacts are.
    odd = "stiffness" in chain.given and chain.materials is None
    if chain.exponent != HERTZ_EXPONENT or odd:
        raise InputError(
            "the stiffness of a wall follows from materials only where the contacts are all "
            "Hertz': give Wall(stiffness=...)"
        )
    radius = float(chain.radii[bead])
    if chain.units == "SI" and chain.materials is not None:
        own = chain.materials[bead]
        modulus = contact_modulus(own, own if wall.material is None else wall.material)
        return float(sphere_stiffness(radius, math.inf, modulus))
    if wall.material is not None and math.isfinite(wall.material.young):
        raise InputError(
            f"a scaled chain has no material to hold against a wall of {wall.material.name}: "
            "use Chain.from_materials, Wall(), Wall.rigid() or Wall(stiffness=...)"
        )
    return math.sqrt(2.0 * radius) * (1.0 if wall.material is None else 2.0)


def _materials(chain: Chain, needed: str) -> tuple[Material, ...]:
    if chain.materials is None:
        raise InputError(
            f"a chain in SI units needs {needed} or materials; Chain.from_materials makes "
            "one of radii and materials"
        )
    return chain.materials
