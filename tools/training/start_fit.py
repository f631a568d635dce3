"""Fit the second order of the response of the first contacts once more, to the whole law.

Ramps determine it for small changes.  Behind the impact of a backward taper, rates change by more
than a tenth per bead.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from hertzchain.collision import Array
from hertzchain.theory.universal_functions import INPUTS, START, UniversalFunctions

from .response_fit import UNIT, UNITS, Anchors, inputs, terms
from .second_degree import Chains, divided
from .sensitivities import law_states

RIDGE: Final = 1e-3
# Errors are relative to the square of the changes plus this value.
FLOOR: Final = 3e-4
# Larger errors are not those of a second degree.
LARGEST: Final = 0.1
ROUNDS: Final = 4


def fit_start(
    functions: Callable[[Array], UniversalFunctions],
    anchors: Anchors,
    response: Array,
    chains: Sequence[Chains],
) -> Array:
    """Response of all stages with another second order of the first contacts.

    The functions are those of a response.
    """
    rates = [row for each in chains for row in each.rates]
    states = [row for each in chains for row in each.states]
    slow = np.array([divided(row)[0][: START + len(INPUTS)] for row in rates])
    found, before = response.copy(), None
    for k in range(START):
        law = functions(found)
        rest = [true[k] - law_states(law, row)[k] for row, true in zip(rates, states, strict=True)]
        x, basis = inputs(anchors, k, slow, k, before), anchors.splines(slow[:, k])
        products = terms(x)[0][:, len(INPUTS) :]
        equations = (products[:, :, None] * basis[:, None]).reshape(len(x), -1)
        change = robust_fit(equations, np.array(rest), UNIT**2 * (x**2).sum(axis=1))
        shape = products.shape[1], basis.shape[1], -1
        found[k, len(INPUTS) :] += change.reshape(shape) / UNITS[len(INPUTS) :]
        before = anchors(k, slow[:, k])
        before += np.einsum("cf,cb,fbo->co", terms(x)[0], basis, found[k] * UNITS)
    return found


def robust_fit(equations: Array, rest: Array, square: Array) -> Array:
    """Coefficients (unknowns, 3) for errors that are relative to a square of the changes."""
    weight = (np.abs(rest).max(axis=1) < LARGEST) / (FLOOR + square)
    robust = np.ones(len(rest))
    for _ in range(ROUNDS):
        weighted = equations * (weight * robust)[:, None]
        normal = weighted.T @ weighted
        scale = np.sqrt(np.diag(normal))
        scale += 1e-3 * scale.max()
        normal = normal / scale / scale[:, None] + RIDGE * np.eye(len(scale))
        right = weighted.T @ (rest * (weight * robust)[:, None])
        found = np.linalg.solve(normal, right / scale[:, None]) / scale[:, None]
        # Outliers count with the root of their error.
        error = weight * np.linalg.norm(rest - equations @ found, axis=1)
        robust = 1.0 / np.sqrt(1.0 + error / np.median(error[weight > 0.0]) / 3.0)
    return np.asarray(found)
