"""The response of one stage, by least squares."""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.interpolate import BSpline, CubicSpline

from hertzchain.contacts import Array
from hertzchain.theory.universal import (
    END,
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
from hertzchain.training.samples import BEADS, HIGHEST, LOWEST, NODES, Sample

KNOTS: Final = np.array(
    [LOWEST, -0.13, -0.1, -0.07, -0.035, 0.0, 0.04, 0.1, 0.2, 0.35, 0.5, 0.75, HIGHEST]
)
# A deviation of this size counts as one in the fits, where it is punished to be large.
UNIT: Final = 0.1
RIDGES: Final = {"start": 1e-4, "within": 1e-3, "end": 1e-2}


class Anchors:
    """State of each stage on an exponential chain, as a function of its rate."""

    def __init__(self, exponential: Sample) -> None:
        at = [*range(START), BEADS // 2 + 12, *range(-END, 0)]
        self.values = exponential.states[:, at]
        self.values[..., 0] -= bca_growth(NODES)[:, None]
        self.spline = CubicSpline(NODES, self.values)

    def __call__(self, stage: int, rate: Array) -> Array:
        """States of a stage, shape (..., 3)."""
        found = self.spline(np.clip(rate, LOWEST, HIGHEST))[..., stage, :]
        found[..., 0] += bca_growth(rate)
        return np.asarray(found)


def splines(rate: Array) -> Array:
    """Values of all B-splines at some rates.

    Parameters
    ----------
    rate : ndarray
        Rates; outside the tables the nearest one counts.

    Returns
    -------
    ndarray, shape (..., splines)

    Examples
    --------
    >>> splines(np.array([0.0, 0.3])).sum(axis=1).round(12)
    array([1., 1.])
    """
    flat = np.clip(rate, LOWEST, HIGHEST).ravel()
    return BSpline.design_matrix(flat, padded_knots(KNOTS), 3).toarray().reshape(*rate.shape, -1)


def terms(inputs: Array) -> tuple[Array, Array]:
    """All terms of second degree of the inputs, and their derivatives.

    Parameters
    ----------
    inputs : ndarray, shape (C, 7)
        Deviations, in units of `UNIT`.

    Returns
    -------
    values : ndarray, shape (C, terms)
    slopes : ndarray, shape (C, terms, 7)

    Examples
    --------
    >>> values, slopes = terms(np.full((1, 7), 2.0))
    >>> values[0, 0], values[0, 7], slopes[0, 7, 0]
    (np.float64(2.0), np.float64(4.0), np.float64(4.0))
    """
    i, j = np.array(PAIRS).T
    values = np.concatenate([inputs, inputs[:, i] * inputs[:, j]], axis=1)
    slopes = np.zeros((*values.shape, len(INPUTS)))
    linear, products = np.arange(len(INPUTS)), len(INPUTS) + np.arange(len(PAIRS))
    slopes[:, linear, linear] = 1.0
    slopes[:, products, i] += inputs[:, j]
    slopes[:, products, j] += inputs[:, i]
    return values, slopes


def inputs(anchors: Anchors, stage: int, rates: Array, contact: int, before: Array | None) -> Array:
    """What the state of a contact responds to, in units of `UNIT`, shape (C, 7).

    Parameters
    ----------
    anchors : Anchors
        States on exponential chains.
    stage : int
        Index in `STAGES`.
    rates : ndarray, shape (C, M)
        Rates of the contacts.
    contact : int
        Contact, counted from 0 at the first column.
    before : ndarray, shape (C, 3), or None
        State of the contact before, if there is one.

    Returns
    -------
    ndarray

    Examples
    --------
    The rate changes by 0.1 from one contact to the next:

    >>> contacts = len(NODES), BEADS - 1
    >>> anchors = Anchors(Sample(np.zeros(contacts), np.zeros((*contacts, 3))))
    >>> inputs(anchors, WITHIN, 0.1 * np.arange(9.0)[None], 5, np.zeros((1, 3)))[0, 3:].round(9)
    array([1., 1., 1., 1.])
    """
    found = np.zeros((len(rates), len(INPUTS)))
    if before is not None:
        found[:, :3] = before - anchors(REFERENCES[stage], rates[:, contact - 1])
    # Differences that reach beyond the strike or the free end count as none.
    ahead = 2 if stage <= WITHIN else 0
    for column, last in enumerate(range(contact - 1, contact + ahead + 1), start=len(STATE)):
        if last >= 1:
            found[:, column] = rates[:, last] - rates[:, last - 1]
    return found / UNIT


def fit_contact(anchors: Anchors, stage: int, sample: Sample, contacts: list[int]) -> Array:
    """Response of one stage by least squares, contact by contact.

    Parameters
    ----------
    anchors : Anchors
        States on exponential chains.
    stage : int
        Index in `STAGES`.
    sample : Sample
        Chains.
    contacts : list of int
        Contacts of that stage, counted from 0.

    Returns
    -------
    ndarray, shape (terms, splines, 3)

    Examples
    --------
    Done by ``python -m hertzchain.training``.
    """
    ridge = RIDGES[STAGES[stage].split()[0]]
    xs, ys, rates = [], [], []
    for contact in contacts:
        before = sample.states[:, contact - 1] if contact else None
        xs.append(inputs(anchors, stage, sample.rates, contact, before))
        rates.append(sample.rates[:, contact])
        ys.append(sample.states[:, contact] - anchors(stage, sample.rates[:, contact]))
    x, y, rate = np.concatenate(xs), np.concatenate(ys), np.concatenate(rates)
    size = UNIT * np.linalg.norm(x, axis=1)
    # Errors are judged by the size of what caused them: fully within, less at the ends.
    weight = 1.0 / (size + 1e-4) if stage == WITHIN else 1.0 / (np.sqrt(size) + 1e-2)
    used = (size > 3e-5) & (size < 0.5) if stage == WITHIN else np.full(len(size), True)
    x, y, rate, weight = x[used], y[used], rate[used], weight[used, None]
    unknowns = len(TERMS) * (len(KNOTS) + 2)
    matrix, right = np.zeros((unknowns, unknowns)), np.zeros((unknowns, len(STATE)))
    for rows in np.array_split(np.arange(len(x)), 1 + len(x) // 5000):
        part = terms(x[rows])[0][:, :, None] * splines(rate[rows])[:, None, :]
        part = part.reshape(len(rows), -1) * weight[rows]
        matrix += part.T @ part
        right += part.T @ (y[rows] * weight[rows])
    # What does not occur, such as differences before the strike, gets no response.
    occurs = np.diag(matrix) > 0.0
    scale = np.sqrt(np.diag(matrix)[occurs])
    normal = matrix[np.ix_(occurs, occurs)] / scale[:, None] / scale + ridge * np.eye(len(scale))
    found = np.zeros((unknowns, len(STATE)))
    found[occurs] = np.linalg.solve(normal, right[occurs] / scale[:, None]) / scale[:, None]
    return found.reshape(len(TERMS), -1, len(STATE))
