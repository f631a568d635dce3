"""Determine the tables between which the law interpolates for other exponents.

    PYTHONPATH=tools python -m training.exponents WORK src/hertzchain/theory/universal_tables

WORK keeps the tables of finished exponents, so that an interrupted run can be resumed.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np

from hertzchain.collision import Array
from hertzchain.kernels.error_terms import PARTS
from hertzchain.theory.exponents import (
    EXPONENTS,
    FILE,
    HIGHEST,
    LOWEST,
    PLACES,
    interpolated_tables,
    pack_tables,
    scaled,
    shrink_of,
)
from hertzchain.theory.universal_functions import INPUTS, functions_of

from .error_fit import FITTED, REFERENCE, quantile_fit, terms_and_errors
from .estimate_chains import estimate_chains
from .fast_data import Effort, simulated
from .stored import Stored
from .train import fast_changes, slow_tables

# Less than for Hertz contacts: the differences between neighbouring exponents would show no more.
EFFORT: Final = Effort(1600, 600, 9, 500, 2, 2, 5, ((63, 700, 100, 0, 0),), (0, 0), 0, 0)
# The constants of the error estimate are piecewise linear in the logarithm of the exponent.  They
# are determined at that many random exponents, so that they include errors of the interpolation.
ERROR_EXPONENTS: Final = np.geomspace(LOWEST, HIGHEST, 8)
TRIED: Final = 160
# Number of chains of each class at each exponent.
HELD_OUT: Final = 8
# Fewer chains of each exponent require more caution, above all about changes in strong backward
# tapers, where the response to slow changes is less accurate, and at the free end.
CAUTION: Final = np.full(FITTED, 2.3)
CAUTION[[5, 11, 12]] = 4.0
# Constant of the last term, for the largest exponents.
JAGGED: Final = 1.0
# Share of the beads below which a term is too rare for a fit.
RARE: Final = 0.01


def one_exponent(exponent: float, report: Callable[[str], None]) -> dict[str, Array]:
    """Tables of one exponent."""
    shrink = shrink_of(exponent)
    stored = Stored(None, lambda stage: report(f"p = {exponent:.4g}: {stage}"))
    slow = stored("slow changes", lambda: slow_tables(exponent, shrink, EFFORT))
    response, measured, _ = fast_changes(exponent, slow, shrink, EFFORT, stored)
    anchors = slow.anchors
    return {
        "nodes": anchors.nodes, "values": anchors.values, "knots": anchors.knots,
        "response": response, "places": measured["places"], "single": measured["single"],
        "early": measured["early"],
        "end": measured["end"], "end_slopes": measured["end_slopes"],
        "fast_knots": measured["knots"], "second": measured["second"],
    }  # fmt: skip


def all_exponents(work: Path, report: Callable[[str], None]) -> list[dict[str, Array]]:
    """Tables of all exponents, computed unless they are known."""
    work.mkdir(parents=True, exist_ok=True)
    found = []
    for exponent in EXPONENTS:
        file = work / f"p{exponent:.4f}.npz"
        if not file.exists():
            np.savez(file, **one_exponent(exponent, report))
        with np.load(file) as stored:
            found.append({name: stored[name] for name in stored})
    return found


def write_tables(folder: Path, found: list[dict[str, Array]]) -> None:
    """Write the tables of all exponents, still without an error estimate."""
    stacked = {name: np.array([each[name] for each in found]) for name in found[0]}
    response = stacked.pop("response")
    stacked["linear"] = response[:, :, : len(INPUTS)]
    stacked["products"] = response[:, :, len(INPUTS) :]
    # Those of the first exponent, without the factor of its negative rates.
    places = {name: scaled(found[0][name], 1.0 / shrink_of(EXPONENTS[0])) for name in PLACES}
    np.savez_compressed(
        folder / FILE,
        **pack_tables(stacked),
        **{name: np.round(each, 6) for name, each in places.items()},
        error_exponents=ERROR_EXPONENTS,
        errors=np.zeros((len(ERROR_EXPONENTS), PARTS)),
    )


def add_estimate(folder: Path, report: Callable[[str], None]) -> None:
    """Determine the error estimate on chains of random exponents, and add it to the tables."""
    random = np.random.default_rng(3)
    # One exponent in each of so many intervals.
    cells = (np.arange(TRIED) + random.random(TRIED)) / TRIED
    logs = np.log(LOWEST) + np.log(HIGHEST / LOWEST) * cells
    found = []
    for count, log in enumerate(logs):
        exponent = float(np.exp(log))
        report(f"error estimate, {count + 1} of {TRIED}: p = {exponent:.4g}")
        classes = estimate_chains(random, HELD_OUT, shrink_of(exponent))
        chains = [rates for each in classes for rates in each]
        functions = functions_of(exponent, interpolated_tables(folder, exponent))
        found.append(terms_and_errors(functions, simulated(chains, exponent)))
    with np.load(folder / FILE) as stored:
        tables = dict(stored)
    tables["errors"] = error_constants(logs, found)
    np.savez_compressed(folder / FILE, **tables)


def error_constants(logs: Array, found: list[tuple[Array, Array, Array]]) -> Array:
    """Constants of the estimate, from terms, errors and weights at all tried exponents."""
    at, constants, known = np.log(ERROR_EXPONENTS), [], []
    for hat in np.eye(len(at)):
        shares = np.interp(logs, at, hat)
        near = np.flatnonzero(shares)
        parts, errors = (np.concatenate([found[i][n] for i in near]) for n in (0, 1))
        parts = parts[:, :FITTED]
        weights = np.concatenate([shares[i] * found[i][2] for i in near])
        fitted = quantile_fit(parts, errors, weights=weights, reference=REFERENCE)
        constants.append(CAUTION * fitted)
        known.append(weights @ (parts > 0.0) > RARE * weights.sum())
    all_of_them, often = np.array(constants), np.array(known)
    # Steep forward tapers are outside the tables of small exponents.
    largest = np.max(all_of_them, axis=0, where=often, initial=0.0)
    all_of_them = np.where(often | ~often.any(axis=0), all_of_them, largest)
    return np.column_stack([all_of_them, np.full(len(at), JAGGED)])


def main(work: Path, folder: Path) -> None:
    """Determine all tables."""

    def report(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    write_tables(folder, all_exponents(work, report))
    add_estimate(folder, report)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
