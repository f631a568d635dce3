"""Random chains of many classes, on which the error estimate is calibrated."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from hertzchain.collision import Array
from hertzchain.theory.exponents import scaled

from .training_chains import (
    HIGHEST,
    LONGEST,
    LOWEST_RANDOM,
    odd_rates,
    random_rates,
    random_sign,
    random_size,
    steep_rates,
)  # fmt: skip

Random = np.random.Generator


def exponential(random: Random, contacts: int) -> Array:
    """Constant rate, often near 0."""
    rate = random.uniform(-0.13, 0.35) if random.random() < 0.6 else 0.03 * random.normal()
    return np.full(contacts, rate)


def linear(random: Random, contacts: int) -> Array:
    """Radii that grow or shrink by the same amount from bead to bead."""
    beads = np.arange(contacts + 1)
    growth = random_size(random, 1e-3, 2.0)
    if random.random() < 0.4:
        growth = -random.uniform(0.3, 0.98) * min(growth, 1.0) / contacts
    return np.diff(np.log1p(growth * beads))


def power(random: Random, contacts: int) -> Array:
    """Radii that follow a power of the distance from a point in front of the chain."""
    distance = np.arange(contacts + 1) + random_size(random, 0.5, 40.0)
    return np.diff(random.uniform(-1.2, 1.5) * np.log(distance))


def waves(random: Random, contacts: int) -> Array:
    """Rates that oscillate, with periods from 9 beads on, or change quickly over a few beads."""
    k = np.arange(contacts)
    rates = random.choice((0.0, 0.03)) * random.normal() + np.zeros(contacts)
    for largest, longest in ((0.14, 60.0), (0.05, 80.0)):
        cycles = k / random_size(random, 9.0, longest) + random.random()
        rates += random_size(random, 0.005, largest) * np.sin(2.0 * np.pi * cycles)
        if random.random() < 0.5:
            break
    if random.random() < 0.3:
        position = (k - random.integers(contacts)) / random_size(random, 3.0, 25.0)
        rates += random_sign(random) * random_size(random, 0.01, 0.1) * np.clip(position, 0.0, 1.0)
    return rates


def short(random: Random, contacts: int) -> Array:
    """Few beads: ramps, waves and scattered knots of the rate, some of them with odd radii."""
    contacts = 8 + contacts % 16
    k, kind = np.arange(contacts), random.integers(4)
    if kind == 0:
        rates = np.linspace(*random.uniform(-0.14, 0.2, 2), contacts)
    elif kind == 1:
        rates = np.full(contacts, random.uniform(-0.13, 0.2))
    elif kind == 2:
        cycles = k / random_size(random, 10.0, 80.0) + random.random()
        rates = random_size(random, 0.004, 0.08) * np.sin(2.0 * np.pi * cycles)
        rates += random.choice((0.0, 1.0)) * random.uniform(-0.08, 0.1)
    else:
        knots = random.uniform(-0.1, 0.1, random.integers(3, 5)) * random.random()
        rates = np.interp(k, np.linspace(0, contacts - 1, len(knots)), knots)
    if random.random() < 0.3:
        odd = random.normal(size=contacts + 1) * (random.random(contacts + 1) < 0.4)
        rates = rates + random_size(random, 3e-4, 0.02) * np.diff(odd)
    return rates


def periodic(random: Random, beads: int) -> Array:
    """Every second to fifth bead is another."""
    every = np.arange(beads) % random.integers(2, 6) == random.integers(2)
    return np.asarray(random_sign(random) * random_size(random, 2e-3, 0.6) * every)


def scatter(random: Random, beads: int) -> Array:
    """Random radii."""
    return random_size(random, 5e-4, 0.03) * random.normal(size=beads)


def single(random: Random, beads: int) -> Array:
    """One odd bead, or one step."""
    place, bead = random.integers(1, beads), np.arange(beads)
    if random.random() < 0.5:
        return np.asarray(0.25 * random.normal() * (bead == place))
    return np.asarray(0.15 * random.normal() * (bead >= place))


TAPERS: Final = (exponential, linear, power, waves, short)
CHANGES: Final = (periodic, scatter, single)


def changed(random: Random, change: Callable[[Random, int], Array], shrink: float) -> Array:
    """Equal beads, or an exponential chain, whose radii are changed."""
    base = 0.0 if random.random() < 0.6 else random.uniform(-0.1 * shrink, 0.15)
    return base + np.diff(change(random, int(random_size(random, 9.0, 150.0))))


def gentle(random: Random, taper: Callable[[Random, int], Array], shrink: float) -> Array:
    """A taper within the range of the law."""
    while True:
        rates = scaled(taper(random, int(random_size(random, 8.0, 150.0))), shrink)
        if shrink * LOWEST_RANDOM < rates.min() and rates.max() < HIGHEST:
            return rates


def estimate_chains(random: Random, count: int, shrink: float = 1.0) -> list[list[Array]]:
    """Rates of chains of twelve classes, with so many chains each."""
    lengths = [int(random_size(random, 8.0, 200.0)) for _ in range(count)]
    found = [
        [random_rates(random, 1, n, smooth=False, shrink=shrink)[0] for n in lengths],
        [random_rates(random, 1, n, smooth=True, shrink=shrink)[0] for n in lengths],
        [odd_rates(random, 1, n, shrink)[0] for n in lengths],
        [steep_rates(random, 1, n, shrink)[0] for n in lengths],
    ]
    for make, kinds in ((gentle, TAPERS), (changed, CHANGES)):
        for kind in kinds:
            chains: list[Array] = []
            while len(chains) < count:
                rates = make(random, kind, shrink)
                if abs(rates.sum()) < LONGEST:
                    chains.append(rates)
            found.append(chains)
    return found
