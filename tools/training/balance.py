"""Find the constants of the estimated errors for Hertz contacts by a coordinate search.

The chains are those of ``benchmarks/local_rate_chains.py`` with other seeds than those of the
verification.  In each class of chains, the estimate should cover nearly all beads, exceed the
error by a moderate factor, and never be much too small; an error above 1% should have a warning.
"""

from __future__ import annotations

import runpy
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hertzchain.chain.chain import Chain
from hertzchain.collision import Array
from hertzchain.propagation.propagate import propagate_many
from hertzchain.theory.local_rate import DOUBTFUL, solve
from hertzchain.theory.universal_functions import UniversalFunctions

CHAINS: Final = Path(__file__).parents[2] / "benchmarks" / "local_rate_chains.py"
SEEDS: Final = (40404, 40405, 40406, 40407, 60606, *range(901, 910))
# Number of chains of each class for each seed.
COUNT: Final = 200
RTOL: Final = 1e-9
# Wanted in each class: percentage of beads covered, median of estimate/error, and largest
# error/estimate of each chain; in the last one, a margin is left to the limit of 6.
COVERED, MEDIAN, LARGEST_RATIO = 98.0, 6.9, 3.4
# Percentage below which a class counts much more.
MIN_COVERED: Final = 96.0
# The same of alternating radii, of which there are few chains, all of them similar.
ALTERNATING_COVERED: Final = 99.0
# In chains far outside the law, errors are of any size, and the median means nothing.
OUTSIDE: Final = ("periodic", "decorated", "one odd bead")
# Constants that are searched; few chains have the terms of the others.
SEARCHED: Final = 12
ROUNDS: Final = 12
# Largest change of a constant, which becomes smaller where no change is an improvement.
FIRST_FACTOR, REFINED = 1.3, 0.6
# Constants do not fall below this part of the first ones: a class of a few chains, such as those
# that alternate, would not prevent it.
SMALLEST_PART: Final = 0.5
# The constants are enlarged by this factor, as the estimate should hold for other chains, too.
MARGIN: Final = 1.03
# Smallest improvement of the score.
LEAST: Final = 1e-3
TINY, LARGEST_LOGARITHM = 1e-9, 50.0
NamedPulse = tuple[str, Array, Array]


@dataclass(frozen=True, eq=False)
class Beads:
    """Terms and errors at all beads of chains, class by class.

    Attributes
    ----------
    names : list of str
        Classes.
    parts, errors, lost : ndarray
        Terms of the estimate (beads, 16), errors, and 1 where the law has diverged.
    first : ndarray
        First bead of each chain.
    of_class : ndarray
        Class of each chain.
    outside : ndarray of bool
        Chains with rates outside the tables.
    """

    names: list[str]
    parts: Array
    errors: Array
    lost: Array
    first: NDArray[np.intp]
    of_class: NDArray[np.intp]
    outside: NDArray[np.bool_]


@dataclass(frozen=True)
class Result:
    """How the estimate does in a class of chains: ratios and errors without a warning by chain."""

    covered: float
    median: float
    ratios: Array
    unwarned: Array


def estimate_pulses(seeds: Sequence[int] = SEEDS, count: int = COUNT) -> list[NamedPulse]:
    """Classes, rates and simulated logarithms of velocities of chains, sorted by class."""
    all_chains = runpy.run_path(str(CHAINS))["all_chains"]
    named = sorted(
        (each for seed in seeds for each in all_chains(count, seed)), key=lambda each: each[0]
    )
    radii = [np.exp(np.concatenate([[0.0], np.cumsum(rates)])) for _, rates in named]
    chains = [Chain.from_radii(row) for row in radii]
    table = propagate_many(chains, rtol=RTOL)
    return [
        (*each, np.log(table[index].velocity[1:]))
        for index, each in enumerate(named)
        if index not in table.reasons
    ]


def beads_of(functions: UniversalFunctions, pulses: Sequence[NamedPulse]) -> Beads:
    """Evaluate the law and the terms of its estimate."""
    names = sorted({name for name, _, _ in pulses})
    found: list[tuple[Array, Array, Array, int, bool]] = []
    for name, rates, true in pulses:
        radii = np.exp(np.concatenate([[0.0], np.cumsum(rates)]))
        solution = solve(Chain.from_radii(radii), functions)
        error = np.abs(np.expm1(np.cumsum(solution.states[:, 0]) - true)) + TINY
        lost = (np.arange(len(error)) >= solution.lost).astype(float)
        low, high = functions.range
        outside = bool(rates.min() < low or rates.max() > high)
        found.append((solution.error_parts, error, lost, names.index(name), outside))
    parts, errors, lost_beads, of_class, outsides = zip(*found, strict=True)
    lengths = np.array([len(each) for each in errors])
    return Beads(
        names, np.concatenate(parts), np.concatenate(errors), np.concatenate(lost_beads),
        np.concatenate([[0], np.cumsum(lengths)[:-1]]), np.array(of_class), np.array(outsides),
    )  # fmt: skip


def results(beads: Beads, constants: Array) -> list[Result]:
    """How the estimate with some constants does in each class."""
    total = np.minimum(beads.parts @ constants + beads.lost, LARGEST_LOGARITHM)
    estimate = np.expm1(total)
    ratio = estimate / beads.errors
    worst = 1.0 / np.minimum.reduceat(ratio, beads.first)
    warned = beads.outside | (np.maximum.reduceat(estimate, beads.first) > DOUBTFUL)
    unwarned = np.where(warned, 0.0, np.maximum.reduceat(beads.errors, beads.first))
    ends = np.append(beads.first[1:], len(ratio))
    found = []
    for number in range(len(beads.names)):
        chains = np.flatnonzero(beads.of_class == number)
        # Chains are sorted by class.
        of_beads = ratio[beads.first[chains[0]] : ends[chains[-1]]]
        found.append(
            Result(
                100.0 * float(np.mean(of_beads >= 1.0)), float(np.median(of_beads)),
                worst[chains], unwarned[chains],
            )
        )  # fmt: skip
    return found


def score(beads: Beads, constants: Array) -> float:
    """Sum of the penalties of all classes."""
    total = 0.0
    for name, of in zip(beads.names, results(beads, constants), strict=True):
        median = min(of.median, MEDIAN) if name.startswith(OUTSIDE) else of.median
        total += 0.6 * max(0.0, COVERED - of.covered) ** 2
        least = ALTERNATING_COVERED if name.startswith("alternating") else MIN_COVERED
        total += 30.0 * max(0.0, least - of.covered) ** 2
        total += 500.0 * max(0.0, np.log(median / MEDIAN)) ** 2 + 0.15 * np.log(max(median, 2.0))
        total += 20.0 * np.sum(np.maximum(0.0, np.log(of.ratios / LARGEST_RATIO)) ** 2)
        total += 50.0 * np.count_nonzero(of.unwarned > 0.01)
        total += 30.0 * np.sum(np.maximum(0.0, of.unwarned / DOUBTFUL - 1.0))
    return float(total)


def balance(beads: Beads, constants: Array) -> Array:
    """Constants with a better score, changed one after the other."""
    found, best = constants.copy(), score(beads, constants)
    factors = np.full(SEARCHED, FIRST_FACTOR)
    for _ in range(ROUNDS):
        for i in range(SEARCHED):
            improved = False
            for factor in (factors[i], 1.0 / factors[i]):
                while True:
                    tried = found.copy()
                    tried[i] *= factor
                    if tried[i] < SMALLEST_PART * constants[i]:
                        break
                    if (value := score(beads, tried)) > best - LEAST:
                        break
                    found, best, improved = tried, value, True
                if improved:
                    break
            if not improved:
                factors[i] **= REFINED
    return MARGIN * found
