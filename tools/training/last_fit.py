"""Fit the second order of the response of the last contacts.

The equations are the states of chains that change slowly towards their end, and the derivatives of
those of other random chains with respect to the radii.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.interpolate import BSpline

from hertzchain.collision import Array
from hertzchain.kernels import last_contacts as kernel
from hertzchain.kernels.fast_changes import STATES
from hertzchain.kernels.local_rate_pulse import divide
from hertzchain.theory.universal_functions import UniversalFunctions, padded_knots

from .second_degree import STEP, Chains, divided, sound
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
# The last B-splines are zero, except for the last contact: in strong backward tapers, few chains
# determine them, and the response is nearly of first order.
ZERO: Final = 3


@dataclass(frozen=True, eq=False)
class Equations:
    """Equations of one of the last contacts.

    Attributes
    ----------
    matrix, size, rest : ndarray, shapes (C, n), (C,), (C, 3)
        Products times B-splines, typical errors, and what the states lack.
    normal, right : ndarray, shapes (n, n), (n, 3)
        Normal equations of the derivatives with respect to the radii.
    """

    matrix: Array
    size: Array
    rest: Array
    normal: Array
    right: Array


def products_of(parts: tuple[Array, Array], contact: int, knots: Array) -> tuple[Array, Array]:
    """Memories at a contact, and their products times B-splines, from both parts of the rates."""
    memories, products = np.empty(kernel.COUNT), np.empty(kernel.PRODUCTS)
    mean = kernel.recall(contact, *parts, memories)
    kernel.multiply_memories(memories, products)
    flat = np.clip([mean], knots[0], knots[-1])
    splines = BSpline.design_matrix(flat, padded_knots(knots), 3).toarray()[0]
    return memories, (products[:, None] * splines).ravel()


def value_equations(
    rates: Sequence[Array], rest: Sequence[Array], left: int, knots: Array
) -> tuple[Array, Array, Array]:
    """Products times B-splines, typical errors, and what the states of a contact lack."""
    both = [products_of(divide(row, len(row)), len(row) - 1 - left, knots) for row in rates]
    memories = np.array([memory for memory, _ in both])
    fast = memories[:, kernel.COUNT - len(kernel.OFFSETS) :]
    size = FLOOR + OF_CHANGE * memories[:, 0] ** 2 + OF_MEMORY * memories[:, kernel.SLOW - 1] ** 2
    size += OF_FAST * (fast**2).sum(axis=1)
    return np.array([products for _, products in both]), size, np.array([
        each[-1 - left] for each in rest
    ])  # fmt: skip


def slope_equations(rest: Sequence[Sensitivity], left: int, knots: Array) -> tuple[Array, Array]:
    """Normal equations of the derivatives with respect to the radii."""
    unknowns = kernel.PRODUCTS * (len(knots) + 2)
    normal, right = np.zeros((unknowns, unknowns)), np.zeros((unknowns, STATES))
    for chain in rest:
        contact = len(chain.rates) - 1 - left
        if not sound(chain, slice(contact, contact + 1)):
            continue
        weight = OF_SLOPES / (SIZE + np.sqrt(np.mean(divided(chain.rates)[1] ** 2)))
        steps = STEP * np.eye(len(chain.rates))
        moved = [
            products_of(divide(chain.rates + step, len(step)), contact, knots)[1]
            - products_of(divide(chain.rates - step, len(step)), contact, knots)[1]
            for step in steps
        ]
        slopes = weight * of_radii(np.array(moved).T / (2.0 * STEP))
        normal += slopes @ slopes.T
        right += slopes @ (weight * of_radii(chain.slopes[contact])).T
    return normal, right


def fit_last(
    functions: UniversalFunctions, ending: Chains, chains: Sequence[Sensitivity] = ()
) -> Array:
    """Coefficients of B-splines, (splines, 792), for functions that have none yet."""
    knots = functions.fast.last_knots
    rates = ending.rates
    rest = [
        true - law_states(functions, row) for row, true in zip(rates, ending.states, strict=True)
    ]
    sloped = [chain.less(law_slopes(functions, chain.rates)) for chain in chains]
    found = [
        fit_one(
            Equations(
                *value_equations(rates, rest, left, knots), *slope_equations(sloped, left, knots)
            )
        )
        for left in reversed(range(kernel.LAST))
    ]
    # From (contacts, states, products, splines).
    of_contacts = np.array(found)
    of_contacts[:-1, ..., -ZERO:] = 0.0
    return np.moveaxis(of_contacts, 3, 0).reshape(len(knots) + 2, -1)


def fit_one(of: Equations) -> Array:
    """Coefficients (states, products, splines) of one contact."""
    found = []
    for error, right_of_slope in zip(of.rest.T, of.right.T, strict=True):
        used = (np.abs(error) < LARGEST) / of.size
        for _ in range(ROUNDS):
            weighted = of.matrix * used[:, None]
            normal = weighted.T @ weighted + of.normal
            scale = np.sqrt(np.diag(normal))
            scale += 1e-3 * scale.max()
            normal = normal / scale / scale[:, None] + RIDGE * np.eye(len(scale))
            right = weighted.T @ (error * used) + right_of_slope
            coefficients = np.linalg.solve(normal, right / scale) / scale
            # Outliers count with the root of their error.
            left = np.abs(error - of.matrix @ coefficients) / of.size
            used = (np.abs(error) < LARGEST) / of.size / np.sqrt(1.0 + left / np.median(left) / 3.0)
        found.append(coefficients.reshape(kernel.PRODUCTS, -1))
    return np.array(found)
