r"""States of the last four contacts.

Near the free end, the slow part of the rates is not well defined, and the response depends on the
history of the rate more strongly than within the chain.  The states of the last four contacts are
therefore expanded about a mean of the rates s behind them:

.. math::

    z_k = Z_k(\bar s) + \sum_{o=-13}^{2} G_o(\bar s)\,(s_{k+o} - \bar s)
        + G_*(\bar s)\,(\bar s_{k-14} - \bar s)
        + \beta \sum_{i\le j} B_{ij}(\bar s)\,\eta_i \eta_j
        + \beta^2 \sum_{i\le j\le l\le 3} C_{ijl}(\bar s)\,\eta_i \eta_j \eta_l,
    \\
    \beta = \frac{1}{1 + \sum_i \eta_i^2/\eta_0^2}, \qquad
    \bar s = \bar s_k = \frac{\sum_o \mu^o s_{k-o}}{\sum_o \mu^o} .

Z is the state on a long exponential chain, and G the simulated response to a change of one rate or,
with the mean :math:`\bar s_{k-14}`, of all earlier ones.  In short chains, the impact has not been
forgotten at the end.  There, the states on exponential chains of that length, less those above, are
added, and their response to a linear change of the rates,

.. math:: D_{n,k}(\bar r) + R_{n,k}(\bar r)\,\frac{\sum_j x_j s_j}{\sum_j x_j^2} ,
    \qquad x_j = \frac{j}{n - 1} - \frac12 ,

at the mean :math:`\bar r` of all n rates.  At one of the first twelve contacts, the differences of
Z and G between this contact and one within the chain are part of the states above.

The inputs :math:`\eta` are two memories :math:`\sum_o \lambda_i^o (s_{k-o} - s_{k-o-1})` and the
changes :math:`s_{k+o} - s_{k+o-1}` near the contact, of which the last one comes first.  Beyond the
last contact, deviations and changes are zero.  The factor :math:`\beta` keeps the higher orders
bounded.

Tables for exponents without these functions are empty: there, the free end is that of
`hertzchain.kernels.fast_changes`.
"""

from __future__ import annotations

import numpy as np

from .fast_changes import (
    BEHIND,
    EARLY,
    STATES,
    TAPS,
    allocating,
    combine,
    compiled,
    dot,
    entry_point,
    interval_of,
    polynomials,
)

# Number of these contacts, and of all contacts of the shortest chain.
LAST, SHORTEST = 4, 8
# Factors by which memories decay per contact, and that of the mean.
MEMORIES = (0.6, 0.85)
MEAN = 0.75
# Offsets of the changes, and numbers of memories, and of these and all changes.
OFFSETS = (0, -1, -2, -3, 1, 2)
PAST, COUNT = len(MEMORIES), len(MEMORIES) + len(OFFSETS)
PAIRS = COUNT * (COUNT + 1) // 2
# Products of three inputs are those of the first ones, in a unit in which they are not tiny.
CUBED, UNIT = 3, 0.05
PRODUCTS = PAIRS + CUBED * (CUBED + 1) * (CUBED + 2) // 6
# Terms of first order: deviations of rates, that of the earlier ones, and 1.
TERMS = TAPS + 2
# Sum of squares of the inputs beyond which the higher orders grow no more.
LARGE = 0.2**2


@compiled
def first_of(contacts, tables):
    """First of the contacts with functions of their own; the number of contacts without tables."""
    return contacts - LAST if len(tables.end_places) > 0 else contacts


@compiled
def mean_until(contact, rates):
    """Mean of the rates up to a contact, in which the last ones count most."""
    total, weight = 0.0, 0.0
    for k in range(contact + 1):
        total, weight = MEAN * total + rates[k], MEAN * weight + 1.0
    return total / weight


@compiled
def ramp(contact, contacts):
    """Value at a contact of a line that rises from -1/2 to 1/2, divided by the sum of squares."""
    x = contact / (contacts - 1) - 0.5
    return 12.0 * (contacts - 1) / (contacts * (contacts + 1)) * x


@compiled
def line_through(rates):
    """Mean of the rates, and by how much a line fitted to them rises along the chain."""
    total, rise = 0.0, 0.0
    for k in range(len(rates)):
        total += rates[k]
        rise += ramp(k, len(rates)) * rates[k]
    return total / len(rates), rise


@compiled
def change_at(contact, rates):
    """Change of the rate from the contact before; zero at the first one and beyond the ends."""
    return rates[contact] - rates[contact - 1] if 0 < contact < len(rates) else 0.0


@entry_point
def recall(contact, rates, inputs, terms):
    """Write the inputs of higher orders and the terms of the first; returns the mean rate."""
    inputs[:] = 0.0
    for k in range(contact + 1):
        change = change_at(k, rates)
        for i in range(PAST):
            inputs[i] = MEMORIES[i] * inputs[i] + change
    for i in range(len(OFFSETS)):
        inputs[PAST + i] = change_at(contact + OFFSETS[i], rates)
    mean = mean_until(contact, rates)
    for i in range(TAPS):
        k = contact + i - BEHIND
        terms[i] = rates[k] - mean if 0 <= k < len(rates) else 0.0
    earlier = contact - BEHIND - 1
    terms[TAPS] = mean_until(earlier, rates) - mean if earlier >= 0 else 0.0
    terms[TAPS + 1] = 1.0
    return mean


@entry_point
def multiply_inputs(inputs, products):
    """Write products of two and of three inputs, bounded; returns the factor that bounds them."""
    factor = 1.0 / (1.0 + dot(inputs, inputs) / LARGE)
    n = 0
    for i in range(COUNT):
        scaled = factor * inputs[i]
        for j in range(i, COUNT):
            products[n] = scaled * inputs[j]
            n += 1
    for i in range(CUBED):
        for j in range(i, CUBED):
            scaled = factor * factor / UNIT * inputs[i] * inputs[j]
            for k in range(j, CUBED):
                products[n] = scaled * inputs[k]
                n += 1
    return factor


# rates: of all contacts of the chain
# tables: `hertzchain.kernels.law_tables.FastTables`
# states: (followed, 3), whose last rows are written
@allocating
def write_last(rates, tables, states):
    """Write the states of the last four contacts, as far as they are followed."""
    first = first_of(len(rates), tables)
    if len(states) <= first:
        return
    inputs, products = np.empty(COUNT), np.empty(PRODUCTS)
    terms, values = np.empty(TERMS), np.empty(STATES * max(PRODUCTS, TERMS))
    place, knot, length = 0, 0, len(rates) - SHORTEST
    overall, rise = line_through(rates)
    short, in_short = interval_of(overall, tables.end_places, 0)
    for k in range(first, len(states)):
        mean = recall(k, rates, inputs, terms)
        place, x = interval_of(mean, tables.end_places, place)
        linear = values[: STATES * TERMS]
        polynomials(tables.end_response[k - first, place], x, linear)
        for i in range(STATES):
            states[k, i] = dot(linear[i * TERMS : (i + 1) * TERMS], terms)
        if k < EARLY:
            polynomials(tables.impact[k, place], x, linear)
            for i in range(STATES):
                states[k, i] += dot(linear[i * TERMS : (i + 1) * TERMS], terms)
        if length < len(tables.short):
            polynomials(tables.short[length, k - first, short], in_short, values[: 2 * STATES])
            for i in range(STATES):
                states[k, i] += values[2 * i] + rise * values[2 * i + 1]
        knot, x = interval_of(mean, tables.last_knots, knot)
        higher = values[: STATES * PRODUCTS]
        polynomials(tables.last[k - first, knot], x, higher)
        multiply_inputs(inputs, products)
        for i in range(STATES):
            states[k, i] += dot(higher[i * PRODUCTS : (i + 1) * PRODUCTS], products)


# seeds: (followed, 3), derivatives with respect to the states; those of the last four are set to
#   0, so that the recursion ignores them
# to_rates: as long as the rates; results are added
@allocating
def from_last(rates, tables, seeds, to_rates):
    """Add derivatives with respect to the rates."""
    first = first_of(len(rates), tables)
    if len(seeds) <= first:
        return
    inputs, to_input, terms = np.empty(COUNT), np.empty(COUNT), np.empty(TERMS)
    work = np.empty((3, max(PRODUCTS, TERMS)))
    places, length = tables.end_places, len(rates) - SHORTEST
    for k in range(first, len(seeds)):
        mean = recall(k, rates, inputs, terms)
        pieces = tables.end_response[k - first]
        slope = from_terms(k, places, pieces, mean, terms, seeds[k], work, to_rates)
        if k < EARLY:
            slope += from_terms(k, places, tables.impact[k], mean, terms, seeds[k], work, to_rates)
        if length < len(tables.short):
            pieces = tables.short[length, k - first]
            from_line(rates, places, pieces, seeds[k], work, to_rates)
        spread_mean(k, slope, to_rates)
        pieces = tables.last[k - first]
        slope = from_inputs(tables.last_knots, pieces, mean, inputs, seeds[k], work, to_input)
        spread_mean(k, slope, to_rates)
        for i in range(len(OFFSETS)):
            add_change(k + OFFSETS[i], to_input[PAST + i], to_rates)
        for i in range(PAST):
            value = to_input[i]
            for earlier in range(k, 0, -1):
                add_change(earlier, value, to_rates)
                value *= MEMORIES[i]
        seeds[k] = 0.0


@compiled
def from_line(rates, places, pieces, seed, work, to_rates):
    """Add derivatives of the rest of the impact in short chains."""
    overall, rise = line_through(rates)
    place, x = interval_of(overall, places, 0)
    values, slopes = work[0, :2], work[1, :2]
    combine(pieces[place], seed, x, places[0] <= overall <= places[-1], values, slopes)
    to_mean, contacts = slopes[0] + rise * slopes[1], len(rates)
    for k in range(contacts):
        to_rates[k] += to_mean / contacts + values[1] * ramp(k, contacts)


@compiled
def spread_mean(contact, value, to_rates):
    """Add the derivative with respect to the mean of the rates up to a contact."""
    value *= (1.0 - MEAN) / (1.0 - MEAN ** (contact + 1))
    for k in range(contact, -1, -1):
        to_rates[k] += value
        value *= MEAN


@compiled
def add_change(contact, value, to_rates):
    """Add the derivative with respect to a change of the rate."""
    if 0 < contact < len(to_rates):
        to_rates[contact] += value
        to_rates[contact - 1] -= value


@compiled
def from_terms(contact, places, pieces, rate, terms, seed, work, to_rates):
    """Add derivatives of the first order; returns that by the rate of the tables."""
    weights, slopes, to_mean = work[0, :TERMS], work[1, :TERMS], 0.0
    place, x = interval_of(rate, places, 0)
    combine(pieces[place], seed, x, places[0] <= rate <= places[-1], weights, slopes)
    for i in range(TAPS):
        k = contact + i - BEHIND
        if 0 <= k < len(to_rates):
            to_rates[k] += weights[i]
            to_mean -= weights[i]
    earlier = contact - BEHIND - 1
    if earlier >= 0:
        spread_mean(earlier, weights[TAPS], to_rates)
        to_mean -= weights[TAPS]
    spread_mean(contact, to_mean, to_rates)
    return dot(slopes, terms)


@compiled
def from_inputs(knots, pieces, mean, inputs, seed, work, to_input):
    """Write derivatives of the higher orders by the inputs; returns that by the mean."""
    products, weights, slopes = work[0, :PRODUCTS], work[1, :PRODUCTS], work[2, :PRODUCTS]
    interval, x = interval_of(mean, knots, 0)
    inside = knots[0] <= mean <= knots[-1]
    combine(pieces[interval], seed, x, inside, weights, slopes)
    factor = multiply_inputs(inputs, products)
    bounded = dot(weights[:PAIRS], products[:PAIRS])
    bounded += 2.0 * dot(weights[PAIRS:], products[PAIRS:])
    for i in range(COUNT):
        to_input[i] = -2.0 / LARGE * factor * bounded * inputs[i]
    n = 0
    for i in range(COUNT):
        for j in range(i, COUNT):
            to_input[i] += factor * weights[n] * inputs[j]
            to_input[j] += factor * weights[n] * inputs[i]
            n += 1
    for i in range(CUBED):
        for j in range(i, CUBED):
            for k in range(j, CUBED):
                scaled = factor * factor / UNIT * weights[n]
                to_input[i] += scaled * inputs[j] * inputs[k]
                to_input[j] += scaled * inputs[i] * inputs[k]
                to_input[k] += scaled * inputs[i] * inputs[j]
                n += 1
    return dot(slopes, products)
