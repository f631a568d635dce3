r"""Small oscillations of a chain that a static force holds together.

Precompressed by a force :math:`F_0`, each contact is a spring of stiffness
:math:`K = p\,k^{1/p} F_0^{1-1/p}` for motions that change its overlap little: V. F.
Nesterenko, *Dynamics of Heterogeneous Materials*, Springer 2001.  Without precompression
there is no sound, and nothing here applies.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import require
from hertzchain.checks import number, real_numbers
from hertzchain.contacts import HERTZ_EXPONENT, Array, hertz_stiffness
from hertzchain.errors import InputError, unknown_name

End = Literal["free", "fixed"]


def linear_stiffness(stiffness: ArrayLike, force: float, exponent: float = HERTZ_EXPONENT) -> Array:
    r"""Spring constant of a contact about its static overlap.

    .. math:: K = \frac{dF}{dd} = p\,k\,d_0^{p-1} = p\,k^{1/p} F_0^{1-1/p}

    Parameters
    ----------
    stiffness : array_like
        Contact stiffness k [scaled, or any consistent units].
    force : float
        Static force F_0 > 0 [the same units].
    exponent : float
        Exponent p of the contact force, > 1.

    Returns
    -------
    ndarray
        Of the shape of ``stiffness``.

    Raises
    ------
    InputError
        If a stiffness or the force is not positive and finite.

    Examples
    --------
    Hertz, unit overlap: d(d^1.5)/dd = 1.5.

    >>> float(linear_stiffness(1.0, 1.0))
    1.5
    """
    k = _checked_positive("stiffness", stiffness)
    f = float(_checked_positive("force", number("force", force)))
    exponent = number("exponent", exponent)
    return exponent * k ** (1.0 / exponent) * f ** (1.0 - 1.0 / exponent)


def dispersion_uniform(wave_number: ArrayLike, *, mass: float = 1.0, spring: float = 1.0) -> Array:
    r"""Frequencies of plane waves in a chain of equal beads.

    .. math:: \omega = 2 \sqrt{K/m}\, |\sin(q/2)|

    Sound runs at :math:`\sqrt{K/m}` beads per time; nothing passes above the cut-off
    :math:`2\sqrt{K/m}`.

    Parameters
    ----------
    wave_number : array_like
        Phase q from bead to bead [radians].
    mass, spring : float
        Mass m of a bead and `linear_stiffness` K of a contact [consistent units].

    Returns
    -------
    ndarray
        Angular frequencies, of the shape of ``wave_number``.

    Raises
    ------
    InputError
        If mass or spring is not positive and finite.

    Examples
    --------
    >>> float(dispersion_uniform(np.pi))
    2.0
    """
    scale = _checked_positive("spring", spring) / _checked_positive("mass", mass)
    half = 0.5 * real_numbers("wave number", wave_number)
    return np.asarray(2.0 * np.sqrt(scale) * np.abs(np.sin(half)))


def dispersion_diatomic(
    wave_number: ArrayLike, *, mass: float = 1.0, other_mass: float, spring: float = 1.0
) -> tuple[Array, Array]:
    r"""Frequencies of plane waves in a chain of two kinds of beads in turn.

    .. math::

        \omega^2 = K \left[ s \mp \sqrt{s^2 - \frac{4 \sin^2(q/2)}{m_1 m_2}} \right],
        \qquad s = \frac1{m_1} + \frac1{m_2}

    Parameters
    ----------
    wave_number : array_like
        Phase q from cell to cell, of two beads each [radians].
    mass, other_mass, spring : float
        The two masses and the `linear_stiffness` K of a contact [consistent units].

    Returns
    -------
    acoustic, optical : ndarray
        Angular frequencies of the two branches, of the shape of ``wave_number``.

    Raises
    ------
    InputError
        If a mass or the spring is not positive and finite.

    Examples
    --------
    >>> acoustic, optical = dispersion_diatomic(np.pi, other_mass=0.25)
    >>> (float(acoustic) ** 2, float(optical) ** 2)
    (2.0, 8.0)
    """
    a, b = _checked_positive("mass", mass), _checked_positive("other_mass", other_mass)
    k, half = _checked_positive("spring", spring), 0.5 * real_numbers("wave number", wave_number)
    # s^2 - 4 sin^2/(m1 m2), written so that nothing cancels for equal masses.
    root = np.sqrt((1.0 / a - 1.0 / b) ** 2 + 4.0 * np.cos(half) ** 2 / (a * b))
    upper = 1.0 / a + 1.0 / b + root
    # The product of the branches is known; their difference would cancel for long waves.
    optical = np.sqrt(k * upper)
    return np.asarray(2.0 * k * np.abs(np.sin(half)) / (np.sqrt(a * b) * optical)), optical


def band_edges(*, mass: float = 1.0, other_mass: float, spring: float = 1.0) -> Array:
    r"""Where the two bands of a diatomic chain begin and end.

    .. math::

        0, \quad \sqrt{2K/m_>}, \quad \sqrt{2K/m_<}, \quad
        \sqrt{2K\left(1/m_1 + 1/m_2\right)}

    Parameters
    ----------
    mass, other_mass, spring : float
        As for `dispersion_diatomic`.

    Returns
    -------
    ndarray, shape (4,)
        Ends of the acoustic, then of the optical band: nothing passes in between.

    Raises
    ------
    InputError
        If a mass or the spring is not positive and finite.

    Examples
    --------
    >>> band_edges(other_mass=0.5).round(6)
    array([0.      , 1.414214, 2.      , 2.44949 ])
    """
    a, b = _checked_positive("mass", mass), _checked_positive("other_mass", other_mass)
    k = _checked_positive("spring", spring)
    squares = [0.0, 2.0 / max(a, b), 2.0 / min(a, b), 2.0 * (1.0 / a + 1.0 / b)]
    return np.sqrt(k * np.array(squares))


def modes(
    chain: Chain, force: float, *, ends: tuple[End, End] = ("free", "free")
) -> tuple[Array, Array]:
    r"""Normal modes of a finite chain under a static force.

    The eigenvalues :math:`\omega^2` of :math:`M^{-1/2} K M^{-1/2}`, as `spring_modes`
    finds them, with the springs of `linear_stiffness`.  `hertzchain.spectrum` does this for a
    chain with its own precompression, gravity, walls and losses, in SI units too.

    Parameters
    ----------
    chain : Chain
        Any chain, tapered or not.
    force : float
        Static force F_0 > 0 on every contact [scaled].
    ends : tuple of str
        Left and right end: ``"free"``, held by a force that does not change, or
        ``"fixed"``, in contact with an immobile bead like the last one.  Where the stiffness
        of contacts is given, that contact is as stiff as the chain's last one on its side.

    Returns
    -------
    frequencies : ndarray, shape (N,)
        Angular frequencies, rising; the first is 0 if both ends are free.
    shapes : ndarray, shape (N, N)
        Displacements of the beads; ``shapes[:, j]`` is mode j, with
        :math:`\sum_k m_k x_k^2 = 1`.

    Raises
    ------
    InputError
        If the force is not positive and finite, or an end is neither free nor fixed.

    Examples
    --------
    Two free beads: :math:`\omega = \sqrt{2K/m}` with K = 1.5.

    >>> import hertzchain as hc
    >>> frequencies, shapes = modes(hc.Chain.uniform(2), 1.0)
    >>> frequencies.round(6)
    array([0.      , 1.732051])
    """
    require(chain, "modes", covers=("masses", "stiffness"), instead="use hertzchain.spectrum")
    springs = linear_stiffness(chain.stiffness, force, chain.exponent)
    held = [0.0, 0.0]
    for side, end in enumerate(ends):
        if end not in ("free", "fixed"):
            raise unknown_name("end", end, ("free", "fixed"))
        if end == "fixed":
            radius = chain.radii[-side]
            wall = hertz_stiffness(radius, radius)
            if "stiffness" in chain.given:
                wall = chain.stiffness[-side]
            held[side] = float(linear_stiffness(wall, force, chain.exponent))
    return spring_modes(chain.masses, springs, (held[0], held[1]))


def spring_modes(
    masses: ArrayLike, springs: ArrayLike, ends: tuple[float, float] = (0.0, 0.0)
) -> tuple[Array, Array]:
    r"""Normal modes of masses in a row, joined by springs.

    :math:`M^{-1/2} K M^{-1/2} = A^T A`, where a row of A is a spring: the square root of
    its constant times the difference of its two beads over the roots of their masses.
    The frequencies are the singular values of A, which keeps the digits of the low ones.

    Parameters
    ----------
    masses : array_like, shape (N,)
        Masses.
    springs : array_like, shape (N - 1,)
        Spring constants between neighbours.
    ends : tuple of float
        Spring constants to a wall on the left and on the right; 0 for a free end.

    Returns
    -------
    frequencies : ndarray, shape (N,)
        Angular frequencies, rising.
    shapes : ndarray, shape (N, N)
        As for `modes`.

    Raises
    ------
    InputError
        If a mass or spring is not positive and finite, or their numbers do not match.

    Examples
    --------
    One mass between two walls:

    >>> spring_modes([2.0], [], (1.0, 1.0))[0]
    array([1.])
    """
    m, k = _checked_positive("masses", masses), _checked_positive("springs", springs)
    n = len(m)
    if k.shape != (n - 1,):
        raise InputError(f"{n} masses in a row have {n - 1} springs between them, got {len(k)}")
    rows = np.zeros((n + 1, n))
    inner = np.arange(n - 1)
    rows[inner, inner], rows[inner, inner + 1] = np.sqrt(k / m[:-1]), -np.sqrt(k / m[1:])
    left, right = (_checked_end(end) for end in ends)
    rows[n - 1, 0], rows[n, n - 1] = math.sqrt(left / m[0]), math.sqrt(right / m[-1])
    _, frequencies, vectors = np.linalg.svd(rows)
    frequencies = frequencies[::-1].copy()
    if left == right == 0.0:
        # Moving the chain as a whole costs nothing; the rest is round-off.
        frequencies[0] = 0.0
    return frequencies, vectors[::-1].T / np.sqrt(m)[:, None]


def _checked_positive(name: str, values: ArrayLike) -> Array:
    array = real_numbers(name, values)
    good = (array > 0.0) & np.isfinite(array)
    if not good.all():
        raise InputError(
            f"{name} must be positive and finite, got {float(array.flat[np.argmin(good)]):g}"
        )
    return array


def _checked_end(spring: float) -> float:
    if not 0.0 <= spring < math.inf:
        raise InputError(f"spring of an end must be 0 (free) or positive, got {spring:g}")
    return float(spring)
