"""Fit the higher orders of the states of the last contacts.

The equations are the states of chains that change slowly or quickly towards their end, and the
derivatives of these states with respect to the last radii.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.interpolate import BSpline

from hertzchain.collision import Array
from hertzchain.kernels import last_contacts as kernel
from hertzchain.kernels.fast_changes import STATES
from hertzchain.theory.universal_functions import FastTables, padded_knots

from .sensitivities import Sensitivity, of_radii, simulate_slopes
from .training_chains import ending_rates, wavy_rates

KNOTS: Final = np.array([-0.15, -0.11, -0.08, -0.05, -0.025, 0.0, 0.025, 0.06, 0.12, 0.25, 0.5])
RIDGE: Final = 1e-4
# Numbers of chains that change slowly towards their end, of those among them with larger rates,
# and of those that change quickly, with their numbers of contacts.
SLOWLY, STRONGLY, QUICKLY = 500, 120, 250
CONTACTS, STRONG_CONTACTS = 32, 22
# Number of last rates that are changed; tolerance of these simulations.
CHANGED: Final = 18
RTOL: Final = 1e-9
# Weight of the states, relative to that of derivatives, which decreases with the changes near the
# end: with their size and with its square.
OF_STATES: Final = 40.0
FLOOR, OF_SIZE, OF_SQUARE, NEAR = 2e-3, 0.2, 20.0, 11
ROUNDS: Final = 4
# Larger errors are not those of a low degree.
LARGEST, LARGEST_SLOPE = 0.1, 1.0
# Step of the derivatives of the products.
STEP: Final = 1e-6


def ending_slopes(exponent: float) -> list[Sensitivity]:
    """Chains with the derivatives of their states with respect to the last rates."""
    random = np.random.default_rng(6)
    slowly = [row[-CONTACTS:] for row in ending_rates(random, SLOWLY)]
    strongly = [row[-STRONG_CONTACTS:] + random.uniform(0.1, 0.5) for row in slowly[-STRONGLY:]]
    rates = [*slowly, *strongly, *wavy_rates(random, QUICKLY, CONTACTS)]
    return simulate_slopes(rates, exponent, CHANGED, RTOL)


def last_states(tables: FastTables, rates: Array) -> Array:
    """States of the last contacts, (4, 3)."""
    states = np.zeros((len(rates), STATES))
    kernel.write_last(rates, tables, states)
    return states[-kernel.LAST :]


def products_of(rates: Array, contact: int, knots: Array) -> Array:
    """Products of the inputs of a contact times B-splines."""
    inputs, products = np.empty(kernel.COUNT), np.empty(kernel.PRODUCTS)
    mean = kernel.recall(contact, rates, inputs, np.empty(kernel.TERMS))
    kernel.multiply_inputs(inputs, products)
    flat = np.clip([mean], knots[0], knots[-1])
    splines = BSpline.design_matrix(flat, padded_knots(knots), 3).toarray()[0]
    return (products[:, None] * splines).ravel()


def of_last_rates(function, rates: Array) -> Array:
    """Derivatives of a function of the rates with respect to the last ones, (..., 18)."""
    steps = STEP * np.eye(len(rates))[-CHANGED:]
    moved = [function(rates + step) - function(rates - step) for step in steps]
    return np.moveaxis(np.array(moved), 0, -1) / (2.0 * STEP)


def weight_of(rates: Array, contact: int) -> float:
    """Weight of the derivatives at a contact."""
    square = float((np.diff(rates)[max(0, contact - NEAR + 1) :] ** 2).sum())
    return 1.0 / (FLOOR + OF_SIZE * np.sqrt(square) + OF_SQUARE * square)


def fit_last(tables: FastTables, chains: Sequence[Sensitivity]) -> Array:
    """Coefficients of B-splines, (splines, 552), for tables that have none yet."""
    rest = [
        Sensitivity(
            chain.rates,
            chain.states[-kernel.LAST :] - last_states(tables, chain.rates),
            of_last_radii(
                chain.slopes[-kernel.LAST :]
                - of_last_rates(lambda rates: last_states(tables, rates), chain.rates)
            ),
        )
        for chain in chains
    ]
    found = [fit_one(rest, stage, tables.last_knots) for stage in range(kernel.LAST)]
    # From (contacts, products, splines, states).
    return np.transpose(found, (2, 0, 3, 1)).reshape(len(tables.last_knots) + 2, -1)


def of_last_radii(slopes: Array) -> Array:
    """Derivatives with respect to the radii ahead of the first of the last rates."""
    return of_radii(slopes)[..., 1:]


def fit_one(rest: Sequence[Sensitivity], stage: int, knots: Array) -> Array:
    """Coefficients (products, splines, 3) of one contact."""
    equations = [each for chain in rest for each in equations_of(chain, stage, knots)]
    found = np.zeros((kernel.PRODUCTS * (len(knots) + 2), STATES))
    robust = np.ones(len(equations))
    for _ in range(ROUNDS):
        normal, right = np.zeros((len(found), len(found))), np.zeros_like(found)
        for (matrix, wanted), factor in zip(equations, robust, strict=True):
            normal += factor * matrix @ matrix.T
            right += factor * matrix @ wanted
        scale = np.sqrt(np.diag(normal))
        scale += 1e-3 * scale.max()
        normal = normal / scale / scale[:, None] + RIDGE * np.eye(len(scale))
        found = np.linalg.solve(normal, right / scale[:, None]) / scale[:, None]
        # In steep forward tapers, states have kinks: outliers count with the root of their error.
        missed = np.array([np.abs(wanted - matrix.T @ found).max() for matrix, wanted in equations])
        robust = 1.0 / (1.0 + missed / np.median(missed) / 3.0)
    return found.reshape(kernel.PRODUCTS, -1, STATES)


def equations_of(chain: Sensitivity, stage: int, knots: Array) -> list[tuple[Array, Array]]:
    """Weighted equations of a chain, (unknowns, C), and what they should give, (C, 3)."""
    rates, states, slopes = chain.rates, chain.states[stage], chain.slopes[stage]
    if np.abs(states).max() > LARGEST or np.abs(slopes).max() > LARGEST_SLOPE:
        return []
    contact = len(rates) - kernel.LAST + stage
    weight = weight_of(rates, contact)
    of_state = OF_STATES * products_of(rates, contact, knots)[:, None]
    of_slopes = of_last_radii(of_last_rates(lambda row: products_of(row, contact, knots), rates))
    wanted = np.concatenate([OF_STATES * states[None], slopes.T])
    return [(weight * np.hstack([of_state, of_slopes]), weight * wanted)]
