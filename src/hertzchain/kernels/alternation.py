r"""Effect of radii that alternate from bead to bead, beyond the second order.

With the fourth difference of the rates around contact k, whose sign changes from contact to
contact if the rates alternate, this module computes

.. math::

    \delta_k = \frac{(-1)^k}{16}\,(s_{k-2} - 4s_{k-1} + 6s_k - 4s_{k+1} + s_{k+2}), \qquad
    a_k = (-1)^k \langle\delta\rangle_k, \qquad
    \kappa_k = \max\left(0,\;
        \frac{\langle\delta\rangle_k^2/\langle\delta^2\rangle_k - \kappa_0}{1 - \kappa_0}\right)^2

with means over the contacts k-8 to k+3 (at the first contacts, up to the eighth) that have all
these neighbours, and adds

.. math:: \kappa_k\,Z\bigl(s_k - (-1)^k \delta_k,\; a_k\bigr)

to the state.  Z is the state on a simulated chain whose rates alternate with this amplitude about
this rate, less that of the law.  The factor :math:`\kappa` is 1 if rates alternate, and small if
they are random.  On smooth tapers, :math:`\delta` vanishes.
"""

from __future__ import annotations

import numpy as np

from .fast_changes import (
    CUBICS,
    HALF,
    STATES,
    combine,
    compiled,
    dot,
    interval_of,
    polynomials,
    stage_of,
)

# Weights of the fourth difference, on both sides of a contact.
FOURTH = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / 16.0
SIDE = 2
# Contacts of the means, behind and ahead, and the least last one.
BEFORE, AFTER, LEAST = 8, 3, 7
# Coherence kappa_0 below which rates do not count as alternating.
INCOHERENT = 0.5
# Amplitude of the unit of the powers, beyond which Z is constant, and negligible amplitude.
TOP, NEGLIGIBLE = 0.12, 3e-4
# Fast changes of rates that alternate with amplitude 1: a local polynomial has the opposite sign.
FAST = 1.0 - float(CUBICS[HALF] @ (-1.0) ** np.arange(-HALF, HALF + 1))
# Lowest rate of the alternating chains of the table, below which pulses have several maxima.
LOWEST_RATE = -0.13
# Larger amplitudes, and rates of backward tapers, for which the effect is known less and less.
BEYOND = 0.02
BACKWARD_FROM, FADED = 0.07, 0.06
# Z is a sum of these powers of the amplitude, and of the same with its sign.
LOWEST, POWERS = 2, 6
COUNT = 2 * POWERS
# Numbers that `from_alternation` needs for a contact.
WORK = 4 * COUNT


@compiled
def alternate(contact):
    """Sign of a contact."""
    return 1.0 - 2.0 * (contact % 2)


@compiled
def write_differences(rates, differences):
    """Write fourth differences with alternating signs; returns the contacts that they affect."""
    contacts, first, last = len(rates), len(rates), 0
    for k in range(SIDE, contacts - SIDE):
        value = FOURTH[0] * (rates[k - 2] + rates[k + 2]) + FOURTH[2] * rates[k]
        value += FOURTH[1] * (rates[k - 1] + rates[k + 1])
        differences[k] = alternate(k) * value
        if abs(value) > NEGLIGIBLE:
            first, last = min(first, k), k
    for k in range(SIDE):
        differences[k] = differences[SIDE]
        differences[contacts - 1 - k] = differences[contacts - 1 - SIDE]
    return (first - AFTER if first > LEAST else 0), last + BEFORE + 1


@compiled
def window_of(contact, contacts):
    """First contact of the means, and the one after the last."""
    last = max(contact + AFTER, LEAST)
    return max(contact - BEFORE, SIDE), min(last + 1, contacts - SIDE)


@compiled
def means_of(differences, contact):
    """Means of the differences and of their squares, and their number."""
    first, last = window_of(contact, len(differences))
    total, squares = 0.0, 0.0
    for k in range(first, last):
        total += differences[k]
        squares += differences[k] * differences[k]
    number = last - first
    return total / number, squares / number, number


@compiled
def weight_of(mean, square):
    """Factor kappa, and its derivatives with respect to the means of differences and of squares."""
    excess = (mean * mean / square - INCOHERENT) / (1.0 - INCOHERENT)
    if excess <= 0.0:
        return 0.0, 0.0, 0.0
    slope = 2.0 * excess / (1.0 - INCOHERENT)
    return excess * excess, slope * 2.0 * mean / square, -slope * (mean / square) ** 2


@compiled
def write_powers(amplitude, values, slopes):
    """Write powers of an amplitude, and their derivatives."""
    size = min(abs(amplitude), TOP) / TOP
    sign = 1.0 if amplitude > 0.0 else -1.0
    power = size ** (LOWEST - 1)
    for n in range(POWERS):
        slope = (LOWEST + n) * power / TOP if abs(amplitude) < TOP else 0.0
        power *= size
        values[n], values[POWERS + n] = power, sign * power
        slopes[n], slopes[POWERS + n] = sign * slope, slope


@compiled
def known_part(contact, rates, base, mean):
    """Part of the fast changes at a contact whose effect is that of the table."""
    first, last = max(contact - SIDE, 0), min(contact + SIDE, len(rates) - 1)
    size = 0.0
    for k in range(first, last):
        size += (rates[k + 1] - rates[k]) ** 2
    # If only a part of the changes alternates, their effect differs from the tabulated one.
    ratio = 0.25 * size / ((last - first) * mean * mean)
    outside = max(abs(mean) - TOP, LOWEST_RATE - (base - abs(mean)), 0.0)
    within = max(0.0, 1.0 - outside / BEYOND)
    within *= max(0.0, 1.0 - max(base - BACKWARD_FROM, 0.0) / FADED)
    return within * min(ratio, 1.0 / ratio) ** 3


# Arguments:
# rates: of the chain
# tables: `hertzchain.kernels.law_tables.FastTables`
# differences: (contacts,), is overwritten
# work: (4 COUNT,), is overwritten
# Results:
# states: (followed, 3), to which the effect is added
# regular: (followed, 2), part of the fast changes whose effect is known from the table, and square
#   of these changes
@compiled
def add_alternation(rates, tables, differences, work, states, regular):
    """Add the effect of alternating rates; returns whether there is one."""
    regular[:] = 0.0
    if len(tables.bases) < 2:
        return False
    # The coefficients take the place of the derivatives of the powers.
    values, coefficients, any_effect, place = work[:COUNT], work[COUNT:], False, 0
    first, last = write_differences(rates, differences)
    for k in range(first, min(last, len(states))):
        mean, square, _ = means_of(differences, k)
        if abs(mean) < NEGLIGIBLE:
            continue
        share, _, _ = weight_of(mean, square)
        if share == 0.0:
            continue
        any_effect = True
        base = rates[k] - alternate(k) * differences[k]
        regular[k, 0] = share * known_part(k, rates, base, mean)
        regular[k, 1] = share * (FAST * mean) ** 2
        write_powers(alternate(k) * mean, values, coefficients)
        place, x = interval_of(base, tables.bases, place)
        stage = stage_of(k, len(rates))
        polynomials(tables.alternating[stage, place], x, coefficients)
        for i in range(STATES):
            states[k, i] += share * dot(coefficients[i * COUNT : (i + 1) * COUNT], values)
    return any_effect


# seeds: (followed, 3), derivatives with respect to the states
# to_differences: (contacts,), is overwritten
# to_rates: (contacts,); results are added
@compiled
def from_alternation(rates, tables, differences, work, seeds, to_differences, to_rates):
    """Add derivatives with respect to the rates, if there is an effect."""
    values, slopes = work[:COUNT], work[COUNT : 2 * COUNT]
    coefficients, bends = work[2 * COUNT : 3 * COUNT], work[3 * COUNT :]
    first, last = write_differences(rates, differences)
    to_differences[:] = 0.0
    bases, place = tables.bases, 0
    for k in range(first, min(last, len(seeds))):
        mean, square, number = means_of(differences, k)
        if abs(mean) < NEGLIGIBLE:
            continue
        share, by_mean, by_square = weight_of(mean, square)
        if share == 0.0:
            continue
        sign = alternate(k)
        write_powers(sign * mean, values, slopes)
        base = rates[k] - sign * differences[k]
        place, x = interval_of(base, bases, place)
        inside = bases[0] <= base <= bases[-1]
        pieces = tables.alternating[stage_of(k, len(rates)), place]
        combine(pieces, seeds[k], x, inside, coefficients, bends)
        effect, to_base = dot(coefficients, values), share * dot(bends, values)
        to_rates[k] += to_base
        to_differences[k] -= sign * to_base
        to_mean = (share * sign * dot(coefficients, slopes) + effect * by_mean) / number
        to_square = 2.0 * effect * by_square / number
        begin, end = window_of(k, len(rates))
        for j in range(begin, end):
            to_differences[j] += to_mean + to_square * differences[j]
    for k in range(len(rates)):
        middle = min(max(k, SIDE), len(rates) - 1 - SIDE)
        part = alternate(middle) * to_differences[k]
        for o in range(2 * SIDE + 1):
            to_rates[middle - SIDE + o] += FOURTH[o] * part
