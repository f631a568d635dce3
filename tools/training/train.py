"""Determine the universal functions of an exponent and write their tables."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
from scipy.optimize import minimize

from hertzchain.chain.chain import Chain
from hertzchain.collision import Array
from hertzchain.theory.local_rate import solve
from hertzchain.theory.universal_functions import (
    END,
    INPUTS,
    PAIRS,
    START,
    WITHIN,
    UniversalFunctions,
    assemble,
)  # fmt: skip

from .response_fit import KNOTS, UNIT, Anchors, fit_contact
from .rollout import UNTIL, refine
from .table_writer import write_tables
from .training_chains import (
    DOUBLE_RAMPS,
    NODES,
    Sample,
    double_ramp_rates,
    exponential_rates,
    follow,
    join_samples,
    ramp_rates,
    truncate_ramps,
)  # fmt: skip

# Number of ramps in the Gauss-Newton fit.
FOLLOWED: Final = 3000
# Weight of the exponential chains, on which the law should be exact, in this fit.
REPEATED: Final = 5
# Number of ramps for the error estimate, and fraction of their errors below the estimate.
HELD_OUT: Final = 2000
COVERED: Final = 0.975


def response(
    anchors: Anchors,
    exponential: Sample,
    ramps: Sample,
    ends: Sample,
    random: np.random.Generator,
) -> Array:
    """Response of all stages, shape (stages, terms, splines, 3), in units of the inputs."""
    last = ends.rates.shape[1]
    start = [fit_contact(anchors, k, ramps, [k]) for k in range(START)]
    within = fit_contact(anchors, WITHIN, ramps, list(range(START, UNTIL)))
    chosen = random.choice(len(ramps.rates), min(FOLLOWED, len(ramps.rates)), replace=False)
    followed = [ramps.part(chosen), *[exponential] * REPEATED]
    within = refine(anchors, within, join_samples(followed))
    end = [fit_contact(anchors, WITHIN + 1 + i, ends, [last - END + i]) for i in range(END)]
    found = np.array([*start, within, *end])
    degree = np.array([1] * len(INPUTS) + [2] * len(PAIRS))
    return found / UNIT ** degree[:, None, None]


def error_constants(functions: UniversalFunctions, ramps: Sample) -> Array:
    """Constants of the error estimate, by quantile regression of the logarithm of the error."""
    parts, errors = [], []
    for rates, states in zip(ramps.rates, ramps.states, strict=True):
        radii = np.exp(np.concatenate([[0.0], np.cumsum(rates)]))
        solution = solve(Chain.from_radii(radii, exponent=functions.exponent), functions)
        if solution.lost == len(rates):
            parts.append(solution.error_parts[START:])
            errors.append(np.cumsum(solution.states[:, 0] - states[:, 0])[START:])
    part = np.concatenate(parts)
    logarithm = np.log(np.abs(np.concatenate(errors)) + 1e-7)

    def loss(constants: Array) -> float:
        beyond = logarithm - np.log(part @ np.exp(constants))
        return float(np.mean(np.where(beyond > 0.0, COVERED, COVERED - 1.0) * beyond))

    guess = np.log([1e-5, 1e-3, 3e-4, 1.0])
    return np.asarray(
        np.exp(minimize(loss, guess, method="Nelder-Mead", options={"maxfev": 5000}).x)
    )


def train(exponent: float, folder: Path, report: Callable[[str], None]) -> None:
    """Determine the universal functions of an exponent and write their tables."""
    random = np.random.default_rng(0)
    report(f"p = {exponent:g}: {len(NODES)} exponential chains")
    exponential = follow(exponential_rates(), exponent)
    anchors = Anchors(exponential)
    held_out = ramp_rates(NODES[1::2])
    held_out = held_out[random.choice(len(held_out), HELD_OUT // 2, replace=False)]
    held_out = np.concatenate([held_out, double_ramp_rates(random, HELD_OUT // 2)])
    rates = np.concatenate([ramp_rates(NODES[::2]), double_ramp_rates(random, DOUBLE_RAMPS)])
    report(f"{len(rates)} ramps, truncated ramps, and {HELD_OUT} ramps for the error estimate")
    ramps = follow(rates, exponent)
    ends = follow(truncate_ramps(rates, random), exponent, last=START + END + 1)
    report("fitting")
    found = response(anchors, exponential, ramps, ends, random)
    functions = assemble(exponent, NODES, anchors.values, KNOTS, found, np.zeros(4))
    error = error_constants(functions, follow(held_out, exponent))
    write_tables(folder / f"p{exponent:g}", anchors, found, error)
