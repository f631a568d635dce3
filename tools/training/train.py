"""Determine the universal functions of an exponent and write their tables."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np

from hertzchain.collision import Array
from hertzchain.kernels.fast_changes import PARTS, PRODUCTS, STATES
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
from .response_fit import KNOTS, UNIT, Anchors, fit_contact
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
    ramp_rates,
    random_rates,
    states_of,
)  # fmt: skip

# Number of ramps in the Gauss-Newton fit.
FOLLOWED: Final = 3000
# Weight of the exponential chains, on which the law should be exact, in this fit.
REPEATED: Final = 5
# Numbers of contacts, and of rough and smooth random chains with as many, for the products of
# fast changes and for the error estimate.
RANDOM: Final = ((63, 2600, 300),)
HELD_OUT: Final = ((63, 300, 300), (99, 150, 150), (199, 40, 40), (12, 100, 80), (22, 80, 60),
                   (8, 80, 80))  # fmt: skip


def response(
    anchors: Anchors, exponential: Sample, ramps: Sample, random: np.random.Generator
) -> Array:
    """Response of all stages, shape (stages, terms, splines, 3), in units of the inputs."""
    start = [fit_contact(anchors, k, ramps, [k]) for k in range(START)]
    within = fit_contact(anchors, WITHIN, ramps, list(range(START, UNTIL)))
    chosen = random.choice(len(ramps.rates), min(FOLLOWED, len(ramps.rates)), replace=False)
    followed = [ramps.part(chosen), *[exponential] * REPEATED]
    within = refine(anchors, within, join_samples(followed))
    degree = np.array([1] * len(INPUTS) + [2] * len(PAIRS))
    return np.array([*start, within]) / UNIT ** degree[:, None, None]


def random_chains(
    random: np.random.Generator, plan: tuple[tuple[int, int, int], ...], exponent: float
) -> tuple[list[Array], list[Array]]:
    """Rates and simulated states of random chains."""
    rates: list[Array] = []
    for contacts, rough, smooth in plan:
        rates += random_rates(random, rough, contacts, smooth=False)
        rates += random_rates(random, smooth, contacts, smooth=True)
    found = states_of(rates, exponent)
    kept = [index for index, states in enumerate(found) if states is not None]
    return [rates[i] for i in kept], [states for states in found if states is not None]


def train(exponent: float, folder: Path, report: Callable[[str], None]) -> None:
    """Determine the universal functions of an exponent and write their tables."""
    random, folder = np.random.default_rng(0), folder / f"p{exponent:g}"
    report(f"p = {exponent:g}: {len(NODES)} exponential chains")
    exponential = follow(exponential_rates(), exponent)
    anchors = Anchors(exponential)
    ramps = [ramp_rates(COARSE_NODES[::2]), double_ramp_rates(random, DOUBLE_RAMPS)]
    rates = np.concatenate(ramps)
    report(f"{len(rates)} ramps")
    found = response(anchors, exponential, follow(rates, exponent), random)
    write_tables(folder, anchors, found)
    train_fast(exponent, folder, anchors, found, report)


def train_fast(
    exponent: float,
    folder: Path,
    anchors: Anchors,
    found: Array,
    report: Callable[[str], None],
) -> None:
    """Determine the response to fast changes and the error estimate, and write their tables."""
    random = np.random.default_rng(1)
    report("responses to single changes")
    measured = measure(exponent)
    nothing = np.zeros((len(FAST_KNOTS) + 2, STATES * PRODUCTS))

    def functions(second: Array) -> UniversalFunctions:
        fast = fast_tables(**measured, knots=FAST_KNOTS, second=second)
        return assemble(exponent, NODES, anchors.values, KNOTS, found, fast, np.zeros(PARTS))

    report("products of fast changes")
    second = fit(functions(nothing), *random_chains(random, RANDOM, exponent))
    write_fast(folder, measured, FAST_KNOTS, second)
    report("error estimate")
    train_error(functions(second), folder)


def train_error(functions: UniversalFunctions, folder: Path) -> None:
    """Determine the constants of the error estimate, and write their table."""
    held_out = random_chains(np.random.default_rng(2), HELD_OUT, functions.exponent)
    write_error(folder, error_constants(functions, *held_out))
