"""Accuracy of the local-rate law on random chains of all kinds, compared with `propagate`.

    python benchmarks/local_rate_accuracy.py [CHAINS OF EACH CLASS] [FILE]

The chains have their own generator, which differs from that of `tools/training`.  For each class,
the script prints the largest error of the velocity and the error of the last bead's velocity in %,
the estimate's coverage, and the number of chains with an error above 1% and without a warning.
The default is about 2,100 chains.
"""

from __future__ import annotations

import json
import sys
import warnings
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

import hertzchain as hc

SMOOTH = ("sines", "spline", "sigmoids", "power", "gauss", "chirp", "ramps", "noise")
SCATTERS = (0.001, 0.003, 0.01, 0.02)
ALTERNATING = (0.99, 0.97, 0.9)
LOWEST, HIGHEST, LONGEST = -0.14, 0.3, 25.0


def shape(random: np.random.Generator, kind: str, contacts: int) -> np.ndarray:
    """Rates of a smooth taper, with any amplitude."""
    k = np.arange(contacts)
    if kind == "sines":
        periods = np.exp(random.uniform(np.log(15.0), np.log(200.0), 3))
        phases = random.uniform(0.0, 7.0, 3)
        return np.sin(2.0 * np.pi * k[:, None] / periods + phases) @ random.normal(size=3)
    if kind == "spline":
        points = max(4, int(contacts / random.uniform(12.0, 40.0)) + 2)
        return CubicSpline(np.linspace(0, contacts, points), random.normal(size=points))(k)
    if kind == "sigmoids":
        centres, widths = random.uniform(0, contacts, 3), random.uniform(4.0, 25.0, 3)
        return np.cosh((k[:, None] - centres) / widths) ** -2.0 @ random.normal(size=3)
    if kind == "power":
        return random.choice((-1, 1)) / (k + random.uniform(5.0, 60.0))
    if kind == "gauss":
        white = random.normal(size=contacts + 200)
        return gaussian_filter1d(white, random.uniform(5.0, 30.0))[100 : 100 + contacts]
    if kind == "chirp":
        period, faster = np.exp(random.uniform(np.log(20), np.log(80))), random.uniform(0, 0.7)
        cycles = k / period * (1.0 + faster * k / contacts)
        return np.sin(2.0 * np.pi * (cycles + random.random()))
    if kind == "ramps":
        corners = np.sort(random.uniform(0, contacts, 4))
        return np.interp(k, [0, *corners, contacts], random.normal(size=6))
    values, x = random.normal(size=400), k / random.uniform(10.0, 60.0)
    cell, t = x.astype(int), x % 1.0
    t = t**3 * (t * (6.0 * t - 15.0) + 10.0)
    return values[cell] * (1.0 - t) + values[cell + 1] * t


def smooth_rates(random: np.random.Generator, kind: str, contacts: int, top: float) -> np.ndarray:
    """Rates of a smooth taper; some change around another rate than 0."""
    while True:
        rates = shape(random, kind, contacts)
        rates = rates / np.abs(rates).max() * top
        rates += random.normal() * 0.02 if random.random() < 0.4 else 0.0
        if rates.min() > LOWEST and rates.max() < HIGHEST and abs(rates.sum()) < LONGEST:
            return rates


def class_of(rates: np.ndarray) -> str:
    """Class of a taper: by its roughness and its lowest rate."""
    if np.abs(np.diff(rates)).max() > 0.005:
        return "tapers, rough"
    for limit in (0.0, -0.02, -0.05, -0.1):
        if rates.min() > limit:
            return f"tapers, smooth, lowest rate > {limit:g}"
    return "tapers, smooth, any rate"


def scattered(random: np.random.Generator, scatter: float, beads: int = 100) -> np.ndarray:
    """Rates of beads with random radii."""
    return np.diff(np.log(1.0 + scatter * random.standard_normal(beads)))


def random_chains(count: int, seed: int = 777) -> list[tuple[str, np.ndarray]]:
    """Rates of chains with the name of their class; ``count`` chains in most classes."""
    random = np.random.default_rng(seed)
    found = []

    def taper(kind: str, low: float, high: float, contacts: int | None = None) -> np.ndarray:
        contacts = contacts or int(np.exp(random.uniform(np.log(20), np.log(300)))) - 1
        top = np.exp(random.uniform(np.log(low), np.log(high)))
        return smooth_rates(random, kind, contacts, top)

    for i in range(8 * count):
        rates = taper(SMOOTH[i % 8], 0.004, 0.12)
        found.append((class_of(rates), rates))
    for scatter in SCATTERS:
        for i in range(count):
            found.append((f"equal beads, scatter {scatter:.1%}", scattered(random, scatter)))
            rates = taper(SMOOTH[i % 8], 0.01, 0.06, 99) + scattered(random, scatter)
            found.append((f"tapers, scatter {scatter:.1%}", rates))
    for ratio in ALTERNATING:
        for first, second in ((1.0, ratio), (ratio, 1.0)):
            radii = np.resize([first, second], 100)
            found.append((f"alternating 1 : {ratio:g}", np.diff(np.log(radii))))
    for i in range(count):
        rates = taper(SMOOTH[i % 8], 0.004, 0.06, int(random.integers(8, 19)))
        found.append(("short tapers, 9 to 19 beads", rates))
        step = np.zeros(int(random.integers(20, 150)))
        step[random.integers(1, len(step))] = random.normal() * 0.15
        found.append(("one step of radius", step))
        cells = random.uniform(0.3, 1.0, int(random.integers(2, 4)))
        found.append(("periodic chains", np.diff(np.log(np.resize(cells, 60)))))
        odd = np.ones(64)
        odd[random.integers(1, 64)] = np.exp(random.normal() * 0.3)
        found.append(("one odd bead", np.diff(np.log(odd))))
        decorated = np.ones(int(random.integers(20, 150)))
        decorated[1 :: random.integers(2, 5)] = np.exp(-np.exp(random.uniform(-6.0, 0.4)))
        found.append(("decorated chains", np.diff(np.log(decorated))))
    return found


def evaluate(rates: np.ndarray) -> dict[str, object]:
    """Errors and estimates of the velocities on a chain."""
    chain = hc.Chain.from_radii(np.exp(np.concatenate([[0.0], np.cumsum(rates)])))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        law = hc.local_rate(chain)
    comparison = law.compare(hc.propagate(chain, rtol=1e-9))
    errors = np.abs(comparison.errors("velocity"))[1:]
    return {"warned": bool(caught), "errors": errors, "estimates": law.velocity_error[1:]}


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
    found["covered"] = 100.0 * np.mean(true <= estimate)
    found["error/estimate"] = np.max(true / estimate)
    found["estimate/error"] = np.median(estimate / true)
    return {name: float(value) for name, value in found.items()}


def main(count: int, file: Path | None) -> None:
    """Evaluate all classes and print a table."""
    by_class: dict[str, list[dict]] = {}
    for name, rates in random_chains(count):
        try:
            by_class.setdefault(name, []).append(evaluate(rates))
        except hc.SimulationError as error:
            print(f"{name}: {error}", file=sys.stderr)
    table = {name: summarise(results) for name, results in sorted(by_class.items())}
    print(f"{'':38}  n  warned | median    99%  worst | last: median worst | "
          "covered  error/est.  est./error | unwarned > 1%")  # fmt: skip
    for name, row in table.items():
        print(
            f"{name:38}{row['chains']:4.0f} {row['warned']:4.0f} | {row['median']:7.4f} "
            f"{row['99%']:7.3f} {row['worst']:8.3f} | {row['last, median']:7.4f} "
            f"{row['last, worst']:8.3f} | {row['covered']:6.1f} {row['error/estimate']:6.1f} "
            f"{row['estimate/error']:6.1f} | {row['unwarned > 1%']:3.0f} "
            f"{row['worst unwarned']:6.2f}"
        )
    if file is not None:
        file.write_text(json.dumps(table, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    chains = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    main(chains, Path(sys.argv[2]) if len(sys.argv) > 2 else None)
