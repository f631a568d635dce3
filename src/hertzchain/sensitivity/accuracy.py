"""Estimate of the error of a gradient."""

from __future__ import annotations

from typing import Final

import numpy as np

from .equation import Equation
from .names import Name

# The largest measured error of elastic chains was 7e-6 at 1e-10 and 1.3e-3 at 1e-7; that of 60
# damped chains between walls was 1.0e-4 at 1e-12 and 5.9e-3 at 1e-8, with `Dashpot`.
FACTOR: Final = 20.0
DAMPED_FACTOR: Final = 120.0


# The velocity of the last bead is largest where its contact opens; measured up to 17 times larger.
LAST_FACTOR: Final = 20.0


def relative_error(equation: Equation, rtol: float, name: Name) -> float:
    """Estimated error of the derivatives, relative to the largest one.

    If a rate of the state rises from a touching contact like time to the power s, a step across
    this point has an error of order s + 1 in its length, and s in its derivative.  Such rates are
    the elastic force, and the velocity, to which the damping adds its impulse; where a force is cut
    off, s = 1.
    """
    powers = np.where(equation.damping > 0.0, 1.0 + equation.overlap_powers, np.inf)
    powers = np.where((equation.damping > 0.0) & (equation.pulls == 0.0), 1.0, powers)
    powers = np.minimum(powers, equation.exponents)
    lowest = float(powers[equation.stiffness > 0.0].min())
    factor = FACTOR if equation.hertz is not None else DAMPED_FACTOR
    if name.item in ("velocity", "momentum", "energy") and name.bead == equation.beads:
        factor *= LAST_FACTOR
    return float(min(1.0, factor * rtol ** (lowest / (lowest + 1.0))))
