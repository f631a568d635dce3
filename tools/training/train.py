"""Determine the universal functions of an exponent and write their tables."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from hertzchain.collision import Array
from hertzchain.kernels.error_terms import PARTS
from hertzchain.kernels.fast_changes import PAIRS as FAST_PAIRS
from hertzchain.kernels.fast_changes import STATES
from hertzchain.kernels.last_contact import PRODUCTS as LAST_PRODUCTS
from hertzchain.theory.exponents import scaled, steady_gain
from hertzchain.theory.universal_functions import (
    INPUTS,
    PAIRS,
    START,
    WITHIN,
    UniversalFunctions,
    assemble,
    fast_tables,
    read_response,
)  # fmt: skip

from .alternation import BASES, coefficients
from .error_fit import JAGGED, REFERENCE, error_constants
from .estimate_chains import estimate_chains
from .last_fit import KNOTS as LAST_KNOTS
from .last_fit import fit_last
from .response_fit import UNIT, Anchors, fit_contact
from .responses import measure
from .rollout import UNTIL, missing_states, refine
from .second_degree import KNOTS as FAST_KNOTS
from .second_degree import fit, fit_stages
from .sensitivities import Sensitivity, simulate_slopes
from .table_writer import write_error, write_fast, write_tables
from .training_chains import (
    COARSE_NODES,
    DOUBLE_RAMPS,
    EARLY_CONTACTS,
    NODES,
    Sample,
    double_ramp_rates,
    ending_rates,
    exponential_rates,
    follow,
    gentle,
    join_samples,
    odd_rates,
    ramp_rates,
    random_rates,
    states_of,
    steep_rates,
    wavy_rates,
)  # fmt: skip


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
    ending : int
        Number of chains for the second order of the last contact, which is omitted if it is 0.
    slopes : tuple
        Numbers of long and of short chains whose derivatives are simulated for the products of
        fast changes; without them, there are no products with the slow change.
    """

    ramps: int
    double_ramps: int
    early: int
    followed: int
    repeated: int
    rounds: int
    every: int
    random: tuple[tuple[int, int, int, int, int], ...]
    ending: int
    slopes: tuple[int, int]


FULL: Final = Effort(
    4000, DOUBLE_RAMPS, 3, 1500, 3, 3, 4, ((63, 2600, 300, 300, 0),), 4000, (400, 900)
)
# Added to the constant c of the gain of products whose derivatives are fitted: unlike the
# attenuation, the second derivatives of single states do not vanish in equal beads.
REGULAR: Final = 0.03
# Contacts of the chains whose derivatives are simulated.
LONG, SHORT = 59, 30
# Units of the terms of the response in the fits.
UNITS: Final = UNIT ** np.array([1] * len(INPUTS) + [2] * len(PAIRS))[:, None, None]
# Exponent of the constants of reference.
HERTZ: Final = 1.5
# Number of chains of each class of the error estimate.
HELD_OUT: Final = 600


@dataclass(frozen=True, eq=False)
class Slow:
    """States of exponential chains, the response of all stages to slow changes, and ramps.

    Attributes
    ----------
    anchors : Anchors
        States of exponential chains.
    response : ndarray, shape (stages, terms, splines, 3)
        Response of all stages.
    followed : Sample
        Ramps and exponential chains of the Gauss-Newton fit.
    """

    anchors: Anchors
    response: Array
    followed: Sample


def first_response(
    exponent: float, anchors: Anchors, ramps: Sample, early: Sample
) -> tuple[Array, Array]:
    """Response of the first contacts, and of those within the chain, in units of the inputs."""
    guess = first_guess(exponent)
    if guess is not None:
        return guess[:START] * UNITS, guess[WITHIN] * UNITS
    early = join_samples([early, ramps.first(EARLY_CONTACTS)])
    start = np.array([fit_contact(anchors, k, early, [k]) for k in range(START)])
    return start, fit_contact(anchors, WITHIN, ramps, list(range(START, UNTIL)))


def slow_response(
    exponent: float,
    anchors: Anchors,
    exponential: Sample,
    ramps: Sample,
    early: Sample,
    effort: Effort,
) -> Slow:
    """Fit the response of all stages."""
    start, within = first_response(exponent, anchors, ramps, early)
    if first_guess(exponent) is not None:
        # Sharp ramps are needed for a guess only: slow rates are those of gentle ones.
        ramps = ramps.part(gentle(ramps.rates))
    parts = [ramps.part(slice(effort.followed)), *[exponential] * effort.repeated]
    followed = join_samples(parts)
    within = refine(anchors, within, followed, rounds=effort.rounds, every=effort.every)
    return Slow(anchors, np.array([*start, within]) / UNITS, followed)


def second_order(slow: Slow, functions: UniversalFunctions, effort: Effort) -> Array:
    """Response whose second order is fitted once more, now that the first order is exact."""
    added = missing_states(functions, slow.followed.rates)
    within = slow.response[WITHIN] * UNITS
    rounds = 2 * effort.rounds
    refined = refine(slow.anchors, within, slow.followed, added, rounds, effort.every)
    found = slow.response.copy()
    found[WITHIN] = refined / UNITS
    return found


def first_guess(exponent: float) -> Array | None:
    """Response from an earlier fit, if there is one: from it, the Gauss-Newton method starts.

    That of the first contacts is kept.  From a fit of single contacts, the method converges so
    slowly that the result is three times worse.
    """
    file = Path(__file__).parent / "first_guess" / f"p{exponent:g}.csv"
    return read_response(file)[1] if file.exists() else None


def random_chains(
    random: np.random.Generator,
    plan: tuple[tuple[int, int, int, int, int], ...],
    exponent: float,
    shrink: float = 1.0,
) -> tuple[list[Array], list[Array]]:
    """Rates and simulated states of random chains."""
    rates: list[Array] = []
    for contacts, rough, smooth, odd, steep in plan:
        rates += random_rates(random, rough, contacts, smooth=False, shrink=shrink)
        rates += random_rates(random, smooth, contacts, smooth=True, shrink=shrink)
        rates += odd_rates(random, odd, contacts, shrink)
        rates += steep_rates(random, steep, contacts, shrink)
    return simulated(rates, exponent)


def simulated(rates: list[Array], exponent: float) -> tuple[list[Array], list[Array]]:
    """Rates and simulated states of the chains for which the simulation succeeds."""
    found = states_of(rates, exponent)
    kept = [index for index, states in enumerate(found) if states is not None]
    return [rates[i] for i in kept], [states for states in found if states is not None]


def sloped_chains(
    effort: Effort, exponent: float, shrink: float
) -> tuple[list[Sensitivity], list[Sensitivity]]:
    """Simulated derivatives on long and short random chains."""
    random, (long, short) = np.random.default_rng(4), effort.slopes
    rates = wavy_rates(random, long, LONG, shrink), wavy_rates(random, short, SHORT, shrink)
    return simulate_slopes(rates[0], exponent), simulate_slopes(rates[1], exponent)


def slow_tables(
    exponent: float, shrink: float, effort: Effort, report: Callable[[str], None]
) -> Slow:
    """States of exponential chains, and the response to slow changes."""
    random = np.random.default_rng(0)
    report(f"p = {exponent:g}: {len(NODES)} exponential chains")
    exponential = follow(exponential_rates(shrink), exponent)
    anchors = Anchors(exponential, shrink)
    single = random.permutation(ramp_rates(COARSE_NODES[::2], shrink))[: effort.ramps]
    rates = np.concatenate([single, double_ramp_rates(random, effort.double_ramps, shrink)])
    first = ramp_rates(COARSE_NODES[:: effort.early], shrink, early=True)
    report(f"{len(rates)} ramps, {len(first)} early ramps")
    # In random order, because only the first ones are used in the Gauss-Newton fit.
    ramps, early = follow(random.permutation(rates), exponent), follow(first, exponent)
    report("response to slow changes")
    return slow_response(exponent, anchors, exponential, ramps, early, effort)


def fast_changes(
    exponent: float, slow: Slow, shrink: float, effort: Effort, report: Callable[[str], None]
) -> tuple[Array, dict[str, Array], UniversalFunctions]:
    """Response, tables of fast changes, and functions without an error estimate."""
    random, anchors, found = np.random.default_rng(1), slow.anchors, slow.response
    report("responses to single changes")
    measured = measure(exponent, shrink)
    measured["knots"] = scaled(FAST_KNOTS, shrink)
    measured["steady"] = np.array(steady_gain(exponent) + (REGULAR if effort.slopes[0] else 0.0))

    def functions() -> UniversalFunctions:
        return assemble(
            exponent, anchors.nodes, anchors.values, anchors.knots, found, measured, np.zeros(PARTS)
        )

    measured["second"] = np.zeros((len(FAST_KNOTS) + 2, STATES * FAST_PAIRS))
    measured["last_knots"] = scaled(LAST_KNOTS, shrink)
    measured["last"] = np.zeros((len(LAST_KNOTS) + 2, STATES * LAST_PRODUCTS))
    report("second order of slow changes")
    found = second_order(slow, functions(), effort)
    report("products of fast changes")
    chains = random_chains(random, effort.random, exponent, shrink)
    long, short = sloped_chains(effort, exponent, shrink)
    measured["second"] = fit(functions(), *chains, long)
    if effort.ending:
        report("last contact")
        ending = simulated(ending_rates(random, effort.ending, shrink), exponent)
        measured["last"] = fit_last(functions(), *ending, [*short, *long])
    if effort.slopes[1]:
        report("products of fast changes at both ends")
        measured["second"] = fit_stages(functions(), measured["second"], [*short, *long])
    return found, measured, functions()


def train(exponent: float, folder: Path, report: Callable[[str], None]) -> None:
    """Determine the universal functions of an exponent and write their tables."""
    folder = folder / f"p{exponent:g}"
    slow = slow_tables(exponent, 1.0, FULL, report)
    found, measured, functions = fast_changes(exponent, slow, 1.0, FULL, report)
    report("alternating rates")
    measured |= {"bases": BASES, "alternating": coefficients(functions)}
    write_tables(folder, slow.anchors, found)
    write_fast(folder, measured)
    report("error estimate")
    fast = fast_tables(exponent, functions.tables, **measured)
    train_error(dataclasses.replace(functions, fast=fast), folder)


def train_error(functions: UniversalFunctions, folder: Path) -> None:
    """Determine the constants of the error estimate, and write their table."""
    if functions.exponent == HERTZ:
        write_error(folder, np.append(REFERENCE, JAGGED))
        return
    classes = estimate_chains(np.random.default_rng(2), HELD_OUT)
    held_out = [simulated(rates, functions.exponent) for rates in classes]
    write_error(folder, error_constants(functions, held_out))
