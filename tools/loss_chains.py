"""Random smooth tapers and simulated effects of losses, for `loss_tables.py`."""

import dataclasses

import numpy as np

import hertzchain as hc
from hertzchain.theory.loss_table import RATES
from hertzchain.theory.tabulated_losses import LAWS

RTOL = 1e-9
# Strengths of the losses of random chains, relative to the largest one.
WEAKEST = 0.02


@dataclasses.dataclass(frozen=True)
class Sample:
    """A random taper with a loss: coefficients and strengths of the loss, and its effect."""

    rates: np.ndarray
    coefficients: np.ndarray
    strength: np.ndarray
    log_velocity: np.ndarray
    changes: np.ndarray


def exponential(rate, beads):
    """An exponential chain."""
    return hc.Chain.from_radii(np.exp(rate * np.arange(beads)))


def lossless(chain):
    """The pulse of a chain without loss."""
    return hc.propagate(chain, rtol=1e-10)


def weakened(name, strength, chain, pulse):
    """The law of a name whose largest strength for a lossless pulse is given."""
    tabulated = LAWS[name]
    if tabulated.kind is hc.UnloadingRatio:
        return hc.UnloadingRatio(strength)
    if tabulated.kind is hc.Viscoelastic:
        unit = tabulated.coefficients(hc.Viscoelastic(1.0), chain)
        return hc.Viscoelastic(strength / (unit * pulse.velocity[:-1] ** tabulated.power).max())
    low, high = 0.5, 1.0
    while high - low > 1e-15:
        middle = 0.5 * (low + high)
        weak = hc.Restitution(middle, attractive=tabulated.attractive).damping_ratio < strength
        low, high = (low, middle) if weak else (middle, high)
    return hc.Restitution(high, attractive=tabulated.attractive)


def components(pulse):
    """Growth of ln v, and logarithms of overlap and time in units of each bead."""
    v, p = np.log(pulse.velocity), pulse.chain.exponents
    overlap, time = np.log(pulse.peak_overlap), np.log(np.abs(pulse.residence))
    return np.stack([
        np.diff(v), overlap - 2 / (p + 1) * v[:-1], time + (p - 1) / (p + 1) * v[:-1]
    ])  # fmt: skip


def sample(name, strength, chain, pulse):
    """Effect of a loss on a chain, whose lossless pulse is given."""
    law = weakened(name, strength, chain, pulse)
    lossy = hc.simulate(chain.replace(loss=law), times=0, rtol=RTOL, check=False).pulse()
    changes = components(lossy) - components(pulse)
    if not np.isfinite(changes).all():
        raise hc.SimulationError("the pulse was lost")
    coefficients = LAWS[name].coefficients(law, chain)
    reached = coefficients * lossy.velocity[:-1] ** LAWS[name].power
    rates = np.diff(np.log(chain.radii))
    return Sample(rates, coefficients, reached, np.log(pulse.velocity), changes)


def random_samples(name, random, count, beads):
    """Samples of random tapers with random strengths, up to that of the tables."""
    found, largest = [], LAWS[name].largest
    # The strength of a loss that depends on the velocity decays with it.
    strongest = 1.2 if LAWS[name].power else 1.0
    while len(found) < count:
        rates = random_rates(random, beads - 1)
        chain = hc.Chain.from_radii(np.exp(np.concatenate(([0.0], np.cumsum(rates)))))
        strength = size(random, WEAKEST, strongest) * largest
        each = sample(name, strength, chain, lossless(chain))
        if each.strength.max() <= largest:
            found.append(each)
    return found


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
