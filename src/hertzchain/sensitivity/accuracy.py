"""Estimate of the error of a gradient."""

from __future__ import annotations

from typing import Final

import numpy as np

from .equation import Equation

# The largest measured error of elastic chains was 7e-6 at 1e-10 and 1.3e-3 at 1e-7.
FACTOR: Final = 20.0


def relative_error(equation: Equation, rtol: float) -> float:
    """Estimated error of the derivatives, relative to the largest one.

    If a force rises from a touching contact like time to the power s, a step across this point has
    an error of order s + 1 in its length, and s in its derivative.
    """
    damped = equation.damping > 0.0
    powers = np.where(damped, equation.overlap_powers, equation.exponents)
    lowest = float(powers[equation.stiffness > 0.0].min())
    return float(min(1.0, FACTOR * rtol ** (lowest / (lowest + 1.0))))
