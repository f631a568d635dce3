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
from hertzchain.theory.exponents import scaled, steady_gain
from hertzchain.theory.universal_functions import (
    START,
    WITHIN,
    UniversalFunctions,
    assemble,
    fast_tables,
    read_response,
)  # fmt: skip

from .alternation import BASES, coefficients
from .balance import balance, beads_of, estimate_pulses
from .error_fit import JAGGED, REFERENCE, error_constants
from .estimate_chains import estimate_chains
from .fast_data import Effort, fast_data, simulated
from .last_fit import KNOTS as LAST_KNOTS
from .last_fit import ending_slopes, fit_last
from .response_fit import UNITS, Anchors, fit_contact
from .responses import measure
from .rollout import UNTIL, missing_states, refine
from .second_degree import KNOTS as FAST_KNOTS
from .second_degree import Chains, fit, fit_stages
from .short_chains import NONE, left_by_impact
from .start_fit import fit_start
from .stored import Stored
from .table_writer import write_error, write_fast, write_tables
from .training_chains import (
    COARSE_NODES,
    DOUBLE_RAMPS,
    EARLY_CONTACTS,
    Sample,
    double_ramp_rates,
    exponential_rates,
    follow,
    gentle,
    join_samples,
    ramp_rates,
)  # fmt: skip

# Number of coefficients of higher orders of the last four contacts.
LAST_COEFFICIENTS: Final = 552
FULL: Final = Effort(
    4000, DOUBLE_RAMPS, 3, 1500, 3, 3, 4, ((63, 2600, 300, 300, 0),), (400, 900), 1500, 600
)
# Added to the constant c of the gain of products whose derivatives are fitted: unlike the
# attenuation, the second derivatives of single states do not vanish in equal beads.
REGULAR: Final = 0.03
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


def slow_tables(exponent: float, shrink: float, effort: Effort) -> Slow:
    """States of exponential chains, and the response to slow changes."""
    random = np.random.default_rng(0)
    exponential = follow(exponential_rates(shrink), exponent)
    anchors = Anchors(exponential, shrink)
    single = random.permutation(ramp_rates(COARSE_NODES[::2], shrink))[: effort.ramps]
    rates = np.concatenate([single, double_ramp_rates(random, effort.double_ramps, shrink)])
    first = ramp_rates(COARSE_NODES[:: effort.early], shrink, early=True)
    # In random order, because only the first ones are used in the Gauss-Newton fit.
    ramps, early = follow(random.permutation(rates), exponent), follow(first, exponent)
    return slow_response(exponent, anchors, exponential, ramps, early, effort)


def fast_changes(
    exponent: float, slow: Slow, shrink: float, effort: Effort, stored: Stored
) -> tuple[Array, dict[str, Array], UniversalFunctions]:
    """Response, tables of fast changes, and functions without an error estimate."""
    anchors, found = slow.anchors, slow.response
    measured = dict(stored("responses to single changes", lambda: measure(exponent, shrink)))
    measured["knots"] = scaled(FAST_KNOTS, shrink)
    measured["steady"] = np.array(steady_gain(exponent) + (REGULAR if effort.slopes[0] else 0.0))

    def of_response(response: Array) -> UniversalFunctions:
        slow = anchors.nodes, anchors.values, anchors.knots
        return assemble(exponent, *slow, response, measured, np.zeros(PARTS))

    def functions() -> UniversalFunctions:
        return of_response(found)

    measured["second"] = np.zeros((len(FAST_KNOTS) + 2, STATES * FAST_PAIRS))
    found = stored("second order of slow changes", lambda: second_order(slow, functions(), effort))
    data = stored("chains with fast changes", lambda: fast_data(effort, exponent, shrink))
    if effort.starting:
        refined = found
        found = stored(
            "first contacts", lambda: fit_start(of_response, anchors, refined, [data.starting])
        )
    values, sloped = data.weighted(), [*data.short, *data.long]
    measured["second"] = stored(
        "products of fast changes", lambda: fit(functions(), values, data.long)
    )
    if effort.slopes[1]:
        nothing = np.zeros((len(LAST_KNOTS) + 2, LAST_COEFFICIENTS))
        measured |= {"last_knots": LAST_KNOTS, "last": nothing}
        measured["short"] = NONE
        measured["short"] = stored("short chains", lambda: left_by_impact(functions(), shrink))
        ending = stored("chains with changes at the end", lambda: ending_slopes(exponent))
        measured["last"] = stored("last contacts", lambda: fit_last(functions().fast, ending))
        within = measured["second"]
        measured["second"] = stored(
            "products of fast changes at both ends",
            lambda: fit_stages(functions(), within, sloped, data.starting),
        )
    return found, measured, functions()


def train(
    exponent: float, folder: Path, report: Callable[[str], None], work: Path | None = None
) -> None:
    """Determine the universal functions of an exponent and write their tables."""
    folder, stored = folder / f"p{exponent:g}", Stored(work, report)
    report(f"p = {exponent:g}")
    slow = stored("slow changes", lambda: slow_tables(exponent, 1.0, FULL))
    found, measured, functions = fast_changes(exponent, slow, 1.0, FULL, stored)
    alternating = stored("alternating rates", lambda: coefficients(functions))
    measured |= {"bases": BASES, "alternating": alternating}
    write_tables(folder, slow.anchors, found)
    write_fast(folder, measured)
    report("error estimate")
    fast = fast_tables(exponent, functions.slow, **measured)
    functions = dataclasses.replace(functions, fast=fast)
    write_error(folder, estimate_constants(functions, stored))


def estimate_constants(functions: UniversalFunctions, stored: Stored) -> Array:
    """Constants of the error estimate."""
    if functions.exponent == HERTZ:
        pulses = stored("chains of the estimate", estimate_pulses)
        return balance(beads_of(functions, pulses), np.append(REFERENCE, JAGGED))

    def held_out() -> list[Chains]:
        classes = estimate_chains(np.random.default_rng(2), HELD_OUT)
        return [simulated(rates, functions.exponent) for rates in classes]

    return error_constants(functions, stored("chains of the estimate", held_out))
