"""Determine the constants of the estimated errors on chains that were not fitted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.optimize import minimize

from hertzchain.chain.chain import Chain
from hertzchain.collision import Array
from hertzchain.kernels.error_terms import PARTS
from hertzchain.kernels.fast_changes import END
from hertzchain.theory.local_rate import solve
from hertzchain.theory.universal_functions import UniversalFunctions

# Fraction of the errors below the estimate.
COVERED: Final = 0.965
# Errors of the reference, and larger ones than can be estimated.
SMALLEST, LARGEST = 3e-7, 0.3
# Errors at the free end concern few beads: the last contacts count several times.
REPEATED: Final = 6
# The constant of the last term, which few chains have, is not fitted: in strong backward tapers
# whose rate alternates, the error is 0.2 to 0.3 times this term for exponents up to 2.2, and 0.8
# times for 2.9.
FITTED: Final = PARTS - 1
JAGGED: Final = 0.7
# Factors of the other constants.  They balance the classes of chains of `local_rate_accuracy` with
# the seeds 40404 to 40407, 60606, 901 and 902: terms of large errors at few beads are enlarged,
# those of small errors at many beads reduced.
BALANCE: Final = np.array([
    0.8, 3.0, 0.72, 0.97, 1.3, 1.1, 1.75, 1.28, 0.87, 1.47, 2.9, 6.0, 1.7, 0.46, 2.5,
])  # fmt: skip
# The fit begins with terms that are too large rather than too small, as a small one has no effect.
GUESSED: Final = 0.7
FEWER: Final = 0.2


def quantile_fit(
    parts: Array, errors: Array, covered: float = COVERED, weights: Array | float = 1.0
) -> Array:
    """Constants of a sum of parts that exceeds a fraction of the errors, as closely as possible."""
    logarithm = np.log(errors + SMALLEST)
    weight = np.broadcast_to(weights, errors.shape) / np.sum(np.broadcast_to(weights, errors.shape))

    def loss(constants: Array) -> tuple[float, Array]:
        terms = parts * np.exp(constants)
        total = terms.sum(axis=1)
        beyond = logarithm - np.log(total)
        # A smooth version of the pinball loss.
        soft = np.sqrt(beyond**2 + 1e-2)
        value = weight @ ((covered - 0.5) * beyond + 0.5 * soft)
        slope = -weight * ((covered - 0.5) + 0.5 * beyond / soft) / total
        return float(value), np.asarray(slope @ terms)

    guess = np.log([FEWER * _typical_ratio(errors, part) for part in parts.T])
    bounds = [(start - 16.0, start + 7.0) for start in guess]
    options = {"maxiter": 400}
    found = minimize(loss, guess, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return np.asarray(np.exp(found.x))


def _typical_ratio(errors: Array, part: Array) -> float:
    """A quantile of the ratio of errors to a term, where the term is large."""
    if not part.any():
        return 1.0
    large = part > np.median(part[part > 0.0])
    ratio = errors[large] / part[large] if large.any() else errors / part.max()
    return float(np.quantile(ratio, GUESSED)) + SMALLEST


def terms_and_errors(
    functions: UniversalFunctions, rates: Sequence[Array], states: Sequence[Array]
) -> tuple[Array, Array, Array]:
    """Terms of the estimate, errors of the velocities and weights, for all contacts of chains."""
    parts, errors, weights = [], [], []
    for row, true in zip(rates, states, strict=True):
        radii = np.exp(np.concatenate([[0.0], np.cumsum(row)]))
        solution = solve(Chain.from_radii(radii, exponent=functions.exponent), functions)
        contact = np.arange(len(row))
        parts.append(solution.error_parts)
        errors.append(np.abs(np.expm1(np.cumsum(solution.states[:, 0] - true[:, 0]))))
        weights.append(np.where(contact >= len(row) - END, REPEATED, contact < solution.lost))
    part, error, weight = np.concatenate(parts), np.concatenate(errors), np.concatenate(weights)
    kept = (error < LARGEST) & (weight > 0)
    return part[kept], error[kept], weight[kept] / weight[kept].sum()


def error_constants(
    functions: UniversalFunctions, classes: Sequence[tuple[Sequence[Array], Sequence[Array]]]
) -> Array:
    """Constants of the estimated errors of velocities; all classes of chains weigh the same."""
    found = [terms_and_errors(functions, *chains) for chains in classes]
    parts, errors, weights = (np.concatenate(each) for each in zip(*found, strict=True))
    return np.append(BALANCE * quantile_fit(parts[:, :FITTED], errors, weights=weights), JAGGED)
