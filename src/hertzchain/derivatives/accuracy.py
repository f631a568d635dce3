"""Estimate of the error of a gradient."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import SimulationError
from .equation import Equation

# The second gradient has this fraction of the tolerance.  The error of 900 gradients of random
# elastic chains was at most 3 times their difference; in the median it was equal.
TIGHTER: Final = 0.1
SAFETY: Final = 5.0
# The largest error of 60 damped chains between walls was 1.0e-4 at 1e-12 and 5.9e-3 at 1e-8, with
# `Dashpot`.  Forces that may not pull jump, and differences of such gradients are too small.
DAMPED_FACTOR: Final = 120.0

Derivatives = Mapping[str, Array]


@dataclass(eq=False)
class SecondRun:
    """Gradients of the same quantities at another tolerance, computed when they are needed."""

    compute: Callable[[], Sequence[Derivatives]]

    @cached_property
    def slopes(self) -> Sequence[Derivatives]:
        """Arrays of the gradients; empty if the run fails."""
        try:
            return self.compute()
        except SimulationError:
            return ()


@dataclass(frozen=True, eq=False)
class Accuracy:
    """Data from which the error of one gradient of a run is estimated."""

    least: float
    second: SecondRun
    # Number of the gradient among those of the run.
    index: int
    count: int

    def relative_error(self, found: Derivatives) -> float:
        """Estimated error of the derivatives, relative to the largest one of an array."""
        if any(not np.isfinite(values).all() for values in found.values()):
            return math.nan
        if self.least >= 1.0:
            return 1.0
        others = self.second.slopes
        if len(others) != self.count:
            return math.nan
        difference = max(
            _difference(values, others[self.index][name]) for name, values in found.items()
        )
        return float(min(1.0, max(SAFETY * difference, self.least)))


def _difference(one: Array, other: Array) -> float:
    largest = float(np.abs(one).max(initial=0.0))
    return float(np.abs(one - other).max()) / largest if largest > 0.0 else 0.0


def least_error(equation: Equation, rtol: float) -> float:
    """Smallest estimate of an error: the tolerance, or that of damped chains.

    If a rate of the state rises from a touching contact like time to the power s, a step across
    this point has an error of order s + 1 in its length, and s in its derivative.  With damping,
    such rates are the elastic force, and the velocity, to which the damping adds its impulse; where
    a force is cut off, s = 1.
    """
    if equation.hertz is not None:
        return rtol
    powers = np.where(equation.damping > 0.0, 1.0 + equation.overlap_powers, np.inf)
    powers = np.where((equation.damping > 0.0) & (equation.pulls == 0.0), 1.0, powers)
    powers = np.minimum(powers, equation.exponents)
    lowest = float(powers[equation.stiffness > 0.0].min())
    return float(min(1.0, DAMPED_FACTOR * rtol ** (lowest / (lowest + 1.0))))
