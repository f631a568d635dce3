"""Fit the response of one stage by least squares."""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.interpolate import BSpline, CubicSpline

from hertzchain.collision import Array
from hertzchain.theory.exponents import scaled
from hertzchain.theory.universal_functions import (
    INPUTS,
    PAIRS,
    REFERENCES,
    STAGES,
    START,
    STATE,
    TERMS,
    WITHIN,
    bca_growth,
    padded_knots,
)  # fmt: skip

from .training_chains import BEADS, HIGHEST, LOWEST, NODES, Sample

KNOTS: Final = np.array(
    [LOWEST, -0.13, -0.1, -0.07, -0.035, 0.0, 0.04, 0.1, 0.2, 0.35, 0.5, 0.75, HIGHEST]
)
# Unit of the deviations in the fits, which penalise large coefficients.
UNIT: Final = 0.1
UNITS: Final = UNIT ** np.array([1] * len(INPUTS) + [2] * len(PAIRS))[:, None, None]
RIDGES: Final = {"start": 1e-4, "within": 1e-3}
# Number of fits, in which outliers get a smaller weight each time.
ROUNDS: Final = 4
TINY: Final = 1e-12


class Anchors:
    """State of each stage on an exponential chain, as a function of its rate.

    Negative rates of the tables are multiplied by the factor ``shrink``.
    """

    def __init__(self, exponential: Sample, shrink: float = 1.0) -> None:
        at = [*range(START), BEADS // 2 + 12]
        self.nodes, self.knots = scaled(NODES, shrink), scaled(KNOTS, shrink)
        self.values = exponential.states[:, at]
        self.values[..., 0] -= bca_growth(self.nodes)[:, None]
        self.spline = CubicSpline(self.nodes, self.values)

    def __call__(self, stage: int, rate: Array) -> Array:
        """States of a stage, shape (..., 3)."""
        found = self.spline(np.clip(rate, self.nodes[0], self.nodes[-1]))[..., stage, :]
        found[..., 0] += bca_growth(rate)
        return np.asarray(found)

    def splines(self, rate: Array) -> Array:
        """Values of all B-splines of the response at given rates."""
        flat, knots = np.clip(rate, self.knots[0], self.knots[-1]).ravel(), padded_knots(self.knots)
        return BSpline.design_matrix(flat, knots, 3).toarray().reshape(*rate.shape, -1)


def terms(inputs: Array) -> tuple[Array, Array]:
    """All terms up to second order in the inputs, and their derivatives."""
    i, j = np.array(PAIRS).T
    values = np.concatenate([inputs, inputs[:, i] * inputs[:, j]], axis=1)
    slopes = np.zeros((*values.shape, len(INPUTS)))
    linear, products = np.arange(len(INPUTS)), len(INPUTS) + np.arange(len(PAIRS))
    slopes[:, linear, linear] = 1.0
    slopes[:, products, i] += inputs[:, j]
    slopes[:, products, j] += inputs[:, i]
    return values, slopes


def inputs(anchors: Anchors, stage: int, rates: Array, contact: int, before: Array | None) -> Array:
    """Inputs of the response of a contact, in units of `UNIT`, shape (C, 7)."""
    found = np.zeros((len(rates), len(INPUTS)))
    if before is not None:
        found[:, :3] = before - anchors(REFERENCES[stage], rates[:, contact - 1])
    # Differences beyond the struck bead are 0.
    for column, last in enumerate(range(contact - 1, contact + 3), start=len(STATE)):
        if last >= 1:
            found[:, column] = rates[:, last] - rates[:, last - 1]
    return found / UNIT


def fit_contact(anchors: Anchors, stage: int, sample: Sample, contacts: list[int]) -> Array:
    """Fit the response of one stage by least squares, contact by contact."""
    ridge = RIDGES[STAGES[stage].split()[0]]
    xs, ys, rates = [], [], []
    for contact in contacts:
        before = sample.states[:, contact - 1] if contact else None
        xs.append(inputs(anchors, stage, sample.rates, contact, before))
        rates.append(sample.rates[:, contact])
        ys.append(sample.states[:, contact] - anchors(stage, sample.rates[:, contact]))
    x, y, rate = np.concatenate(xs), np.concatenate(ys), np.concatenate(rates)
    size = UNIT * np.linalg.norm(x, axis=1)
    # Errors are weighted by the size of the deviations: fully within the chain, less at its ends.
    weight = 1.0 / (size + 1e-4) if stage == WITHIN else 1.0 / (np.sqrt(size) + 1e-2)
    used = (size > 3e-5) & (size < 0.5) if stage == WITHIN else np.full(len(size), True)
    x, y, rate, weight = x[used], y[used], rate[used], weight[used, None]
    basis, robust = anchors.splines(rate), np.ones((len(rate), 1))
    for _ in range(ROUNDS):
        found = _solve(x, basis, y, weight * robust, ridge)
        # Outliers count with the root of their error: contacts at which later waves overtake the
        # pulse, as behind steep forward tapers, follow other laws.
        fitted = np.concatenate(
            [_equations(x[rows], basis[rows]) @ found for rows in _portions(len(x))]
        )
        error = weight[:, 0] * np.linalg.norm(y - fitted, axis=1)
        robust = (1.0 + error / (np.median(error) + TINY) / 3.0)[:, None] ** -0.5
    return found.reshape(len(TERMS), -1, len(STATE))


def _portions(rows: int) -> list[Array]:
    """Indices of rows whose equations fit into memory."""
    return np.array_split(np.arange(rows), 1 + rows // 5000)


def _equations(x: Array, basis: Array) -> Array:
    """Terms times B-splines."""
    return np.asarray((terms(x)[0][:, :, None] * basis[:, None, :]).reshape(len(x), -1))


def _solve(x: Array, basis: Array, y: Array, weight: Array, ridge: float) -> Array:
    """Coefficients of all terms times B-splines by weighted least squares."""
    unknowns = len(TERMS) * basis.shape[1]
    matrix, right = np.zeros((unknowns, unknowns)), np.zeros((unknowns, len(STATE)))
    for rows in _portions(len(x)):
        part = _equations(x[rows], basis[rows]) * weight[rows]
        matrix += part.T @ part
        right += part.T @ (y[rows] * weight[rows])
    # Inputs that do not occur, such as differences before the struck bead, have no response.
    occurs = np.diag(matrix) > 0.0
    scale = np.sqrt(np.diag(matrix)[occurs])
    normal = matrix[np.ix_(occurs, occurs)] / scale[:, None] / scale + ridge * np.eye(len(scale))
    found = np.zeros((unknowns, len(STATE)))
    found[occurs] = np.linalg.solve(normal, right[occurs] / scale[:, None]) / scale[:, None]
    return found
