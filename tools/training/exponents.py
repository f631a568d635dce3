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
from hertzchain.kernels.fast_changes import PARTS
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

from .error_fit import SAFETY, quantile_fit, terms_and_errors
from .train import Effort, fast_changes, random_chains, slow_tables

# Less than for Hertz contacts: the differences between neighbouring exponents would show no more.
EFFORT: Final = Effort(1600, 600, 9, 500, 2, 2, 5, ((63, 700, 100, 0, 0),), 0)
# The constants of the error estimate are piecewise linear in the logarithm of the exponent.  They
# are determined at that many random exponents, so that they include errors of the interpolation.
ERROR_EXPONENTS: Final = np.geomspace(LOWEST, HIGHEST, 8)
TRIED: Final = 160
# There are fewer chains of each exponent, so that the estimate must be more cautious.
COVERED: Final = 0.99
CAUTION: Final = SAFETY.copy()
CAUTION[9] = 4.0
HELD_OUT: Final = (
    (63, 5, 5, 3, 4), (99, 3, 2, 2, 2), (150, 1, 1, 0, 1), (12, 2, 1, 1, 1), (22, 2, 1, 1, 1),
    (8, 1, 1, 1, 1),
)  # fmt: skip


def one_exponent(exponent: float, report: Callable[[str], None]) -> dict[str, Array]:
    """Tables of one exponent."""
    shrink = shrink_of(exponent)
    slow = slow_tables(exponent, shrink, EFFORT, report)
    response, measured, _ = fast_changes(exponent, slow, shrink, EFFORT, report)
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
    parts, errors = [], []
    for count, log in enumerate(logs):
        exponent = float(np.exp(log))
        report(f"error estimate, {count + 1} of {TRIED}: p = {exponent:.4g}")
        chains = random_chains(random, HELD_OUT, exponent, shrink_of(exponent))
        functions = functions_of(exponent, interpolated_tables(folder, exponent))
        part, error = terms_and_errors(functions, *chains)
        share = [
            np.interp(log, np.log(ERROR_EXPONENTS), hat) for hat in np.eye(len(ERROR_EXPONENTS))
        ]
        parts.append((np.array(share)[:, None] * part[:, None, :]).reshape(len(part), -1))
        errors.append(error)
    constants = quantile_fit(np.concatenate(parts), np.concatenate(errors), COVERED)
    with np.load(folder / FILE) as stored:
        tables = dict(stored)
    # Terms that are rarely large differ by chance: each exponent has the larger constant of its
    # neighbours.
    fitted = CAUTION * constants.reshape(len(ERROR_EXPONENTS), PARTS)
    padded = np.concatenate([fitted[:1], fitted, fitted[-1:]])
    tables["errors"] = np.max([padded[:-2], padded[1:-1], padded[2:]], axis=0)
    # An error of 1.4% at the end of a short chain was without a warning.
    tables["errors"][0] *= 2.0
    np.savez_compressed(folder / FILE, **tables)


def main(work: Path, folder: Path) -> None:
    """Determine all tables."""

    def report(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    write_tables(folder, all_exponents(work, report))
    add_estimate(folder, report)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
