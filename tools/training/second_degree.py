"""Fit the response to products of two fast changes on random chains."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.interpolate import BSpline

from hertzchain.chain.chain import Chain
from hertzchain.collision import Array
from hertzchain.kernels.fast_changes import (
    AHEAD,
    BEHIND,
    END,
    FACTORS,
    FIRST,
    LARGE,
    LAST,
    NEAR,
    PRODUCTS,
    STATES,
    TAPS,
    TINY,
)
from hertzchain.theory.local_rate import solve
from hertzchain.theory.universal_functions import START, UniversalFunctions, padded_knots

# Beyond the last knot, the response is zero.
KNOTS: Final = np.array(
    [-0.15, -0.1, -0.07, -0.045, -0.025, -0.01, 0.0, 0.01, 0.025, 0.05, 0.1, 0.2]
)
RIDGE: Final = 1e-4
# Mean square of fast changes below which errors are negligible.
FLOOR: Final = 1e-5
# The sum of the growth over contacts is fitted, too, at every eighth contact, with this weight.
SUMMED: Final = 8
WEIGHT_OF_SUMS: Final = 0.35
# Larger errors of a contact are not those of a second degree.
LARGEST: Final = 0.3


def terms(slow: Array, fast: Array, knots: Array, steady: float) -> tuple[Array, Array]:
    """Products of fast changes times their gain, (M, 28), and values of B-splines."""
    padded = np.concatenate([np.zeros(BEHIND), fast, np.zeros(AHEAD)])
    around = np.stack([padded[i : i + len(fast)] for i in range(TAPS)], axis=1)
    size = (around[:, FIRST:LAST] ** 2).mean(axis=1)
    gain = (4.0 * slow**2 + size + TINY) ** 0.25 * (1.0 + size / LARGE) ** -1.25
    gain += steady / (1.0 + size / LARGE)
    i, j = np.triu_indices(FACTORS)
    flat = np.clip(slow, knots[0], knots[-1])
    splines = BSpline.design_matrix(flat, padded_knots(knots), 3).toarray()
    return gain[:, None] * around[:, NEAR + i] * around[:, NEAR + j], splines[:, :-1]


def fit(functions: UniversalFunctions, rates: Sequence[Array], states: Sequence[Array]) -> Array:
    """Coefficients of B-splines, (splines, 84), for functions that have none yet."""
    knots, steady = functions.fast.knots, functions.fast.steady
    unknowns = PRODUCTS * (len(knots) + 1)
    matrix, right = np.zeros((unknowns, unknowns)), np.zeros((unknowns, STATES))
    used = slice(START, -END)
    for row, true in zip(rates, states, strict=True):
        radii = np.exp(np.concatenate([[0.0], np.cumsum(row)]))
        solution = solve(Chain.from_radii(radii, exponent=functions.exponent), functions)
        rest = true - solution.states
        if np.abs(rest).max() > LARGEST:
            continue
        fast = row - solution.slow
        products, splines = terms(solution.slow, fast, knots, steady)
        equations = (products[used, :, None] * splines[used, None, :]).reshape(-1, unknowns)
        weight = 1.0 / (FLOOR + np.mean(fast**2))
        for part, value, factor in (
            (equations, rest[used], weight),
            (
                np.cumsum(equations, axis=0)[SUMMED - 1 :: SUMMED],
                np.cumsum(rest[used], axis=0)[SUMMED - 1 :: SUMMED],
                WEIGHT_OF_SUMS * weight,
            ),
        ):
            matrix += factor**2 * part.T @ part
            right += factor**2 * part.T @ value
    scale = np.sqrt(np.diag(matrix))
    scale += 1e-3 * scale.max()
    normal = matrix / scale[:, None] / scale + RIDGE * np.eye(unknowns)
    found = np.linalg.solve(normal, right / scale[:, None]) / scale[:, None]
    # From (products, splines, states).
    shaped = np.moveaxis(found.reshape(PRODUCTS, -1, STATES), (1, 2, 0), (0, 1, 2))
    return np.concatenate([shaped, np.zeros((1, STATES, PRODUCTS))]).reshape(len(knots) + 2, -1)
