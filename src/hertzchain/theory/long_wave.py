r"""Approximations of the solitary wave, for comparison with the exact one.

The long-wave (continuum) theory of Nesterenko expands the equation of motion in the ratio
of bead diameter to wavelength; the form of Sen and Manciu is a fit of the displacement.
The explanation "Closed forms" lists the errors of both.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ..chain.input_checks import checked_exponent
from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError
from ..validation.keywords import checked_arguments
from ..validation.numbers import bounded_numbers, number
from ..validation.objects import check_list, check_type
from .solitary_wave import SolitaryWave

# Coefficients of Sen and Manciu for p = 3/2, as commonly quoted.  They agree with the Taylor
# coefficients of the exact wave to 5e-5, 6e-4 and 2%.
QUOTED_COEFFICIENTS = (2.39536, 0.268529, 0.0061347)


@checked_arguments("long_wave_speed_constant")
def long_wave_speed_constant(exponent: float = HERTZ_EXPONENT) -> float:
    r"""Speed constant of the solitary wave in the long-wave theory.

    .. math:: C = \left(\frac{2}{p+1}\right)^{1/(p+1)}

    The constant C is defined in `SolitaryWave`: V. F. Nesterenko, J. Appl. Mech. Tech. Phys.
    24, 733 (1983), doi:10.1007/BF00905892.  This value is 0.8% above the exact constant for
    p = 3/2 and becomes exact as p -> 1.

    Parameters
    ----------
    exponent : float
        Exponent p of the contact force, 1 < p <= 50.

    Raises
    ------
    InputError
        If the exponent is out of range.

    Examples
    --------
    >>> import hertzchain as hc
    >>> round(hc.theory.long_wave_speed_constant(), 6)
    0.91461
    """
    p = checked_exponent(exponent)
    return (2.0 / (p + 1.0)) ** (1.0 / (p + 1.0))


@checked_arguments("long_wave_velocity")
def long_wave_velocity(distance: ArrayLike, exponent: float = HERTZ_EXPONENT) -> Array:
    r"""Velocity profile of the solitary wave in the long-wave theory, normalised to its peak.

    .. math::

        w = \cos^{2/(p-1)} (\kappa\xi), \qquad
        \kappa = \frac{p-1}{p+1} \sqrt{\frac{6(p+1)}{p}}, \qquad |\xi| \le \frac{\pi}{2\kappa}

    and zero outside this interval.  For Hertz contacts the profile is
    :math:`\cos^4 (\sqrt{2/5}\,\xi)`, 4.97 beads long.  For the source, see
    `long_wave_speed_constant`.

    Parameters
    ----------
    distance : array_like
        Distance :math:`\xi` from the crest [beads].
    exponent : float
        Exponent p of the contact force, 1 < p <= 50.

    Returns
    -------
    ndarray
        Velocities, in the shape of ``distance``.

    Raises
    ------
    InputError
        If the exponent is out of range.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.theory.long_wave_velocity([0.0, 1.0, 2.5]).round(4)
    array([1.    , 0.4232, 0.    ])
    """
    p = checked_exponent(exponent)
    kappa = (p - 1.0) / (p + 1.0) * math.sqrt(6.0 * (p + 1.0) / p)
    angle = np.minimum(kappa * np.abs(bounded_numbers("distance", distance)), 0.5 * np.pi)
    # In floating point, cos(pi/2) is 6e-17 instead of 0.
    return np.where(angle < 0.5 * np.pi, np.cos(angle), 0.0) ** (2.0 / (p - 1.0))


@checked_arguments("sen_manciu_coefficients")
def sen_manciu_coefficients(wave: SolitaryWave) -> tuple[float, float, float]:
    r"""Coefficients of the Sen-Manciu form that match the exact wave at its crest.

    The displacement of a bead, which is A behind the wave and 0 ahead of it, is written as

    .. math::

        u(\xi) = \frac A2 \left[1 - \tanh\frac{f(\xi)}2\right], \qquad
        f = C_1 \xi + C_3 \xi^3 + C_5 \xi^5

    (S. Sen and M. Manciu, Phys. Rev. E 64, 056605, 2001, doi:10.1103/PhysRevE.64.056605).
    Here the coefficients are the Taylor coefficients of the exact
    :math:`f = 2 \operatorname{artanh}(1 - 2u/A)`.

    Parameters
    ----------
    wave : SolitaryWave
        The exact wave.

    Returns
    -------
    tuple of float
        C_1, C_3 and C_5.

    Examples
    --------
    The values commonly quoted for p = 3/2 are 2.39536, 0.268529 and 0.0061347:

    >>> import hertzchain as hc
    >>> [round(c, 4) for c in hc.theory.sen_manciu_coefficients(hc.solitary_wave())]
    [2.3953, 0.2684, 0.0062]
    """
    check_type("wave", wave, SolitaryWave, "use hc.solitary_wave()")
    # 1 - 2u/A = a1 xi + a3 xi^3 + a5 xi^5 + ... is the integral of the velocity profile.
    w0, w2, w4 = (wave.velocity.crest_derivative(order) for order in (0, 2, 4))
    scale = 2.0 / wave.momentum_constant
    a1, a3, a5 = scale * w0, scale * w2 / 6.0, scale * w4 / 120.0
    return 2.0 * a1, 2.0 * (a3 + a1**3 / 3.0), 2.0 * (a5 + a1**2 * a3 + a1**5 / 5.0)


@checked_arguments("sen_manciu_velocity")
def sen_manciu_velocity(
    distance: ArrayLike, coefficients: tuple[float, float, float] = QUOTED_COEFFICIENTS
) -> Array:
    r"""Velocity profile of the Sen-Manciu form, normalised to its peak.

    .. math:: w = \frac{f'(\xi)}{C_1}\, \operatorname{sech}^2 \frac{f(\xi)}{2}

    Parameters
    ----------
    distance : array_like
        Distance :math:`\xi` from the crest [beads].
    coefficients : tuple of float
        C_1, C_3 and C_5.  The default is those commonly quoted for p = 3/2.

    Returns
    -------
    ndarray
        Velocities, in the shape of ``distance``.

    Examples
    --------
    The exact wave has the velocity 0.32625 at this distance:

    >>> import hertzchain as hc
    >>> round(float(hc.theory.sen_manciu_velocity(1.0)), 5)
    0.32687
    """
    given = check_list("coefficients", coefficients, "numbers")
    if len(given) != 3:
        raise InputError(f"the Sen-Manciu form has three coefficients, got {len(given)}")
    c1, c3, c5 = (number("coefficient", each) for each in given)
    xi = bounded_numbers("distance", distance)
    f = c1 * xi + c3 * xi**3 + c5 * xi**5
    slope = 1.0 + (3.0 * c3 * xi**2 + 5.0 * c5 * xi**4) / c1
    # 4 e^-f / (1 + e^-f)^2 equals sech^2(f/2) and cannot overflow.
    decay = np.exp(-np.abs(f))
    return np.asarray(slope * 4.0 * decay / (1.0 + decay) ** 2)


@checked_arguments("precompressed_speed")
def precompressed_speed(force_ratio: ArrayLike, exponent: float = HERTZ_EXPONENT) -> Array:
    r"""Speed of a solitary wave on a precompressed chain over the sound speed.

    Let f be the ratio of the largest force, including the static one, to the static force
    :math:`F_0`, and :math:`x = f^{1/p}` the ratio of the overlaps.  In the long-wave theory

    .. math::

        \left(\frac V{c_0}\right)^2 = \frac{2}{p(p+1)}\,
        \frac{x^{p+1} - 1 - (p+1)(x-1)}{(x-1)^2}, \qquad
        c_0 = \sqrt{\frac{p\,k^{1/p} F_0^{1-1/p}}{m}} .

    For Hertz contacts
    :math:`V/c_0 = \sqrt{\frac4{15}(3 + 2f^{5/3} - 5f^{2/3})}/(f^{2/3} - 1)`
    (C. Coste, E. Falcon and S. Fauve, Phys. Rev. E 56, 6104, 1997,
    doi:10.1103/PhysRevE.56.6104).  For p = 3/2 it is below the exact speed by 0.04% at f = 2,
    by 0.4% at f = 10, and by at most 1.3%.

    Parameters
    ----------
    force_ratio : array_like
        Ratio f of the largest to the static force, at least 1.
    exponent : float
        Exponent p of the contact force, 1 < p <= 50.

    Returns
    -------
    ndarray
        :math:`V/c_0`, in the shape of ``force_ratio``; it is 1 at f = 1.

    Raises
    ------
    InputError
        If a ratio is below 1 or not finite, or the exponent is out of range.

    Examples
    --------
    At f = 2, the exact wave has 1.0453 times the sound speed:

    >>> import hertzchain as hc
    >>> hc.theory.precompressed_speed([1.0, 2.0]).round(4)
    array([1.    , 1.0449])
    """
    what = "force_ratio, the largest force divided by the static force,"
    p, f = checked_exponent(exponent), bounded_numbers(what, force_ratio, least=1.0)
    excess = np.expm1(np.log(f) / p)
    # Near f = 1 the closed form approaches 0/0; the binomial series converges fast there.
    near = excess < 0.05
    far = np.where(near, 1.0, excess)
    closed = ((1.0 + far) ** (p + 1.0) - 1.0 - (p + 1.0) * far) / far**2
    series, term = np.zeros_like(f), np.full_like(f, 0.5 * p * (p + 1.0))
    for j in range(2, 16):
        series += term
        term = term * np.where(near, excess, 0.0) * (p + 1.0 - j) / (j + 1.0)
    return np.sqrt(2.0 / (p * (p + 1.0)) * np.where(near, series, closed))
