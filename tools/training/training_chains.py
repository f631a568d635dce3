"""Chains for fitting the law, and their simulated pulses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.collision import Array
from hertzchain.errors import SimulationError
from hertzchain.propagation.propagate import propagate_many
from hertzchain.theory.universal_functions import state

# Below the lowest rate, pulses in forward tapers have several maxima; above the highest, the BCA
# differs by a constant.  Nodes of the tables of exponential chains are dense where these curve.
LOWEST: Final = -0.165
HIGHEST: Final = 1.1
NODES: Final = np.unique(
    np.round([*np.linspace(LOWEST, 0.15, 43), *np.linspace(0.15, HIGHEST, 30)], 4)
)
BEADS: Final = 64
# The strongest backward ramps amplify rounding errors and require the second tolerance.
RTOLS: Final = (1e-8, 1e-7)
# Changes of the rate along a ramp, numbers of contacts over which it changes, and contacts
# (counted from 0) at which the change begins.
CHANGES: Final = (0.005, 0.02, 0.05, 0.1, 0.2, 0.4)
LENGTHS: Final = (1, 2, 3, 5, 9, 17, 33, 58)
BEGINNINGS: Final = (0, 1, 3, 22)
DOUBLE_RAMPS: Final = 6000


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
        """Some of the chains."""
        return Sample(self.rates[rows], self.states[rows])


def join_samples(samples: Sequence[Sample]) -> Sample:
    """Concatenate samples."""
    return Sample(
        np.concatenate([sample.rates for sample in samples]),
        np.concatenate([sample.states for sample in samples]),
    )


def exponential_rates() -> Array:
    """Rates of the exponential chains, shape (nodes, contacts)."""
    return np.repeat(NODES[:, None], BEADS - 1, axis=1)


def ramp_rates(beginnings: Array) -> Array:
    """Rates of ramps, which change linearly over several contacts and are constant otherwise."""
    contact = np.arange(BEADS - 1)
    ramps = []
    for start in beginnings:
        for change in (*CHANGES, *(-change for change in CHANGES)):
            end = start + change
            steep = abs(change) > 0.15 and min(start, end) < -0.1
            if not LOWEST <= end <= HIGHEST or steep:
                continue
            for length in LENGTHS:
                for begin in BEGINNINGS:
                    if begin + length <= BEADS - 4:
                        # A ramp from contact 0 over one contact would be constant.
                        position = (contact - begin) / length if begin or length > 1 else contact
                        ramps.append(start + change * np.clip(position, 0.0, 1.0))
    return np.array(ramps)


def double_ramp_rates(random: np.random.Generator, count: int) -> Array:
    """Rates of ramps with two changes close to each other."""
    contact = np.arange(BEADS - 1)
    ramps: list[Array] = []
    while len(ramps) < count:
        rates = np.full(BEADS - 1, random.uniform(LOWEST, 0.5))
        first = int(random.choice((0, 1, 3, 12, 22)))
        for _ in range(2):
            length = int(random.choice((1, 1, 2, 3, 6, 12)))
            change = random.choice((-1.0, 1.0)) * np.exp(random.uniform(np.log(0.003), np.log(0.3)))
            rates += change * np.clip((contact - first) / length, 0.0, 1.0)
            first += length + int(random.choice((0, 0, 1, 3)))
        if rates.min() >= LOWEST and rates.max() <= HIGHEST:
            ramps.append(rates)
    return np.array(ramps)


def truncate_ramps(rates: Array, random: np.random.Generator) -> list[Array]:
    """Rates of ramps that end while they change, or soon after."""
    changing = np.diff(rates, axis=1) != 0.0
    first = np.argmax(changing, axis=1)
    last = changing.shape[1] - np.argmax(changing[:, ::-1], axis=1)
    lengths = np.clip(random.integers(first + 1, last + 4), 9, rates.shape[1])
    return [row[:length] for row, length in zip(rates, lengths, strict=True)]


def follow(rates: Array | list[Array], exponent: float, last: int = BEADS) -> Sample:
    """Simulate chains with given rates, without those for which the simulation fails."""
    radii = [np.exp(np.concatenate([[0.0], np.cumsum(row)])) for row in rates]
    chains = [Chain.from_radii(row, exponent=exponent) for row in radii]
    found: dict[int, Array] = {}
    for rtol in RTOLS:
        left = [index for index in range(len(chains)) if index not in found]
        table = propagate_many([chains[index] for index in left], rtol=rtol)
        for row, index in enumerate(left):
            if row not in table.reasons:
                found[index] = state(table[row])[-last:]
    if len(found) < 0.99 * len(chains):
        raise SimulationError(f"{len(chains) - len(found)} of {len(chains)} chains failed")
    followed = sorted(found)
    return Sample(
        np.array([rates[index][-last:] for index in followed]),
        np.array([found[index] for index in followed]),
    )
