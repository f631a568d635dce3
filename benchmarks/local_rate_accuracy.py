"""Accuracy of the local-rate law on random chains of all kinds, compared with `propagate`.

    python benchmarks/local_rate_accuracy.py [--count 100] [--seed 777] [--exponent 1.5 ...]
        [--lowest -0.14] [--json FILE]

For each class of chains (`local_rate_chains`), the script prints the largest error of the velocity
and the error of the last bead's velocity in %, the estimate's coverage, and the number of chains
with an error above 1% and without a warning, followed by the worst twenty of them.  The default is
about 3,000 chains.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from itertools import cycle
from pathlib import Path

import numpy as np
from local_rate_chains import all_chains

import hertzchain as hc

# Largest errors of chains without a warning that are listed.
LISTED = 20


def evaluate(rates: np.ndarray, exponent: float = 1.5) -> dict[str, object]:
    """Errors and estimates of the velocities on a chain."""
    radii = np.exp(np.concatenate([[0.0], np.cumsum(rates)]))
    chain = hc.Chain.from_radii(radii, exponent=exponent)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        law = hc.local_rate(chain)
    comparison = law.compare(hc.propagate(chain, rtol=1e-9))
    errors = np.abs(comparison.errors("velocity"))[1:]
    return {
        "warned": bool(caught), "errors": errors, "estimates": law.velocity_error[1:],
        "rates": rates, "exponent": exponent,
    }  # fmt: skip


def summarise(results: list[dict]) -> dict[str, float]:
    """Numbers of a class of chains."""
    velocity = [100.0 * one["errors"].max() for one in results]
    last = [100.0 * one["errors"][-1] for one in results]
    quiet = [one for one in results if not one["warned"]]
    of_quiet = [100.0 * one["errors"].max() for one in quiet]
    found = {
        "chains": len(results), "warned": len(results) - len(quiet),
        "median": np.median(velocity), "99%": np.quantile(velocity, 0.99), "worst": max(velocity),
        "last, median": np.median(last), "last, worst": max(last),
        "unwarned > 1%": sum(error > 1.0 for error in of_quiet),
        "worst unwarned": max(of_quiet, default=0.0),
    }  # fmt: skip
    true = np.concatenate([one["errors"] for one in results]) + 1e-9
    estimate = np.concatenate([one["estimates"] for one in results])
    known = np.isfinite(estimate)
    found["unknown"] = 100.0 * np.mean(~known)
    true, estimate = true[known], estimate[known]
    # In some classes far outside the tables, all errors are unknown.
    found["covered"] = 100.0 * np.mean(true <= estimate) if known.any() else np.nan
    found["error/estimate"] = np.max(true / estimate) if known.any() else np.nan
    found["estimate/error"] = np.median(estimate / true) if known.any() else np.nan
    return {name: float(value) for name, value in found.items()}


def cell(value: float, width: int, digits: int) -> str:
    """A number, without its digits if it is large."""
    text = f"{value:{width}.{digits}f}"
    return text if len(text) <= width else f"{value:{width}.0e}"


def show(table: dict[str, dict[str, float]]) -> None:
    """Print the numbers of all classes."""
    print(f"{'':38}  n warned | median     99%   worst | last: median worst | covered "
          "error/est. est./error unknown | unwarned > 1%")  # fmt: skip
    for name, row in table.items():
        print(
            f"{name:38}{row['chains']:4.0f} {row['warned']:4.0f} | {cell(row['median'], 8, 4)} "
            f"{cell(row['99%'], 7, 3)} {cell(row['worst'], 7, 3)} | "
            f"{cell(row['last, median'], 8, 4)} {cell(row['last, worst'], 7, 3)} | "
            f"{row['covered']:6.1f} {cell(row['error/estimate'], 6, 1)} "
            f"{cell(row['estimate/error'], 6, 1)} {row['unknown']:7.1f} | "
            f"{row['unwarned > 1%']:3.0f} {row['worst unwarned']:6.2f}"
        )


def show_worst(by_class: dict[str, list[dict]]) -> None:
    """Print the chains without a warning that have the largest errors."""
    quiet = [(name, one) for name, each in by_class.items() for one in each if not one["warned"]]
    quiet.sort(key=lambda pair: -pair[1]["errors"].max())
    print("\nlargest errors without a warning: error and estimate in %, bead, class, rates around")
    for name, one in quiet[:LISTED]:
        k = int(one["errors"].argmax())
        around = " ".join(f"{rate:.4f}" for rate in one["rates"][max(0, k - 3) : k + 3])
        print(
            f"{100 * one['errors'][k]:6.3f} {100 * one['estimates'][k]:7.3f} {k + 2:4} of "
            f"{len(one['rates']) + 1:<4} p = {one['exponent']:<5.4g} {name:38} {around}"
        )


def main(options: argparse.Namespace) -> None:
    """Evaluate all classes and print tables."""
    by_class: dict[str, list[dict]] = {}
    chains = all_chains(options.count, options.seed, options.lowest)
    for (name, rates), exponent in zip(chains, cycle(options.exponent), strict=False):
        try:
            by_class.setdefault(name, []).append(evaluate(rates, exponent))
        except (hc.SimulationError, hc.InputError) as error:
            print(f"{name}: {error}", file=sys.stderr)
    table = {name: summarise(results) for name, results in sorted(by_class.items()) if results}
    show(table)
    show_worst(by_class)
    total = sum(row["unwarned > 1%"] for row in table.values())
    print(f"\n{sum(map(len, by_class.values()))} chains, {total:.0f} unwarned errors above 1%")
    if options.json is not None:
        options.json.write_text(json.dumps(table, indent=1) + "\n", "utf-8")


def arguments() -> argparse.Namespace:
    """Options of the command line."""
    parser = argparse.ArgumentParser(description="accuracy of the local-rate law")
    parser.add_argument("--count", type=int, default=100, help="chains of each class")
    parser.add_argument("--seed", type=int, default=777)
    parser.add_argument("--exponent", type=float, nargs="+", default=[1.5], help="in turn")
    parser.add_argument("--lowest", type=float, default=-0.14, help="lowest rate of tapers")
    parser.add_argument("--json", type=Path)
    return parser.parse_args()


if __name__ == "__main__":
    main(arguments())
