"""Determine the constants of the estimated errors on chains that were not fitted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.optimize import minimize

from hertzchain.chain.chain import Chain
from hertzchain.collision import Array
from hertzchain.kernels.fast_changes import PARTS
from hertzchain.theory.local_rate import solve
from hertzchain.theory.universal_functions import UniversalFunctions

# Fraction of the errors below the estimate.
COVERED: Final = 0.98
# Errors of the reference, and larger ones than can be estimated.
SMALLEST, LARGEST = 3e-7, 0.3
# Errors by changes of the rate at the free end, and errors of short chains, concern few beads:
# their terms are enlarged.
SAFETY: Final = np.ones(PARTS)
SAFETY[9], SAFETY[11] = 1.5, 2.0


def quantile_fit(parts: Array, errors: Array) -> Array:
    """Constants of a sum of parts that exceeds a fraction of the errors, as closely as possible."""
    logarithm = np.log(errors + SMALLEST)

    def loss(constants: Array) -> tuple[float, Array]:
        terms = parts * np.exp(constants)
        total = terms.sum(axis=1)
        beyond = logarithm - np.log(total)
        # A smooth version of the pinball loss.
        soft = np.sqrt(beyond**2 + 1e-2)
        value = np.mean((COVERED - 0.5) * beyond + 0.5 * soft)
        slope = -((COVERED - 0.5) + 0.5 * beyond / soft) / total
        return float(value), np.asarray((slope[:, None] * terms).mean(axis=0))

    typical = np.sqrt((parts**2).mean(axis=0))
    guess = np.log(np.quantile(errors, 0.9) / typical / parts.shape[1])
    bounds = [(start - 14.0, start + 7.0) for start in guess]
    found = minimize(loss, guess, jac=True, method="L-BFGS-B", bounds=bounds)
    return np.asarray(np.exp(found.x))


def error_constants(
    functions: UniversalFunctions, rates: Sequence[Array], states: Sequence[Array]
) -> Array:
    """Constants of the estimated errors of velocities."""
    parts, errors = [], []
    for row, true in zip(rates, states, strict=True):
        radii = np.exp(np.concatenate([[0.0], np.cumsum(row)]))
        solution = solve(Chain.from_radii(radii, exponent=functions.exponent), functions)
        growth = np.cumsum(solution.states[:, 0] - true[:, 0])[: solution.lost]
        parts.append(solution.error_parts[: solution.lost])
        errors.append(np.abs(np.expm1(np.clip(growth, -50.0, 50.0))))
    part, error = np.concatenate(parts), np.concatenate(errors)
    kept = error < LARGEST
    return SAFETY * quantile_fit(part[kept], error[kept])
