"""Noise that grows with the signal or with its slope: random errors of gains or of times.

Such residuals are independent, but large where the signal is large or steep.  A wrong model leaves
residuals that change slowly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from ..collision import Array
from ..representation import measure
from .goodness import MAX_CORRELATION, goodness_of
from .weights import data_residuals

if TYPE_CHECKING:
    from .result import FitResult

# Range in which the size of the noise is sought, in units of that which doubles the variance of the
# sample where it is largest.
RANGE: Final = (1e-2, 1e4)


@dataclass(frozen=True)
class SignalNoise:
    """The size of such a noise in words, and the cost of the residuals over it.

    The cost is -2 times the logarithm of the likelihood.  Without this noise, it is chi-squared.
    """

    advice: str
    cost: float


def signal_noise_of(result: FitResult) -> SignalNoise | None:
    """Noise of gains or of times, if it explains the residuals."""
    residuals = data_residuals(result.problem, result._residual_vector)
    levels, slopes = _signals_and_slopes(result)
    # The last one is a noise of all samples that is larger than before the pulse.
    factors = levels, slopes, np.ones(len(levels))
    fits = [_fitted_noise(residuals, each) for each in factors]
    best = int(np.argmin([cost for _, cost, _ in fits]))
    size, cost, scaled = fits[best]
    used = ~result.problem.skipped
    good = goodness_of(result.traces, scaled, used, len(result.names) + 1)
    # The samples of pulses, in which this noise exceeds that before them.
    large = size * np.abs(factors[best]) > 1.0
    pairs = np.flatnonzero(large[:-1] & large[1:])
    correlated = _correlated(scaled[pairs], scaled[pairs + 1])
    # The residuals themselves, which the summary states, must be independent, too.
    correlated |= result.goodness.correlation > MAX_CORRELATION
    if best == 2 or not good.describes or correlated:
        return None
    if best == 0:
        text = (
            f"the residuals are independent, and their size is that of a noise of {size:.2g} times "
            "the signal: check the sensors and amplifiers"
        )
    else:
        error = measure(size, "s", digits=2)
        text = (
            f"the residuals are independent, and their size is that of random errors of {error} in "
            "the times of the samples: check the clock of the digitiser, and whether the times are "
            "rounded"
        )
    return SignalNoise(f"{text}. No other effect that was tested explains them better", cost)


def _correlated(first: Array, second: Array) -> bool:
    """Whether successive residuals of variance 1 have the same sign more often than by chance."""
    return float(first @ second) > MAX_CORRELATION * max(len(first), 1) ** 0.5


def _signals_and_slopes(result: FitResult) -> tuple[Array, Array]:
    """Predicted signals without their first value, and their slopes, over the noise."""
    levels, slopes = [], []
    for shot, predicted in zip(result.traces.shots, result.predicted, strict=True):
        for signal, model in zip(shot.signals, predicted, strict=True):
            scale = signal.sigma * signal.counted**0.5
            levels.append((model - model[0])[signal.valid] / scale)
            slopes.append(np.gradient(model, shot.times)[signal.valid] / scale)
    return np.concatenate(levels), np.concatenate(slopes)


def _fitted_noise(residuals: Array, factors: Array) -> tuple[float, float, Array]:
    """Size of a noise proportional to factors by maximum likelihood, its cost, and the residuals.

    The cost is -2 times the logarithm of the likelihood; the residuals are those over all noise.
    """
    from scipy.optimize import minimize_scalar

    unit = 1.0 / float(np.abs(factors).max())

    def variances(logarithm: float) -> Array:
        return np.asarray(1.0 + (unit * np.exp(logarithm) * factors) ** 2)

    def cost(logarithm: float) -> float:
        own = variances(logarithm)
        return float(np.sum(np.log(own) + residuals**2 / own))

    found = minimize_scalar(cost, bounds=np.log(RANGE), method="bounded")
    size = unit * float(np.exp(found.x))
    return size, float(found.fun), residuals / variances(found.x) ** 0.5
