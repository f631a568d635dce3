"""Correlation of successive residuals, and the number of samples per independent one."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..collision import Array
from ..traces.noise import MIN_INDEPENDENT, SIGNIFICANT, autocorrelation, unbiased_first_lag

# Correlations are summed up to this lag, and while they are significant.
MAX_LAG: Final = 200
# Least number of residuals whose correlation is examined, and the largest one.
MIN_CORRELATED, MAX_FIRST_LAG = 8, 0.999
# Largest order of an autoregression.
MAX_ORDER: Final = 4


def first_lag(values: Array) -> float:
    """Correlation of successive samples, corrected for their mean."""
    rho = float(autocorrelation(values)[:2][-1])
    return min(unbiased_first_lag(rho, len(values)), MAX_FIRST_LAG)


def correlation_length(residuals: Array) -> float:
    """Samples per independent sample, :math:`1 + 2\\sum\\rho`, at least 1.

    This is the larger of two estimates.  The sum of the significant correlations is too small if
    there are few samples.  An autoregression describes smooth noise, such as that behind a filter
    of second order, less well.
    """
    count = len(residuals)
    if count < MIN_CORRELATED:
        return 1.0
    rho = autocorrelation(residuals)[: MAX_LAG + 1]
    significant = rho[1:] > SIGNIFICANT / count**0.5
    if not significant[:1].all():
        return 1.0
    end = len(rho) if significant.all() else 1 + int(np.argmin(significant))
    longest = max(count / MIN_INDEPENDENT, 1.0)
    return max(float(2.0 * rho[:end].sum() - 1.0), min(_of_autoregression(rho, count), longest))


def _of_autoregression(rho: Array, count: int) -> float:
    """Samples per independent one of the autoregression with the least BIC.

    With the coefficients a and the relative variance v of the innovations, this is the spectral
    density at zero frequency, :math:`v/(1 - \\sum a)^2`; the coefficients follow from the recursion
    of Levinson and Durbin.  Only a coefficient of first order is corrected for the mean: the sum of
    several can have less than half of its bias, and the density of smooth noise amplifies errors.
    """
    coefficients, variance = np.zeros(0), 1.0
    best, found = np.inf, 1.0
    for order in range(1, min(MAX_ORDER, len(rho) - 1) + 1):
        last = float(rho[order] - coefficients @ rho[order - 1 : 0 : -1]) / variance
        coefficients = np.append(coefficients - last * coefficients[::-1], last)
        variance *= 1.0 - last**2
        if variance <= 0.0:
            break
        bic = count * np.log(variance) + order * np.log(count)
        if bic < best:
            total = min(float(coefficients.sum()), MAX_FIRST_LAG)
            best, found = bic, variance / (1.0 - total) ** 2
            if order == 1:  # with the corrected coefficient, the variance changes, too
                total = min(unbiased_first_lag(last, count), MAX_FIRST_LAG)
                found = (1.0 + total) / (1.0 - total)
    return found
