"""Fit the second order of the response of the last contact.

The equations are the states of chains that change slowly towards their end, and the derivatives of
those of other random chains with respect to the radii.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.interpolate import BSpline

from hertzchain.collision import Array
from hertzchain.kernels import last_contact as kernel
from hertzchain.kernels.fast_changes import STATES
from hertzchain.kernels.local_rate_pulse import divide
from hertzchain.theory.universal_functions import UniversalFunctions, padded_knots

from .second_degree import STEP, Equations, divided, sound
from .sensitivities import Sensitivity, law_slopes, law_states, of_radii

KNOTS: Final = np.array([-0.15, -0.11, -0.08, -0.05, -0.025, 0.0, 0.025, 0.06, 0.12, 0.25, 0.5])
RIDGE: Final = 1e-3
# Errors are relative to that of a second degree with typical coefficients.
FLOOR, OF_CHANGE, OF_MEMORY, OF_FAST = 3e-5, 20.0, 1.0, 1.0
# Weight of derivatives, which decreases with the size of the fast changes.
OF_SLOPES, SIZE = 0.4, 0.004
# Larger errors are not those of a second degree.
LARGEST: Final = 0.1
ROUNDS: Final = 6


def products_of(rates: Array, knots: Array) -> tuple[Array, Array]:
    """Memories, and their products times B-splines."""
    memories, products = np.empty(kernel.COUNT), np.empty(kernel.PRODUCTS)
    mean = kernel.recall(*divide(rates, len(rates)), memories)
    kernel.multiply_memories(memories, products)
    flat = np.clip([mean], knots[0], knots[-1])
    splines = BSpline.design_matrix(flat, padded_knots(knots), 3).toarray()[0]
    return memories, (products[:, None] * splines).ravel()


def value_equations(
    functions: UniversalFunctions, rates: Sequence[Array], states: Sequence[Array]
) -> tuple[Array, Array, Array]:
    """Products times B-splines, typical errors, and what the last states lack."""
    knots, law = functions.fast.last_knots, [law_states(functions, row)[-1] for row in rates]
    both = [products_of(row, knots) for row in rates]
    memories = np.array([memory for memory, _ in both])
    size = FLOOR + OF_CHANGE * memories[:, 0] ** 2 + OF_MEMORY * memories[:, kernel.SLOW - 1] ** 2
    size += OF_FAST * (memories[:, kernel.SLOW :] ** 2).sum(axis=1)
    rest = np.array([each[-1] for each in states]) - law
    return np.array([products for _, products in both]), size, rest


def slope_equations(functions: UniversalFunctions, chains: Sequence[Sensitivity]) -> Equations:
    """Normal equations of the derivatives with respect to the radii."""
    knots = functions.fast.last_knots
    unknowns = kernel.PRODUCTS * (len(knots) + 2)
    matrix, right = np.zeros((unknowns, unknowns)), np.zeros((unknowns, STATES))
    for chain in chains:
        rest = chain.less(law_slopes(functions, chain.rates))
        if not sound(rest, slice(-1, None)):
            continue
        weight = OF_SLOPES / (SIZE + np.sqrt(np.mean(divided(chain.rates)[1] ** 2)))
        steps = STEP * np.eye(len(chain.rates))
        moved = [
            products_of(chain.rates + step, knots)[1] - products_of(chain.rates - step, knots)[1]
            for step in steps
        ]
        slopes = weight * of_radii(np.array(moved).T / (2.0 * STEP))
        matrix += slopes @ slopes.T
        right += slopes @ (weight * of_radii(rest.slopes[-1])).T
    return matrix, right


def fit_last(
    functions: UniversalFunctions,
    rates: Sequence[Array],
    states: Sequence[Array],
    chains: Sequence[Sensitivity] = (),
) -> Array:
    """Coefficients of B-splines, (splines, 84), for functions that have none yet."""
    matrix, size, rest = value_equations(functions, rates, states)
    of_slopes, right_of_slopes = slope_equations(functions, chains)
    found = []
    for error, right_of_slope in zip(rest.T, right_of_slopes.T, strict=True):
        used = (np.abs(error) < LARGEST) / size
        for _ in range(ROUNDS):
            weighted = matrix * used[:, None]
            normal = weighted.T @ weighted + of_slopes
            scale = np.sqrt(np.diag(normal))
            scale += 1e-3 * scale.max()
            normal = normal / scale / scale[:, None] + RIDGE * np.eye(len(scale))
            right = weighted.T @ (error * used) + right_of_slope
            coefficients = np.linalg.solve(normal, right / scale) / scale
            # Outliers count with the root of their error.
            left = np.abs(error - matrix @ coefficients) / size
            used = (np.abs(error) < LARGEST) / size / np.sqrt(1.0 + left / np.median(left) / 3.0)
        found.append(coefficients.reshape(kernel.PRODUCTS, -1))
    # From (states, products, splines).
    return np.moveaxis(np.array(found), 2, 0).reshape(len(functions.fast.last_knots) + 2, -1)
