"""Measure speed and accuracy of the leading pulse: ``make benchmark``.

The script prints tables and writes the numbers to ``benchmark/benchmark.json``.  Ratios are those
of medians measured in the same run, because the machine may be shared.
"""

from __future__ import annotations

import functools
import json
import math
import os
import platform
import resource
import statistics
import subprocess
import sys
import time
import timeit
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import other_solvers
from numba import njit
from rich.console import Console
from rich.table import Table
from scipy.integrate import solve_ivp

import hertzchain as hc
from hertzchain.kernels import narrow_window, narrow_window_rows
from hertzchain.propagation import window_choice
from hertzchain.propagation.batch import Batch

BEADS = 100
TAPERS = {
    "backward-exponential": 0.05,
    "backward-linear": 0.5,
    "forward-exponential": 0.05,
    "forward-linear": 0.009,
}
ENSEMBLE = 4_000
REPEATS = 7
# Error that all solvers must reach on all four tapers.
GOAL = 1e-7
LENGTHS = (100, 1_000, 10_000, 100_000, 1_000_000)


@dataclass(frozen=True)
class Row:
    """Error and time of one solver on one chain."""

    solver: str
    taper: str
    error: float
    seconds_per_passage: float


def median_time(
    action: Callable[[], object], repeats: int = REPEATS, *, wall: bool = False
) -> float:
    """Median CPU time of several runs [s], after one that is not measured.

    Calls that use several threads are measured by wall time.
    """
    clock = time.perf_counter if wall else time.process_time
    action()
    times = []
    for _ in range(repeats):
        began = clock()
        action()
        times.append(clock() - began)
    return statistics.median(times)


def shortest_time(action: Callable[[], object]) -> float:
    """Shortest of many times [s], for calls of microseconds that other processes may interrupt."""
    action()
    times = timeit.repeat(action, number=20, repeat=500)
    return min(times) / 20


def propagate_rows(taper: str, chain: hc.Chain, exact: np.ndarray) -> list[Row]:
    """A single chain, and an ensemble of nearly equal chains on one and two threads."""
    rows = []
    for rtol in (1e-7, 1e-8):
        velocity = hc.propagate(chain, rtol=rtol).velocity
        error = largest(velocity[1:], exact[1:])
        seconds = median_time(lambda rtol=rtol: hc.propagate(chain, rtol=rtol), 40)
        rows.append(Row(f"single chain at {rtol:g}", taper, error, seconds / (BEADS - 1)))
        radii = ensemble(taper)
        for threads in (1, 2):
            seconds = median_time(
                lambda rtol=rtol, radii=radii, threads=threads: hc.propagate_many(
                    radii, rtol=rtol, threads=threads
                ),
                wall=threads > 1,
            )
            name = f"ensemble at {rtol:g}, " + ("1 thread", "2 threads, wall time")[threads - 1]
            rows.append(Row(name, taper, error, seconds / len(radii) / (BEADS - 1)))
    return rows


def ensemble(taper: str) -> np.ndarray:
    """Chains with rates within 2% of the taper's."""
    if taper == "uniform":
        return np.ones((ENSEMBLE, BEADS))
    rates = TAPERS[taper] * np.linspace(0.98, 1.02, ENSEMBLE)
    return np.array([hc.Chain.tapered(taper, rate, beads=BEADS).radii for rate in rates])


def scipy_rows(taper: str, chain: hc.Chain, exact: np.ndarray, until: float) -> list[Row]:
    """SciPy at the largest tolerance that reaches the required error."""
    rows = []
    for method in ("DOP853", "LSODA"):
        for compiled in (False, True):
            for rtol in (1e-8, 1e-9, 1e-10, 1e-11, 1e-12):
                found, seconds = other_solvers.scipy_solver(
                    chain.radii, until, method=method, rtol=rtol, compiled=compiled
                )
                error = largest(found, exact[1:-1])
                if error <= GOAL:
                    break
            seconds = min(
                seconds,
                other_solvers.scipy_solver(
                    chain.radii, until, method=method, rtol=rtol, compiled=compiled
                )[1],
            )
            name = f"SciPy {method}, {'numba' if compiled else 'numpy'} rhs, rtol {rtol:g}"
            rows.append(Row(name, taper, error, seconds / (BEADS - 1)))
    return rows


def fixed_step_rows(taper: str, chain: hc.Chain, exact: np.ndarray, until: float) -> list[Row]:
    """Velocity Verlet in a script and in LAMMPS; the step is a fiftieth of the shortest time."""
    step = 0.02 * float(np.diff(hc.propagate(chain).arrival).min())
    rows = []
    found, seconds = other_solvers.verlet_script(chain.radii, until, step=step)
    rows.append(Row("numba Verlet script", taper, largest(found, exact[1:-1]), seconds / 99))
    if other_solvers.lammps_missing() is None:
        found, seconds = other_solvers.lammps_chain(chain.radii, until, step=step)
        rows.append(Row("LAMMPS", taper, largest(found, exact[1:-1]), seconds / 99))
    return rows


def largest(found: np.ndarray, exact: np.ndarray) -> float:
    """Largest relative error."""
    return float(np.max(np.abs(found / exact - 1.0)))


@njit(cache=True, error_model="numpy")
def square_roots(values, times):
    """Compute a vectorised square root of each value, ``times`` times."""
    half = len(values) // 2
    for _ in range(times):
        for i in range(half):
            values[half + i] = math.sqrt(values[i])
        values[0] = values[half] + 1.0


def time_in_square_roots() -> dict[str, float]:
    """Time of the kernel per force evaluation of a contact, in units of a vectorised root."""
    values, times = np.full(2 * 104, 1.5), 20_000
    results = {}
    for taper, window in (
        ("uniform", window_choice.WINDOWS.narrow), ("forward", window_choice.WINDOWS.wide),
    ):  # fmt: skip
        rate = 0.05
        chains = [
            hc.Chain.uniform(BEADS) if taper == "uniform"
            else hc.Chain.tapered("forward-exponential", rate, beads=BEADS)
        ] * 400  # fmt: skip
        batch = Batch.of(chains)
        given = (batch.given, batch.first, batch.beads, None)
        columns = np.empty((narrow_window_rows.COLUMNS, len(batch.masses)))
        ratios, steps = [], 0
        for _ in range(REPEATS + 2):
            status, signal = np.zeros(len(chains), np.int64), np.zeros(2, np.int64)
            began = time.process_time()
            steps = narrow_window.follow(
                narrow_window.ABREAST, (*window, window_choice.STEP_PART, 0.1),
                (np.inf, np.inf, np.inf), given, columns, status, signal,
                narrow_window.scratch_of(narrow_window.ABREAST),
            )  # fmt: skip
            middle = time.process_time()
            square_roots(values, times)
            ended = time.process_time()
            evaluations = steps * 8 * window[0] * narrow_window_rows.LANES
            root = (ended - middle) / (times * len(values) / 2)
            ratios.append((middle - began) / evaluations / root)
        results[f"{taper}, window of {window[0]}"] = statistics.median(ratios[2:])
    results["nanoseconds per square root"] = 1e9 * root
    return results


def growth() -> dict[str, Any]:
    """Time and error of single chains of equal beads, and exponent of the growth of the time."""
    seconds, errors = [], []
    for beads in LENGTHS:
        chain = hc.Chain.uniform(beads)
        repeats = 9 if beads < 100_000 else 3
        seconds.append(median_time(lambda chain=chain: hc.propagate(chain), repeats))
        velocity = hc.propagate(chain).velocity[int(0.9 * beads)]
        errors.append(abs(float(velocity) / 0.681631548571 - 1.0))
    slope = np.polyfit(np.log(LENGTHS[1:]), np.log(seconds[1:]), 1)[0]
    return {"beads": LENGTHS, "seconds": seconds, "error": errors, "exponent": float(slope)}


def first_call() -> dict[str, float]:
    """Time of import and first call in a new process with compiled code, median of five [s]."""
    code = (
        "import time; t = time.perf_counter(); import hertzchain as hc; "
        "hc.propagate(hc.Chain.uniform(100)); print(time.perf_counter() - t)"
    )
    run = [sys.executable, "-c", code]
    times = [float(subprocess.run(run, capture_output=True, check=True).stdout) for _ in range(6)]
    return {"seconds": statistics.median(times[1:])}


def paper() -> dict[str, float]:
    """Time of all chains of the paper, with a hundred beads [s]."""
    rates = {
        "backward-exponential": np.arange(1, 9) / 100,
        "forward-exponential": np.arange(1, 7) / 100,
        "backward-linear": np.arange(1, 10) / 10,
        "forward-linear": np.arange(1, 11) / 1000,
    }
    chains = [
        hc.Chain.tapered(taper, float(rate), beads=BEADS - (rate == 0.01 and "linear" in taper))
        for taper, some in rates.items()
        for rate in some
    ]
    failed = hc.propagate_many(chains).reasons
    return {
        "chains": len(chains),
        "failed": len(failed),
        "seconds": median_time(lambda: hc.propagate_many(chains, threads=1)),
    }


def local_rate_times() -> dict[str, float]:
    """Shortest time of the local-rate law and its gradient on the slowest taper [us]."""
    chains = [hc.Chain.tapered(taper, rate, beads=BEADS) for taper, rate in TAPERS.items()]
    actions: dict[str, Callable[[hc.Chain], object]] = {
        "local_rate": hc.local_rate,
        "local_rate_gradient": lambda chain: hc.local_rate_gradient(chain, bead=BEADS),
        "local_rate_gradient of the arrival": lambda chain: hc.local_rate_gradient(
            chain, "arrival", bead=BEADS
        ),
    }
    return {
        name: 1e6 * max(shortest_time(functools.partial(action, chain)) for chain in chains)
        for name, action in actions.items()
    }


# Peak memory of a process [kB]. On Linux, ru_maxrss includes that of the parent process.
PEAK = (
    "import pathlib, resource; status = pathlib.Path('/proc/self/status');"
    "peak = lambda: int(status.read_text().split('VmHWM:')[1].split()[0]) if status.exists() "
    "else resource.getrusage(resource.RUSAGE_SELF).ru_maxrss;"
)


def sweep() -> dict[str, float]:
    """Time and memory of 1e5 chains of a hundred beads on two threads, in a separate process."""
    code = (
        PEAK + "import numpy as np, hertzchain as hc, time;"
        "q = np.linspace(0.01, 0.06, 100_000)[:, None]; radii = (1 + q) ** -np.arange(100.0);"
        "hc.propagate_many(radii[:20]); t = time.perf_counter();"
        "hc.propagate_many(radii, threads=2, rtol=1e-7);"
        "print(time.perf_counter() - t, peak())"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout
    seconds, kilobytes = map(float, out.split())
    return {
        "seconds": seconds,
        "million passages per second and core": 9.9 / seconds / 2,
        "GiB": kilobytes / 2**20,
    }


def long_chain() -> dict[str, float]:
    """Time and memory of a million equal beads, in a separate process with compiled code."""
    code = (
        PEAK + "import time, hertzchain as hc; t = time.perf_counter();"
        "hc.propagate(hc.Chain.uniform(1_000_000));"
        "print(time.perf_counter() - t, peak())"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout
    seconds, kilobytes = map(float, out.split())
    return {"seconds": seconds, "GiB": kilobytes / 2**20}


def heterogeneous_chains() -> dict[str, hc.Chain]:
    """Chains that scatter the pulse, and chains with other force laws."""
    random = np.random.default_rng(7)
    return {
        "dimer, radii 1 and 0.5": hc.Chain.from_radii(np.tile([1.0, 0.5], BEADS // 2)),
        "decorated, radii 1 and 0.3": hc.Chain.from_radii(np.tile([1.0, 0.3], BEADS // 2)),
        "random radii 0.3 .. 3": hc.Chain.from_radii(random.uniform(0.3, 3.0, BEADS)),
        "random radii within 20%": hc.Chain.from_radii(np.exp(random.uniform(-0.2, 0.2, BEADS))),
        "equal beads, p = 2": hc.Chain.uniform(BEADS, exponent=2.0),
        "equal beads, p = 1.7": hc.Chain.uniform(BEADS, exponent=1.7),
        "forward exponential, q = 0.15": hc.Chain.tapered("forward-exponential", 0.15, beads=BEADS),
        "forward exponential, q = 0.3": hc.Chain.tapered("forward-exponential", 0.3, beads=BEADS),
    }


def heterogeneous_rows(console: Console) -> dict[str, dict[str, float]]:
    """Compare `propagate` with the full chain at rtol 1e-13, for heterogeneous chains."""
    table, results = Table(title="heterogeneous chains of 100 beads, rtol 1e-8"), {}
    for heading in (
        "",
        "worst error",
        "us per passage",
        "in 200, 2 threads (wall)",
        "full chain / this",
    ):
        table.add_column(heading, justify="right" if heading else "left")
    for name, chain in heterogeneous_chains().items():
        exact = hc.simulate(chain, times=0).pulse().velocity
        error = largest(hc.propagate(chain).velocity[1:], exact[1:])
        one = median_time(lambda chain=chain: hc.propagate(chain)) / (BEADS - 1)
        several = [chain] * 200
        many = median_time(
            lambda several=several: hc.propagate_many(several, threads=2), 3, wall=True
        )
        full = median_time(lambda chain=chain: hc.simulate(chain, times=0), 3) / (BEADS - 1)
        results[name] = {
            "error": error, "us": 1e6 * one, "us of 200": 1e6 * many / 200 / (BEADS - 1),
            "full chain / this": full / one,
        }  # fmt: skip
        table.add_row(
            name, f"{error:.0e}", f"{1e6 * one:.3g}", f"{results[name]['us of 200']:.3g}",
            f"{full / one:.3g}",
        )  # fmt: skip
    console.print(table)
    return results


def targets() -> dict[str, dict[str, float]]:
    """Milliseconds of CPU time of single chains, with the targets that they must or should meet."""
    random = hc.Chain.from_radii(np.random.default_rng(0).uniform(0.5, 2.0, BEADS))
    cases: dict[str, tuple[hc.Chain, float, float]] = {
        "single pulse, equal beads": (hc.Chain.uniform(BEADS), 0.25, 0.15),
        "random radii 0.5 .. 2": (random, 19.0, 6.3),
        "a million equal beads": (hc.Chain.uniform(1_000_000), 500.0, 5.0),
    }
    for exponent in (1.2, 2.0, 2.5):
        chain = hc.Chain.tapered("backward-exponential", 0.05, beads=BEADS, exponent=exponent)
        cases[f"backward exponential, p = {exponent:g}"] = (chain, 0.8, 0.45)
    found = {}
    for name, (chain, must, aim) in cases.items():
        hc.propagate(chain)
        number = 20 if chain.beads == BEADS else 1
        times = timeit.repeat(
            lambda chain=chain: hc.propagate(chain), timer=time.process_time, number=number,
            repeat=5,
        )  # fmt: skip
        found[name] = {"ms": 1e3 * min(times) / number, "must": must, "aim": aim}
    return found


def against_scipy() -> dict[str, float]:
    """Time of SciPy's DOP853 (NumPy, rtol 1e-9, no dense output) over that of an ensemble."""
    found = {}
    for taper, rate in TAPERS.items():
        chain = hc.Chain.tapered(taper, rate, beads=BEADS)
        radii, end = ensemble(taper)[:400], hc.simulate(chain, times=0).end_time
        hc.propagate_many(radii, threads=1)
        start = np.append(np.zeros(BEADS), chain.velocities)
        derivative = other_solvers.numpy_derivative(chain.radii)
        times: tuple[list[float], list[float]] = ([], [])
        for _ in range(3):
            began = time.process_time()
            solve_ivp(derivative, (0.0, end), start, method="DOP853", rtol=1e-9, atol=1e-20)
            middle = time.process_time()
            hc.propagate_many(radii, threads=1)
            times[0].append(middle - began)
            times[1].append((time.process_time() - middle) / len(radii))
        found[taper] = min(times[0]) / min(times[1])
    return found


def show(console: Console, title: str, rows: list[Row]) -> None:
    """Print a table of solvers, with the largest error and the mean time over these rows."""
    by_name: dict[str, list[Row]] = {}
    for row in rows:
        by_name.setdefault(row.solver.split(", rtol")[0], []).append(row)
    means = {
        name: statistics.fmean(row.seconds_per_passage for row in some)
        for name, some in by_name.items()
    }
    table = Table(title=title)
    for heading in ("", "rtol", "worst error", "us per passage", "numpy DOP853 / this", "numba"):
        table.add_column(heading, justify="right" if heading else "left")
    for name, some in by_name.items():
        tolerances = sorted({row.solver.split(", rtol ")[-1] for row in some} - {name})
        table.add_row(
            name, " ".join(tolerances), f"{max(row.error for row in some):.0e}",
            f"{1e6 * means[name]:.3g}", f"{means['SciPy DOP853, numpy rhs'] / means[name]:.3g}",
            f"{means['SciPy DOP853, numba rhs'] / means[name]:.3g}",
        )  # fmt: skip
    console.print(table)


def machine() -> str:
    """Name and number of cores of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        name = next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        name = platform.processor() or platform.machine()
    return f"{name}, {os.cpu_count()} cores"


def main() -> None:
    """Run all benchmarks, print the results and write them to a file."""
    console = Console(width=120)
    console.print(f"hertzchain {hc.__version__} on {machine()}, Python {platform.python_version()}")
    rows: list[Row] = []
    for taper in (*TAPERS, "uniform"):
        chain = hc.Chain.uniform(BEADS)
        if taper in TAPERS:
            chain = hc.Chain.tapered(taper, TAPERS[taper], beads=BEADS)
        run = hc.simulate(chain, times=0)
        exact = run.pulse().velocity
        rows += propagate_rows(taper, chain, exact)
        rows += scipy_rows(taper, chain, exact, run.end_time)
        rows += fixed_step_rows(taper, chain, exact, run.end_time)
    titles = {True: f"{BEADS} beads, four tapers: {TAPERS}", False: f"{BEADS} equal beads"}
    for tapered, title in titles.items():
        show(console, title, [row for row in rows if (row.taper in TAPERS) == tapered])
    heterogeneous_results = heterogeneous_rows(console)
    missing = other_solvers.lammps_missing()
    if missing:
        console.print(missing)
    report: dict[str, Any] = {"machine": machine(), "rows": [asdict(row) for row in rows]}
    report["heterogeneous"] = heterogeneous_results
    for name, measure in (
        ("targets [ms]", targets), ("SciPy / ensemble, must 1000, aim 2500", against_scipy),
        ("growth", growth), ("time in square roots", time_in_square_roots),
        ("first call", first_call), ("paper", paper), ("sweep", sweep),
        ("a million equal beads", long_chain), ("us of the local-rate law", local_rate_times),
    ):  # fmt: skip
        report[name] = measure()
        console.print(name, report[name])
    report["GiB of this process"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    target = Path("benchmark")
    target.mkdir(exist_ok=True)
    (target / "benchmark.json").write_text(json.dumps(report, indent=1, allow_nan=False) + "\n")
    console.print("written to benchmark/benchmark.json")


if __name__ == "__main__":
    main()
