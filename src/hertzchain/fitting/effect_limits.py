"""Largest effects of sensors that the data do not exclude, from fits with the effect fixed.

In a first approximation, a lag is a delay, which a free time offset includes.  What remains grows
with the square of the lag, so that its limit does not follow from the linearised fit.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from ..collision import Array
from .names import Name
from .sensors import SENSOR_KINDS
from .systematics import DEVIATIONS, Effect, extended, most_shifted
from .weights import remaining_weights

if TYPE_CHECKING:
    from .result import FitResult

# Gauss-Newton steps of a fit with a fixed effect, and largest number of factors of two between its
# limit and that of the linearised fit.
STEPS, MAX_FACTORS = 2, 12
# Accuracy of a limit, as a part of it.
ACCURACY: Final = 0.02


def limited(result: FitResult) -> FitResult:
    """A result whose effects have limits of this kind, if their notes state them."""
    if result.goodness.noiseless:
        return result
    effects = (
        _limited(result, each) if each.note and not each.present else each
        for each in result.effects
    )
    return replace(result, effects=tuple(effects))


def _limited(result: FitResult, effect: Effect) -> Effect:
    """An effect with its limit and the shift there; as it is if no limit is found."""
    weights = remaining_weights(result.problem, result._residual_vector)
    inverse = np.linalg.pinv(weights[:, None] * result.jacobian, rcond=1e-12)
    values = result.model.values(result.variables)
    problem = extended(result.problem, values, Name(effect.name))
    typical = SENSOR_KINDS[effect.name].typical
    unit = math.copysign(typical, effect.value)
    low, high = result.problem.bounds()

    def fitted(size: float) -> tuple[float, Array]:
        """Chi-squared and the variables of a fit with the effect fixed."""
        variables = result.variables
        for step in range(STEPS + 1):
            residuals = weights * problem.residuals(np.append(variables, size / unit))
            if step == STEPS or not np.all(np.isfinite(residuals)):
                break
            variables = np.clip(variables - inverse @ residuals, low, high)
        return float(residuals @ residuals), variables

    # In the linearised fit, an effect that a parameter imitates exactly has no limit.
    guess = effect.limit if np.isfinite(effect.limit) else typical
    limit = _limit(lambda size: fitted(size)[0], guess)
    if not np.isfinite(limit):
        return effect
    moved, shift = most_shifted(result.model, inverse, fitted(limit)[1] - result.variables)
    return replace(effect, limit=limit, moved=moved, shift=shift)


def _limit(chi2: Callable[[float], float], guess: float) -> float:
    """Size at which chi-squared exceeds its least value by four; NaN if there is none nearby."""
    from scipy.optimize import brentq

    found = {0.0: chi2(0.0), guess: chi2(guess)}

    def excess(size: float) -> float:
        if size not in found:
            found[size] = chi2(size)
        return min(found[size] - least, 1e6) - DEVIATIONS**2

    least = min(found.values())
    factor = 0.5 if excess(guess) > 0.0 else 2.0
    sizes = [guess]
    for _ in range(MAX_FACTORS):
        sizes.append(factor * sizes[-1])
        outside = excess(sizes[-1]) > 0.0
        least = min(found.values())
        if outside == (factor > 1.0):
            break
    else:
        return np.nan
    lower, upper = sorted(sizes[-2:])
    if excess(lower) > 0.0:
        return np.nan
    root = brentq(
        lambda logarithm: excess(math.exp(logarithm)), math.log(lower), math.log(upper),
        xtol=ACCURACY,
    )  # fmt: skip
    return math.exp(root)
