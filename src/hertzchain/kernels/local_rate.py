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
# Coefficients of a cubic polynomial for each component of the state.
POWERS = 4 * STATES
# A state this far from an exponential chain's has run away; it is held there, and told.
FARTHEST = 1.0

# Sums may be taken in any order, so that they can be taken four numbers at a time.
compiled = njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract"})


@compiled
def stage_of(contact, contacts):
    """Stage of a contact, counted from 0."""
    if contact < START:
        return contact
    return max(WITHIN, WITHIN + 1 + contact - (contacts - END))


@compiled
def interval_of(rate, ends, guess):
    """The interval that holds a rate and the distance from its left end; outside, the nearest.

    Searched from the contact before: most rates are close to it.
    """
    clipped = min(max(rate, ends[0]), ends[-1])
    interval = guess
    while interval > 0 and clipped < ends[interval]:
        interval -= 1
    while interval < len(ends) - 2 and clipped >= ends[interval + 1]:
        interval += 1
    return interval, clipped - ends[interval]


@compiled
def bca_growth(rate):
    """Growth of velocity by the BCA, ln[2/(1 + e^(3s))], without overflow."""
    if rate > 0.0:
        return np.log(2.0) - 3.0 * rate - np.log1p(np.exp(-3.0 * rate))
    return np.log(2.0) - np.log1p(np.exp(3.0 * rate))


@compiled
def anchor(rate, pieces, ends, guess, value, slope):
    """State on an exponential chain of this rate and its derivative; outside, the BCA's trend.

    Returns the interval of the rate.
    """
    interval, x = interval_of(rate, ends, guess)
    inside = ends[0] <= rate <= ends[-1]
    powers = pieces[interval]
    for i in range(STATES):
        a, b, c = powers[i], powers[STATES + i], powers[2 * STATES + i]
        value[i] = ((a * x + b) * x + c) * x + powers[3 * STATES + i]
        slope[i] = (3.0 * a * x + 2.0 * b) * x + c if inside else 0.0
    value[0] += bca_growth(rate)
    slope[0] -= 3.0 / (1.0 + np.exp(-3.0 * rate))
    return interval


@compiled
def gather(contact, stage, rates, x):
    """The inputs of a contact that are differences of the rates around it."""
    ahead = 2 if stage <= WITHIN else 0
    for i in range(INPUTS - STATES):
        last = contact - 1 + i
        known = last >= 1 and last <= contact + ahead
        x[STATES + i] = rates[last] - rates[last - 1] if known else 0.0


@compiled
def all_terms(x, terms):
    """Each input, then each product of two."""
    terms[:INPUTS] = x
    term = INPUTS
    for i in range(INPUTS):
        for j in range(i, INPUTS):
            terms[term] = x[i] * x[j]
            term += 1


@compiled
def respond(terms, pieces, x, inside, value, slope):
    """Add the terms times their polynomials to the state, and to its derivative to the rate."""
    # All twelve sums at once stay in registers: growth, force, time for each power of x.
    a0 = a1 = a2 = b0 = b1 = b2 = c0 = c1 = c2 = d0 = d1 = d2 = 0.0
    for term in range(TERMS):
        factor, row = terms[term], pieces[term]
        a0 += factor * row[0]
        a1 += factor * row[1]
        a2 += factor * row[2]
        b0 += factor * row[3]
        b1 += factor * row[4]
        b2 += factor * row[5]
        c0 += factor * row[6]
        c1 += factor * row[7]
        c2 += factor * row[8]
        d0 += factor * row[9]
        d1 += factor * row[10]
        d2 += factor * row[11]
    value[0] += ((a0 * x + b0) * x + c0) * x + d0
    value[1] += ((a1 * x + b1) * x + c1) * x + d1
    value[2] += ((a2 * x + b2) * x + c2) * x + d2
    if inside:
        slope[0] += (3.0 * a0 * x + 2.0 * b0) * x + c0
        slope[1] += (3.0 * a1 * x + 2.0 * b1) * x + c1
        slope[2] += (3.0 * a2 * x + 2.0 * b2) * x + c2


@compiled
def second_degree(terms, pieces, x):
    """Size of what the products of two inputs add to the growth."""
    size = 0.0
    for term in range(INPUTS, TERMS):
        a, b, c = pieces[term, 0], pieces[term, STATES], pieces[term, 2 * STATES]
        size += abs(terms[term] * (((a * x + b) * x + c) * x + pieces[term, 3 * STATES]))
    return size


@compiled
def forward(rates, nodes, anchors, knots, response, states, slopes, records, doubts):
    """States of all contacts; returns the first contact that ran away, or their number if none.

    Parameters
    ----------
    rates : (M,) rates of the contacts
    nodes, anchors : ends of intervals, and (stages, intervals, 12) polynomials: the coefficients
        of x^3 to x^0, each for the three components of the state
    knots, response : the same of the (stages, intervals, terms, 12) responses
    states : (M, 3), written
    slopes : (M, 3, 2), derivatives of the state to the contact's own rate, all others held,
        and of its stage's anchor, written
    records : (M, 7), the inputs of each contact, written
    doubts : (M, 4), what the estimated error is made of, written: one; the norm of all inputs
        after the strike and of those at all other contacts up to here; and, of these, of the
        products of their size and of the growth's second degree
    """
    contacts = len(rates)
    value, slope = np.zeros(STATES), np.zeros(STATES)
    terms = np.empty(TERMS)
    start, others, third = 0.0, 0.0, 0.0
    node, interval = 0, 0
    lost = contacts
    for k in range(contacts):
        stage = stage_of(k, contacts)
        if k == START:
            # What happens within is measured from the anchor within; other stages have their own.
            anchor(rates[k - 1], anchors[WITHIN], nodes, node, value, slope)
            slopes[k - 1, :, 1] = slope
        x = records[k]
        for i in range(STATES):
            x[i] = states[k - 1, i] - value[i] if k > 0 else 0.0
        gather(k, stage, rates, x)
        node = anchor(rates[k], anchors[stage], nodes, node, value, slope)
        states[k], slopes[k, :, 0], slopes[k, :, 1] = value, slope, slope
        interval, distance = interval_of(rates[k], knots, interval)
        all_terms(x, terms)
        inside = knots[0] <= rates[k] <= knots[-1]
        pieces = response[stage, interval]
        respond(terms, pieces, distance, inside, states[k], slopes[k, :, 0])
        square = 0.0
        for i in range(INPUTS):
            square += x[i] * x[i]
        if k < START:
            start += square
        else:
            others += square
            third += square * second_degree(terms, pieces, distance) ** 2
        doubts[k, 0], doubts[k, 1] = 1.0, np.sqrt(start)
        doubts[k, 2], doubts[k, 3] = np.sqrt(others), np.sqrt(third)
        away = False
        for i in range(STATES):
            if not abs(states[k, i] - value[i]) < FARTHEST:
                away = True
        if away:
            states[k] = value
            lost = min(lost, k)
    return lost


@compiled
def pull_back(x, distance, pieces, weight, weights, pulled, to_x):
    """Derivatives of the weighted state to the inputs; ``weights`` and ``pulled`` are scratch."""
    power = 1.0
    for row in range(3, -1, -1):
        for i in range(STATES):
            weights[row * STATES + i] = weight[i] * power
        power *= distance
    for term in range(TERMS):
        total = 0.0
        for i in range(POWERS):
            total += weights[i] * pieces[term, i]
        pulled[term] = total
    to_x[:] = pulled[:INPUTS]
    term = INPUTS
    for i in range(INPUTS):
        for j in range(i, INPUTS):
            to_x[i] += pulled[term] * x[j]
            to_x[j] += pulled[term] * x[i]
            term += 1


@compiled
def backward(rates, knots, response, slopes, records, seeds, to_rates):
    """Derivatives of a number to all rates, given those to the states.

    Parameters
    ----------
    rates, knots, response : as for `forward`
    slopes, records : what `forward` wrote
    seeds : (M, 3) derivatives to the states; overwritten
    to_rates : (M,) derivatives to the rates are added to it
    """
    contacts = len(rates)
    to_x, weights, pulled = np.zeros(INPUTS), np.empty(POWERS), np.empty(TERMS)
    interval = 0
    for k in range(contacts - 1, -1, -1):
        stage = stage_of(k, contacts)
        interval, distance = interval_of(rates[k], knots, interval)
        pieces = response[stage, interval]
        pull_back(records[k], distance, pieces, seeds[k], weights, pulled, to_x)
        for i in range(STATES):
            to_rates[k] += seeds[k, i] * slopes[k, i, 0]
            if k > 0:
                seeds[k - 1, i] += to_x[i]
                to_rates[k - 1] -= to_x[i] * slopes[k - 1, i, 1]
        ahead = 2 if stage <= WITHIN else 0
        for i in range(INPUTS - STATES):
            last = k - 1 + i
            if last >= 1 and last <= k + ahead:
                to_rates[last] += to_x[STATES + i]
                to_rates[last - 1] -= to_x[STATES + i]
