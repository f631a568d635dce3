"""Estimate of the error of a gradient."""

from __future__ import annotations

from typing import Final

import numpy as np

from .equation import Equation
from .names import Name

# The largest error of 160 random elastic chains was 9e-6 at 1e-10, 4e-4 at 1e-9 and 1e-3 at 1e-7;
# in a window that moves, 6e-4 at the default of 3e-8.  That of 60 damped chains between walls was
# 1.0e-4 at 1e-12 and 5.9e-3 at 1e-8, with `Dashpot`.
FACTOR, WINDOW_FACTOR = 120.0, 20.0
# Error of a window, at any tolerance, if masses of neighbours differ by a factor e; it grows like
# the square of the logarithm of this factor.
CUT_OFF: Final = 5e-3
DAMPED_FACTOR: Final = 120.0


# The velocity of the last bead is largest where its contact opens; measured up to 17 times larger.
LAST_FACTOR: Final = 20.0
SPEEDS: Final = ("velocity", "momentum", "energy")


def relative_error(equation: Equation, rtol: float, name: Name, *, in_window: bool) -> float:
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
    factor = WINDOW_FACTOR if in_window else factor
    if name.quantity in SPEEDS and name.bead == equation.beads:
        factor *= LAST_FACTOR
    error = factor * rtol ** (lowest / (lowest + 1.0))
    if in_window:
        error = max(error, CUT_OFF * float(np.abs(np.diff(np.log(equation.masses))).max()) ** 2)
    return float(min(1.0, error))
