"""Determine the universal functions of an exponent and write their tables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from hertzchain.collision import Array
from hertzchain.kernels.fast_changes import PARTS, PRODUCTS, STATES
from hertzchain.theory.exponents import scaled
from hertzchain.theory.universal_functions import (
    INPUTS,
    PAIRS,
    START,
    WITHIN,
    UniversalFunctions,
    assemble,
    fast_tables,
)  # fmt: skip

from .error_fit import error_constants
from .response_fit import UNIT, Anchors, fit_contact
from .responses import measure
from .rollout import UNTIL, refine
from .second_degree import KNOTS as FAST_KNOTS
from .second_degree import fit
from .table_writer import write_error, write_fast, write_tables
from .training_chains import (
    COARSE_NODES,
    DOUBLE_RAMPS,
    NODES,
    Sample,
    double_ramp_rates,
    exponential_rates,
    follow,
    join_samples,
    odd_rates,
    ramp_rates,
    random_rates,
    states_of,
)  # fmt: skip


@dataclass(frozen=True)
class Effort:
    """Numbers of simulations, and of steps of the Gauss-Newton fit.

    Attributes
    ----------
    ramps, double_ramps : int
        Ramps begin at every so many nodes; number of ramps with two changes.
    followed, repeated, rounds, every : int
        Number of ramps in the Gauss-Newton fit, weight of the exponential chains, on which the
        law should be exact, number of its steps, and the contacts between those that are compared.
    random : tuple
        Numbers of contacts, and of rough, smooth and odd random chains with as many, for the
        products of fast changes.
    """

    ramps: int
    double_ramps: int
    followed: int
    repeated: int
    rounds: int
    every: int
    random: tuple[tuple[int, int, int, int], ...]


FULL: Final = Effort(2, DOUBLE_RAMPS, 3000, 5, 3, 1, ((63, 2600, 300, 300),))
# Numbers of contacts, and of rough, smooth and odd random chains of the error estimate.
HELD_OUT: Final = (
    (63, 500, 400, 200), (99, 250, 200, 100), (199, 80, 60, 30), (12, 120, 120, 60),
    (22, 120, 100, 60), (8, 100, 100, 40),
)  # fmt: skip


def response(anchors: Anchors, exponential: Sample, ramps: Sample, effort: Effort) -> Array:
    """Response of all stages, shape (stages, terms, splines, 3), in units of the inputs."""
    start = [fit_contact(anchors, k, ramps, [k]) for k in range(START)]
    within = fit_contact(anchors, WITHIN, ramps, list(range(START, UNTIL)))
    followed = [ramps.part(slice(effort.followed)), *[exponential] * effort.repeated]
    within = refine(anchors, within, join_samples(followed), effort.rounds, effort.every)
    degree = np.array([1] * len(INPUTS) + [2] * len(PAIRS))
    return np.array([*start, within]) / UNIT ** degree[:, None, None]


def random_chains(
    random: np.random.Generator,
    plan: tuple[tuple[int, int, int, int], ...],
    exponent: float,
    shrink: float = 1.0,
) -> tuple[list[Array], list[Array]]:
    """Rates and simulated states of random chains."""
    rates: list[Array] = []
    for contacts, rough, smooth, odd in plan:
        rates += random_rates(random, rough, contacts, smooth=False, shrink=shrink)
        rates += random_rates(random, smooth, contacts, smooth=True, shrink=shrink)
        rates += odd_rates(random, odd, contacts, shrink)
    found = states_of(rates, exponent)
    kept = [index for index, states in enumerate(found) if states is not None]
    return [rates[i] for i in kept], [states for states in found if states is not None]


def slow_tables(
    exponent: float, shrink: float, effort: Effort, report: Callable[[str], None]
) -> tuple[Anchors, Array]:
    """States of exponential chains, and the response to slow changes."""
    random = np.random.default_rng(0)
    report(f"p = {exponent:g}: {len(NODES)} exponential chains")
    exponential = follow(exponential_rates(shrink), exponent)
    anchors = Anchors(exponential, shrink)
    rates = np.concatenate(
        [
            ramp_rates(COARSE_NODES[:: effort.ramps], shrink),
            double_ramp_rates(random, effort.double_ramps, shrink),
        ]
    )
    report(f"{len(rates)} ramps")
    # In random order, because only the first ones are used in the Gauss-Newton fit.
    ramps = follow(random.permutation(rates), exponent)
    return anchors, response(anchors, exponential, ramps, effort)


def fast_changes(
    exponent: float,
    slow: tuple[Anchors, Array],
    shrink: float,
    effort: Effort,
    report: Callable[[str], None],
) -> tuple[dict[str, Array], UniversalFunctions]:
    """Tables of the response to fast changes, and functions without an error estimate."""
    random, (anchors, found) = np.random.default_rng(1), slow
    report("responses to single changes")
    measured = measure(exponent, shrink)
    measured["knots"] = scaled(FAST_KNOTS, shrink)

    def functions() -> UniversalFunctions:
        fast = fast_tables(exponent, **measured)
        return assemble(
            exponent, anchors.nodes, anchors.values, anchors.knots, found, fast, np.zeros(PARTS)
        )

    report("products of fast changes")
    measured["second"] = np.zeros((len(FAST_KNOTS) + 2, STATES * PRODUCTS))
    chains = random_chains(random, effort.random, exponent, shrink)
    measured["second"] = fit(functions(), *chains)
    return measured, functions()


def train(exponent: float, folder: Path, report: Callable[[str], None]) -> None:
    """Determine the universal functions of an exponent and write their tables."""
    folder = folder / f"p{exponent:g}"
    slow = slow_tables(exponent, 1.0, FULL, report)
    write_tables(folder, *slow)
    measured, functions = fast_changes(exponent, slow, 1.0, FULL, report)
    write_fast(folder, measured)
    report("error estimate")
    train_error(functions, folder)


def train_error(functions: UniversalFunctions, folder: Path) -> None:
    """Determine the constants of the error estimate, and write their table."""
    held_out = random_chains(np.random.default_rng(2), HELD_OUT, functions.exponent)
    write_error(folder, error_constants(functions, *held_out))
