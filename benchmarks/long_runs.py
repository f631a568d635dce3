"""Compare long runs between walls with a Verlet script: ``make benchmark``.

The script compares computing times for a given largest energy drift, of 100 equal beads between two
walls until T = 600: `hertzchain.simulate` with ``method="symplectic"``, and velocity Verlet in
twenty lines of numba.  It also measures the time for a pulse to pass uniform chains, as a function
of the number of beads.  Times are the shortest of several interleaved runs.  The script prints
tables and writes ``benchmark/long_runs.json``.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from numba import njit
from rich.console import Console
from rich.table import Table

import hertzchain as hc

BEADS, UNTIL, REPEATS = 100, 600.0, 7
# Largest energy drifts for which computing times are compared.
DRIFTS = (1e-5, 1.5e-7)


@njit(error_model="numpy", fastmath={"contract"})
def verlet(x, v, k, h, steps):  # type: ignore[no-untyped-def]
    """Velocity Verlet; x has a place for each wall."""
    n = len(v)
    f, a = np.zeros(n + 1), np.zeros(n)
    for s in range(steps + 1):
        if s > 0:
            for i in range(n):
                v[i] += 0.5 * h * a[i]
                x[i + 1] += h * v[i]
        for c in range(n + 1):
            d = x[c] - x[c + 1]
            d = d if d > 0.0 else 0.0
            f[c] = k[c] * d * math.sqrt(d)
        for i in range(n):
            a[i] = f[i] - f[i + 1]
            if s > 0:
                v[i] += 0.5 * h * a[i]


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def forces_between_walls(y, overlap, stiffness, inverse_mass, out):  # type: ignore[no-untyped-def]
    """Derivative of positions and velocities of beads between walls; overlaps are those at rest."""
    n, pushed = len(inverse_mass), 0.0
    for c in range(n + 1):
        d = overlap[c] + (y[c - 1] if c > 0 else 0.0) - (y[c] if c < n else 0.0)
        force = stiffness[c] * d * math.sqrt(d) if d > 0.0 else 0.0
        if c > 0:
            out[c - 1] = y[n + c - 1]
            out[n + c - 1] = (pushed - force) * inverse_mass[c - 1]
        pushed = force


def script(chain: hc.Chain, h: float, steps: int, pieces: int = 1) -> float:
    """Run the script in some pieces; returns its largest drift at their ends."""
    x, v, k = np.zeros(BEADS + 2), np.array(chain.velocities), np.array(chain.contact_stiffness)
    drift = 0.0
    for _ in range(pieces):
        verlet(x, v, k, h, steps // pieces)
        closed = np.maximum(x[:-1] - x[1:], 0.0)
        energy = 0.5 * (v**2).sum() + 0.4 * (k * closed**2.5).sum()
        drift = max(drift, abs(energy / 0.5 - 1.0))
    return drift


def step_of_script(chain: hc.Chain, drift: float) -> float:
    """A step of the script with a drift below the request."""
    h = math.sqrt(drift / 0.27)
    while script(chain, h, int(UNTIL / h), pieces=4000) > drift:
        h *= 0.95
    return h


def shortest(calls: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Shortest CPU time of each call [s]: interleaved runs, after first ones, which may compile."""
    best = dict.fromkeys(calls, math.inf)
    for call in calls.values():
        call()
    for _ in range(REPEATS):
        for name, call in calls.items():
            began = time.process_time()
            call()
            best[name] = min(best[name], time.process_time() - began)
    return best


def rattling() -> dict[str, dict[str, float]]:
    """Times of the symplectic method and of the script for each drift."""
    chain = hc.Chain.uniform(BEADS).replace(left_wall=hc.Wall(), right_wall=hc.Wall())
    found = {}
    for drift in DRIFTS:
        h = step_of_script(chain, drift)
        run = hc.simulate(chain, until=UNTIL, times=0, method="symplectic", drift=drift)

        times = shortest({
            "symplectic": partial(
                hc.simulate, chain, until=UNTIL, times=0, method=run.method, drift=drift
            ),
            "script": partial(script, chain, h, int(UNTIL / h)),
        })  # fmt: skip
        found[f"{drift:g}"] = {
            "symplectic": times["symplectic"], "drift": run.energy_drift, "script": times["script"],
            "ratio": times["symplectic"] / times["script"],
        }  # fmt: skip
    return found


def transits() -> dict[str, float]:
    """Time for a pulse to pass uniform chains at rtol = 1e-8, and its growth."""
    chains = {f"{n}": hc.Chain.uniform(n) for n in (1000, 4000)}
    calls = {
        name: partial(hc.simulate, chain, times=0, rtol=1e-8) for name, chain in chains.items()
    }
    found = shortest(calls)
    return found | {"growth": math.log(found["4000"] / found["1000"]) / math.log(4.0)}


def main() -> None:
    """Measure, print and save."""
    found = {"rattling": rattling(), "transit": transits()}
    console = Console(width=110)
    table = Table(title=f"{BEADS} equal beads between walls, T = {UNTIL:g}: times [ms]")
    for heading in ("drift requested", "found", "symplectic", "twenty-line Verlet", "ratio"):
        table.add_column(heading, justify="right")
    for drift, row in found["rattling"].items():
        table.add_row(
            drift, f"{row['drift']:.1e}", f"{1e3 * row['symplectic']:.1f}",
            f"{1e3 * row['script']:.1f}", f"{row['ratio']:.2f}",
        )  # fmt: skip
    console.print(table)
    table = Table(title="one pulse in equal beads, rtol = 1e-8: times [ms]")
    for heading in ("1000 beads", "4000 beads", "growth exponent"):
        table.add_column(heading, justify="right")
    transit = found["transit"]
    table.add_row(
        f"{1e3 * transit['1000']:.1f}", f"{1e3 * transit['4000']:.1f}", f"{transit['growth']:.2f}"
    )
    console.print(table)
    target = Path("benchmark") / "long_runs.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(found, indent=2) + "\n")
    console.print(f"written to {target}")


if __name__ == "__main__":
    main()
