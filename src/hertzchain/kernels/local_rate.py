r"""The local-rate law, forward along a chain and its derivatives backward.

The state of contact k (`hertzchain.theory.universal`) follows from that of the contact before:

.. math::

    z_k = z^*(s_k) + \sum_i c_i(s_k)\,x_i + \sum_{i \le j} c_{ij}(s_k)\,x_i x_j,
    \qquad x = \left(z_{k-1} - z^*(s_{k-1}),\; s_{k-1} - s_{k-2},\; s_k - s_{k-1},\;
                 s_{k+1} - s_k,\; s_{k+2} - s_{k+1}\right)

with functions of the rate that are polynomials of third degree on intervals, and that belong
to one of the stages: the first four contacts, those within, the last three.  Going backward,
the derivatives of any one number to all rates cost as much as two or three times the law.
"""

from __future__ import annotations

import numpy as np
from numba import njit

STATES = 3
INPUTS = 7
TERMS = INPUTS + INPUTS * (INPUTS + 1) // 2
START, END = 4, 3
WITHIN = START
# The stage from whose anchor the state before is measured.
REFERENCES = np.array([0, 0, 1, 2, WITHIN, WITHIN, 5, 6])
# A state this far from an exponential chain's has run away; it is held there, and told.
FARTHEST = 1.0

compiled = njit(cache=True, nogil=True, error_model="numpy")


@compiled
def stage_of(contact, contacts):
    """Stage of a contact, counted from 0."""
    if contact < START:
        return contact
    return max(WITHIN, WITHIN + 1 + contact - (contacts - END))


@compiled
def interval_of(rate, ends):
    """The interval that holds a rate and the distance from its left end; outside, the nearest."""
    clipped = min(max(rate, ends[0]), ends[-1])
    interval = min(max(np.searchsorted(ends, clipped) - 1, 0), len(ends) - 2)
    return interval, clipped - ends[interval]


@compiled
def bca_growth(rate):
    """Growth of velocity by the BCA, ln[2/(1 + e^(3s))], without overflow."""
    if rate > 0.0:
        return np.log(2.0) - 3.0 * rate - np.log1p(np.exp(-3.0 * rate))
    return np.log(2.0) - np.log1p(np.exp(3.0 * rate))


@compiled
def anchor(rate, pieces, ends, value, slope):
    """State on an exponential chain of this rate and its derivative; outside, the BCA's trend."""
    interval, x = interval_of(rate, ends)
    inside = ends[0] <= rate <= ends[-1]
    for i in range(STATES):
        a, b, c, d = pieces[interval, :, i]
        value[i] = ((a * x + b) * x + c) * x + d
        slope[i] = (3.0 * a * x + 2.0 * b) * x + c if inside else 0.0
    value[0] += bca_growth(rate)
    slope[0] -= 3.0 / (1.0 + np.exp(-3.0 * rate))


@compiled
def local_response(rate, pieces, ends, value, slope):
    """Coefficients of all terms at a rate, and their derivatives to it."""
    interval, x = interval_of(rate, ends)
    inside = 1.0 if ends[0] <= rate <= ends[-1] else 0.0
    a, b, c, d = pieces[interval]
    for i in range(TERMS * STATES):
        value[i] = ((a[i] * x + b[i]) * x + c[i]) * x + d[i]
        slope[i] = inside * ((3.0 * a[i] * x + 2.0 * b[i]) * x + c[i])


@compiled
def gather(contact, stage, rates, deviation, x):
    """The inputs of a contact: deviation of the state before, differences of rates around."""
    ahead = 2 if stage <= WITHIN else 0
    for i in range(STATES):
        x[i] = deviation[i] if contact > 0 else 0.0
    for i in range(INPUTS - STATES):
        last = contact - 1 + i
        known = last >= 1 and last <= contact + ahead
        x[STATES + i] = rates[last] - rates[last - 1] if known else 0.0


@compiled
def respond(x, coefficients, out):
    """Add all terms to the state in ``out``; returns the size of what is of second degree."""
    for i in range(INPUTS):
        for o in range(STATES):
            out[o] += coefficients[i * STATES + o] * x[i]
    second = 0.0
    term = INPUTS
    for i in range(INPUTS):
        for j in range(i, INPUTS):
            product = x[i] * x[j]
            for o in range(STATES):
                out[o] += coefficients[term * STATES + o] * product
            second += abs(coefficients[term * STATES] * product)
            term += 1
    return second


@compiled
def pull_back(x, coefficients, slopes, weight, to_x):
    """Derivatives of the weighted state to the inputs; returns that to the rate, by the terms."""
    to_x[:] = 0.0
    to_rate = 0.0
    for i in range(INPUTS):
        for o in range(STATES):
            to_x[i] += weight[o] * coefficients[i * STATES + o]
            to_rate += weight[o] * slopes[i * STATES + o] * x[i]
    term = INPUTS
    for i in range(INPUTS):
        for j in range(i, INPUTS):
            pulled = 0.0
            for o in range(STATES):
                pulled += weight[o] * coefficients[term * STATES + o]
                to_rate += weight[o] * slopes[term * STATES + o] * x[i] * x[j]
            to_x[i] += pulled * x[j]
            to_x[j] += pulled * x[i]
            term += 1
    return to_rate


@compiled
def forward(rates, nodes, anchors, knots, response, states, records, thirds):
    """States of all contacts; returns the number of them that ran away.

    Parameters
    ----------
    rates : (M,) rates of the contacts
    nodes, anchors : ends of intervals, and (stages, intervals, 4, 3) polynomials
    knots, response : the same of the (stages, intervals, 4, terms * 3) responses
    states : (M, 3), written
    records : (M, 7), the inputs of each contact, written
    thirds : (M,), the size of the growth's second degree times that of the inputs, written:
        in proportion to the third degree, which is left out
    """
    contacts = len(rates)
    value, slope = np.zeros(STATES), np.zeros(STATES)
    deviation = np.zeros(STATES)
    coefficients, ignored = np.empty(TERMS * STATES), np.empty(TERMS * STATES)
    lost = 0
    for k in range(contacts):
        stage = stage_of(k, contacts)
        if k > 0:
            anchor(rates[k - 1], anchors[REFERENCES[stage]], nodes, value, slope)
            deviation[:] = states[k - 1] - value
        gather(k, stage, rates, deviation, records[k])
        anchor(rates[k], anchors[stage], nodes, states[k], slope)
        local_response(rates[k], response[stage], knots, coefficients, ignored)
        value[:] = states[k]
        thirds[k] = respond(records[k], coefficients, states[k]) * np.sqrt(np.sum(records[k] ** 2))
        away = False
        for i in range(STATES):
            if not abs(states[k, i] - value[i]) < FARTHEST:
                away = True
        if away:
            states[k] = value
            lost += 1
    return lost


@compiled
def backward(rates, nodes, anchors, knots, response, records, seeds, to_rates):
    """Derivatives of a number to all rates, given those to the states.

    Parameters
    ----------
    rates, nodes, anchors, knots, response : as for `forward`
    records : (M, 7) the inputs that `forward` wrote
    seeds : (M, 3) derivatives to the states; overwritten
    to_rates : (M,) derivatives to the rates are added to it
    """
    contacts = len(rates)
    value, slope = np.zeros(STATES), np.zeros(STATES)
    to_x = np.zeros(INPUTS)
    coefficients, slopes = np.empty(TERMS * STATES), np.empty(TERMS * STATES)
    for k in range(contacts - 1, -1, -1):
        stage = stage_of(k, contacts)
        anchor(rates[k], anchors[stage], nodes, value, slope)
        local_response(rates[k], response[stage], knots, coefficients, slopes)
        to_rates[k] += pull_back(records[k], coefficients, slopes, seeds[k], to_x)
        for i in range(STATES):
            to_rates[k] += seeds[k, i] * slope[i]
        if k == 0:
            # Nothing before it; its other inputs follow.
            to_x[:STATES] = 0.0
        else:
            anchor(rates[k - 1], anchors[REFERENCES[stage]], nodes, value, slope)
            for i in range(STATES):
                seeds[k - 1, i] += to_x[i]
                to_rates[k - 1] -= to_x[i] * slope[i]
        ahead = 2 if stage <= WITHIN else 0
        for i in range(INPUTS - STATES):
            last = k - 1 + i
            if last >= 1 and last <= k + ahead:
                to_rates[last] += to_x[STATES + i]
                to_rates[last - 1] -= to_x[STATES + i]
