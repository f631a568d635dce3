r"""The local-rate law along a chain, and its derivatives by backward differentiation.

The state of contact k follows from that of the contact before
(`hertzchain.theory.universal_functions`):

.. math::

    z_k = z^*(s_k) + y^T A(s_k)\,y, \qquad
    y = \left(1,\; z_{k-1} - z^*(s_{k-1}),\; s_{k-1} - s_{k-2},\; s_k - s_{k-1},\;
                 s_{k+1} - s_k,\; s_{k+2} - s_{k+1}\right)

with a symmetric matrix A for each of the three components of z.  :math:`z^*` and A are piecewise
cubic polynomials of the rate, one set for each stage: the first four contacts, those within the
chain, the last three.  Almost all work is the product A y, from which everything follows::

    A(s) y  --->  z  = z* + y.(A y)      forward
            --->  dz/dy = 2 A y          stored for the backward pass
            --->  dz/ds = y.(A'(s) y)    from the same coefficients

so that the derivatives of a number with respect to all rates take little more time than the law.
"""

from __future__ import annotations

import numpy as np
from numba import njit

STATES = 3
# Inputs including the constant one, padded to the eight numbers of a vector register.
INPUTS = 7
FORM = 1 + INPUTS
# Length of a row of all three matrices side by side, and of all rows.
ROW = STATES * FORM
MATRIX = FORM * ROW
START, END = 4, 3
WITHIN = START
# Largest distance from the state of an exponential chain; beyond it, the law has diverged.
FARTHEST = 1.0

# Sums may be evaluated in any order, so that the compiler can vectorise them.
compiled = njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract"})


@compiled
def stage_of(contact, contacts):
    """Stage of a contact, counted from 0."""
    if contact < START:
        return contact
    return max(WITHIN, WITHIN + 1 + contact - (contacts - END))


@compiled
def rates_ahead(stage):
    """Number of rates ahead of a contact to which it responds."""
    return 2 if stage <= WITHIN else 0


@compiled
def interval_of(rate, ends, guess):
    """Interval that contains a rate (or the nearest one), and the distance from its left end."""
    # The search begins at the interval of the contact before, whose rate is usually close.
    clipped = min(max(rate, ends[0]), ends[-1])
    interval = guess
    while interval > 0 and clipped < ends[interval]:
        interval -= 1
    while interval < len(ends) - 2 and clipped >= ends[interval + 1]:
        interval += 1
    return interval, clipped - ends[interval]


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
def gather(contact, stage, rates, y):
    """Write the inputs of a contact that are differences of the rates around it."""
    ahead = rates_ahead(stage)
    for i in range(INPUTS - STATES):
        last = contact - 1 + i
        known = last >= 1 and last <= contact + ahead
        y[1 + STATES + i] = rates[last] - rates[last - 1] if known else 0.0


@compiled
def evaluate(pieces, x, matrix, derivative):
    """Evaluate the matrix A and its derivative with respect to the rate."""
    for i in range(MATRIX):
        a, b, c = pieces[0, i], pieces[1, i], pieces[2, i]
        matrix[i] = ((a * x + b) * x + c) * x + pieces[3, i]
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
# rates: (M,), of all contacts
# nodes, anchors: ends of intervals, and polynomials (stages, intervals, 12), which are
#   coefficients of x^3 to x^0, each for the three components of the state
# knots, response: the same for the matrices A, (stages, intervals, 4, 192): powers, eight rows,
#   three components, eight columns
# Results:
# states: (followed, 3)
# slopes: (followed, 3, 2), derivatives of the state with respect to the rate of the contact,
#   and of the anchor of its stage
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
    lost = followed
    for k in range(followed):
        stage = stage_of(k, len(rates))
        if k == START:
            # Deviations are measured from the anchor of the inner stage; other stages differ.
            anchor(rates[k - 1], anchors[WITHIN], nodes, node, value, slope)
            slopes[k - 1, :, 1] = slope
        for i in range(STATES):
            y[1 + i] = states[k - 1, i] - value[i] if k > 0 else 0.0
        gather(k, stage, rates, y)
        node = anchor(rates[k], anchors[stage], nodes, node, value, slope)
        interval, distance = interval_of(rates[k], knots, interval)
        inside = knots[0] <= rates[k] <= knots[-1]
        pieces = response[stage, interval]
        evaluate(pieces, distance, matrix, derivative)
        product(matrix, y, by_input)
        product(derivative, y, by_input_slope)
        for i in range(STATES):
            states[k, i] = value[i] + times(y, by_input, i)
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
def backward(contacts, slopes, to_inputs, seeds, to_rates):
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
        ahead = rates_ahead(stage_of(k, contacts))
        for i in range(INPUTS - STATES):
            last = k - 1 + i
            if last >= 1 and last <= k + ahead:
                to_rates[last] += to_y[1 + STATES + i]
                to_rates[last - 1] -= to_y[1 + STATES + i]


@compiled
def logarithms(radii):
    """Logarithms of the radii, and the rates of the contacts."""
    logs = np.log(radii)
    return logs, logs[1:] - logs[:-1]


@compiled
def estimated_error(contact, doubts, constants, lost):
    """Estimated relative error of the velocity behind a contact."""
    # Beyond a state that has diverged, the error is unknown.
    error = 1.0 if contact >= lost else 0.0
    for i in range(4):
        error += constants[i] * doubts[contact, i]
    return error


@compiled
def any_outside(rates, ends):
    """Whether a rate lies outside the tables."""
    for rate in rates:
        if not ends[0] <= rate <= ends[-1]:
            return True
    return False


@compiled
def log_stiffness(radii, contact):
    """Logarithm of a contact's stiffness, see `hertzchain.collision.hertz_stiffness`."""
    left, right = radii[contact], radii[contact + 1]
    return 0.5 * np.log(2.0 * left * (right / (left + right)))


@compiled
def log_of_bead(powers, log_radius, log_velocity):
    """Logarithm of m^a v^b of a bead, given those of its radius and velocity."""
    return powers[0] * 3.0 * log_radius + powers[1] * log_velocity


@compiled
def log_of_contact(powers, stiffness, state):
    """Logarithm of r^c e^(d phi + e tau) of a contact, given that of its stiffness r."""
    return powers[2] * stiffness + powers[3] * state[1] + powers[4] * state[2]


@compiled
def pulse(
    radii, nodes, anchors, knots, response, constants, of_time, of_overlap, by_bead, by_contact
):
    """Evaluate the law; returns the error at the last bead, infinite if a rate is outside."""
    # nodes, anchors, knots, response: as for `forward`
    # constants: (4,), of the estimated error
    # of_time, of_overlap: powers (a, b, c, d, e) of residence times and overlaps
    # by_bead (3, N): result: velocities, their estimated errors, arrivals
    # by_contact (2, N - 1): result: residence times, overlaps
    logs, rates = logarithms(radii)
    contacts = len(rates)
    states, doubts = np.empty((contacts, STATES)), np.empty((contacts, 4))
    slopes, to_inputs = np.empty((contacts, STATES, 2)), np.empty((contacts, STATES, FORM))
    lost = forward(
        rates, contacts, nodes, anchors, knots, response, states, slopes, to_inputs, doubts
    )
    velocity, error, arrival = by_bead[0], by_bead[1], by_bead[2]
    residence, overlap = by_contact[0], by_contact[1]
    velocity[0], error[0], arrival[0] = 1.0, 0.0, 0.0
    log_velocity = 0.0
    for k in range(contacts):
        stiffness, z = log_stiffness(radii, k), states[k]
        of_bead = log_of_bead(of_time, logs[k], log_velocity)
        residence[k] = np.exp(of_bead + log_of_contact(of_time, stiffness, z))
        of_bead = log_of_bead(of_overlap, logs[k], log_velocity)
        overlap[k] = np.exp(of_bead + log_of_contact(of_overlap, stiffness, z))
        log_velocity += states[k, 0]
        velocity[k + 1] = np.exp(log_velocity)
        error[k + 1] = estimated_error(k, doubts, constants, lost)
        arrival[k + 1] = arrival[k] + residence[k]
    return np.inf if any_outside(rates, nodes) else error[-1]


@compiled
def gradient(
    radii, nodes, anchors, knots, response, constants, powers, begin, end, followed, found
):
    """Sum of a quantity over beads, and its error; writes derivatives of ln(sum) to ``found``."""
    # powers: (a, b, c, d, e) of the quantity; begin, end: the beads, from 0, the last excluded
    # followed: number of contacts on which the quantity depends
    # found: (N,), derivatives with respect to the logarithms of the radii
    logs, rates = logarithms(radii)
    states, doubts = np.empty((followed, STATES)), np.empty((followed, 4))
    slopes, to_inputs = np.empty((followed, STATES, 2)), np.empty((followed, STATES, FORM))
    lost = forward(
        rates, followed, nodes, anchors, knots, response, states, slopes, to_inputs, doubts
    )
    parts = np.empty(end - begin)
    log_velocity = states[:begin, 0].sum()
    for k in range(begin, end):
        log_part = log_of_bead(powers, logs[k], log_velocity)
        if k < followed:
            log_part += log_of_contact(powers, log_stiffness(radii, k), states[k])
            log_velocity += states[k, 0]
        parts[k - begin] = np.exp(log_part)
    total = parts.sum()
    pull_back(rates, begin, parts / total, radii, powers, slopes, to_inputs, found)
    error = estimated_error(followed - 1, doubts, constants, lost) if followed > 0 else 0.0
    return total, np.inf if any_outside(rates[:followed], nodes) else error


@compiled
def pull_back(rates, begin, weights, radii, powers, slopes, to_inputs, found):
    """Derivatives of weighted logarithms of a quantity with respect to all log radii."""
    followed = len(slopes)
    seeds, to_rates = np.zeros((followed, STATES)), np.zeros(len(rates))
    found[:] = 0.0
    to_velocity = 0.0
    for k in range(begin + len(weights) - 1, -1, -1):
        # A velocity is the product of the growth at all contacts before.
        if k < followed:
            seeds[k, 0] = to_velocity
        if k < begin:
            continue
        weight = weights[k - begin]
        to_velocity += weight * powers[1]
        found[k] += weight * powers[0] * 3.0
        if k < followed:
            seeds[k, 1], seeds[k, 2] = weight * powers[3], weight * powers[4]
            half = 0.5 * weight * powers[2] / (radii[k] + radii[k + 1])
            found[k] += half * radii[k + 1]
            found[k + 1] += half * radii[k]
    backward(len(rates), slopes, to_inputs, seeds, to_rates)
    found[1:] += to_rates
    found[:-1] -= to_rates
