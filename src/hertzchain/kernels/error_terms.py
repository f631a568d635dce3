"""Terms of the estimated error of the local-rate law.

The logarithm of a velocity is the sum of the growth at all contacts before, and so is its error.
Each term is a size of errors that were observed on random chains (`tools/training`), which also
determine its constant.
"""

from __future__ import annotations

import numpy as np

from .fast_changes import AHEAD, BACKWARD, BEHIND, END, HALF, LARGE, TAPS, compiled, size_of

# Terms of `hertzchain.kernels.local_rate.forward`, and all of them.
SLOW_PARTS, PARTS = 4, 16
# Contacts from which on the state of the recursion counts, and from which on the pulse has
# forgotten the impact.  The first contacts have functions of their own, which are more accurate.
RECURSIVE, SETTLED = 12, 24
# Weight of the higher orders of large changes there, and of steep forward tapers.
FIRST, MORE_ACCURATE, LARGE_START, LONGER = 2, 0.15, 600.0, 0.09
# Relative growth of these errors per contact, and the contact from which on they grow.
ADDED, SUMMED = 0.14, 6
# Part of the square of an early error that strong backward tapers keep, up to a rate.
PERSISTENT, PERSISTENT_UP_TO = 0.1, 0.25
# First contacts, whose slow rates follow the rates closely, and whose products of fast changes are
# those within the chain, but should not be: there, squares of the curvature of the rates count.
EARLY, UNKNOWN = 6, 0.45
# Error of the tabulated effect of alternating rates, relative to that of the third order, and
# square of amplitudes beyond which it grows no more.
TABULATED, LARGE_KNOWN = 2.5e-4, 1e-3
# Part of the slow changes that is not in doubt if rates alternate about 0.
REGULAR_SLOW = 0.955
# Part of alternating fast changes that is not in doubt, and weights of changes of this part, as the
# effect is known where the rates have alternated for some contacts, and of those of the slow rate.
EXACT, TRANSITION, CHANGING = 0.995, 4.0, 3.6
# Additional weight of fast changes where the slow rate changes at the first contacts of backward
# tapers, because the products of both are those within the chain, and rate at which it is half.
OF_START, BACKWARD_START = 9.0, 0.05
# Decay per contact of errors that do not accumulate, and weights of changes out of sight, and of
# changes of the slow rate one and two contacts ahead.
FADING, OF_AHEAD, OF_NEXT, OF_SECOND = 0.75, 0.8, 0.5, 0.1
# Error of the interpolation in tapers, relative to the error near the rate 0, and number of
# contacts after which it has doubled.
INTERPOLATED, DOUBLING = 0.042, 60.0
# Error near the rate 0 if the rate is constant, what large changes of the rate add to it, and the
# change that adds half of this.
OF_CONSTANT, OF_CHANGES, SATURATED = 0.4, 1.1, 0.007
# Overlap of impact and free end in equal beads.
OF_EQUAL = 0.05
# The same for the difference between the largest and the smallest rate: its weight, that of its
# first power, the error of the interpolation for constant rates, and the larger weight in forward
# tapers.
OF_SPREAD, LEAST, INTERPOLATED_END, STEEPER = 1.8, 0.015, 0.003, 1.5
# Larger weight of changes in backward tapers, where products of fast changes are less well known.
LESS_KNOWN = 1.5
# Weights of higher orders of large changes, and of fast changes that are much larger.
LARGE_CHANGE, BEYOND = 40.0, 2.5
# Error of the interpolation at the last contacts, and weight of the third power of a change of the
# rate at the last one.
ENDING, STEEP_END = 2e-7, 1200.0
# Rates near the free end below which the last two and four beads may lose their first maximum, and
# rate below which all beads beyond may: in exponential chains, their velocities jump by 9% between
# -0.1615 and -0.162.  Within the ramp below each of these rates, the error becomes unknown.
TWO_LOST, FOUR_LOST, ALL_LOST, RAMP = -0.1235, -0.149, -0.161, 0.0015
# Difference between the largest and the smallest rate beyond which the last bead may lose it, too.
NOT_CONSTANT = 1e-3
# Rates below which a pulse leaves a train of waves behind, and above which these overtake it.
TRAIN, CATCHING = -0.13, -0.05


@compiled
def memory(rate, scale):
    """Weight of errors that the pulse forgets at once in strong backward tapers."""
    return 1.0 / (1.0 + (max(rate, 0.0) / scale) ** 4)


@compiled
def steepness(rate):
    """Excess of a forward taper's rate, in units in which 4 is the end of the tables."""
    return max(-0.08 - rate, 0.0) / 0.02


@compiled
def slow_weight(rate):
    """Weight of deviations: near the rate 0, the first order is smoothed, beyond it is exact."""
    ratio = (max(rate, 0.0) / 0.075) ** 4
    return (1.0 + 0.15 * steepness(rate) ** 2) / (1.0 + ratio * ratio)


@compiled
def rate_of(contact, slow, fast):
    """Sum of both parts of a rate."""
    return slow[contact] + fast[BEHIND + contact]


@compiled
def curvatures(contact, slow, fast):
    """Sum of squares of the second differences of the rates that affect an early contact."""
    total = 0.0
    for k in range(max(contact, 1), min(contact + HALF, len(slow) - 1)):
        change = rate_of(k - 1, slow, fast) - 2.0 * rate_of(k, slow, fast)
        total += (change + rate_of(k + 1, slow, fast)) ** 2
    return total


@compiled
def change_of_base(contact, slow, fast):
    """Change per contact of a rate about which the rates alternate."""
    if contact < 2:
        return 0.0
    return 0.5 * (rate_of(contact, slow, fast) - rate_of(contact - 2, slow, fast))


@compiled
def change_of_regular(contact, slow, fast, regular, known):
    """Square of changes of an alternation whose effect is tabulated, and of its mean rate."""
    if contact < 1:
        return 0.0
    transition = TRANSITION * (regular[contact, 1] - regular[contact - 1, 1])
    changing = CHANGING * change_of_base(contact, slow, fast)
    return transition * transition + known * changing * changing


@compiled
def kinks(rate):
    """Weight of changes near the free end, where the state of steep forward tapers has kinks."""
    return 1.0 + 100.0 * (max(-0.1 - rate, 0.0) / 0.03) ** 2


@compiled
def start_size(contact, rate, square):
    """Size of slow changes at the first contacts, from their square."""
    # Forward tapers remember them longer.
    steep = (max(-rate, 0.0) / 0.04) ** 2
    forward = 1.0 + steep + LONGER * (4 + contact) * steep * steep
    remembered = PERSISTENT * memory(rate, PERSISTENT_UP_TO)
    remembered += (1.0 - PERSISTENT) * memory(rate, 0.07)
    # Near the rate 0, the first order is smoothed, and its slope is not that of the simulation.
    smoothed = 1.0 + 2.5 / (1.0 + ((rate - 0.01) / 0.01) ** 4)
    return square * (1.0 + LARGE_START * square) * forward * remembered * smoothed


@compiled
def start_weight(contact):
    """Weight of changes at the first contacts: their errors add up along the chain."""
    if contact < FIRST:
        return MORE_ACCURATE
    return 1.0 + ADDED * max(contact - SUMMED, 0) if contact < RECURSIVE else 1.0


@compiled
def of_exponential(contact, rate, spread):
    """Error where the rate changes slowly by ``spread``, besides that of the first contacts."""
    excess = steepness(rate)
    value = 0.15 * excess**2 * (1.0 + (excess / 2.4) ** 5)
    beyond = (max(rate, 0.0) / 0.32) ** 4
    accumulated = 1.0 + contact / DOUBLING
    value += INTERPOLATED * accumulated * (1.0 - memory(rate, 0.24)) / (1.0 + beyond * beyond)
    value += 0.5 * INTERPOLATED * min(1.0, (max(-0.05 - rate, 0.0) / 0.02) ** 2)
    if contact < RECURSIVE:
        return value
    # Near the rate 0, the law's first order is smoothed.
    constant = OF_CONSTANT * memory(rate, 0.015)
    constant += (1.0 - OF_CONSTANT) * min(1.0, (max(-rate, 0.0) / 0.04) ** 2)
    return value + constant + OF_CHANGES * spread / (spread + SATURATED) * memory(rate, 0.04)


@compiled
def step_square(contact, slow):
    """Square of the change of the slow rate at a contact, if it is known."""
    if not 0 < contact < len(slow):
        return 0.0
    return (slow[contact] - slow[contact - 1]) ** 2


@compiled
def size_ahead(contact, fast):
    """Sum of squares of the fast changes that a contact sees through its slow rate alone."""
    # The filter is wider than the response, whose first order is exact only up to `AHEAD`.
    total = 0.0
    for i in range(contact + BEHIND + AHEAD, min(contact + BEHIND + HALF + 1, len(fast))):
        total += fast[i] * fast[i]
    return total


@compiled
def doubt_below(rate, start):
    """Doubt about maxima that may be lost below a rate: 0 above it, 1 if it is total."""
    return min(1.0, max(0.0, (start - rate) / RAMP) ** 2)


@compiled
def lost_maximum(contacts, contact, slow, spread):
    """Doubt about the beads at the free end, whose first maximum may be lost; 1 if it is total."""
    # The velocity is then another by up to 25%, or correct: the two cases alternate many times
    # between the rates -0.13 and -0.16, and depend on the length of the chain.
    left = contacts - contact
    if left > 4:
        return 0.0
    lowest = 0.0
    for k in range(max(contact - 3, 0), len(slow)):
        lowest = min(lowest, slow[k])
    doubt = doubt_below(lowest, TWO_LOST if left <= 2 else FOUR_LOST)
    if left == 1 and lowest > FOUR_LOST:
        # In exponential chains, the state of the last bead is tabulated.
        doubt *= min(1.0, spread / NOT_CONSTANT)
    return doubt


@compiled
def train_behind(rate, train):
    """Length of the part of the chain in which the pulse left a train of waves behind."""
    return train + max(TRAIN - rate, 0.0) / 0.1


@compiled
def overlap(contacts, contact, ending, mean_size, mean, lowest, spread):
    """Effect of the impact on the free end of a short chain."""
    if contact >= ending:
        # The effect is known for rates that are constant or change linearly.
        forward = 1.0 + STEEPER * min(1.0, max(-0.015 - lowest, 0.0) / 0.03)
        size = (INTERPOLATED_END + spread) * (LEAST + spread)
        return OF_SPREAD * forward * np.exp(-0.4 * contacts) * size
    if contacts - contact > END:
        return 0.0
    # Nearly all of it on the last bead.
    share = 1.0 if contact == contacts - 1 else 0.015
    size = np.exp(-0.25 * contacts) * mean_size + OF_EQUAL * np.exp(-0.55 * contacts)
    return share * np.exp(-60.0 * max(mean, 0.0)) * size


# ending: first of the contacts with functions of their own, which forget the rates after the impact
# doubts: (followed, 4), of `hertzchain.kernels.local_rate.forward`
# regular: (followed, 2), of `hertzchain.kernels.alternation.add_alternation`
# parts: (followed, 16), result.  With the size a of fast changes, the slow rate q, its change b,
#   and weights that decrease in strong backward tapers: one; the largest error of an exponential
#   chain; the doubts; sums of bounded a^3 and of a^2 |q|, root of the sum of a^2 b^2; the sum of
#   a^2 + b^2 fading along the chain, with `size_ahead` and `curvatures`, and the same in steep
#   forward tapers; a constant with b^2, a^2 and `overlap` near the free end; `lost_maximum` and
#   waves that overtake the pulse; the sum of squares of alternating b that strong backward tapers
#   leave to the slow rates.  Nearly all of a^2 is omitted where rates alternate
@compiled
def write_parts(contacts, ending, slow, fast, doubts, regular, parts):
    """Write the terms of the estimated error of the velocity behind each contact."""
    exponential, third, tapered, mixed, faded, steep = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    train, overtaken, mean, mean_size, weight = 0.0, 0.0, 0.0, 0.0, 0.0
    before, jagged, slope = 0.0, 0.0, 0.0
    lowest, highest = slow[0], slow[0]
    for k in range(len(parts)):
        q, all_of_it = slow[k], size_of(fast[k : k + TAPS])
        doubted = 1.0 - EXACT * regular[k, 0]
        size = doubted * all_of_it
        step = slow[k] - slow[k - 1] if k > 0 else 0.0
        forgotten = memory(q, 0.2)
        lowest, highest = min(lowest, q), max(highest, q)
        spread = highest - lowest
        exponential = max(exponential, of_exponential(k, q, spread))
        third += size * (np.sqrt(size) / (1.0 + size / LARGE) + BEYOND * size)
        known = all_of_it - size
        third += TABULATED * known / (1.0 + known / LARGE_KNOWN)
        # Errors of the attenuation by periodic changes have the same sign at all contacts.
        remembered = memory(q, BACKWARD)
        tapered += size * abs(q) * memory(q, 0.11)
        jagged += (1.0 - remembered) * max(-step * before, 0.0)
        before = step
        of_regular = change_of_regular(k, slow, fast, regular, all_of_it - size)
        backward = 1.0 - memory(q, BACKWARD_START) if k < RECURSIVE else 0.0
        of_steps = (1.0 + OF_START * backward) * size * step * step * doubted
        mixed += (of_steps + of_regular) * forgotten
        steps = step * step + OF_NEXT * step_square(k + 1, slow)
        both = size + doubted * steps * (MORE_ACCURATE if k < FIRST else 1.0)
        if k < EARLY:
            both += UNKNOWN * doubted * curvatures(k, slow, fast)
        both *= 1.0 + LARGE_CHANGE * both
        doubtful = (max(-0.11 - q, 0.0) / 0.01) ** 2
        ahead = OF_AHEAD * size_ahead(k, fast) + OF_SECOND * step_square(k + 2, slow)
        ahead *= doubted
        recent = forgotten * (1.0 + LESS_KNOWN * (1.0 - memory(q, 0.05)))
        faded = FADING * faded + both * recent
        steep = FADING * steep + both * doubtful
        # At the free end, the slow rates of alternating rates change, too.
        slope = FADING * slope + (1.0 - FADING) * doubted * step
        mean, mean_size = FADING * mean + q, FADING * mean_size + abs(q)
        weight = FADING * weight + 1.0
        train = train_behind(q, train)
        if q > CATCHING:
            overtaken = max(overtaken, 0.05 * min(1.0, train * train))
        at_end = contacts - k <= END
        regular_slow = EXACT if at_end else REGULAR_SLOW
        alternating = regular_slow * regular[k, 0] / (1.0 + (q / 0.02) ** 4)
        parts[k, 0], parts[k, 1] = 1.0, exponential
        for i in range(SLOW_PARTS):
            parts[k, 2 + i] = doubts[k, i] * (1.0 - alternating)
        parts[k, 6], parts[k, 7], parts[k, 8] = third, tapered, np.sqrt(mixed)
        parts[k, 9], parts[k, 10] = faded + ahead * recent, steep + ahead * doubtful
        parts[k, 11] = ENDING + doubted * step * step * kinks(q) if at_end else 0.0
        if k == contacts - 1:
            parts[k, 11] += STEEP_END * abs(slope) ** 3
        parts[k, 12] = size if at_end else 0.0
        average, size_of_it = mean / weight, mean_size / weight
        parts[k, 13] = overlap(contacts, k, ending, size_of_it, average, lowest, spread)
        lost = lost_maximum(contacts, k, slow, spread) + doubt_below(lowest, ALL_LOST)
        parts[k, 14], parts[k, 15] = lost + overtaken, jagged
