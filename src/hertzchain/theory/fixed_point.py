r"""The equation of the solitary wave, :math:`c^2 \varphi = \Lambda * \varphi^p`, by iteration.

With the triangle :math:`\Lambda(\xi) = (1 - |\xi|)_+` and the crest held at one, each
iteration is one convolution, done by Fourier transform.  The wave is smooth and falls
off doubly exponentially, so that a periodic grid is exact to round-off.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from hertzchain.contacts import Array
from hertzchain.errors import InputError

POINTS_PER_BEAD: Final = 64
# Successive iterates that differ by less than this are the same but for round-off.
ROUND_OFF: Final = 1e-15
ITERATION_LIMIT: Final = 2000


def fixed_point(exponent: float, half_length: float) -> tuple[float, Array]:
    r"""Squared speed and overlap of the solitary wave with crest overlap one.

    Parameters
    ----------
    exponent : float
        Exponent p of the contact force, > 1.
    half_length : float
        The wave is periodic on [-half_length, half_length) [beads]: a whole number,
        large enough for the wave to vanish at its ends.

    Returns
    -------
    squared_speed : float
        :math:`c^2` [beads per time, with crest overlap, mass and stiffness one].
    overlap : ndarray, shape (2 * half_length * POINTS_PER_BEAD,)
        Overlap on the grid; its crest is in the middle.

    Raises
    ------
    InputError
        If the iteration does not converge.

    Examples
    --------
    The long-wave theory has 0.8 (Nesterenko 1983, doi:10.1007/BF00905892):

    >>> squared_speed, overlap = fixed_point(1.5, 6.0)
    >>> round(squared_speed, 3)
    0.82
    """
    n = int(2 * half_length) * POINTS_PER_BEAD
    xi = (np.arange(n) - n // 2) / POINTS_PER_BEAD
    triangle = box_transform(half_length, n) ** 2
    # The wave itself in the limit p -> 1.
    overlap = np.exp(-3.0 * (exponent - 1.0) * xi**2)
    for _ in range(ITERATION_LIMIT):
        new = np.fft.irfft(np.fft.rfft(overlap**exponent) * triangle, n)
        # Symmetry kills the drift of the crest, which nothing else holds back; what is
        # negative is round-off of the tail.
        new = np.maximum(0.5 * (new + np.roll(new[::-1], 1)), 0.0)
        squared_speed = float(new[n // 2])
        new /= squared_speed
        change = float(np.max(np.abs(new - overlap)))
        overlap = new
        if change < ROUND_OFF:
            return squared_speed, overlap
    raise InputError(
        f"no solitary wave of exponent {exponent:g} was found within {ITERATION_LIMIT} "
        "iterations: use an exponent farther from 1"
    )


def box_transform(half_length: float, points: int) -> Array:
    r"""Fourier transform :math:`\sin(q/2)/(q/2)` of the box of width one.

    Parameters
    ----------
    half_length : float
        Half of the period [beads].
    points : int
        Number of points of the grid.

    Returns
    -------
    ndarray, shape (points // 2 + 1,)
        At the wave numbers of ``numpy.fft.rfft``; its square is that of the triangle.

    Examples
    --------
    >>> float(box_transform(1.0, 4)[0])
    1.0
    """
    return np.sinc(np.fft.rfftfreq(points, 2.0 * half_length / points))
