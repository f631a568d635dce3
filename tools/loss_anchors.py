"""Effect of losses on exponential chains, for `loss_tables.py`."""

import numpy as np
from loss_chains import exponential, lossless, sample

from hertzchain.theory.loss_table import END, RATES, START, rate_polynomials, strength_polynomials
from hertzchain.theory.tabulated_losses import LAWS

# Degrees + 1 of the tables, in the rate and in the strength.
RATE_DEGREE, DEGREE = 14, 5
# Beads of the chains, and of those that end before a strength has become small.
BEADS, SHORT = 48, 24
# Weakest loss relative to the strongest, which is twice that of the tables, and their number.
WEAK, LOSSES = 1.5e-3, 40
# Contacts at which the pulse has settled, in the shorter chains for rates of at least FAST.
SETTLED, SETTLED_SHORT, FAST = 30, 14, 0.05
# Smallest rate of the shorter chains at whose end the effect is determined.
ENDS_EARLY = -0.03
# Strength, relative to the largest one, up to which it is fitted, and below which less weight is
# put on it.
FITTED, SMALL = 1.3, 0.02
# Suppression of high degrees within the chain, and at its end.
SMOOTH, SMOOTH_END = 1e-7, 1e-3


def anchors(name):
    """Series of the effect on exponential chains: after the impact, within, and at the end."""
    low, high = RATES
    rates = 0.5 * (low + high + (high - low) * chebyshev_nodes(RATE_DEGREE))
    of_rate = velocity_dependent if LAWS[name].power else constant
    found = [of_rate(name, rate) for rate in rates]
    to_rates = np.linalg.inv(rate_polynomials(rates, RATE_DEGREE))
    return [
        np.einsum("ai,ikcb->kcab", to_rates, np.array(each)) for each in zip(*found, strict=True)
    ]


def chebyshev_nodes(count):
    """Zeros of a Chebyshev polynomial."""
    return np.cos(np.pi * (np.arange(count) + 0.5) / count)


def constant(name, rate):
    """Series in a strength that is the same at all contacts, at the first and last contacts."""
    largest, chain = LAWS[name].largest, exponential(rate, BEADS)
    pulse = lossless(chain)
    strengths = 0.5 * largest * (1.0 + chebyshev_nodes(DEGREE))
    effects = np.array([sample(name, x, chain, pulse).changes / x for x in strengths])
    to_strengths = np.linalg.inv(strength_polynomials(strengths, largest, DEGREE))
    series = np.einsum("bj,jck->kcb", to_strengths, effects)
    return series[:START], series[-END:] - series[-END - 1]


def velocity_dependent(name, rate):
    """Series in a strength that changes along the chain, at the first and last contacts.

    At each contact, different losses have different strengths.  For strengths that do not occur,
    the series is close to that of the next contact.
    """
    largest = LAWS[name].largest
    long, short = (samples(name, rate, beads) for beads in (BEADS, SHORT))
    late = [pairs(long, k) for k in range(SETTLED, BEADS - 1 - END)]
    if rate >= FAST:
        late += [pairs(short, k) for k in range(SETTLED_SHORT, SHORT - 1 - END)]
    settled = series = fit(largest, *joined(late), SMOOTH)
    start = [settled]
    for k in range(START - 1)[::-1]:
        chains = [long, short] if k < SHORT - 1 - END else [long]
        series = fit(largest, *joined([pairs(each, k) for each in chains]), SMOOTH, series)
        start.append(series)
    last = short if rate >= ENDS_EARLY else long
    end = [fit(largest, *pairs(last, k - END), SMOOTH_END, settled) - settled for k in range(END)]
    return np.array(start[::-1]), np.array(end)


def samples(name, rate, beads):
    """Exponential chains with weak to strong losses."""
    chain, largest = exponential(rate, beads), LAWS[name].largest
    pulse = lossless(chain)
    unit = (chain.stiffness / chain.masses[:-1]) ** 0.4 * pulse.velocity[:-1] ** LAWS[name].power
    # The strength is that of the contact at which it is largest.
    rise = unit.max() / unit[0]
    strengths = np.geomspace(2.0 * WEAK * largest, 2.0 * largest * rise, LOSSES)
    return [sample(name, x, chain, pulse) for x in strengths]


def pairs(chains, contact):
    """Strengths at a contact, and effects per strength."""
    x = np.array([each.strength[contact] for each in chains])
    return x, np.array([each.changes[:, contact] for each in chains]) / x[:, np.newaxis]


def joined(found):
    """Pairs of several contacts or chains."""
    return [np.concatenate(each) for each in zip(*found, strict=True)]


def fit(largest, strengths, effects, smooth, start=0.0):
    """Series of effects per strength, the closer to another one the less is known."""
    kept = strengths < FITTED * largest
    x, of = strengths[kept], strength_polynomials(strengths[kept], largest, DEGREE)
    weights = x / (x + SMALL * largest)
    rest = effects[kept] - of @ (np.zeros((DEGREE, 3)) + np.transpose(start))
    scaled = of * weights[:, np.newaxis] ** 2
    penalty = smooth * len(x) * np.diag(np.arange(DEGREE) ** 4.0)
    return start + np.linalg.solve(of.T @ scaled + penalty, scaled.T @ rest).T
