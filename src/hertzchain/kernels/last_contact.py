r"""Second order of the response of the last contact to slow changes of the rate.

The last bead leaves the chain with whatever the pulse gives to it, and its velocity depends on
the history of the rate more strongly than that of any other bead.  To the state of the last
contact, this module adds

.. math::

    \frac{1}{1 + h_3^2/h_0^2} \sum_{i\le j} B_{ij}(\bar q)\,h_i h_j, \qquad
    h_i = \sum_{o\ge0} \lambda_i^o\,(q_{N-1-o} - q_{N-2-o}), \qquad
    \bar q = \frac{\sum_o \mu^o q_{N-1-o}}{\sum_o \mu^o}

with three memories :math:`\lambda_i` of the changes of the slow rate q, and its mean.  The
denominator keeps the term bounded for large changes.
"""

from __future__ import annotations

import numpy as np

from .fast_changes import STATES, allocating, combine, dot, entry_point, interval_of, polynomials

# Factors by which memories decay per contact, and that of the mean.
MEMORIES = (0.0, 0.6, 0.85)
MEAN = 0.75
COUNT = len(MEMORIES)
PRODUCTS = COUNT * (COUNT + 1) // 2
# Square of the slowest memory beyond which the term grows no more.
LARGE = 0.1**2


@entry_point
def recall(slow, memories):
    """Write the memories at the last contact; returns the mean of the rates."""
    memories[:] = 0.0
    total, weight = slow[0], 1.0
    for k in range(1, len(slow)):
        total, weight = MEAN * total + slow[k], MEAN * weight + 1.0
        change = slow[k] - slow[k - 1]
        for i in range(COUNT):
            memories[i] = MEMORIES[i] * memories[i] + change
    return total / weight


@entry_point
def multiply_memories(memories, products):
    """Write all products of two memories, bounded; returns the factor that bounds them."""
    factor = 1.0 / (1.0 + memories[-1] ** 2 / LARGE)
    n = 0
    for i in range(COUNT):
        for j in range(i, COUNT):
            products[n] = factor * memories[i] * memories[j]
            n += 1
    return factor


# slow: slow rates of the whole chain
# tables: `hertzchain.theory.universal_functions.FastTables`
# states: (contacts, 3), to whose last row the response is added
@allocating
def add_last(slow, tables, states):
    """Add the response of the last contact."""
    memories, products = np.empty(COUNT), np.empty(PRODUCTS)
    coefficients = np.empty(STATES * PRODUCTS)
    mean = recall(slow, memories)
    interval, x = interval_of(mean, tables.last_knots, 0)
    polynomials(tables.last[interval], x, coefficients)
    multiply_memories(memories, products)
    for i in range(STATES):
        states[-1, i] += dot(coefficients[i * PRODUCTS : (i + 1) * PRODUCTS], products)


# seed: (3,), derivatives with respect to the state of the last contact
# to_slow: as long as slow; results are added
@allocating
def from_last(slow, tables, seed, to_slow):
    """Add derivatives with respect to the slow rates."""
    memories, products = np.empty(COUNT), np.empty(PRODUCTS)
    weights, slopes = np.empty(PRODUCTS), np.empty(PRODUCTS)
    mean, knots = recall(slow, memories), tables.last_knots
    interval, x = interval_of(mean, knots, 0)
    inside = knots[0] <= mean <= knots[-1]
    combine(tables.last[interval], seed, x, inside, weights, slopes)
    factor = multiply_memories(memories, products)
    to_memory = np.zeros(COUNT)
    to_memory[-1] = -2.0 * memories[-1] / LARGE * factor * dot(weights, products)
    n = 0
    for i in range(COUNT):
        for j in range(i, COUNT):
            to_memory[i] += factor * weights[n] * memories[j]
            to_memory[j] += factor * weights[n] * memories[i]
            n += 1
    contacts = len(slow)
    share = dot(slopes, products) * (1.0 - MEAN) / (1.0 - MEAN**contacts)
    for k in range(contacts - 1, -1, -1):
        to_slow[k] += share
        share *= MEAN
        if k > 0:
            for i in range(COUNT):
                to_slow[k] += to_memory[i]
                to_slow[k - 1] -= to_memory[i]
                to_memory[i] *= MEMORIES[i]
