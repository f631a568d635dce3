"""Pulses by the local-rate law, and derivatives of their quantities."""

from __future__ import annotations

import numpy as np

from .alternation import WORK as ALTERNATION_WORK
from .alternation import add_alternation, from_alternation
from .error_terms import PARTS, SLOW_PARTS, write_parts
from .fast_changes import (
    AHEAD,
    BEHIND,
    STATES,
    WORK,
    add_response,
    allocating,
    compiled,
    entry_point,
    from_response,
    from_smooth,
    smooth,
    write_steps,
)
from .last_contacts import first_of, from_last, write_last
from .law_tables import FastTables, SlowTables
from .local_rate import WORK as SLOW_WORK
from .local_rate import backward, forward

LONGEST_WORK = max(WORK, SLOW_WORK, ALTERNATION_WORK)
# Largest estimated error of a logarithm, so that its exponential is finite.
LARGEST_ERROR = 50.0
# Below this value, e^x - 1 is evaluated as a polynomial.
SMALL_ERROR = 0.02


@allocating
def logarithms(radii):
    """Logarithms of the radii, and the rates of the contacts."""
    logs = np.log(radii)
    return logs, logs[1:] - logs[:-1]


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


@entry_point
def estimated_error(contact, parts, constants, lost):
    """Estimated relative error of the velocity behind a contact."""
    # The parts are errors of its logarithm.  Beyond a state that has diverged, it is unknown.
    error = 1.0 if contact >= lost else 0.0
    for i in range(PARTS):
        error += constants[i] * parts[contact, i]
    if error < SMALL_ERROR:
        return error * (1.0 + error / 2.0 * (1.0 + error / 3.0 * (1.0 + error / 4.0)))
    return np.expm1(min(error, LARGEST_ERROR))


@allocating
def divide(rates, followed):
    """Slow and fast parts of the rates, up to two contacts ahead of the last one followed."""
    known = min(len(rates), followed + AHEAD)
    slow, fast = np.empty(known), np.empty(BEHIND + known + AHEAD)
    smooth(rates, slow, fast)
    return slow, fast


# With reference counting, as its results are those of functions that count references.
@allocating
def tables_of(arrays):
    """Tables from a plain tuple: to read named ones from Python takes three times as long."""
    return SlowTables(*arrays[:4]), FastTables(*arrays[4:])


# rates, slow, fast: of the chain, and results of `divide`
# arrays: of all tables, `hertzchain.theory.universal_functions.UniversalFunctions.arrays`
# states: (followed, 3), result; deviations, slopes: see `forward`
# parts: (followed, 16), result, see `write_parts`
@allocating
def evaluate(rates, slow, fast, arrays, states, deviations, slopes, parts):
    """Compute states of contacts.

    Returns the first that diverges and the first at which products of fast changes are
    meaningless, or else their number, and whether rates alternate.
    """
    (nodes, anchors, knots, response), fast_tables = tables_of(arrays)
    doubts, work = np.empty((len(states), SLOW_PARTS)), np.empty(LONGEST_WORK)
    contacts, regular = len(rates), np.empty((len(states), 2))
    lost = forward(
        slow, len(states), nodes, anchors, knots, response, work, states, deviations, slopes, doubts
    )
    steps = np.empty(len(fast))
    write_steps(slow, steps)
    within = states[: first_of(contacts, fast_tables)]
    sound = add_response(contacts, slow, fast, steps, fast_tables, work, within)
    if sound == len(within):
        sound = len(states)
    write_last(rates, fast_tables, states)
    differences = np.empty(contacts)
    alternating = add_alternation(rates, fast_tables, differences, work, states, regular)
    ending = first_of(contacts, fast_tables)
    write_parts(contacts, ending, slow, fast, doubts, regular, parts)
    return min(lost, sound), sound, alternating


@compiled
def all_sound(by_bead, by_contact):
    """Whether all results are finite and, except those of the struck bead, positive."""
    good = True
    for i in range(len(by_bead)):
        for k in range(1, by_bead.shape[1]):
            good &= 0.0 < by_bead[i, k] < np.inf
    for i in range(len(by_contact)):
        for k in range(by_contact.shape[1]):
            good &= 0.0 < by_contact[i, k] < np.inf
    return good


@allocating
def pulse(radii, arrays, constants, of_time, of_overlap, by_bead, by_contact):
    """Evaluate the law; returns the largest estimated error, and whether all values are sound."""
    # The error is infinite if a rate is outside the tables.
    # arrays: as for `evaluate`; constants: (16,), of the estimated error
    # of_time, of_overlap: powers (a, b, c, d, e) of residence times and overlaps
    # by_bead (3, N): result: velocities, their estimated errors, arrivals
    # by_contact (2, N - 1): result: residence times, overlaps
    logs, rates = logarithms(radii)
    contacts = len(rates)
    slow, fast = divide(rates, contacts)
    states, parts = np.empty((contacts, STATES)), np.empty((contacts, PARTS))
    deviations, slopes = np.empty((contacts, STATES)), np.empty((contacts, STATES, 2))
    lost, _, _ = evaluate(rates, slow, fast, arrays, states, deviations, slopes, parts)
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
        error[k + 1] = estimated_error(k, parts, constants, lost)
        arrival[k + 1] = arrival[k] + residence[k]
    largest = np.inf if any_outside(rates, arrays[0]) else np.max(error)
    return largest, all_sound(by_bead, by_contact)


@allocating
def gradient(radii, arrays, constants, powers, begin, end, followed, found):
    """Sum of a quantity over beads, and its error; writes derivatives of ln(sum) to ``found``."""
    # powers: (a, b, c, d, e) of the quantity; begin, end: the beads, from 0, the last excluded
    # followed: number of contacts on which the quantity depends
    # found: (N,), derivatives with respect to the logarithms of the radii
    slow_tables, fast_tables = tables_of(arrays)
    logs, rates = logarithms(radii)
    slow, fast = divide(rates, followed)
    states, parts = np.empty((followed, STATES)), np.empty((followed, PARTS))
    deviations, slopes = np.empty((followed, STATES)), np.empty((followed, STATES, 2))
    lost, sound, alternating = evaluate(
        rates, slow, fast, arrays, states, deviations, slopes, parts
    )
    weights = np.empty(end - begin)
    log_velocity = states[:begin, 0].sum()
    for k in range(begin, end):
        log_part = log_of_bead(powers, logs[k], log_velocity)
        if k < followed:
            log_part += log_of_contact(powers, log_stiffness(radii, k), states[k])
            log_velocity += states[k, 0]
        weights[k - begin] = np.exp(log_part)
    total = weights.sum()
    seeds, to_rates = np.zeros((followed, STATES)), np.zeros(len(rates))
    seed_states(radii, begin, weights / total, powers, seeds, found)
    to_slow, to_fast = np.zeros(len(slow)), np.zeros(len(fast))
    work, steps, to_steps = np.empty(LONGEST_WORK), np.empty(len(fast)), np.empty(len(fast))
    write_steps(slow, steps)
    if alternating:
        differences, to_differences = np.empty(len(rates)), np.empty(len(rates))
        from_alternation(rates, fast_tables, differences, work, seeds, to_differences, to_rates)
    from_last(rates, fast_tables, seeds, to_rates)
    within = seeds[: first_of(len(rates), fast_tables)]
    from_response(
        len(rates), slow, fast, steps, fast_tables, within, work, sound, to_slow, to_fast, to_steps
    )
    _, _, knots, response = slow_tables
    backward(slow, knots, response, deviations, slopes, seeds, work, to_slow)
    from_smooth(rates, to_slow, to_fast, slow, to_rates)
    found[1:] += to_rates
    found[:-1] -= to_rates
    error = 0.0
    for k in range(followed):
        error = max(error, estimated_error(k, parts, constants, lost))
    return total, np.inf if any_outside(rates[:followed], arrays[0]) else error


@compiled
def seed_states(radii, begin, weights, powers, seeds, found):
    """Derivatives of weighted logarithms of a quantity with respect to states, and radii."""
    followed = len(seeds)
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
