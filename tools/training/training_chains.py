"""Chains for fitting the law, and their simulated pulses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.ndimage import gaussian_filter1d

from hertzchain.chain.chain import Chain
from hertzchain.collision import Array
from hertzchain.errors import SimulationError
from hertzchain.propagation.propagate import propagate_many
from hertzchain.theory.exponents import scaled
from hertzchain.theory.universal_functions import state

# Below the lowest rate, pulses in forward tapers have several maxima; above the highest, the BCA
# differs by a constant.  Nodes of the tables of exponential chains are dense where these curve,
# above all around 0, where the state has a term |s|^(5/2).
LOWEST: Final = -0.165
HIGHEST: Final = 1.1
COARSE_NODES: Final = np.unique(
    np.round([*np.linspace(LOWEST, 0.15, 43), *np.linspace(0.15, HIGHEST, 30)], 4)
)
NEAR_ZERO: Final = (0.0005, 0.001, 0.002, 0.0035, 0.005)
NODES: Final = np.union1d(COARSE_NODES, [*NEAR_ZERO, *np.negative(NEAR_ZERO)])
BEADS: Final = 64
# The strongest backward ramps amplify rounding errors and require the second tolerance; random
# chains are simulated with the smallest one that is possible.
RTOLS: Final = (1e-8, 1e-7)
FINE_RTOLS: Final = (1e-10, 1e-9, *RTOLS)
# Range of random rates, and largest logarithm of the ratio of the last to the first radius.
LOWEST_RANDOM: Final = -0.15
LONGEST: Final = 12.0
# Changes of the rate along a ramp, numbers of contacts over which it changes, and contacts
# (counted from 0) at which the change begins.
CHANGES: Final = (0.005, 0.02, 0.05, 0.1, 0.2, 0.4)
LENGTHS: Final = (1, 2, 3, 5, 9, 17, 33, 58)
BEGINNINGS: Final = (0, 2, 5, 12, 22, 30)
EARLY_LENGTHS: Final = (1, 2, 3, 5, 9, 17)
EARLY_BEGINNINGS: Final = (0, 1, 2, 3, 4)
EARLY_CONTACTS: Final = 24
DOUBLE_RAMPS: Final = 3000


@dataclass(frozen=True, eq=False)
class Sample:
    """Rates of chains of the same length, and states of their pulses.

    Attributes
    ----------
    rates : ndarray, shape (C, M)
        Rates of the contacts.
    states : ndarray, shape (C, M, 3)
        States of the contacts.
    """

    rates: Array
    states: Array

    def part(self, rows: Array | slice) -> Sample:
        """Some of the chains, by index or mask."""
        return Sample(self.rates[rows], self.states[rows])

    def first(self, contacts: int) -> Sample:
        """The first contacts of all chains."""
        return Sample(self.rates[:, :contacts], self.states[:, :contacts])


def join_samples(samples: Sequence[Sample]) -> Sample:
    """Concatenate samples."""
    return Sample(
        np.concatenate([sample.rates for sample in samples]),
        np.concatenate([sample.states for sample in samples]),
    )


def exponential_rates(shrink: float = 1.0) -> Array:
    """Rates of the exponential chains, shape (nodes, contacts)."""
    return np.repeat(scaled(NODES, shrink)[:, None], BEADS - 1, axis=1)


def ramp_rates(beginnings: Array, shrink: float = 1.0, *, early: bool = False) -> Array:
    """Rates of ramps, which change linearly over several contacts and are constant otherwise.

    Early ramps are those of short chains, for the first contacts.
    """
    contact = np.arange(EARLY_CONTACTS if early else BEADS - 1)
    lengths, first = (EARLY_LENGTHS, EARLY_BEGINNINGS) if early else (LENGTHS, BEGINNINGS)
    ramps = []
    for start in beginnings:
        for change in (*CHANGES, *(-change for change in CHANGES)):
            end = start + change
            steep = abs(change) > 0.15 and min(start, end) < -0.1
            if not LOWEST <= end <= HIGHEST or steep:
                continue
            for length in lengths:
                for begin in first:
                    if begin + length <= len(contact) - 3:
                        # A ramp from contact 0 over one contact would be constant.
                        position = (contact - begin) / length if begin or length > 1 else contact
                        ramps.append(start + change * np.clip(position, 0.0, 1.0))
    return scaled(np.array(ramps), shrink)


def double_ramp_rates(random: np.random.Generator, count: int, shrink: float = 1.0) -> Array:
    """Rates of ramps with two changes close to each other."""
    contact = np.arange(BEADS - 1)
    ramps: list[Array] = []
    while len(ramps) < count:
        rates = np.full(BEADS - 1, random.uniform(LOWEST, 0.5))
        first = int(random.choice((0, 1, 3, 8, 16, 24)))
        for _ in range(2):
            length = int(random.choice((5, 6, 8, 12, 18, 30)))
            change = random_sign(random) * random_size(random, 0.003, 0.2)
            rates += change * np.clip((contact - first) / length, 0.0, 1.0)
            first += length + int(random.choice((0, 0, 2, 5)))
        if rates.min() >= LOWEST and rates.max() <= HIGHEST:
            ramps.append(rates)
    return scaled(np.array(ramps), shrink)


def gentle(rates: Array) -> Array:
    """Whether the rates change as slow rates do: over five contacts, or in backward tapers."""
    changes = np.count_nonzero(np.abs(np.diff(rates, axis=1)) > 1e-12, axis=1)
    return (changes >= 5) | (rates.min(axis=1) > 0.05)


def random_rates(
    random: np.random.Generator, count: int, contacts: int, *, smooth: bool, shrink: float = 1.0
) -> list[Array]:
    """Rates of random chains: slow changes, ramps and kinks, also near both ends.

    Unless smooth, chains also have random, periodic or single odd radii.
    """
    k = np.arange(contacts)
    lowest = shrink * LOWEST_RANDOM
    found: list[Array] = []
    while len(found) < count:
        near_zero = random.random() < 0.4
        base = 0.02 * random.normal() if near_zero else random.uniform(-0.13 * shrink, 0.2)
        rates = np.full(contacts, base)
        if random.random() < 0.15:
            # Radii grow like a power of the distance, which begins with large rates.
            rates = random.uniform(0.3, 1.5) * np.log1p(1.0 / (k + random_size(random, 0.7, 20.0)))
        chosen = random.random(5) < (
            (0.7, 0.6, 0.0, 0.0, 0.0) if smooth else (0.5, 0.4, 0.5, 0.25, 0.15)
        )
        if chosen[0]:
            period = random_size(random, 50.0 if smooth else 8.0, 200.0)
            rates += (
                random_sign(random)
                * random_size(random, 0.003, 0.08)
                * np.sin(2.0 * np.pi * (k / period + random.random()))
            )
        if chosen[1]:
            for _ in range(random.integers(1, 4)):
                length = random.choice((9, 20, 40) if smooth else (1, 1, 2, 4, 9, 20))
                position = (k - random.integers(-5, contacts)) / length
                change = random_sign(random) * random_size(random, 0.003, 0.1)
                rates += change * np.clip(position, 0.0, 1.0)
        if chosen[2]:
            rates += np.diff(random_size(random, 5e-4, 0.02) * random.normal(size=contacts + 1))
        if chosen[3]:
            # Bead by bead, or every third to fifth bead is odd.
            odd = np.arange(contacts + 1) % random.choice((2, 2, 2, 3, 4, 5)) == 0
            rates += (
                random_sign(random) * random_size(random, 1e-3, 0.08) * np.diff(odd.astype(float))
            )
        if chosen[4]:
            odd = random.random(contacts + 1) < random.choice((1.0, 3.0)) / contacts
            rates += (
                random_sign(random) * random_size(random, 3e-3, 0.1) * np.diff(odd.astype(float))
            )
        gentle = rates.min() > lowest and rates.max() < HIGHEST and abs(rates.sum()) < LONGEST
        if chosen.any() and gentle:
            found.append(rates)
    return found


def odd_rates(
    random: np.random.Generator, count: int, contacts: int, shrink: float = 1.0
) -> list[Array]:
    """Rates of equal beads, or of an exponential chain, of which some are odd."""
    found: list[Array] = []
    while len(found) < count:
        equal = random.random() < 0.5
        base = 0.0 if equal else random.uniform(-0.1 * shrink, 0.1)
        kind, beads = random.integers(4), np.arange(contacts + 1)
        if kind == 0:
            odd = random_size(random, 3e-4, 0.02) * random.normal(size=contacts + 1)
        elif kind == 1:
            odd = (
                random_sign(random)
                * random_size(random, 3e-3, 0.15)
                * (beads == random.choice(beads))
            )
        elif kind == 2:
            every = beads % random.choice((2, 2, 3, 4)) == 1
            odd = random_sign(random) * random_size(random, 3e-4, 0.1) * every
        else:
            odd = (
                random_sign(random)
                * random_size(random, 3e-3, 0.1)
                * (beads >= random.choice(beads))
            )
        rates = base + np.diff(odd)
        if rates.min() > LOWEST * shrink and abs(rates.sum()) < LONGEST:
            found.append(rates)
    return found


def steep_rates(
    random: np.random.Generator, count: int, contacts: int, shrink: float = 1.0
) -> list[Array]:
    """Rates of ramps, often steep ones, with a small change: periodic, single or random radii."""
    k, beads = np.arange(contacts), np.arange(contacts + 1)
    found: list[Array] = []
    while len(found) < count:
        low, high = -0.14 * shrink, 0.2
        ends = random.uniform(low, high, 2) if random.random() < 0.5 else random.uniform(low, 0.1)
        rates = np.broadcast_to(ends, 2) @ [1.0 - k / contacts, k / contacts]
        kind = random.integers(5)
        if kind == 0:
            odd = beads % random.integers(2, 6) == random.integers(2)
        elif kind == 1:
            odd = beads >= random.choice(beads)
        elif kind == 2:
            odd = beads == random.choice(beads)
        elif kind == 3:
            odd = random.normal(size=contacts + 1) * (abs(beads - random.choice(beads)) < 3)
        else:
            odd = np.maximum(beads - random.choice(beads), 0)
        rates = rates + random_sign(random) * random_size(random, 1e-4, 0.04) * np.diff(
            odd.astype(float)
        )
        if rates.min() > shrink * LOWEST_RANDOM and abs(rates.sum()) < LONGEST:
            found.append(rates)
    return found


def ending_rates(random: np.random.Generator, count: int, shrink: float = 1.0) -> list[Array]:
    """Rates of chains of 30 to 55 contacts that change slowly towards the free end.

    Half of them have some odd radii, too.
    """
    found: list[Array] = []
    while len(found) < count:
        contacts = int(random.integers(30, 56))
        k, left = np.arange(contacts), np.arange(contacts)[::-1]
        near_zero = random.random() < 0.4
        base = 0.02 * random.normal() if near_zero else random.uniform(-0.13 * shrink, 0.2)
        kind = random.integers(4)
        if kind == 0:
            shape = random_size(random, 3e-4, 0.015) * np.clip(left, 0, random.integers(3, 40))
        else:
            if kind == 1:
                shape = np.sin(
                    2.0 * np.pi * (k / random_size(random, 20.0, 150.0) + random.random())
                )
            elif kind == 2:
                white = random.normal(size=contacts + 120)
                shape = gaussian_filter1d(white, random_size(random, 4.0, 25.0))[60 : 60 + contacts]
            else:
                shape = np.exp(-left / random_size(random, 2.0, 20.0))
            shape *= random_size(random, 0.003, 0.08) / np.abs(shape).max()
        rates = base + random_sign(random) * shape
        if random.random() < 0.5:
            size, odd = random_size(random, 2e-4, 0.01), random.normal(size=contacts + 1)
            rates += np.diff(size * np.where(random.random(contacts + 1) < 0.5, odd, 0.0))
        gentle = rates.min() > shrink * LOWEST_RANDOM and rates.max() < 0.5
        if gentle and abs(rates.sum()) < LONGEST:
            found.append(rates)
    return found


def starting_rates(
    random: np.random.Generator, count: int, contacts: int, shrink: float = 1.0
) -> list[Array]:
    """Rates that change quickly behind the impact and become constant, some with odd radii."""
    k = np.arange(contacts)
    found: list[Array] = []
    while len(found) < count:
        base = 0.01 * random.normal() if random.random() < 0.4 else random.uniform(-0.12, 0.12)
        if random.random() < 0.5:
            # Radii that follow a power of the distance from a point in front of the chain.
            shape = np.log1p(1.0 / (k + random_size(random, 0.8, 12.0)))
            rates = base + random.uniform(-0.4, 1.6) * shape
        else:
            size = random_sign(random) * random_size(random, 0.01, 0.4)
            rates = base + size * np.exp(-k / random_size(random, 1.0, 12.0))
        if random.random() < 0.5:
            odd = random.normal(size=contacts + 1) * (random.random(contacts + 1) < 0.5)
            rates += random_size(random, 2e-4, 0.01) * np.diff(odd)
        rates = scaled(rates, shrink)
        if rates.min() > shrink * LOWEST_RANDOM and rates.max() < HIGHEST:
            found.append(rates)
    return found


def oscillating_rates(
    random: np.random.Generator, count: int, contacts: int, shrink: float = 1.0
) -> list[Array]:
    """Rates that oscillate quickly about a constant one, some with scattered radii."""
    k = np.arange(contacts)
    found: list[Array] = []
    while len(found) < count:
        base = 0.01 * random.normal() if random.random() < 0.5 else random.uniform(-0.05, 0.1)
        cycles = k / random_size(random, 8.0, 26.0) + random.random()
        rates = base + random_size(random, 0.004, 0.06) * np.sin(2.0 * np.pi * cycles)
        if random.random() < 0.5:
            size = random_size(random, 2e-4, 0.01)
            rates += np.diff(size * random.normal(size=contacts + 1))
        rates = scaled(rates, shrink)
        if rates.min() > -0.12 * shrink:
            found.append(rates)
    return found


def wavy_rates(
    random: np.random.Generator, count: int, contacts: int, shrink: float = 1.0
) -> list[Array]:
    """Rates that are constant or oscillate slowly, with scattered, odd or alternating radii."""
    k, beads = np.arange(contacts), np.arange(contacts + 1)
    found: list[Array] = []
    while len(found) < count:
        kind = random.integers(5)
        base = (0.02 * random.normal(), 0.02 * random.normal(), 0.0, 0.015 * random.normal())
        rates = np.full(contacts, random.uniform(-0.1, 0.15) if kind == 4 else base[kind])
        for _ in range(random.integers(1, 3) if kind < 2 else 0):
            cycles = k / random_size(random, 25.0, 90.0) + random.random()
            rates += random_size(random, 0.005, 0.05) * np.sin(2.0 * np.pi * cycles)
        odd = random.normal(size=contacts + 1)
        if random.random() < 0.15:
            odd *= 3.0 * (random.random(contacts + 1) < 0.12)
        elif random.random() < 0.15:
            odd = beads % 2 + 0.3 * odd
        rates += random_size(random, 5e-4, 0.01) * np.diff(odd)
        rates = scaled(rates, shrink)
        if rates.min() > -0.135 * shrink:
            found.append(rates)
    return found


def random_size(random: np.random.Generator, low: float, high: float) -> float:
    """A number whose logarithm is uniform."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def random_sign(random: np.random.Generator) -> int:
    """1 or -1."""
    return int(random.choice((-1, 1)))


def follow(rates: Array, exponent: float) -> Sample:
    """Simulate chains with given rates, without those for which the simulation fails."""
    found = states_of(list(rates), exponent, RTOLS)
    followed = [index for index, states in enumerate(found) if states is not None]
    return Sample(rates[followed], np.array([found[index] for index in followed]))


def states_of(
    rates: Sequence[Array], exponent: float, rtols: tuple[float, ...] = FINE_RTOLS
) -> list[Array | None]:
    """Simulated states of chains with given rates, for the smallest tolerance that is possible."""
    radii = [np.exp(np.concatenate([[0.0], np.cumsum(row)])) for row in rates]
    chains = [Chain.from_radii(row, exponent=exponent) for row in radii]
    found: list[Array | None] = [None] * len(chains)
    for rtol in rtols:
        left = [index for index in range(len(chains)) if found[index] is None]
        if not left:
            break
        table = propagate_many([chains[index] for index in left], rtol=rtol)
        for row, index in enumerate(left):
            if row not in table.reasons:
                found[index] = state(table[row])
    failed = sum(states is None for states in found)
    if failed > 0.01 * len(chains):
        raise SimulationError(f"{failed} of {len(chains)} chains failed")
    return found
