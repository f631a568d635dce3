"""Tables of the local-rate law with loss: ``python tools/loss_tables.py FILE``.

For each law, exponential chains determine the effect of the loss after the impact, within the
chain and at its end; the response to changes of the rate is fitted to random smooth tapers, and the
estimate of the error to others.  About five minutes.
"""

import dataclasses
import sys

import numpy as np
from training.error_fit import quantile_fit

import hertzchain as hc
from hertzchain.theory.loss_table import (
    END,
    INPUTS,
    RATES,
    START,
    LossTable,
    inputs,
    rate_polynomials,
    strength_polynomials,
)
from hertzchain.theory.lossy_law import LAWS, OVERTAKEN, error_parts

# Degrees + 1 of the tables, in the rate and in the strength.
ANCHORS, RESPONSE = (14, 5), (5, 3)
BEADS, LONG = 48, 100
CHAINS, OTHERS = 900, 350
RTOL = 1e-9
# Errors that concern few chains, and are not fitted: by the tail of the pulse, at the largest
# strength, and by rates outside the tables, per strength.
TAIL, OUTSIDE = 0.216, 3.0
# The law that has the response of the one before.
WITHOUT_PULL = "restitution without pull"


def make(name, strength):
    """The law of a name with a strength."""
    law, attractive, _ = LAWS[name]
    if law is hc.UnloadingRatio:
        return law(strength)
    low, high = 0.5, 1.0
    while high - low > 1e-15:
        middle = 0.5 * (low + high)
        weak = law(middle, attractive=attractive).damping_ratio < strength
        low, high = (low, middle) if weak else (middle, high)
    return law(high, attractive=attractive)


def components(pulse):
    """Growth of ln v, and logarithms of overlap and time in units of each bead."""
    v, p = np.log(pulse.velocity), pulse.chain.exponents
    overlap, time = np.log(pulse.peak_overlap), np.log(np.abs(pulse.residence))
    return np.stack([
        np.diff(v), overlap - 2 / (p + 1) * v[:-1], time + (p - 1) / (p + 1) * v[:-1]
    ])  # fmt: skip


def lossy(chain, law):
    """The simulated pulse of a chain with a law."""
    return hc.simulate(chain.replace(loss=law), times=0, rtol=RTOL, check=False).pulse()


def change(chain, law, lossless):
    """Changes of the components by a loss."""
    found = components(lossy(chain, law)) - components(lossless)
    if not np.isfinite(found).all():
        raise hc.SimulationError("the pulse was lost")
    return found


def anchors(name):
    """Series of the effect on exponential chains: after the impact, within, and at the end."""
    low, high = RATES
    largest = LAWS[name][2]
    count, degree = ANCHORS
    rates = 0.5 * (low + high + (high - low) * chebyshev_nodes(count))
    strong = 0.5 * largest * (1.0 + chebyshev_nodes(degree))
    effects = np.empty((count, degree, 3, BEADS - 1))
    for i, rate in enumerate(rates):
        chain = hc.Chain.from_radii(np.exp(rate * np.arange(BEADS)))
        lossless = hc.propagate(chain, rtol=1e-10)
        for j, x in enumerate(strong):
            effects[i, j] = change(chain, make(name, x), lossless) / x
    to_rates = np.linalg.inv(rate_polynomials(rates, count))
    to_strengths = np.linalg.inv(strength_polynomials(strong, largest, degree))
    series = np.einsum("ai,bj,ijck->kcab", to_rates, to_strengths, effects)
    return series[:START], series[-END:] - series[-END - 1]


def chebyshev_nodes(count):
    """Zeros of a Chebyshev polynomial."""
    return np.cos(np.pi * (np.arange(count) + 0.5) / count)


def random_rates(random, contacts):
    """Rates of one random smooth taper: random, ramps, periods, powers, one change."""
    k = np.arange(contacts)
    while True:
        kind = random.integers(6)
        base = random.choice([0.0, 0.01 * random.normal(), random.uniform(-0.08, 0.1)])
        rates = np.full(contacts, base)
        if kind in (0, 1):
            width = random.uniform(6, 35)
            weights = np.exp(-0.5 * (np.arange(-80, 81) / width) ** 2)
            wave = np.convolve(random.normal(size=contacts + 240), weights, "same")
            wave = wave[120 : 120 + contacts]
            rates += size(random, 0.004, 0.08) * wave / np.abs(wave).max()
        elif kind == 2:
            for _ in range(random.integers(1, 4)):
                position = (k - random.integers(-10, contacts)) / size(random, 6, 60)
                rates += sign(random) * size(random, 0.004, 0.08) * np.clip(position, 0.0, 1.0)
        elif kind == 3:
            phase = k / size(random, 25, 200) + random.random()
            rates += size(random, 0.004, 0.06) * np.sin(2.0 * np.pi * phase)
        elif kind == 4:
            slope = size(random, 0.003, 0.12)
            backward = np.log1p(slope / (1.0 + slope * k))
            forward = np.log1p(-1.0 / (size(random, contacts + 12, 10 * contacts) - k))
            rates = backward if random.random() < 0.6 else forward
            rates = rates * (random.uniform(-1.0, 1.5) if random.random() < 0.5 else 1.0)
        else:
            position = (k - random.uniform(0, contacts)) / size(random, 4, 25)
            rates += sign(random) * size(random, 0.004, 0.07) * np.tanh(position)
        inside = rates.min() > RATES[0] and rates.max() < RATES[1] and abs(rates.sum()) < 9.0
        if inside and np.abs(np.diff(rates)).max() < 0.012:
            return rates


def size(random, low, high):
    """A number whose logarithm is uniform."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def sign(random):
    """Plus or minus one."""
    return random.choice((-1.0, 1.0))


def random_changes(name, random, count, lengths):
    """Random tapers with random strengths: strength, rates, velocities without loss, changes."""
    found = []
    while len(found) < count:
        rates = random_rates(random, int(random.choice(lengths)) - 1)
        chain = hc.Chain.from_radii(np.exp(np.concatenate(([0.0], np.cumsum(rates)))))
        lossless = hc.propagate(chain, rtol=1e-10)
        strength = size(random, 0.03, 1.0) * LAWS[name][2]
        changes = change(chain, make(name, strength), lossless)
        found.append((strength, rates, np.log(lossless.velocity), changes))
    return found


def response(table, changes):
    """Fit the response to the velocities along random tapers, and to their contacts."""
    x, rates, effects = (np.array([each[i] for each in changes]) for i in (0, 1, 3))
    rest = effects - table.effect(rates, x)
    polynomials = np.einsum(
        "nka,nb,n->nkab",
        rate_polynomials(rates, RESPONSE[0]),
        strength_polynomials(x, table.largest, RESPONSE[1]),
        x,
    )
    design = np.einsum("nfk,nkab->nkfab", inputs(rates), polynomials)
    design = design.reshape(*rates.shape, -1)
    weights = np.ones(len(x))
    for _ in range(5):
        growth = weighted(design, rest[:, 0], weights, accumulate=True)
        error = np.abs(np.cumsum(rest[:, 0] - design @ growth, axis=1)).max(axis=1)
        # Chains whose pulse is overtaken by its tail do not count.
        weights = np.where(error < 0.1, 1e-3 / (1e-3 + error), 0.0)
    others = [weighted(design, rest[:, c], weights, accumulate=False) for c in (1, 2)]
    return np.array([growth, *others]).reshape(3, INPUTS, *RESPONSE), error


def weighted(design, values, weights, *, accumulate):
    """Least squares of contacts and, if asked for, of sums along the chain."""
    matrix, right = np.zeros(2 * design.shape[-1:]), 0.0
    for sums, factor in ((False, 3.0), (True, 1.0))[: 1 + accumulate]:
        rows, to = (np.cumsum(a, axis=1) if sums else a for a in (design, values))
        scaled = rows * (factor * weights[:, np.newaxis, np.newaxis])
        flat = scaled.reshape(-1, rows.shape[-1])
        matrix = matrix + flat.T @ flat
        right = right + flat.T @ (to * factor * weights[:, np.newaxis]).ravel()
    ridge = 1e-9 * np.trace(matrix) / len(matrix) * np.eye(len(matrix))
    return np.linalg.solve(matrix + ridge, right)


def estimate(table, changes):
    """Constants of the estimated error, from chains that were not used for the response."""
    parts, errors = [], []
    for x, rates, log_velocity, effects in changes:
        decay = np.cumsum(table.effect(rates, x)[0])
        after = log_velocity + np.concatenate(([0.0], decay))
        part, relative = error_parts(rates, x, after)
        before = np.cumprod(relative < OVERTAKEN).astype(bool)
        parts.append(part[:, before].T)
        errors.append(np.abs(np.expm1(decay - np.cumsum(effects[0])))[before])
    part, error = np.concatenate(parts), np.concatenate(errors)
    fixed = np.array([TAIL / table.largest, OUTSIDE])
    constants = np.append(quantile_fit(part[:, :-2], error), fixed)
    estimated = part @ constants
    covered, ratio = np.mean(error <= estimated), np.median(estimated / error)
    print(
        f"covered {covered:.2%}, median ratio of estimate to error {ratio:.1f}, largest of error "
        f"to estimate {np.max(error / estimated):.1f};",
        constants.round(5),
        flush=True,
    )
    return constants


def trained(name, start, end):
    """Response and error constants of a law."""
    blank = np.zeros((3, INPUTS, *RESPONSE))
    table = LossTable(LAWS[name][2], start, end, blank, np.zeros(0))
    found, error = response(table, random_changes(name, np.random.default_rng(14), CHAINS, [LONG]))
    print(name, "response, largest errors of chains: 50, 90, 95, 100%",
          np.quantile(error, (0.5, 0.9, 0.95, 1.0)).round(5), flush=True)  # fmt: skip
    table = dataclasses.replace(table, response=found)
    others = random_changes(name, np.random.default_rng(15), OTHERS, [20, 40, LONG, LONG, 150])
    return {"response": found, "error": estimate(table, others)}


def main(path):
    """Write the tables."""
    stored = {}
    for name in LAWS:
        start, end = anchors(name)
        if name != WITHOUT_PULL:
            # For these losses, it hardly matters whether contacts may pull.
            fitted = trained(name, start, end)
        parts = {"anchors": start, "end": end, **fitted}
        stored |= {f"{name}/{key}": value.astype(np.float32) for key, value in parts.items()}
        stored[f"{name}/largest"] = np.array(LAWS[name][2])
        np.savez_compressed(path, **stored)


if __name__ == "__main__":
    main(sys.argv[1])
