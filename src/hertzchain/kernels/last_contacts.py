r"""Second order of the response of the last four contacts to changes of the rate.

Near the free end, the response depends on the history of the rate more strongly than within the
chain.  To the states of the last four contacts, this module adds

.. math::

    \frac{1}{1 + (\eta_3^2 + \eta_4^2 + \dots + \eta_{11}^2)/\eta_0^2}
        \sum_{i\le j} B_{ij}(\bar q_k)\,\eta_i \eta_j, \qquad
    \bar q_k = \frac{\sum_o \mu^o q_{k-o}}{\sum_o \mu^o}

with three memories of the changes of the slow rate q,

.. math:: \eta_i = \sum_{o\ge0} \lambda_i^o\,(q_{k-o} - q_{k-o-1}) ,

of which the first is the last change, with the changes of q at the next two contacts, and the fast
changes e at the contacts k, k - 1, k - 2, k - 3, k + 1 and k + 2.  Beyond the last contact, changes
are zero.  The denominator keeps the term bounded for large changes.
"""

from __future__ import annotations

import numpy as np

from .fast_changes import (
    AHEAD,
    BEHIND,
    STATES,
    allocating,
    combine,
    compiled,
    dot,
    entry_point,
    interval_of,
    polynomials,
)

# Number of these contacts.
LAST = 4
# Factors by which memories decay per contact, and that of the mean.
MEMORIES = (0.0, 0.6, 0.85)
MEAN = 0.75
# Offsets of the fast changes, and numbers of memories, and of these and all changes.
OFFSETS = (0, -1, -2, -3, 1, 2)
SLOW, COUNT = len(MEMORIES), len(MEMORIES) + AHEAD + len(OFFSETS)
PRODUCTS = COUNT * (COUNT + 1) // 2
# Sum of squares of the slowest memory and the other changes beyond which the term grows no more.
LARGE = 0.1**2


@compiled
def advance(contact, slow, memories, total, weight):
    """Update the memories, and the sums of the mean rate, at the next contact."""
    change = slow[contact] - slow[contact - 1] if contact > 0 else 0.0
    for i in range(SLOW):
        memories[i] = MEMORIES[i] * memories[i] + change
    return MEAN * total + slow[contact], MEAN * weight + 1.0


@compiled
def add_changes(contact, slow, fast, memories):
    """Write the changes at and near a contact behind its memories."""
    for o in range(1, AHEAD + 1):
        known = contact + o < len(slow)
        memories[SLOW + o - 1] = slow[contact + o] - slow[contact + o - 1] if known else 0.0
    for i in range(len(OFFSETS)):
        memories[SLOW + AHEAD + i] = fast[BEHIND + contact + OFFSETS[i]]


@entry_point
def recall(contact, slow, fast, memories):
    """Write the memories and changes at a contact; returns the mean of the rates."""
    memories[:] = 0.0
    total, weight = 0.0, 0.0
    for k in range(contact + 1):
        total, weight = advance(k, slow, memories, total, weight)
    add_changes(contact, slow, fast, memories)
    return total / weight


@entry_point
def multiply_memories(memories, products):
    """Write all products of two memories, bounded; returns the factor that bounds them."""
    square = 0.0
    for i in range(SLOW - 1, COUNT):
        square += memories[i] ** 2
    factor = 1.0 / (1.0 + square / LARGE)
    n = 0
    for i in range(COUNT):
        scaled = factor * memories[i]
        for j in range(i, COUNT):
            products[n] = scaled * memories[j]
            n += 1
    return factor


# contacts: number of contacts of the chain
# slow, fast: results of `smooth`, up to two contacts ahead of the last one followed
# tables: `hertzchain.theory.universal_functions.FastTables`
# states: (followed, 3), to whose last rows the response is added
@allocating
def add_last(contacts, slow, fast, tables, states):
    """Add the response of the last four contacts, as far as they are followed."""
    if len(states) <= contacts - LAST:
        return
    memories, products = np.zeros(COUNT), np.empty(PRODUCTS)
    coefficients = np.empty(STATES * PRODUCTS)
    total, weight, interval = 0.0, 0.0, 0
    for k in range(len(states)):
        total, weight = advance(k, slow, memories, total, weight)
        stage = k - (contacts - LAST)
        if stage < 0:
            continue
        add_changes(k, slow, fast, memories)
        interval, x = interval_of(total / weight, tables.last_knots, interval)
        polynomials(tables.last[stage, interval], x, coefficients)
        multiply_memories(memories, products)
        for i in range(STATES):
            states[k, i] += dot(coefficients[i * PRODUCTS : (i + 1) * PRODUCTS], products)


# seeds: (followed, 3), derivatives with respect to the states
# to_slow, to_fast: as long as slow and fast; results are added
@allocating
def from_last(contacts, slow, fast, tables, seeds, to_slow, to_fast):
    """Add derivatives with respect to both parts of the rates."""
    if len(seeds) <= contacts - LAST:
        return
    memories, to_memory, held = np.zeros(COUNT), np.zeros(COUNT), np.zeros(SLOW)
    work, to_mean = np.empty((3, PRODUCTS)), 0.0
    for k in range(len(seeds) - 1, -1, -1):
        to_mean *= MEAN
        for i in range(SLOW):
            held[i] *= MEMORIES[i]
        stage = k - (contacts - LAST)
        if stage >= 0:
            mean = recall(k, slow, fast, memories)
            slope = from_memories(
                tables.last_knots, tables.last[stage], mean, memories, seeds[k], work, to_memory
            )
            to_mean += slope * (1.0 - MEAN) / (1.0 - MEAN ** (k + 1))
            from_changes(k, to_memory, to_slow, to_fast)
            for i in range(SLOW):
                held[i] += to_memory[i]
        to_slow[k] += to_mean
        if k > 0:
            for i in range(SLOW):
                to_slow[k] += held[i]
                to_slow[k - 1] -= held[i]


@compiled
def from_memories(knots, pieces, mean, memories, seed, work, to_memory):
    """Write derivatives with respect to the memories; returns that with respect to the mean."""
    products, weights, slopes = work[0], work[1], work[2]
    interval, x = interval_of(mean, knots, 0)
    inside = knots[0] <= mean <= knots[-1]
    combine(pieces[interval], seed, x, inside, weights, slopes)
    factor = multiply_memories(memories, products)
    bounded = -2.0 / LARGE * factor * dot(weights, products)
    for i in range(COUNT):
        to_memory[i] = bounded * memories[i] if i >= SLOW - 1 else 0.0
    n = 0
    for i in range(COUNT):
        for j in range(i, COUNT):
            to_memory[i] += factor * weights[n] * memories[j]
            to_memory[j] += factor * weights[n] * memories[i]
            n += 1
    return dot(slopes, products)


@compiled
def from_changes(contact, to_memory, to_slow, to_fast):
    """Add derivatives with respect to the changes at and near a contact."""
    for o in range(1, AHEAD + 1):
        if contact + o < len(to_slow):
            to_slow[contact + o] += to_memory[SLOW + o - 1]
            to_slow[contact + o - 1] -= to_memory[SLOW + o - 1]
    for i in range(len(OFFSETS)):
        to_fast[BEHIND + contact + OFFSETS[i]] += to_memory[SLOW + AHEAD + i]
