r"""Small oscillations of a precompressed chain.

Under a static force :math:`F_0`, each contact acts as a spring of stiffness
:math:`K = p\,k^{1/p} F_0^{1-1/p}`, as long as its overlap changes little: V. F. Nesterenko,
*Dynamics of Heterogeneous Materials*, Springer 2001.  Without precompression the sound
speed is zero, and this theory does not apply.
"""

from __future__ import annotations

import math
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..chain.chain import Chain
from ..chain.feature_support import require_supported
from ..chain.input_checks import checked_exponent
from ..collision import HERTZ_EXPONENT, Array, hertz_stiffness
from ..errors import InputError, short_repr
from ..validation.keywords import checked_arguments
from ..validation.numbers import bounded_numbers, number
from ..validation.objects import check_choice, check_list

End = Literal["free", "fixed"]
ENDS: Final[tuple[End, ...]] = get_args(End)


@checked_arguments("linear_stiffness")
def linear_stiffness(stiffness: ArrayLike, force: float, exponent: float = HERTZ_EXPONENT) -> Array:
    r"""Spring constant of a contact about its static overlap.

    .. math:: K = \frac{dF}{dd} = p\,k\,d_0^{p-1} = p\,k^{1/p} F_0^{1-1/p}

    Parameters
    ----------
    stiffness : array_like
        Contact stiffness k, in any consistent units.
    force : float
        Static force F_0 > 0, in the same units.
    exponent : float
        Exponent p of the contact force, 1 < p <= 50.

    Returns
    -------
    ndarray
        Spring constants, in the shape of ``stiffness``.

    Raises
    ------
    InputError
        If a stiffness or the force is not positive and finite.

    Examples
    --------
    A Hertz contact with unit overlap has K = 1.5:

    >>> import hertzchain as hc
    >>> float(hc.theory.linear_stiffness(1.0, 1.0))
    1.5
    """
    k = bounded_numbers("stiffness", stiffness, above=0.0)
    f = number("force", force, above=0.0)
    exponent = checked_exponent(exponent)
    return exponent * k ** (1.0 / exponent) * f ** (1.0 - 1.0 / exponent)


@checked_arguments("dispersion_uniform")
def dispersion_uniform(wave_number: ArrayLike, *, mass: float = 1.0, spring: float = 1.0) -> Array:
    r"""Frequencies of plane waves in a chain of equal beads.

    .. math:: \omega = 2 \sqrt{K/m}\, |\sin(q/2)|

    The sound speed is :math:`\sqrt{K/m}` beads per unit time.  Waves do not propagate above
    the cut-off frequency :math:`2\sqrt{K/m}`.

    Parameters
    ----------
    wave_number : array_like
        Phase q from bead to bead [radians].
    mass, spring : float
        Mass m of a bead and `linear_stiffness` K of a contact, in consistent units.

    Returns
    -------
    ndarray
        Angular frequencies, in the shape of ``wave_number``.

    Raises
    ------
    InputError
        If mass or spring is not positive and finite.

    Examples
    --------
    >>> import hertzchain as hc
    >>> import numpy as np
    >>> float(hc.theory.dispersion_uniform(np.pi))
    2.0
    """
    scale = number("spring", spring, above=0.0) / number("mass", mass, above=0.0)
    half = 0.5 * bounded_numbers("wave number", wave_number)
    return np.asarray(2.0 * np.sqrt(scale) * np.abs(np.sin(half)))


@checked_arguments("dispersion_diatomic")
def dispersion_diatomic(
    wave_number: ArrayLike, *, mass: float = 1.0, other_mass: float, spring: float = 1.0
) -> tuple[Array, Array]:
    r"""Frequencies of plane waves in a chain of alternating beads.

    .. math::

        \omega^2 = K \left[ s \mp \sqrt{s^2 - \frac{4 \sin^2(q/2)}{m_1 m_2}} \right],
        \qquad s = \frac1{m_1} + \frac1{m_2}

    Parameters
    ----------
    wave_number : array_like
        Phase q from one cell of two beads to the next [radians].
    mass, other_mass, spring : float
        The two masses and the `linear_stiffness` K of a contact, in consistent units.

    Returns
    -------
    acoustic, optical : ndarray
        Angular frequencies of the two branches, in the shape of ``wave_number``.

    Raises
    ------
    InputError
        If a mass or the spring is not positive and finite.

    Examples
    --------
    >>> import hertzchain as hc
    >>> import numpy as np
    >>> acoustic, optical = hc.theory.dispersion_diatomic(np.pi, other_mass=0.25)
    >>> float(round(acoustic**2, 12)), float(round(optical**2, 12))
    (2.0, 8.0)
    """
    a, b = number("mass", mass, above=0.0), number("other_mass", other_mass, above=0.0)
    k, half = number("spring", spring, above=0.0), 0.5 * bounded_numbers("wave number", wave_number)
    # s^2 - 4 sin^2/(m1 m2), in a form without cancellation for equal masses.
    root = np.sqrt((1.0 / a - 1.0 / b) ** 2 + 4.0 * np.cos(half) ** 2 / (a * b))
    upper = 1.0 / a + 1.0 / b + root
    # Computed from the product of the branches; the difference would cancel for long waves.
    optical = np.sqrt(k * upper)
    return np.asarray(2.0 * k * np.abs(np.sin(half)) / (np.sqrt(a * b) * optical)), optical


@checked_arguments("band_edges")
def band_edges(*, mass: float = 1.0, other_mass: float, spring: float = 1.0) -> Array:
    r"""Edges of the two frequency bands of a diatomic chain.

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
        Angular frequencies of the lower and upper edge of the acoustic band, then of the optical
        band (`Spectrum.band_edges` has cycles per unit of time).  Waves do not propagate at
        frequencies between the bands.

    Raises
    ------
    InputError
        If a mass or the spring is not positive and finite.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.theory.band_edges(other_mass=0.5).round(6)
    array([0.      , 1.414214, 2.      , 2.44949 ])
    """
    a, b = number("mass", mass, above=0.0), number("other_mass", other_mass, above=0.0)
    k = number("spring", spring, above=0.0)
    squares = [0.0, 2.0 / max(a, b), 2.0 / min(a, b), 2.0 * (1.0 / a + 1.0 / b)]
    return np.sqrt(k * np.array(squares))


@checked_arguments("modes")
def modes(
    chain: Chain, force: float, *, ends: tuple[End, End] = ("free", "free")
) -> tuple[Array, Array]:
    r"""Normal modes of a finite chain under a static force.

    The squares :math:`\omega^2` of the frequencies are the eigenvalues of
    :math:`M^{-1/2} K M^{-1/2}` (see `spring_modes`), with the spring constants of
    `linear_stiffness`.  For a chain with its own precompression, gravity, walls and losses,
    also in SI units, use `hertzchain.spectrum`.

    Parameters
    ----------
    chain : Chain
        Any chain, tapered or not.
    force : float
        Static force F_0 > 0 on every contact [scaled].
    ends : tuple of str
        Left and right end: ``"free"`` (held by a constant force) or ``"fixed"`` (in contact
        with an immobile bead of the same size).  If the chain's stiffness is given, the
        contact at a fixed end is as stiff as the chain's last contact at this end.

    Returns
    -------
    frequencies : ndarray, shape (N,)
        Angular frequencies in ascending order; the first is 0 if both ends are free.
    shapes : ndarray, shape (N, N)
        Displacements of the beads; ``shapes[:, j]`` is mode j, with
        :math:`\sum_k m_k x_k^2 = 1`.

    Raises
    ------
    InputError
        If the force is not positive and finite, or an end is neither free nor fixed.

    Examples
    --------
    Two free beads have :math:`\omega = \sqrt{2K/m}` with K = 1.5:

    >>> import hertzchain as hc
    >>> frequencies, shapes = hc.theory.modes(hc.Chain.uniform(2), 1.0)
    >>> frequencies.round(6)
    array([0.      , 1.732051])
    """
    require_supported(
        chain, "modes", supported=("masses", "stiffness"), alternative="use hertzchain.spectrum"
    )
    springs = linear_stiffness(chain.stiffness, force, chain.exponents)
    held = [0.0, 0.0]
    for side, end in enumerate(_both_ends(ends)):
        if check_choice("end", end, ENDS) == "fixed":
            radius = chain.radii[-side]
            wall = hertz_stiffness(radius, radius)
            if "stiffness" in chain.given:
                wall = chain.stiffness[-side]
            held[side] = float(linear_stiffness(wall, force, chain.exponents))
    return spring_modes(chain.masses, springs, (held[0], held[1]))


@checked_arguments("spring_modes")
def spring_modes(
    masses: ArrayLike, springs: ArrayLike, ends: tuple[float, float] = (0.0, 0.0)
) -> tuple[Array, Array]:
    r"""Normal modes of a line of masses joined by springs.

    The matrix is factorised as :math:`M^{-1/2} K M^{-1/2} = A^T A`.  The row of A that belongs
    to the spring between masses j and j + 1 has the entries :math:`\sqrt{K_j/m_j}` and
    :math:`-\sqrt{K_j/m_{j+1}}`.  The frequencies are the singular values of A, which keeps
    low frequencies accurate.

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
        Angular frequencies in ascending order.
    shapes : ndarray, shape (N, N)
        Displacements, as for `modes`.

    Raises
    ------
    InputError
        If a mass or spring is not positive and finite, or their numbers do not match.

    Examples
    --------
    One mass between two walls:

    >>> import hertzchain as hc
    >>> hc.theory.spring_modes([2.0], [], (1.0, 1.0))[0]
    array([1.])
    """
    m = bounded_numbers("masses", masses, above=0.0)
    k = bounded_numbers("springs", springs, above=0.0)
    if m.ndim != 1 or not m.size:
        raise InputError(f"masses must be a list of numbers, got {short_repr(masses)}")
    n = len(m)
    if k.shape != (n - 1,):
        raise InputError(f"{n} masses require {n - 1} springs between them, got {k.size}")
    rows = np.zeros((n + 1, n))
    inner = np.arange(n - 1)
    rows[inner, inner], rows[inner, inner + 1] = np.sqrt(k / m[:-1]), -np.sqrt(k / m[1:])
    left, right = (
        number("spring of an end", end, least=0.0, hint="0 is a free end")
        for end in _both_ends(ends)
    )
    rows[n - 1, 0], rows[n, n - 1] = math.sqrt(left / m[0]), math.sqrt(right / m[-1])
    _, frequencies, vectors = np.linalg.svd(rows)
    frequencies = frequencies[::-1].copy()
    if left == right == 0.0:
        # The translation of the whole chain has frequency 0, apart from rounding errors.
        frequencies[0] = 0.0
    return frequencies, vectors[::-1].T / np.sqrt(m)[:, None]


def _both_ends(ends: Any) -> list[Any]:
    found = check_list("ends", ends, "two values")
    if len(found) != 2:
        raise InputError(f"ends must be those of the left and the right end, got {len(found)}")
    return found
