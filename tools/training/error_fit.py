"""Determine the constants of the estimated errors on chains that were not fitted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.optimize import minimize

from hertzchain.chain.chain import Chain
from hertzchain.collision import Array
from hertzchain.kernels.fast_changes import END, PARTS
from hertzchain.theory.local_rate import solve
from hertzchain.theory.universal_functions import UniversalFunctions

# Fraction of the errors below the estimate.
COVERED: Final = 0.98
# Errors of the reference, and larger ones than can be estimated.
SMALLEST, LARGEST = 3e-7, 0.3
# Errors by changes of the rate at the free end, and errors of short chains, concern few beads:
# the last contacts count several times, and their terms are enlarged.  So are those of slow
# changes, because the chains are rougher than smooth tapers, and that of alternating rates, which
# only matters where few of the chains are.
REPEATED: Final = 6
SAFETY: Final = np.ones(PARTS)
SAFETY[:4], SAFETY[9], SAFETY[11], SAFETY[12] = 1.5, 2.5, 2.0, 10.0


def quantile_fit(parts: Array, errors: Array, covered: float = COVERED) -> Array:
    """Constants of a sum of parts that exceeds a fraction of the errors, as closely as possible."""
    logarithm = np.log(errors + SMALLEST)

    def loss(constants: Array) -> tuple[float, Array]:
        terms = parts * np.exp(constants)
        total = terms.sum(axis=1)
        beyond = logarithm - np.log(total)
        # A smooth version of the pinball loss.
        soft = np.sqrt(beyond**2 + 1e-2)
        value = np.mean((covered - 0.5) * beyond + 0.5 * soft)
        slope = -((covered - 0.5) + 0.5 * beyond / soft) / total
        return float(value), np.asarray((slope[:, None] * terms).mean(axis=0))

    typical = np.sqrt((parts**2).mean(axis=0))
    guess = np.log(np.quantile(errors, 0.9) / typical / parts.shape[1])
    bounds = [(start - 14.0, start + 7.0) for start in guess]
    found = minimize(loss, guess, jac=True, method="L-BFGS-B", bounds=bounds)
    return np.asarray(np.exp(found.x))


def terms_and_errors(
    functions: UniversalFunctions, rates: Sequence[Array], states: Sequence[Array]
) -> tuple[Array, Array]:
    """Terms of the estimate and errors of the velocities, for all contacts of all chains."""
    parts, errors = [], []
    for row, true in zip(rates, states, strict=True):
        radii = np.exp(np.concatenate([[0.0], np.cumsum(row)]))
        solution = solve(Chain.from_radii(radii, exponent=functions.exponent), functions)
        growth = np.cumsum(solution.states[:, 0] - true[:, 0])
        contact = np.arange(len(row))
        counted = np.where(contact >= len(row) - END, REPEATED, contact < solution.lost)
        parts.append(np.repeat(solution.error_parts, counted, axis=0))
        errors.append(np.repeat(np.abs(growth), counted))
    part, error = np.concatenate(parts), np.concatenate(errors)
    kept = error < LARGEST
    return part[kept], error[kept]


def error_constants(
    functions: UniversalFunctions, rates: Sequence[Array], states: Sequence[Array]
) -> Array:
    """Constants of the estimated errors of velocities."""
    return SAFETY * quantile_fit(*terms_and_errors(functions, rates, states))
