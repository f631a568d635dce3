"""Fit the response within the chain to whole ramps."""

from __future__ import annotations

from typing import Final

import numpy as np

from hertzchain.collision import Array
from hertzchain.kernels.fast_changes import AHEAD, BEHIND, END, WORK, add_response, write_steps
from hertzchain.theory.universal_functions import (
    INPUTS,
    START,
    STATE,
    TERMS,
    WITHIN,
    UniversalFunctions,
)

from .response_fit import UNIT, Anchors, inputs, terms
from .training_chains import BEADS, Sample

# The last contacts of a long chain are not used for the response within the chain.
UNTIL: Final = BEADS - 7
# Velocity errors below this value are negligible.
MIN_ERROR: Final = 6e-5


class Rollout:
    """The law along many ramps, with its derivatives with respect to the response.

    Attributes
    ----------
    contact : int
        Current contact, counted from 0.
    state : ndarray, shape (C, 3)
        State of this contact.
    slopes : ndarray, shape (C, 3, 3 * terms * splines)
        Derivatives of the state with respect to the response, by component first.
    log_velocity, velocity_slopes : ndarray
        Growth accumulated since the start, and its derivatives.
    lost : ndarray of bool, shape (C,)
        Ramps whose state has diverged.
    """

    def __init__(self, anchors: Anchors, response: Array, sample: Sample) -> None:
        chains = len(sample.rates)
        self.anchors, self.response, self.sample = anchors, response, sample
        self.contact = START - 1
        self.state = sample.states[:, self.contact]
        self.slopes = np.zeros((chains, 3, response.size))
        self.log_velocity = np.zeros(chains)
        self.velocity_slopes = np.zeros((chains, response.size))
        self.lost = np.zeros(chains, bool)

    def step(self) -> None:
        """Proceed to the next contact."""
        self.contact += 1
        rate = self.sample.rates[:, self.contact]
        x = inputs(self.anchors, WITHIN, self.sample.rates, self.contact, self.state)
        values, slopes = terms(x)
        basis = self.anchors.splines(rate)
        local = np.einsum("cb,fbo->cfo", basis, self.response)
        change = np.einsum("cf,cfo->co", values, local)
        jacobian = np.einsum("cfi,cfo->coi", slopes[:, :, :3], local) / UNIT
        # With a first guess some ramps diverge; they are kept constant and ignored from then on.
        self.lost |= ~(np.abs(change).max(axis=1) < 1.0)
        change[self.lost], jacobian[self.lost] = 0.0, 0.0
        self.state = self.anchors(WITHIN, rate) + change
        self.slopes = jacobian @ self.slopes
        direct = (values[:, :, None] * basis[:, None, :]).reshape(len(rate), -1)
        for component in range(3):
            first = component * direct.shape[1]
            self.slopes[:, component, first : first + direct.shape[1]] += direct
        self.log_velocity += self.state[:, 0]
        self.velocity_slopes += self.slopes[:, 0]


def missing_states(functions: UniversalFunctions, rates: Array) -> Array:
    """Terms that the law adds to the states of the recursion if rates are slow, (C, M, 3)."""
    found = np.zeros((*rates.shape, len(STATE)))
    fast = np.zeros(BEHIND + rates.shape[1] + AHEAD)
    steps, work = np.empty_like(fast), np.empty(WORK)
    for row, states in zip(rates, found, strict=True):
        write_steps(row, steps)
        # The chain continues beyond these contacts.
        add_response(len(row) + END, row, fast, steps, functions.fast, work, states)
    return found


def refine(
    anchors: Anchors,
    response: Array,
    sample: Sample,
    added: Array | float = 0.0,
    rounds: int = 3,
    every: int = 1,
) -> Array:
    """Fit the response to whole ramps by the Gauss-Newton method.

    Each ramp is weighted by its largest change of rate, and outliers by the root of their error.
    Only every so many contacts are compared.  If states that are ``added`` to those of the
    recursion are given, they belong to its first order: only the second order is fitted.
    """
    roughest = np.abs(np.diff(sample.rates[:, START - 1 : UNTIL])).max(axis=1)
    weight = 1.0 / (MIN_ERROR + 0.03 * roughest)
    wanted = sample.states - added
    growth = np.cumsum(wanted[:, START:UNTIL, 0], axis=1)
    products = np.arange(len(TERMS)) >= (0 if np.ndim(added) == 0 else len(INPUTS))
    fitted = np.tile(np.repeat(products, response.shape[1]), len(STATE))
    for _ in range(rounds):
        rollout = Rollout(anchors, response, sample)
        unknowns = int(fitted.sum())
        matrix, right = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
        for contact in range(START, UNTIL):
            rollout.step()
            if (contact - START) % every:
                continue
            true = wanted[:, contact]
            errors = [rollout.log_velocity - growth[:, contact - START]]
            errors += [0.5 * (rollout.state[:, i] - true[:, i]) for i in (1, 2)]
            slopes = [rollout.velocity_slopes, *(0.5 * rollout.slopes[:, i] for i in (1, 2))]
            for error, slope in zip(errors, slopes, strict=True):
                kept = ~rollout.lost
                weighted = weight[kept] * error[kept]
                robust = 1.0 / np.sqrt(1.0 + np.abs(weighted) / 3.0)
                part = slope[np.ix_(kept, fitted)] * (weight[kept] * robust)[:, None]
                matrix += part.T @ part
                right += part.T @ (weighted * robust)
        scale = np.sqrt(np.diag(matrix))
        scale += 1e-3 * scale.max()
        change = np.zeros(response.size)
        change[fitted] = np.linalg.solve(matrix + 1e-4 * np.diag(scale**2), right)
        response = response - np.moveaxis(change.reshape(3, *response.shape[:2]), 0, -1)
    return response
