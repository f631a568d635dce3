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

from .second_degree import Chains

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
# Constants with which the search for those of Hertz contacts begins (`training.balance`), and which
# those of other exponents are similar to.
REFERENCE: Final = np.array([
    2.4e-7, 3.9e-5, 1.9e-3, 2.9e-3, 2.0e-3, 4.2, 6.3, 0.33, 1.1, 0.087, 30.0, 3.8, 12.0, 3.0, 9.7,
])  # fmt: skip
# Other constants are fitted to classes of chains with less weight on the worst ones, and enlarged.
CAUTION: Final = np.full(FITTED, 1.5)
# The third order of fast changes determines the estimate for alternating radii, too.
CAUTION[6] = 2.0
# They are at most so many times smaller or larger.
SMALLER, LARGER = 5.0, 20.0
# The fit begins with terms that are too large rather than too small, as a small one has no effect.
GUESSED: Final = 0.7
FEWER: Final = 0.2


def quantile_fit(
    parts: Array,
    errors: Array,
    covered: float = COVERED,
    weights: Array | float = 1.0,
    reference: Array | None = None,
) -> Array:
    """Constants of a sum of parts that exceeds a fraction of the errors, as closely as possible.

    If there is a reference, the constants are similar to it: chains with few of the terms would
    determine the others badly.
    """
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
    if reference is not None:
        guess = np.log(reference)
        bounds = [(start - np.log(SMALLER), start + np.log(LARGER)) for start in guess]
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


def terms_and_errors(functions: UniversalFunctions, chains: Chains) -> tuple[Array, Array, Array]:
    """Terms of the estimate, errors of the velocities and weights, for all contacts of chains."""
    parts, errors, weights = [], [], []
    for row, true in zip(chains.rates, chains.states, strict=True):
        radii = np.exp(np.concatenate([[0.0], np.cumsum(row)]))
        solution = solve(Chain.from_radii(radii, exponent=functions.exponent), functions)
        contact = np.arange(len(row))
        parts.append(solution.error_parts)
        errors.append(np.abs(np.expm1(np.cumsum(solution.states[:, 0] - true[:, 0]))))
        weights.append(np.where(contact >= len(row) - END, REPEATED, contact < solution.lost))
    part, error, weight = np.concatenate(parts), np.concatenate(errors), np.concatenate(weights)
    kept = (error < LARGEST) & (weight > 0)
    return part[kept], error[kept], weight[kept] / weight[kept].sum()


def error_constants(functions: UniversalFunctions, classes: Sequence[Chains]) -> Array:
    """Constants of the estimated errors of velocities; all classes of chains weigh the same."""
    found = [terms_and_errors(functions, chains) for chains in classes]
    parts, errors, weights = (np.concatenate(each) for each in zip(*found, strict=True))
    fitted = quantile_fit(parts[:, :FITTED], errors, weights=weights, reference=REFERENCE)
    return np.append(CAUTION * fitted, JAGGED)
