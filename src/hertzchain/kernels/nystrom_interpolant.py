"""Interpolant of the steps of `hertzchain.kernels.nystrom`.

Position, velocity, acceleration and jerk at both ends determine a polynomial of degree 7 for each
position; velocities are its derivative.  The rates of the accumulators follow from the interpolated
motion.  The coefficients are those of `hertzchain.kernels.interpolant`.
"""

from __future__ import annotations

import numpy as np

from .compilation import CONTRACTED, compiled, internal
from .contact_law import HERTZ, force, law_of
from .driving import MOVING_WALL, NOTHING, PUSH, drive_at
from .forces import DRIVEN, LEFT_IMPULSE, PUSHED, RIGHT_IMPULSE, overlap_and_closing
from .interpolant import COEFFICIENTS, value

contracted = internal(**CONTRACTED)

# Nodes at which the rates of accumulators are interpolated.
RATE_NODES = np.linspace(0.0, 1.0, 6)


def _from_rates():
    """Matrix (7, 1 + nodes) from a change and the rates at the nodes to coefficients."""
    rows = np.zeros((1 + len(RATE_NODES), COEFFICIENTS))
    for i in range(COEFFICIENTS):
        one = np.polynomial.Polynomial([1.0])
        for factor in range(i, -1, -1):
            one *= np.polynomial.Polynomial([1.0, -1.0] if factor % 2 else [0.0, 1.0])
        rows[0, i] = one(1.0) - one(0.0)
        rows[1:, i] = one.deriv()(RATE_NODES)
    return np.linalg.inv(rows)


FROM_RATES = _from_rates()


@compiled
def hertz_rates(x, v, h, setup, wall, rates):
    """Changes in a time h of the forces of Hertz contacts, walls included."""
    stiffness, gap, beads = setup.stiffness, setup.gap, len(x)
    for c in range(1, beads):
        overlap = x[c - 1] - x[c] - gap[c]
        overlap = overlap if overlap > 0.0 else 0.0
        rates[c] = HERTZ * stiffness[c] * np.sqrt(overlap) * (h * (v[c - 1] - v[c]))
    first, last = max(wall[0] - x[0] - gap[0], 0.0), max(x[beads - 1] - gap[beads], 0.0)
    rates[0] = HERTZ * stiffness[0] * np.sqrt(first) * (h * (wall[1] - v[0]))
    rates[beads] = HERTZ * stiffness[beads] * np.sqrt(last) * (h * v[beads - 1])


@compiled
def plain_rates(x, v, h, stiffness, exponent, rates):
    """Changes in a time h of the forces of a default chain."""
    if exponent == HERTZ:
        for c in range(len(stiffness)):
            overlap = x[c] - x[c + 1]
            overlap = overlap if overlap > 0.0 else 0.0
            rates[c] = HERTZ * stiffness[c] * np.sqrt(overlap) * (h * (v[c] - v[c + 1]))
        return
    for c in range(len(stiffness)):
        rates[c] = change_of_force(x[c] - x[c + 1], h * (v[c] - v[c + 1]), stiffness[c], exponent)


@compiled
def change_of_force(overlap, approach, stiffness, exponent):
    """Change of the force of an elastic contact whose overlap increases by ``approach``."""
    if overlap <= 0.0:
        return 0.0
    return exponent * force(overlap, stiffness, exponent) / overlap * approach


@compiled
def find_jerks(time, y, h, setup, contacts, segment, jerks):
    """Rates of change of the accelerations in the state ``y``, times h.

    Without the factor h, rates may underflow and powers of h overflow.  ``jerks`` has one entry per
    bead, followed by scratch.
    """
    beads, inverse_mass = len(setup.inverse_mass), setup.inverse_mass
    x, v = y[:beads], y[beads : 2 * beads]
    if contacts is None:
        rates = jerks[beads:]
        plain_rates(x, v, h, setup.stiffness, setup.exponent, rates)
        jerks[0] = -rates[0] * inverse_mass[0]
        for k in range(1, beads - 1):
            jerks[k] = (rates[k - 1] - rates[k]) * inverse_mass[k]
        jerks[beads - 1] = rates[beads - 2] * inverse_mass[beads - 1]
        return
    rates = jerks[beads : 2 * beads + 1]
    drive = drive_at(time, setup, segment) if setup.drive != NOTHING else (0.0, 0.0, 0.0)
    wall = drive if setup.drive == MOVING_WALL else (0.0, 0.0, 0.0)
    if setup.law.shared and setup.law.exponent == HERTZ:
        hertz_rates(x, v, h, setup, wall, rates)
    else:
        for c in range(beads + 1):
            overlap, closing = overlap_and_closing(c, y, beads, setup.gap[c], wall)
            rates[c] = change_of_force(
                overlap, h * closing, setup.stiffness[c], law_of(c, setup).exponent
            )
    for k in range(beads):
        jerks[k] = (rates[k] - rates[k + 1]) * inverse_mass[k]
    if setup.drive == PUSH:
        jerks[0] += h * drive[1] * inverse_mass[0]


# Each of the following loops computes one row, so that the compiler can vectorise it.


@contracted
def position_coefficients(h, y, y_new, first, last, start, end, mean, dense):
    """Coefficients of the positions."""
    # The change of a position in the step is h v + h^2 mean.  A difference of positions would
    # suffer from cancellation.
    beads = len(mean)
    v, v_new = y[beads : 2 * beads], y_new[beads : 2 * beads]
    c0, c1, c2, c3 = dense[0, :beads], dense[1, :beads], dense[2, :beads], dense[3, :beads]
    c4, c5, c6 = dense[4, :beads], dense[5, :beads], dense[6, :beads]
    for k in range(beads):
        c1[k] = -(h * (h * mean[k]))
    for k in range(beads):
        c2[k] = h * v[k] - 2.0 * c1[k] - h * v_new[k]
    for k in range(beads):
        c3[k] = 0.5 * (h * (h * first[k])) + c1[k] - c2[k]
    for k in range(beads):
        c4[k] = 0.5 * (h * (h * last[k])) + c1[k] + 2.0 * c2[k] - c3[k]
    for k in range(beads):
        c5[k] = h * (h * start[k]) / 6.0 + c2[k] + 2.0 * c3[k] - c4[k]
    for k in range(beads):
        c6[k] = -(h * (h * end[k])) / 6.0 - c2[k] + 2.0 * c3[k] + 3.0 * c4[k] - c5[k]
    # At the end of the step the interpolant is the state, except for rounding.
    for k in range(beads):
        c0[k] = y_new[k] - y[k]


@contracted
def velocity_coefficients(h, y, y_new, first, last, start, end, mean, dense):
    """Coefficients of the velocities, the derivative of the polynomials of the positions."""
    beads = len(mean)
    v, v_new = y[beads : 2 * beads], y_new[beads : 2 * beads]
    stop = 2 * beads
    c0, c1 = dense[0, beads:stop], dense[1, beads:stop]
    c2, c3 = dense[2, beads:stop], dense[3, beads:stop]
    c4, c5, c6 = dense[4, beads:stop], dense[5, beads:stop], dense[6, beads:stop]
    for k in range(beads):
        c0[k] = v_new[k] - v[k]
    for k in range(beads):
        c1[k] = h * first[k] - c0[k]
    for k in range(beads):
        c2[k] = c0[k] - c1[k] - h * last[k]
    for k in range(beads):
        c3[k] = 0.5 * (h * start[k]) + c1[k] - c2[k]
    for k in range(beads):
        c4[k] = 0.5 * (h * end[k]) + c1[k] + 2.0 * c2[k] - c3[k]
    # The integral over the step is the change of the position.
    for k in range(beads):
        c5[k] = h * mean[k] - 0.5 * c0[k] - c1[k] / 6.0 - c2[k] / 12.0
    for k in range(beads):
        c5[k] = 140.0 * (c5[k] - c3[k] / 30.0 - c4[k] / 60.0)
        c6[k] = 0.0


@compiled
def rates_within(theta, time, h, y, setup, segment, dense):
    """Rates of the accumulators, from the interpolated motion.

    They are the power of the drive, its force, and the forces of both walls; nothing is lost.
    """
    beads, at = len(setup.inverse_mass), time + theta * h
    drive = drive_at(at, setup, segment) if setup.drive != NOTHING else (0.0, 0.0, 0.0)
    wall = drive if setup.drive == MOVING_WALL else (0.0, 0.0, 0.0)
    first = wall[0] - value(0, theta, y, dense) - setup.gap[0]
    last = value(beads - 1, theta, y, dense) - setup.gap[beads]
    left = force(first, setup.stiffness[0], law_of(0, setup).exponent)
    right = force(last, setup.stiffness[beads], law_of(beads, setup).exponent)
    if setup.drive == PUSH:
        return drive[0] * value(beads, theta, y, dense), drive[0], left, right
    return left * wall[1], 0.0, left, right


@compiled
def accumulator_coefficients(time, h, y, y_new, setup, segment, dense):
    """Coefficients of the accumulators, from their changes and their rates at the nodes."""
    offset = 2 * len(setup.inverse_mass)
    dense[:, offset : len(y)] = 0.0
    for row in range(COEFFICIENTS):
        for i in range(offset, len(y)):
            dense[row, i] = FROM_RATES[row, 0] * (y_new[i] - y[i])
    for node in range(len(RATE_NODES)):
        power, push, left, right = rates_within(RATE_NODES[node], time, h, y, setup, segment, dense)
        for row in range(COEFFICIENTS):
            weight = h * FROM_RATES[row, 1 + node]
            dense[row, offset + DRIVEN] += weight * power
            dense[row, offset + PUSHED] += weight * push
            dense[row, offset + LEFT_IMPULSE] += weight * left
            dense[row, offset + RIGHT_IMPULSE] += weight * right


@compiled
def find_coefficients(
    time, y, h, y_new, first, last, mean, setup, contacts, segment, dense, start, end
):
    """Coefficients of the interpolant of all components; ``start`` and ``end`` are scratch.

    ``first`` and ``last`` are the accelerations at both ends; ``mean`` is the weighted mean of the
    accelerations at the stages that determines the positions at the end.
    """
    beads = len(setup.inverse_mass)
    find_jerks(time, y, h, setup, contacts, segment, start)
    find_jerks(time + h, y_new, h, setup, contacts, segment, end)
    position_coefficients(h, y, y_new, first, last, start[:beads], end[:beads], mean, dense)
    velocity_coefficients(h, y, y_new, first, last, start[:beads], end[:beads], mean, dense)
    if contacts is not None:
        accumulator_coefficients(time, h, y, y_new, setup, segment, dense)
