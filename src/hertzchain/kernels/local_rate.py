r"""The local-rate law along a chain, and its derivatives by backward differentiation.

The state of contact k follows from that of the contact before
(`hertzchain.theory.universal_functions`):

.. math::

    \zeta_k = z^*_k(q_k) + \sum_i L_i(q_k)\,y_i + \sum_{i\le j} M_{ij}(q_k)\,y_i y_j, \qquad
    y = \left(\zeta_{k-1} - z^*_{k-1}(q_{k-1}),\; q_{k-1} - q_{k-2},\; q_k - q_{k-1},\;
                 q_{k+1} - q_k,\; q_{k+2} - q_{k+1}\right)

:math:`z^*`, L and M are piecewise cubic polynomials of the slow rate q, one set for each stage: the
first four contacts, and those within the chain.  `hertzchain.kernels.fast_changes` adds the
response to fast changes.  The backward pass evaluates the coefficients again, already added
up with the derivatives with respect to the three components, which is faster than storing them.
"""

from __future__ import annotations

import numpy as np

from .error_terms import RECURSIVE, SETTLED, slow_weight, start_size, start_weight
from .fast_changes import (
    STATES,
    combine,
    compiled,
    dot,
    entry_point,
    interval_of,
    three_sums,
)

# Contacts with separate functions after the impact.
START = 4
WITHIN = START
# Inputs, and terms of first and second order; padded, so that loops over them use vectors.
INPUTS = 7
TERMS = INPUTS + INPUTS * (INPUTS + 1) // 2
ROW = TERMS + 1
# Square of a deviation whose orders beyond the second are as large as the third.
LARGE_STATE = 0.05
# Largest distance from the state of an exponential chain; beyond it, the law has diverged.
FARTHEST = 1.0


@compiled
def bca_growth(rate):
    """Growth of velocity by the BCA, ln[2/(1 + e^(3s))], and its derivative, without overflow."""
    if rate > 0.0:
        small = np.exp(-3.0 * rate)
        return np.log(2.0) - 3.0 * rate - np.log1p(small), -3.0 / (1.0 + small)
    small = np.exp(3.0 * rate)
    return np.log(2.0) - np.log1p(small), -3.0 * small / (1.0 + small)


@compiled
def anchor(rate, pieces, ends, guess, value, slope):
    """Write state and derivative on an exponential chain; returns the interval of the rate."""
    interval, x = interval_of(rate, ends, guess)
    for i in range(STATES):
        a, b = pieces[interval, i], pieces[interval, STATES + i]
        c = pieces[interval, 2 * STATES + i]
        value[i] = ((a * x + b) * x + c) * x + pieces[interval, 3 * STATES + i]
        slope[i] = (3.0 * a * x + 2.0 * b) * x + c
    if not ends[0] <= rate <= ends[-1]:
        # Outside the tables, the trend is that of the BCA.
        growth, growth_slope = bca_growth(rate)
        value[0] += growth - bca_growth(ends[interval] + x)[0]
        slope[0], slope[1], slope[2] = growth_slope, 0.0, 0.0
    return interval


@compiled
def gather(contact, rates, deviations, inputs):
    """Write the inputs of a contact."""
    for i in range(STATES):
        inputs[i] = deviations[contact - 1, i] if contact > 0 else 0.0
    for i in range(INPUTS - STATES):
        last = contact - 1 + i
        known = 1 <= last < len(rates)
        inputs[STATES + i] = rates[last] - rates[last - 1] if known else 0.0


@compiled
def write_terms(inputs, terms):
    """Write the inputs and all products of two of them."""
    n = INPUTS
    for i in range(INPUTS):
        terms[i] = inputs[i]
        for j in range(i, INPUTS):
            terms[n] = inputs[i] * inputs[j]
            n += 1


@compiled
def second_degree(pieces, x, terms):
    """Size of the contribution of products of two inputs to the growth."""
    size = 0.0
    for n in range(INPUTS, TERMS):
        value = ((pieces[0, n] * x + pieces[1, n]) * x + pieces[2, n]) * x + pieces[3, n]
        size += abs(value * terms[n])
    return size


@compiled
def parts_of(work):
    """Arrays for terms, their coefficients, inputs, anchors and their derivatives."""
    first = ROW + STATES * ROW
    second = first + INPUTS
    return (
        work[:ROW], work[ROW:first], work[first:second], work[second : second + STATES],
        work[second + STATES : second + 2 * STATES],
    )  # fmt: skip


# Numbers that `forward` and `backward` need for a contact.
WORK = (1 + STATES) * ROW + INPUTS + 2 * STATES


# Arguments of `forward`:
# rates: slow rates, up to two contacts ahead of the last one that is followed
# nodes, anchors: ends of intervals, and polynomials (stages, intervals, 12), which are
#   coefficients of x^3 to x^0, each for the three components of the state
# knots, response: the same for the terms of the response, (stages, intervals, 4, 108): powers,
#   three components, 35 terms and a zero
# work: (WORK,), is overwritten
# Results:
# states: (followed, 3)
# deviations: (followed, 3), of the states from the anchors that the next contact refers to
# slopes: (followed, 3, 2): derivatives of the anchor of the contact, and of that reference
# doubts: (followed, 4), terms of the estimated error: norms of the differences of the rates at
#   the first contacts, of the deviations that the impact left, of all inputs at the other contacts
#   up to this one, and of the products of their size and of the second degree of the growth
@entry_point
def forward(
    rates, followed, nodes, anchors, knots, response, work, states, deviations, slopes, doubts
):  # fmt: skip
    """Compute states of contacts; returns the first in doubt, or else ``followed``."""
    terms, _, inputs, value, slope = parts_of(work)
    terms[TERMS] = 0.0
    start, impact, others, third = 0.0, 0.0, 0.0, 0.0
    node, interval = 0, 0
    lost = followed
    for k in range(followed):
        stage = min(k, WITHIN)
        if k == START:
            # Deviations are measured from the anchor of the inner stage; other stages differ.
            anchor(rates[k - 1], anchors[WITHIN], nodes, node, value, slope)
            for i in range(STATES):
                deviations[k - 1, i] = states[k - 1, i] - value[i]
                slopes[k - 1, i, 1] = slope[i]
        gather(k, rates, deviations, inputs)
        write_terms(inputs, terms)
        node = anchor(rates[k], anchors[stage], nodes, node, value, slope)
        interval, distance = interval_of(rates[k], knots, interval)
        pieces, away = response[stage, interval], False
        changes = three_sums(pieces, distance, terms)
        for i in range(STATES):
            states[k, i], deviations[k, i] = value[i] + changes[i], changes[i]
            slopes[k, i, 0] = slopes[k, i, 1] = slope[i]
            if not abs(changes[i]) < FARTHEST:
                away = True
        of_state, of_rates = 0.0, 0.0
        for i in range(STATES):
            of_state += inputs[i] * inputs[i]
        for i in range(STATES, INPUTS):
            of_rates += inputs[i] * inputs[i]
        if k < RECURSIVE:
            # The state after the impact is known, and only changes of the rate are in doubt.
            start += start_size(k, rates[k], of_rates)
        else:
            weight = slow_weight(rates[k]) ** 2
            large = (of_state / LARGE_STATE) ** 2
            products = (1.0 + large) * second_degree(pieces, distance, terms) ** 2
            third += (of_state + of_rates) * products
            others += of_rates * weight
            if k < SETTLED:
                impact += of_state * weight
            else:
                others += of_state * weight
        doubts[k, 0] = np.sqrt(start) * start_weight(k)
        doubts[k, 1], doubts[k, 2], doubts[k, 3] = np.sqrt(impact), np.sqrt(others), np.sqrt(third)
        if away:
            for i in range(STATES):
                states[k, i], deviations[k, i] = value[i], 0.0
            # The state before, from which this one followed, has begun to diverge.
            lost = min(lost, max(k - 1, 0))
    return lost


# Arguments: as for `forward`, and
# seeds: derivatives with respect to the states, (followed, 3), which are overwritten
# to_rates: results are added
@entry_point
def backward(rates, knots, response, deviations, slopes, seeds, work, to_rates):
    """Add derivatives with respect to the slow rates."""
    terms, of_terms, inputs, _, _ = parts_of(work)
    weights, weight_slopes = of_terms[:ROW], of_terms[ROW : 2 * ROW]
    to_input = of_terms[2 * ROW : 2 * ROW + INPUTS]
    terms[TERMS] = 0.0
    interval = 0
    for k in range(len(seeds) - 1, -1, -1):
        gather(k, rates, deviations, inputs)
        write_terms(inputs, terms)
        interval, distance = interval_of(rates[k], knots, interval)
        inside = knots[0] <= rates[k] <= knots[-1]
        pieces = response[min(k, WITHIN), interval]
        combine(pieces, seeds[k], distance, inside, weights, weight_slopes)
        to_rates[k] += dot(weight_slopes, terms)
        for i in range(STATES):
            to_rates[k] += seeds[k, i] * slopes[k, i, 0]
        for i in range(INPUTS):
            to_input[i] = weights[i]
        n = INPUTS
        for i in range(INPUTS):
            for j in range(i, INPUTS):
                to_input[i] += weights[n] * inputs[j]
                to_input[j] += weights[n] * inputs[i]
                n += 1
        if k > 0:
            for i in range(STATES):
                seeds[k - 1, i] += to_input[i]
                to_rates[k - 1] -= to_input[i] * slopes[k - 1, i, 1]
        for i in range(INPUTS - STATES):
            last = k - 1 + i
            if 1 <= last < len(to_rates):
                to_rates[last] += to_input[STATES + i]
                to_rates[last - 1] -= to_input[STATES + i]
