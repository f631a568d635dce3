"""Simulated chains to which the response to fast changes is fitted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from hertzchain.collision import Array

from .second_degree import Chains
from .sensitivities import Sensitivity, simulate_slopes
from .training_chains import (
    odd_rates,
    oscillating_rates,
    random_rates,
    starting_rates,
    states_of,
    steep_rates,
    wavy_rates,
)  # fmt: skip

# Contacts of the chains whose derivatives are simulated, and of those with quick changes.
LONG, SHORT, STARTING, OSCILLATING = 59, 30, 40, 63
# Weights of the states of chains, relative to derivatives.  In chains that change quickly all
# along, small errors of all contacts add up.
WEIGHTS: Final = 10.0, 10.0, 200.0


@dataclass(frozen=True)
class Effort:
    """Numbers of simulations, and of steps of the Gauss-Newton fit.

    Attributes
    ----------
    ramps, double_ramps, early : int
        Numbers of ramps with one and two changes; early ramps begin at every so many nodes.
    followed, repeated, rounds, every : int
        Number of ramps in the Gauss-Newton fit, weight of the exponential chains, on which the
        law should be exact, number of its steps, and the contacts between those that are compared.
    random : tuple
        Numbers of contacts, and of rough, smooth, odd and steep random chains with as many, for
        the products of fast changes.
    slopes : tuple
        Numbers of long and of short chains whose derivatives are simulated for the products of
        fast changes; without them, there are no products with the slow change, and the last
        contacts have no functions of their own.
    starting, oscillating : int
        Numbers of chains whose rates change quickly behind the impact, or all along.
    """

    ramps: int
    double_ramps: int
    early: int
    followed: int
    repeated: int
    rounds: int
    every: int
    random: tuple[tuple[int, int, int, int, int], ...]
    slopes: tuple[int, int]
    starting: int
    oscillating: int


@dataclass(frozen=True, eq=False)
class FastData:
    """Chains to which the response to fast changes is fitted.

    Attributes
    ----------
    random, starting, oscillating : Chains
        Chains of all kinds, and those that change quickly behind the impact, or all along.
    long, short : list of Sensitivity
        Chains whose derivatives are known.
    """

    random: Chains
    starting: Chains
    oscillating: Chains
    long: list[Sensitivity]
    short: list[Sensitivity]

    def weighted(self) -> list[Chains]:
        """Chains of the response within, with the weights of their equations."""
        kinds = (self.random, self.starting, self.oscillating)
        return [replace(each, weight=weight) for each, weight in zip(kinds, WEIGHTS, strict=True)]


def fast_data(effort: Effort, exponent: float, shrink: float) -> FastData:
    """Simulate all chains for the response to fast changes."""
    first, second, third = (np.random.default_rng(seed) for seed in (1, 5, 4))
    long, short = effort.slopes
    return FastData(
        random_chains(first, effort.random, exponent, shrink),
        simulated(starting_rates(second, effort.starting, STARTING, shrink), exponent),
        simulated(oscillating_rates(second, effort.oscillating, OSCILLATING, shrink), exponent),
        simulate_slopes(wavy_rates(third, long, LONG, shrink), exponent),
        simulate_slopes(wavy_rates(third, short, SHORT, shrink), exponent),
    )


def random_chains(
    random: np.random.Generator,
    plan: tuple[tuple[int, int, int, int, int], ...],
    exponent: float,
    shrink: float = 1.0,
) -> Chains:
    """Random chains of all kinds."""
    rates: list[Array] = []
    for contacts, rough, smooth, odd, steep in plan:
        rates += random_rates(random, rough, contacts, smooth=False, shrink=shrink)
        rates += random_rates(random, smooth, contacts, smooth=True, shrink=shrink)
        rates += odd_rates(random, odd, contacts, shrink)
        rates += steep_rates(random, steep, contacts, shrink)
    return simulated(rates, exponent)


def simulated(rates: list[Array], exponent: float) -> Chains:
    """Chains for which the simulation succeeds, with their states."""
    found = states_of(rates, exponent)
    kept = [index for index, states in enumerate(found) if states is not None]
    return Chains([rates[i] for i in kept], [states for states in found if states is not None])
