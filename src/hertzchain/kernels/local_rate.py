r"""The local-rate law along a chain, and its derivatives by backward differentiation.

The state of contact k follows from that of the contact before
(`hertzchain.theory.universal_functions`):

.. math::

    z_k = z^*(s_k) + y^T A(s_k)\,y, \qquad
    y = \left(1,\; z_{k-1} - z^*(s_{k-1}),\; s_{k-1} - s_{k-2},\; s_k - s_{k-1},\;
                 s_{k+1} - s_k,\; s_{k+2} - s_{k+1}\right)

with a symmetric matrix A for each of the three components of z.  :math:`z^*` and A are piecewise
cubic polynomials of the rate, one set for each stage: the first four contacts, those within the
chain.  The rates are slow; `hertzchain.kernels.fast_changes` adds the response to fast
changes.  Almost all work is the product A y, from which everything follows::

    A(s) y  --->  z  = z* + y.(A y)      forward
            --->  dz/dy = 2 A y          stored for the backward pass
            --->  dz/ds = y.(A'(s) y)    from the same coefficients

so that the derivatives of a number with respect to all rates take little more time than the law.
"""

from __future__ import annotations

import numpy as np

from .fast_changes import START, STATES, WITHIN, compiled, interval_of, polynomials

# Inputs including the constant one, padded to the eight numbers of a vector register.
INPUTS = 7
FORM = 1 + INPUTS
# Length of a row of all three matrices side by side, and of all rows.
ROW = STATES * FORM
MATRIX = FORM * ROW
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
    # Outside the tables, the trend is that of the BCA.
    interval, x = interval_of(rate, ends, guess)
    inside = ends[0] <= rate <= ends[-1]
    powers = pieces[interval]
    for i in range(STATES):
        a, b, c = powers[i], powers[STATES + i], powers[2 * STATES + i]
        value[i] = ((a * x + b) * x + c) * x + powers[3 * STATES + i]
        slope[i] = (3.0 * a * x + 2.0 * b) * x + c if inside else 0.0
    growth, growth_slope = bca_growth(rate)
    value[0] += growth
    slope[0] += growth_slope
    return interval


@compiled
def gather(contact, rates, y):
    """Write the inputs of a contact that are differences of the rates around it."""
    for i in range(INPUTS - STATES):
        last = contact - 1 + i
        known = 1 <= last < len(rates)
        y[1 + STATES + i] = rates[last] - rates[last - 1] if known else 0.0


@compiled
def differentiate(pieces, x, derivative):
    """Evaluate the derivative of the matrix A with respect to the rate."""
    for i in range(MATRIX):
        a, b, c = pieces[0, i], pieces[1, i], pieces[2, i]
        derivative[i] = (3.0 * a * x + 2.0 * b) * x + c


@compiled
def product(matrix, y, found):
    """Evaluate A y for all three components."""
    y0, y1, y2, y3, y4, y5, y6, y7 = y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7]
    # Unrolled, so that the compiler vectorises it.
    for i in range(ROW):
        found[i] = (
            (y0 * matrix[i] + y1 * matrix[ROW + i])
            + (y2 * matrix[2 * ROW + i] + y3 * matrix[3 * ROW + i])
            + (y4 * matrix[4 * ROW + i] + y5 * matrix[5 * ROW + i])
            + (y6 * matrix[6 * ROW + i] + y7 * matrix[7 * ROW + i])
        )


@compiled
def times(y, found, i):
    """Component i of y.(A y)."""
    total = 0.0
    for j in range(FORM):
        total += y[j] * found[i * FORM + j]
    return total


@compiled
def second_degree(matrix, y):
    """Size of the contribution of products of two inputs to the growth."""
    y1, y2, y3, y4 = abs(y[1]), abs(y[2]), abs(y[3]), abs(y[4])
    y5, y6, y7 = abs(y[5]), abs(y[6]), abs(y[7])
    size = 0.0
    for j in range(1, FORM):
        size += abs(y[j]) * (
            (y1 * abs(matrix[ROW + j]) + y2 * abs(matrix[2 * ROW + j]))
            + (y3 * abs(matrix[3 * ROW + j]) + y4 * abs(matrix[4 * ROW + j]))
            + (y5 * abs(matrix[5 * ROW + j]) + y6 * abs(matrix[6 * ROW + j]))
            + y7 * abs(matrix[7 * ROW + j])
        )
    return size


# Arguments of `forward`:
# rates: slow rates, up to two contacts ahead of the last one that is followed
# nodes, anchors: ends of intervals, and polynomials (stages, intervals, 12), which are
#   coefficients of x^3 to x^0, each for the three components of the state
# knots, response: the same for the matrices A, (stages, intervals, 4, 192): powers, eight rows,
#   three components, eight columns
# Results:
# states: (followed, 3)
# slopes: (followed, 3, 2), or empty if not needed: derivatives of the state with respect to the
#   rate of the contact, and of the anchor of its stage
# to_inputs: (followed, 3, 8), derivatives of the state with respect to y
# doubts: (followed, 4), terms of the estimated error: one; norms of all inputs after the
#   impact, of those at all other contacts up to this one, and of the products of their size and
#   of the second degree of the growth
@compiled
def forward(
    rates, followed, nodes, anchors, knots, response, states, slopes, to_inputs, doubts
):  # fmt: skip
    """Compute states of contacts; returns the first that diverges, or else ``followed``."""
    value, slope = np.zeros(STATES), np.zeros(STATES)
    y, matrix, derivative = np.ones(FORM), np.empty(MATRIX), np.empty(MATRIX)
    by_input, by_input_slope = np.empty(ROW), np.empty(ROW)
    start, others, third = 0.0, 0.0, 0.0
    node, interval = 0, 0
    lost, differentiated = followed, len(slopes) > 0
    for k in range(followed):
        stage = min(k, WITHIN)
        if k == START:
            # Deviations are measured from the anchor of the inner stage; other stages differ.
            anchor(rates[k - 1], anchors[WITHIN], nodes, node, value, slope)
            if differentiated:
                slopes[k - 1, :, 1] = slope
        for i in range(STATES):
            y[1 + i] = states[k - 1, i] - value[i] if k > 0 else 0.0
        gather(k, rates, y)
        node = anchor(rates[k], anchors[stage], nodes, node, value, slope)
        interval, distance = interval_of(rates[k], knots, interval)
        inside = knots[0] <= rates[k] <= knots[-1]
        pieces = response[stage, interval]
        polynomials(pieces, distance, matrix)
        product(matrix, y, by_input)
        for i in range(STATES):
            states[k, i] = value[i] + times(y, by_input, i)
        if differentiated:
            differentiate(pieces, distance, derivative)
            product(derivative, y, by_input_slope)
            for i in range(STATES):
                slopes[k, i, 0] = slopes[k, i, 1] = slope[i]
                if inside:
                    slopes[k, i, 0] += times(y, by_input_slope, i)
                for j in range(FORM):
                    to_inputs[k, i, j] = 2.0 * by_input[i * FORM + j]
        square = 0.0
        for i in range(1, FORM):
            square += y[i] * y[i]
        if k < START:
            start += square
        else:
            others += square
            third += square * second_degree(matrix, y) ** 2
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
def backward(slopes, to_inputs, seeds, to_rates):
    """Add derivatives with respect to the rates to ``to_rates``; ``seeds`` are those to states."""
    # slopes, to_inputs: results of `forward`.  seeds is overwritten.
    to_y = np.empty(FORM)
    for k in range(len(seeds) - 1, -1, -1):
        for j in range(FORM):
            to_y[j] = 0.0
            for i in range(STATES):
                to_y[j] += seeds[k, i] * to_inputs[k, i, j]
        for i in range(STATES):
            to_rates[k] += seeds[k, i] * slopes[k, i, 0]
            if k > 0:
                seeds[k - 1, i] += to_y[1 + i]
                to_rates[k - 1] -= to_y[1 + i] * slopes[k - 1, i, 1]
        for i in range(INPUTS - STATES):
            last = k - 1 + i
            if 1 <= last < len(to_rates):
                to_rates[last] += to_y[1 + STATES + i]
                to_rates[last - 1] -= to_y[1 + STATES + i]
