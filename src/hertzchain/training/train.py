"""From an exponent to its tables."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
from scipy.optimize import minimize

from hertzchain.chain.chain import Chain
from hertzchain.contacts import Array
from hertzchain.theory.local_rate import solve
from hertzchain.theory.universal import (
    END,
    INPUTS,
    PAIRS,
    START,
    WITHIN,
    UniversalFunctions,
    assembled,
)  # fmt: skip
from hertzchain.training.fit import KNOTS, UNIT, Anchors, fit_contact
from hertzchain.training.rollout import UNTIL, refine
from hertzchain.training.samples import (
    DOUBLE_RAMPS,
    NODES,
    Sample,
    double_ramp_rates,
    exponential_rates,
    follow,
    joined,
    ramp_rates,
    truncated,
)  # fmt: skip
from hertzchain.training.tables import write_tables

# Ramps that the Gauss-Newton steps follow as a whole.
FOLLOWED: Final = 3000
# Exponential chains, on which the law should be exact, count so many times beside them.
REPEATED: Final = 5
# Ramps that the error is estimated from, and the part of their errors that it covers.
HELD_OUT: Final = 2000
COVERED: Final = 0.975


def response(
    anchors: Anchors,
    exponential: Sample,
    ramps: Sample,
    ends: Sample,
    random: np.random.Generator,
) -> Array:
    """Response of every stage, shape (stages, terms, splines, 3), in units of the inputs.

    Parameters
    ----------
    anchors : Anchors
        States on exponential chains.
    exponential : Sample
        These chains.
    ramps : Sample
        Ramps in chains so long that the free end is not felt.
    ends : Sample
        The last contacts of ramps cut off.
    random : numpy.random.Generator
        Chooses the ramps that are followed as a whole.

    Returns
    -------
    ndarray

    Examples
    --------
    Done by ``python -m hertzchain.training``.
    """
    last = ends.rates.shape[1]
    start = [fit_contact(anchors, k, ramps, [k]) for k in range(START)]
    within = fit_contact(anchors, WITHIN, ramps, list(range(START, UNTIL)))
    chosen = random.choice(len(ramps.rates), min(FOLLOWED, len(ramps.rates)), replace=False)
    followed = [ramps.part(chosen), *[exponential] * REPEATED]
    within = refine(anchors, within, joined(followed))
    end = [fit_contact(anchors, WITHIN + 1 + i, ends, [last - END + i]) for i in range(END)]
    found = np.array([*start, within, *end])
    degree = np.array([1] * len(INPUTS) + [2] * len(PAIRS))
    return found / UNIT ** degree[:, None, None]


def error_constants(functions: UniversalFunctions, ramps: Sample) -> Array:
    """Constants of the estimated error, by quantile regression of the true error's logarithm.

    Parameters
    ----------
    functions : UniversalFunctions
        The law.
    ramps : Sample
        Ramps that it was not fitted to.

    Returns
    -------
    ndarray, shape (4,)

    Examples
    --------
    Done by ``python -m hertzchain.training``.
    """
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


def train(exponent: float, folder: Path, tell: Callable[[str], None]) -> None:
    """Find the universal functions of an exponent and write their tables.

    Parameters
    ----------
    exponent : float
        Exponent p of the contact force.
    folder : Path
        Folder of all tables.
    tell : callable
        Told what is being done.

    Examples
    --------
    Done by ``python -m hertzchain.training``.
    """
    random = np.random.default_rng(0)
    tell(f"p = {exponent:g}: {len(NODES)} exponential chains")
    exponential = follow(exponential_rates(), exponent)
    anchors = Anchors(exponential)
    held_out = ramp_rates(NODES[1::2])
    held_out = held_out[random.choice(len(held_out), HELD_OUT // 2, replace=False)]
    held_out = np.concatenate([held_out, double_ramp_rates(random, HELD_OUT // 2)])
    rates = np.concatenate([ramp_rates(NODES[::2]), double_ramp_rates(random, DOUBLE_RAMPS)])
    tell(f"{len(rates)} ramps, cut off at their ends, and {HELD_OUT} held out")
    ramps = follow(rates, exponent)
    ends = follow(truncated(rates, random), exponent, last=START + END + 1)
    tell("fit")
    found = response(anchors, exponential, ramps, ends, random)
    functions = assembled(exponent, NODES, anchors.values, KNOTS, found, np.zeros(4))
    error = error_constants(functions, follow(held_out, exponent))
    write_tables(folder / f"p{exponent:g}", anchors, found, error)
