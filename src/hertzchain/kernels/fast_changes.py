r"""Linear response of the local-rate law, products of fast changes, and the free end.

The rates are divided into slow rates q, by local cubic polynomials, and the rest e (which
vanishes in strong backward tapers).  To the states :math:`\zeta_k` on a chain of the slow rates,
this module adds

.. math::

    \sum_o G_o(q_k)\,e_{k+o} + h(q_k) + \sum_o H_o(q_k)\,(q_{k+o} - q_{k+o-1})
        + g_k \sum_{i\le j} A_{ij}(q_k)\,e_{k+i}\,e_{k+j}
        + \gamma_k \sum_i K_i(q_k)\,e_{k+i},
    \qquad
    g_k = \frac{c_p}{1 + \epsilon_k^2/\epsilon_0^2}
        + \frac{(4q_k^2 + \epsilon_k^2)^{1/4}}{(1 + \epsilon_k^2/\epsilon_0^2)^{5/4}},

where :math:`\epsilon_k` is the root mean square of the fast changes near the contact, :math:`c_p`
depends on the exponent of the contact force, and :math:`\gamma_k` is the mean change of the slow
rate from contact k - 4 to k + 2, on which the response to fast changes depends, too.  G is the
response of the simulated state to a small change of one rate, and H the difference between the
simulated response to slow rates and that of the recursion (`hertzchain.theory.linear_response`).
The state h on an exponential chain, less that of the recursion, differs from zero after the impact
and near the free end.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from .compilation import OPTIONS, internal

STATES = 3
# Numbers of each component in a table of a response, also in that of the recursion; the last ones
# are zero.
COLUMNS = 36
# Contacts with separate responses after the impact and before the free end.
EARLY, END = 12, 5
WITHIN = EARLY
STAGES = EARLY + 1 + END
# Offsets o of the rates to which a contact responds.
BEHIND, AHEAD = 13, 2
TAPS = BEHIND + 1 + AHEAD
# Fast changes in products: those from offset -4 to 2.  They are multiplied by each other, and by
# the mean change of the slow rate over these offsets.
RISING = 4
NEAR = BEHIND - RISING
FACTORS = TAPS - NEAR
PAIRS = FACTORS * (FACTORS + 1) // 2
PRODUCTS = PAIRS + FACTORS
# Offsets -2 to 1 determine the size of fast changes.
FIRST, LAST = BEHIND - 2, BEHIND + 2
# Square of the size beyond which products grow no more.
LARGE = 0.06**2
# Effect of products on a state from which on they are meaningless, in chains far outside the law.
MEANINGLESS = 1.0
TINY = 1e-12
# Sum of squares of fast changes whose products are negligible.
NEGLIGIBLE = 1e-12
# Half the number of rates of a local polynomial, besides the central one.
HALF = 4
# Rate beyond which changes are treated as slow.
BACKWARD = 0.15

# Sums may be evaluated in any order, so that the compiler can vectorise them.  Without reference
# counting (`_nrt`), views of arrays cost nothing, but no array can be created: those that a
# function needs are parts of its argument ``work``.
REORDERED: dict[str, Any] = OPTIONS | {"fastmath": {"reassoc", "contract"}}
entry_point = njit(**REORDERED)
compiled = internal(**REORDERED)
allocating = njit(**(REORDERED | {"_nrt": True}))


def local_cubics() -> np.ndarray:
    """Weights (5, 9) of the slow rate of a contact with 0 to 4 contacts behind it."""
    found = np.zeros((HALF + 1, 2 * HALF + 1))
    for behind in range(HALF + 1):
        offsets = np.arange(-behind, HALF + 1)
        weight = (1.0 - (offsets / (HALF + 1.0)) ** 2) ** 2
        powers = np.vander(offsets / HALF, 4, increasing=True)
        normal = powers.T @ (weight[:, None] * powers)
        found[behind, HALF - behind :] = np.linalg.solve(normal, (weight[:, None] * powers).T)[0]
    return found


CUBICS = local_cubics()


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
def fitted_rate(rates, k):
    """Value of the local cubic polynomial at a contact."""
    behind, ahead = min(k, HALF), min(len(rates) - 1 - k, HALF)
    total = 0.0
    if ahead < HALF:
        for o in range(-HALF, ahead + 1):
            total += CUBICS[ahead, HALF - o] * rates[k + o]
    else:
        for o in range(-behind, HALF + 1):
            total += CUBICS[behind, HALF + o] * rates[k + o]
    return total


@compiled
def fit_rates(rates, fitted):
    """Evaluate the local cubic polynomials at the first contacts."""
    until = min(len(fitted), len(rates) - HALF)
    for k in range(HALF, until):
        fitted[k] = 0.0
    # Contact by contact only near the ends: the inner loop uses vectors.
    for o in range(2 * HALF + 1):
        weight = CUBICS[HALF, o]
        for k in range(HALF, until):
            fitted[k] += weight * rates[k + o - HALF]
    for k in range(min(HALF, len(fitted))):
        fitted[k] = fitted_rate(rates, k)
    for k in range(max(until, HALF), len(fitted)):
        fitted[k] = fitted_rate(rates, k)


@compiled
def share(rate):
    """Part of the deviation from the polynomial that is fast, and its derivative."""
    # In strong backward tapers, the memory is so short that no change is fast.
    ratio = max(rate, 0.0) / BACKWARD
    value = 1.0 / (1.0 + ratio**4)
    return value, -4.0 * ratio**3 * value * value / BACKWARD


@compiled
def smooth(rates, slow, fast):
    """Divide the first rates of a chain of at least eight contacts."""
    # fast: BEHIND zeros, the fast changes, AHEAD zeros
    fast[:] = 0.0
    fit_rates(rates, slow)
    for k in range(len(slow)):
        change = share(slow[k])[0] * (rates[k] - slow[k])
        slow[k], fast[BEHIND + k] = rates[k] - change, change


@compiled
def from_smooth(rates, to_slow, to_fast, fitted, to_rates):
    """Add derivatives with respect to the rates to ``to_rates``."""
    # fitted: as long as to_slow, is overwritten
    contacts = len(to_rates)
    fit_rates(rates, fitted)
    for k in range(len(to_slow)):
        behind, ahead = min(k, HALF), min(contacts - 1 - k, HALF)
        part, slope = share(fitted[k])
        difference = to_slow[k] - to_fast[BEHIND + k]
        to_rates[k] += to_slow[k] - part * difference
        change = (part - slope * (rates[k] - fitted[k])) * difference
        if ahead < HALF:
            for o in range(-HALF, ahead + 1):
                to_rates[k + o] += CUBICS[ahead, HALF - o] * change
        else:
            for o in range(-behind, HALF + 1):
                to_rates[k + o] += CUBICS[behind, HALF + o] * change


@compiled
def stage_of(contact, contacts):
    """Stage of a contact, from 0: those before the free end come last."""
    left = contacts - contact
    # The impact affects the fifth last contact of a short chain more than the free end does.
    if left > END or (left == END and contact < EARLY):
        return min(contact, EARLY)
    return STAGES - left


@compiled
def size_of(around):
    """Mean square of the fast changes next to a contact."""
    total = 0.0
    for i in range(FIRST, LAST):
        total += around[i] * around[i]
    return total / (LAST - FIRST)


@compiled
def gain(rate, size, steady):
    """Factor g of the products, and its derivatives with respect to rate and mean square."""
    sum_of = 4.0 * rate * rate + size + TINY
    limit = 1.0 + size / LARGE
    value = np.sqrt(np.sqrt(sum_of / limit)) / limit
    by_size = value * (0.25 / sum_of - 1.25 / (LARGE * limit)) - steady / (LARGE * limit * limit)
    return value + steady / limit, value * 2.0 * rate / sum_of, by_size


@compiled
def negligible(around):
    """Whether fast changes are so small that their products are."""
    total = 0.0
    for i in range(NEAR, TAPS):
        total += around[i] * around[i]
    return total < NEGLIGIBLE


@compiled
def rise_between(contact, slow):
    """Contacts between which the slow rate changes near a contact."""
    return max(contact - RISING, 0), min(contact + AHEAD, len(slow) - 1)


@compiled
def multiply(around, g, rise, products):
    """Write all products of two fast changes and the gain, and of one and the rise."""
    n = 0
    for i in range(NEAR, TAPS):
        scaled = g * around[i]
        for j in range(i, TAPS):
            products[n] = scaled * around[j]
            n += 1
        products[PAIRS + i - NEAR] = rise * around[i]


@compiled
def polynomials(pieces, x, values):
    """Evaluate cubic polynomials (4, n) of x."""
    for i in range(len(values)):
        a, b, c = pieces[0, i], pieces[1, i], pieces[2, i]
        values[i] = ((a * x + b) * x + c) * x + pieces[3, i]


@compiled
def three_sums(pieces, x, factors):
    """Sums of factors times cubic polynomials (4, 108) of x, for each component."""
    # All at once and of constant length: twice as fast as three sums of stored values.
    first, second, third = 0.0, 0.0, 0.0
    for n in range(COLUMNS):
        i, j = COLUMNS + n, 2 * COLUMNS + n
        value = ((pieces[0, n] * x + pieces[1, n]) * x + pieces[2, n]) * x + pieces[3, n]
        first += value * factors[n]
        value = ((pieces[0, i] * x + pieces[1, i]) * x + pieces[2, i]) * x + pieces[3, i]
        second += value * factors[n]
        value = ((pieces[0, j] * x + pieces[1, j]) * x + pieces[2, j]) * x + pieces[3, j]
        third += value * factors[n]
    return first, second, third


@compiled
def combine(pieces, weights, x, inside, values, slopes):
    """Evaluate weighted sums of three cubic polynomials, and their derivatives, side by side."""
    # pieces (4, 3 n), weights (3,), values and slopes (n,); slopes are zero outside the tables
    n = len(values)
    first, second, third = weights[0], weights[1], weights[2]
    for i in range(n):
        a = first * pieces[0, i] + second * pieces[0, n + i] + third * pieces[0, 2 * n + i]
        b = first * pieces[1, i] + second * pieces[1, n + i] + third * pieces[1, 2 * n + i]
        c = first * pieces[2, i] + second * pieces[2, n + i] + third * pieces[2, 2 * n + i]
        d = first * pieces[3, i] + second * pieces[3, n + i] + third * pieces[3, 2 * n + i]
        values[i] = ((a * x + b) * x + c) * x + d
        slopes[i] = (3.0 * a * x + 2.0 * b) * x + c if inside else 0.0


@entry_point
def write_steps(slow, steps):
    """Write BEHIND zeros, the differences of the slow rates, AHEAD zeros."""
    steps[:] = 0.0
    for k in range(1, len(slow)):
        steps[BEHIND + k] = slow[k] - slow[k - 1]


@compiled
def dot(values, factors):
    """Sum of products."""
    total = 0.0
    for n in range(len(factors)):
        total += values[n] * factors[n]
    return total


# Numbers that `add_response` and `from_response` need for a contact.
WORK = 2 * STATES * COLUMNS


@compiled
def write_factors(contact, fast, steps, factors):
    """Write what a contact responds to in first order: fast changes, slow steps, and 1."""
    for n in range(TAPS):
        factors[n], factors[TAPS + n] = fast[contact + n], steps[contact + n]
    factors[2 * TAPS] = 1.0
    for n in range(2 * TAPS + 1, COLUMNS):
        factors[n] = 0.0


# Arguments:
# contacts: number of contacts of the chain
# slow, fast: results of `smooth`, up to two contacts ahead of the last one followed
# steps: result of `write_steps`
# tables: `hertzchain.kernels.law_tables.FastTables`
# work: (WORK,), is overwritten
# states: (followed, 3), to which the response is added
@entry_point
def add_response(contacts, slow, fast, steps, tables, work, states):
    """Add the response to changes of the rate and to the free end.

    Returns the first contact at which products are meaningless, or else ``followed``: from there
    on, they are omitted.
    """
    products, factors = work[:COLUMNS], work[COLUMNS : 2 * COLUMNS]
    products[PRODUCTS:] = 0.0
    place, knot, sound = 0, 0, len(states)
    for k in range(len(states)):
        q, stage = slow[k], stage_of(k, contacts)
        around = fast[k : k + TAPS]
        place, x = interval_of(q, tables.places, place)
        write_factors(k, fast, steps, factors)
        first, second, third = three_sums(tables.first[stage, place], x, factors)
        states[k, 0] += first
        states[k, 1] += second
        states[k, 2] += third
        if k < sound and not negligible(around):
            knot, distance = interval_of(q, tables.knots, knot)
            g, _, _ = gain(q, size_of(around), tables.steady)
            begin, end = rise_between(k, slow)
            multiply(around, g, (slow[end] - slow[begin]) / (end - begin), products)
            first, second, third = three_sums(tables.second[stage, knot], distance, products)
            if max(abs(first), abs(second), abs(third)) < MEANINGLESS:
                states[k, 0] += first
                states[k, 1] += second
                states[k, 2] += third
            else:
                sound = k
    return sound


# Arguments: as above, and
# seeds: (followed, 3), derivatives with respect to the states
# sound: result of `add_response`
# to_slow, to_fast, to_steps: as long as slow, fast and steps; results are added, and to_steps is
#   overwritten
@compiled
def from_response(
    contacts, slow, fast, steps, tables, seeds, work, sound, to_slow, to_fast, to_steps
):  # fmt: skip
    """Add derivatives with respect to both parts of the rates."""
    n = COLUMNS
    products, bends, bend_slopes = work[:n], work[n : 2 * n], work[2 * n : 3 * n]
    factors, values, slopes = work[3 * n : 4 * n], work[4 * n : 5 * n], work[5 * n : 6 * n]
    products[PRODUCTS:] = 0.0
    to_steps[:] = 0.0
    place, knot = 0, 0
    for k in range(len(seeds)):
        q, stage = slow[k], stage_of(k, contacts)
        around = fast[k : k + TAPS]
        place, x = interval_of(q, tables.places, place)
        inside = tables.places[0] <= q <= tables.places[-1]
        write_factors(k, fast, steps, factors)
        combine(tables.first[stage, place], seeds[k], x, inside, values, slopes)
        to_slow[k] += dot(slopes, factors)
        to_around, to_near = to_fast[k : k + TAPS], to_steps[k : k + TAPS]
        for n in range(TAPS):
            to_around[n] += values[n]
            to_near[n] += values[TAPS + n]
        if k >= sound:
            continue
        knot, distance = interval_of(q, tables.knots, knot)
        begin, end = rise_between(k, slow)
        rise = (slow[end] - slow[begin]) / (end - begin)
        if negligible(around):
            add_rise(tables.second[stage, knot], seeds[k], distance, rise, to_around)
        else:
            within = tables.knots[0] <= q <= tables.knots[-1]
            combine(tables.second[stage, knot], seeds[k], distance, within, bends, bend_slopes)
            g, by_rate, by_size = gain(q, size_of(around), tables.steady)
            multiply(around, g, rise, products)
            to_gain = dot(bends[:PAIRS], products[:PAIRS]) / g
            to_slow[k] += dot(bend_slopes, products) + to_gain * by_rate
            to_rise = from_products(around, g, rise, bends, to_gain * by_size, to_around)
            to_slow[end] += to_rise / (end - begin)
            to_slow[begin] -= to_rise / (end - begin)
    for k in range(1, len(slow)):
        to_slow[k] += to_steps[BEHIND + k]
        to_slow[k - 1] -= to_steps[BEHIND + k]


@compiled
def add_rise(pieces, weights, x, rise, to_around):
    """Add derivatives with respect to fast changes that are zero, because of the rise."""
    for i in range(FACTORS):
        total = 0.0
        for state in range(STATES):
            n = state * COLUMNS + PAIRS + i
            value = ((pieces[0, n] * x + pieces[1, n]) * x + pieces[2, n]) * x + pieces[3, n]
            total += weights[state] * value
        to_around[NEAR + i] += rise * total


@compiled
def from_products(around, g, rise, to_products, to_size, to_around):
    """Add derivatives with respect to fast changes nearby; returns that for the rise."""
    n, to_rise = 0, 0.0
    for i in range(NEAR, TAPS):
        to_around[i] += rise * to_products[PAIRS + i - NEAR]
        to_rise += around[i] * to_products[PAIRS + i - NEAR]
        for j in range(i, TAPS):
            to_around[i] += g * to_products[n] * around[j]
            to_around[j] += g * to_products[n] * around[i]
            n += 1
    for i in range(FIRST, LAST):
        to_around[i] += to_size * 2.0 * around[i] / (LAST - FIRST)
    return to_rise
