r"""Second order of the response of the last contact to changes of the rate.

The last bead leaves the chain with whatever the pulse gives to it, and its velocity depends on
the history of the rate more strongly than that of any other bead.  To the state of the last
contact, this module adds

.. math::

    \frac{1}{1 + (h_3^2 + h_4^2 + \dots + h_7^2)/h_0^2}
        \sum_{i\le j} B_{ij}(\bar q)\,h_i h_j, \qquad
    h_i = \sum_{o\ge0} \lambda_i^o\,(q_{N-1-o} - q_{N-2-o}), \qquad
    \bar q = \frac{\sum_o \mu^o q_{N-1-o}}{\sum_o \mu^o}

with three memories :math:`h_1, h_2, h_3` of the changes of the slow rate q, its mean, and the last
four fast changes, :math:`h_{4+i} = e_{N-1-i}`.  The denominator keeps the term bounded for large
changes.
"""

from __future__ import annotations

import numpy as np

from .fast_changes import (
    BEHIND,
    STATES,
    allocating,
    combine,
    dot,
    entry_point,
    interval_of,
    polynomials,
)

# Factors by which memories decay per contact, and that of the mean.
MEMORIES = (0.0, 0.6, 0.85)
MEAN = 0.75
# Numbers of memories, and of these and the fast changes.
SLOW, COUNT = len(MEMORIES), len(MEMORIES) + 4
PRODUCTS = COUNT * (COUNT + 1) // 2
# Sum of squares of the slowest memory and the fast changes beyond which the term grows no more.
LARGE = 0.1**2


@entry_point
def recall(slow, fast, memories):
    """Write the memories at the last contact, and fast changes; returns the mean of the rates."""
    memories[:SLOW] = 0.0
    total, weight = slow[0], 1.0
    for k in range(1, len(slow)):
        total, weight = MEAN * total + slow[k], MEAN * weight + 1.0
        change = slow[k] - slow[k - 1]
        for i in range(SLOW):
            memories[i] = MEMORIES[i] * memories[i] + change
    for i in range(COUNT - SLOW):
        memories[SLOW + i] = fast[BEHIND + len(slow) - 1 - i]
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
        for j in range(i, COUNT):
            products[n] = factor * memories[i] * memories[j]
            n += 1
    return factor


# slow, fast: results of `smooth` for the whole chain
# tables: `hertzchain.theory.universal_functions.FastTables`
# states: (contacts, 3), to whose last row the response is added
@allocating
def add_last(slow, fast, tables, states):
    """Add the response of the last contact."""
    memories, products = np.empty(COUNT), np.empty(PRODUCTS)
    coefficients = np.empty(STATES * PRODUCTS)
    mean = recall(slow, fast, memories)
    interval, x = interval_of(mean, tables.last_knots, 0)
    polynomials(tables.last[interval], x, coefficients)
    multiply_memories(memories, products)
    for i in range(STATES):
        states[-1, i] += dot(coefficients[i * PRODUCTS : (i + 1) * PRODUCTS], products)


# seed: (3,), derivatives with respect to the state of the last contact
# to_slow, to_fast: as long as slow and fast; results are added
@allocating
def from_last(slow, fast, tables, seed, to_slow, to_fast):
    """Add derivatives with respect to both parts of the rates."""
    memories, products = np.empty(COUNT), np.empty(PRODUCTS)
    weights, slopes = np.empty(PRODUCTS), np.empty(PRODUCTS)
    mean, knots = recall(slow, fast, memories), tables.last_knots
    interval, x = interval_of(mean, knots, 0)
    inside = knots[0] <= mean <= knots[-1]
    combine(tables.last[interval], seed, x, inside, weights, slopes)
    factor = multiply_memories(memories, products)
    to_memory = np.zeros(COUNT)
    bounded = -2.0 / LARGE * factor * dot(weights, products)
    for i in range(SLOW - 1, COUNT):
        to_memory[i] = bounded * memories[i]
    n = 0
    for i in range(COUNT):
        for j in range(i, COUNT):
            to_memory[i] += factor * weights[n] * memories[j]
            to_memory[j] += factor * weights[n] * memories[i]
            n += 1
    contacts = len(slow)
    for i in range(COUNT - SLOW):
        to_fast[BEHIND + contacts - 1 - i] += to_memory[SLOW + i]
    share = dot(slopes, products) * (1.0 - MEAN) / (1.0 - MEAN**contacts)
    for k in range(contacts - 1, -1, -1):
        to_slow[k] += share
        share *= MEAN
        if k > 0:
            for i in range(SLOW):
                to_slow[k] += to_memory[i]
                to_slow[k - 1] -= to_memory[i]
                to_memory[i] *= MEMORIES[i]
