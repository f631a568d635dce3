r"""Force law of one contact and head-on collision of two beads.

A contact of stiffness :math:`k` and overlap :math:`d > 0` pushes its two beads
apart with the force

.. math:: F = k\,d^{\,p},

with :math:`p = 3/2` for elastic bodies with smooth round surfaces (Hertz).  The
contact carries no tension.  This module treats a single contact:
`hertzchain.simulation.simulate` integrates chains with many contacts, and
`hertzchain.theory` has approximations in which one contact acts at a time.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError, real_number, short_repr

__all__ = (
    "collision_cascade", "collision_overlap", "compression_time", "hertz_stiffness",
    "reduced_mass", "velocity_transfer",
)  # fmt: skip

# Arrays of float64, unless a docstring states another type.
Array: TypeAlias = NDArray[Any]

HERTZ_EXPONENT = 1.5


def __dir__() -> tuple[str, ...]:
    return __all__  # for completion


def _floats(values: ArrayLike) -> Array:
    """Convert to floats; quantities and masked arrays are rejected."""
    if type(values) is np.ndarray and values.dtype == float:
        return values
    # NumPy would drop the unit of a quantity and the mask of a masked array.
    if hasattr(values, "magnitude") or np.ma.is_masked(values):
        raise InputError(f"contact formulas require plain numbers, got {short_repr(values)}")
    return np.asarray(values, float)


def _exponents(given: float | Array) -> float | Array:
    """One exponent, or an array with one for each contact."""
    return given if isinstance(given, np.ndarray) else real_number("exponent", given)


def _compression_integral(s: float) -> float:
    return math.sqrt(math.pi) * math.gamma(1.0 + s) / math.gamma(0.5 + s)


_compression_integrals = np.vectorize(_compression_integral, otypes=[float])


def hertz_stiffness(radius: ArrayLike, next_radius: ArrayLike) -> Array:
    r"""Scaled contact stiffness of two spheres of the same material.

    .. math:: r_k = \left[\frac{2 R_k R_{k+1}}{R_k + R_{k+1}}\right]^{1/2}

    This is the factor in Eqs. (1) and (4) of the paper.  Two spheres of unit radius
    have stiffness one.

    Parameters
    ----------
    radius, next_radius : array_like
        Radii of the beads on the left and right of each contact [scaled], > 0.

    Returns
    -------
    ndarray
        Stiffness of each contact [scaled].

    Examples
    --------
    >>> import hertzchain as hc
    >>> float(hc.collision.hertz_stiffness(1.0, 1.0))
    1.0
    """
    left, right = _floats(radius), _floats(next_radius)
    # R_k/(R_k + R_k+1) is evaluated first: the product of two tiny radii would underflow.
    return np.sqrt(2.0 * left * (right / (left + right)))


def velocity_transfer(mass: ArrayLike, next_mass: ArrayLike, restitution: float = 1.0) -> Array:
    r"""Velocity ratio of a head-on collision with a bead at rest.

    .. math:: \frac{v_{k+1}}{v_k} = \frac{1 + e}{1 + m_{k+1}/m_k}

    For e = 1 this is one factor of the product for the BCA, Eq. (5) of the paper.

    Parameters
    ----------
    mass, next_mass : array_like
        Masses of the moving bead and of the bead at rest, in the same unit.
    restitution : float
        Coefficient of restitution e, the ratio of the relative speeds after and before
        the collision, 0 < e <= 1.

    Returns
    -------
    ndarray
        Velocity of the second bead after the collision, divided by that of the first bead
        before it.

    Examples
    --------
    Equal beads exchange their velocities:

    >>> import hertzchain as hc
    >>> float(hc.collision.velocity_transfer(1.0, 1.0))
    1.0
    """
    return (1.0 + _floats(restitution)) / (1.0 + _floats(next_mass) / _floats(mass))


def collision_cascade(masses: ArrayLike, restitution: float = 1.0) -> Array:
    r"""Velocities of beads that collide one after the other, each with the next at rest.

    .. math:: v_k = \prod_{j=1}^{k-1} \frac{1 + e}{1 + m_{j+1}/m_j}, \qquad v_1 = 1

    For e = 1 this is Eq. (5) of the paper.

    Parameters
    ----------
    masses : array_like, shape (N,)
        Masses of the beads in any unit, starting with the struck bead.
    restitution : float
        Coefficient of restitution e, 0 < e <= 1.

    Returns
    -------
    ndarray, shape (N,)
        Velocities, in units of the impact velocity.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.collision.collision_cascade([1.0, 1.0, 3.0])
    array([1. , 1. , 0.5])
    """
    m = _floats(masses)
    return np.concatenate(([1.0], np.cumprod(velocity_transfer(m[:-1], m[1:], restitution))))


def reduced_mass(mass: ArrayLike, next_mass: ArrayLike) -> Array:
    r"""Reduced mass :math:`\mu_k = m_k m_{k+1}/(m_k + m_{k+1})` of two beads.

    Parameters
    ----------
    mass, next_mass : array_like
        Masses of the two beads, in the same unit.

    Returns
    -------
    ndarray
        Reduced mass, in this unit.

    Examples
    --------
    >>> import hertzchain as hc
    >>> float(hc.collision.reduced_mass(1.0, 1.0))
    0.5
    """
    left, right = _floats(mass), _floats(next_mass)
    return left * (right / (left + right))


def collision_overlap(
    reduced: ArrayLike,
    stiffness: ArrayLike,
    speed: ArrayLike,
    exponent: float | Array = HERTZ_EXPONENT,
) -> Array:
    r"""Largest overlap of two colliding beads.

    .. math:: d = \left[\frac{(p+1)\,\mu v^2}{2k}\right]^{1/(p+1)}

    At this overlap all kinetic energy of the relative motion, :math:`\mu v^2/2`, is
    stored in the contact, :math:`k d^{p+1}/(p+1)`.

    Parameters
    ----------
    reduced : array_like
        Reduced mass [scaled].
    stiffness : array_like
        Contact stiffness [scaled].
    speed : array_like
        Relative speed when the contact begins [scaled].
    exponent : float or ndarray
        Exponent p of the force law, > 1; one, or one for each contact.

    Returns
    -------
    ndarray
        Overlap when the two velocities are equal [scaled].

    Examples
    --------
    >>> import hertzchain as hc
    >>> round(float(hc.collision.collision_overlap(0.5, 1.0, 1.0)), 6)
    0.828614
    """
    exponent = _exponents(exponent)
    energy = _floats(reduced) * np.square(_floats(speed)) / 2.0
    return np.asarray(((exponent + 1.0) * energy / _floats(stiffness)) ** (1.0 / (exponent + 1.0)))


def compression_time(
    reduced: ArrayLike,
    stiffness: ArrayLike,
    speed: ArrayLike,
    exponent: float | Array = HERTZ_EXPONENT,
) -> Array:
    r"""Time from the beginning of a collision to the largest overlap.

    .. math::

        T = I_p \left[\frac{(p+1)\mu}{2k}\right]^{1/(p+1)} v^{-(p-1)/(p+1)},
        \qquad
        I_p = \int_0^1 \frac{du}{\sqrt{1-u^{p+1}}}
            = \sqrt{\pi}\,\frac{\Gamma(1+\frac{1}{p+1})}{\Gamma(\frac12+\frac{1}{p+1})} .

    In the binary collision approximation this is the residence time :math:`T_k` of the
    pulse on a bead (Rosas and Lindenberg, Phys. Rev. E 69, 037601, 2004,
    doi:10.1103/PhysRevE.69.037601).

    Parameters
    ----------
    reduced, stiffness, speed, exponent
        As for `collision_overlap`.

    Returns
    -------
    ndarray
        Half the duration of the collision [scaled].

    Examples
    --------
    Twice :math:`I_{3/2}` is the constant 2.943275 of Hertz's contact time:

    >>> import hertzchain as hc
    >>> overlap = hc.collision.collision_overlap(0.5, 1.0, 1.0)
    >>> round(float(2 * hc.collision.compression_time(0.5, 1.0, 1.0) / overlap), 6)
    2.943275
    """
    s = 1.0 / (_exponents(exponent) + 1.0)
    integral = _compression_integral(s) if isinstance(s, float) else _compression_integrals(s)
    return integral * collision_overlap(reduced, stiffness, speed, exponent) / _floats(speed)
