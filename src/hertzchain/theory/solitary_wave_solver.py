r"""Solve the solitary-wave equation, :math:`c^2 \varphi = \Lambda * \varphi^p`, by iteration.

Each iteration is one convolution with the triangle :math:`\Lambda(\xi) = (1 - |\xi|)_+`,
computed by Fourier transform, after which the crest is normalised to one.  The wave is
smooth and decays doubly exponentially: a periodic grid is exact to rounding.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError

POINTS_PER_BEAD: Final = 64
# Successive iterates that differ by less than this are equal except for rounding errors.
ROUND_OFF: Final = 1e-15
ITERATION_LIMIT: Final = 2000


def solve_solitary_wave(exponent: float, half_length: float) -> tuple[float, Array]:
    r"""Squared speed and overlap of the solitary wave, with crest overlap one."""
    n = int(2 * half_length) * POINTS_PER_BEAD
    xi = (np.arange(n) - n // 2) / POINTS_PER_BEAD
    triangle = box_transform(half_length, n) ** 2
    # The initial guess is the wave in the limit p -> 1.
    overlap = np.exp(-3.0 * (exponent - 1.0) * xi**2)
    for _ in range(ITERATION_LIMIT):
        new = np.fft.irfft(np.fft.rfft(overlap**exponent) * triangle, n)
        # Symmetrising prevents a drift of the crest; negative values are rounding errors.
        new = np.maximum(0.5 * (new + np.roll(new[::-1], 1)), 0.0)
        squared_speed = float(new[n // 2])
        new /= squared_speed
        change = float(np.max(np.abs(new - overlap)))
        overlap = new
        if change < ROUND_OFF:
            return squared_speed, overlap
    raise InputError(
        f"the solitary wave of exponent {exponent:g} did not converge within {ITERATION_LIMIT} "
        "iterations; use an exponent farther from 1"
    )


def box_transform(half_length: float, points: int) -> Array:
    r"""Fourier transform :math:`\sin(q/2)/(q/2)` of the box of width one."""
    return np.sinc(np.fft.rfftfreq(points, 2.0 * half_length / points))
