"""Fit the second order of the response of the last contact, on chains that change slowly there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.interpolate import BSpline

from hertzchain.chain.chain import Chain
from hertzchain.collision import Array
from hertzchain.kernels import last_contact as kernel
from hertzchain.kernels.fast_changes import AHEAD, BEHIND
from hertzchain.theory.local_rate import solve
from hertzchain.theory.universal_functions import UniversalFunctions, padded_knots

KNOTS: Final = np.array([-0.15, -0.11, -0.08, -0.05, -0.025, 0.0, 0.025, 0.06, 0.12, 0.25, 0.5])
RIDGE: Final = 1e-3
# Errors are relative to that of a second degree with typical coefficients.
FLOOR, OF_CHANGE, OF_MEMORY, OF_FAST = 3e-5, 20.0, 1.0, 1.0
# Larger errors are not those of a second degree.
LARGEST: Final = 0.1
ROUNDS: Final = 6


def equations(functions: UniversalFunctions, rates: Sequence[Array]) -> tuple[Array, Array, Array]:
    """Products of memories times B-splines, typical errors, and states of the last contacts."""
    memories, means, states = np.empty((len(rates), kernel.COUNT)), [], []
    products = np.empty((len(rates), kernel.PRODUCTS))
    for i, row in enumerate(rates):
        radii = np.exp(np.concatenate([[0.0], np.cumsum(row)]))
        solution = solve(Chain.from_radii(radii, exponent=functions.exponent), functions)
        fast = np.zeros(BEHIND + len(row) + AHEAD)
        fast[BEHIND : BEHIND + len(row)] = row - solution.slow
        means.append(kernel.recall(solution.slow, fast, memories[i]))
        kernel.multiply_memories(memories[i], products[i])
        states.append(solution.states[-1])
    knots = functions.fast.last_knots
    flat = np.clip(means, knots[0], knots[-1])
    splines = BSpline.design_matrix(flat, padded_knots(knots), 3).toarray()
    size = FLOOR + OF_CHANGE * memories[:, 0] ** 2 + OF_MEMORY * memories[:, kernel.SLOW - 1] ** 2
    size += OF_FAST * (memories[:, kernel.SLOW :] ** 2).sum(axis=1)
    matrix = (products[:, :, None] * splines[:, None, :]).reshape(len(rates), -1)
    return matrix, size, np.array(states)


def fit_last(
    functions: UniversalFunctions, rates: Sequence[Array], states: Sequence[Array]
) -> Array:
    """Coefficients of B-splines, (splines, 84), for functions that have none yet."""
    matrix, size, law = equations(functions, rates)
    rest = np.array([each[-1] for each in states]) - law
    found = []
    for error in rest.T:
        used = (np.abs(error) < LARGEST) / size
        for _ in range(ROUNDS):
            weighted = matrix * used[:, None]
            normal = weighted.T @ weighted
            scale = np.sqrt(np.diag(normal))
            scale += 1e-3 * scale.max()
            normal = normal / scale / scale[:, None] + RIDGE * np.eye(len(scale))
            right = weighted.T @ (error * used)
            coefficients = np.linalg.solve(normal, right / scale) / scale
            # Outliers count with the root of their error.
            left = np.abs(error - matrix @ coefficients) / size
            used = (np.abs(error) < LARGEST) / size / np.sqrt(1.0 + left / np.median(left) / 3.0)
        found.append(coefficients.reshape(kernel.PRODUCTS, -1))
    # From (states, products, splines).
    return np.moveaxis(np.array(found), 2, 0).reshape(len(functions.fast.last_knots) + 2, -1)
