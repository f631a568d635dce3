r"""Two beads in contact: the force law and the head-on collision it leads to.

A contact of stiffness :math:`k` and overlap :math:`d > 0` pushes its two beads
apart with the force

.. math:: F = k\,d^{\,p},

with :math:`p = 3/2` for elastic bodies with smooth round surfaces (Hertz).
Beads never pull.  Everything here is about *one* contact; what a whole chain
does with its contacts is the business of `hertzchain.simulation.simulate`, and what
becomes of it if only one contact acts at a time that of `hertzchain.theory`.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hertzchain.errors import InputError, real_number, shown

# Of float64, unless a docstring says otherwise.
Array: TypeAlias = NDArray[Any]

HERTZ_EXPONENT = 1.5


def _floats(values: ArrayLike) -> Array:
    """An array of floats; NumPy alone would strip a unit, or unmask masked entries."""
    if hasattr(values, "magnitude") or np.ma.is_masked(values):
        raise InputError(f"formulas of contacts take plain numbers, got {shown(values)}")
    return np.asarray(values, float)


def hertz_stiffness(radius: ArrayLike, next_radius: ArrayLike) -> Array:
    r"""Contact stiffness of two spheres of one material, scaled.

    .. math:: r_k = \left[\frac{2 R_k R_{k+1}}{R_k + R_{k+1}}\right]^{1/2}

    the factor of Eqs. (1) and (4) of the paper; two spheres of unit radius have
    stiffness one.

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
    >>> float(hertz_stiffness(1.0, 1.0))
    1.0
    """
    left, right = _floats(radius), _floats(next_radius)
    # R_k/(R_k + R_k+1) first: the plain product of two tiny radii underflows.
    return np.sqrt(2.0 * left * (right / (left + right)))


def velocity_transfer(mass: ArrayLike, next_mass: ArrayLike, restitution: float = 1.0) -> Array:
    r"""Velocity handed to a resting bead by a head-on collision.

    .. math:: \frac{v_{k+1}}{v_k} = \frac{1 + e}{1 + m_{k+1}/m_k}

    the factor of the paper's product for the BCA, Eq. (5), where e = 1.

    Parameters
    ----------
    mass, next_mass : array_like
        Masses of the striking and of the struck bead [any one unit].
    restitution : float
        Coefficient of restitution e: relative speed after over before, 0 < e <= 1.

    Returns
    -------
    ndarray
        Ratio of the struck bead's velocity after to the striking bead's before.

    Examples
    --------
    Equal beads exchange their velocities:

    >>> float(velocity_transfer(1.0, 1.0))
    1.0
    """
    return (1.0 + _floats(restitution)) / (1.0 + _floats(next_mass) / _floats(mass))


def collision_cascade(masses: ArrayLike, restitution: float = 1.0) -> Array:
    r"""Velocities if each bead strikes the next, at rest, in a collision of two.

    .. math:: v_k = \prod_{j=1}^{k-1} \frac{1 + e}{1 + m_{j+1}/m_j}, \qquad v_1 = 1

    Eq. (5) of the paper, where e = 1.

    Parameters
    ----------
    masses : array_like, shape (N,)
        Masses of the beads, struck bead first [any one unit].
    restitution : float
        Coefficient of restitution e, 0 < e <= 1.

    Returns
    -------
    ndarray, shape (N,)
        Velocities [of the strike].

    Examples
    --------
    >>> collision_cascade([1.0, 1.0, 3.0])
    array([1. , 1. , 0.5])
    """
    m = _floats(masses)
    return np.concatenate(([1.0], np.cumprod(velocity_transfer(m[:-1], m[1:], restitution))))


def reduced_mass(mass: ArrayLike, next_mass: ArrayLike) -> Array:
    r"""Reduced mass :math:`\mu_k = m_k m_{k+1}/(m_k + m_{k+1})` of two beads.

    Parameters
    ----------
    mass, next_mass : array_like
        Masses of the two beads [any one unit].

    Returns
    -------
    ndarray
        Reduced mass [the same unit].

    Examples
    --------
    >>> float(reduced_mass(1.0, 1.0))
    0.5
    """
    left, right = _floats(mass), _floats(next_mass)
    return left * (right / (left + right))


def collision_overlap(
    reduced: ArrayLike, stiffness: ArrayLike, speed: ArrayLike, exponent: float = HERTZ_EXPONENT
) -> Array:
    r"""Largest overlap of two beads that collide with a relative speed.

    .. math:: d = \left[\frac{(p+1)\,\mu v^2}{2k}\right]^{1/(p+1)}

    where all of the relative motion's energy :math:`\mu v^2/2` sits in the
    contact, :math:`k d^{p+1}/(p+1)`.

    Parameters
    ----------
    reduced : array_like
        Reduced mass [scaled].
    stiffness : array_like
        Contact stiffness [scaled].
    speed : array_like
        Relative speed at first touch [scaled].
    exponent : float
        Exponent p of the force law, > 1.

    Returns
    -------
    ndarray
        Overlap at the moment of equal velocities [scaled].

    Examples
    --------
    >>> round(float(collision_overlap(0.5, 1.0, 1.0)), 6)
    0.828614
    """
    exponent = real_number("exponent", exponent)
    energy = _floats(reduced) * np.square(_floats(speed)) / 2.0
    return np.asarray(((exponent + 1.0) * energy / _floats(stiffness)) ** (1.0 / (exponent + 1.0)))


def compression_time(
    reduced: ArrayLike, stiffness: ArrayLike, speed: ArrayLike, exponent: float = HERTZ_EXPONENT
) -> Array:
    r"""Time from first touch to largest overlap of two colliding beads.

    .. math::

        T = I_p \left[\frac{(p+1)\mu}{2k}\right]^{1/(p+1)} v^{-(p-1)/(p+1)},
        \qquad
        I_p = \int_0^1 \frac{du}{\sqrt{1-u^{p+1}}}
            = \sqrt{\pi}\,\frac{\Gamma(1+\frac{1}{p+1})}{\Gamma(\frac12+\frac{1}{p+1})} .

    It is the residence time :math:`T_k` of the pulse on a bead in the binary
    collision approximation (Rosas and Lindenberg, Phys. Rev. E 69, 037601,
    2004, doi:10.1103/PhysRevE.69.037601).

    Parameters
    ----------
    reduced, stiffness, speed, exponent
        As for `collision_overlap`.

    Returns
    -------
    ndarray
        Half of the contact's duration [scaled].

    Examples
    --------
    Twice :math:`I_{3/2}` is the classic 2.943275 of Hertz' contact time:

    >>> overlap = collision_overlap(0.5, 1.0, 1.0)
    >>> round(float(2 * compression_time(0.5, 1.0, 1.0) / overlap), 6)
    2.943275
    """
    s = 1.0 / (real_number("exponent", exponent) + 1.0)
    integral = math.sqrt(math.pi) * math.gamma(1.0 + s) / math.gamma(0.5 + s)
    return integral * collision_overlap(reduced, stiffness, speed, exponent) / _floats(speed)
