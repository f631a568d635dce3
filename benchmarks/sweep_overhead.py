"""Compare the time of a sweep with that of `propagate_many`: ``make benchmark``.

The script prints a table and writes ``benchmark/sweeps.json``.  The ratio is that of medians
measured in the same run.  Memory is the peak of a separate process that sweeps a million chains
(0.8 GB on disk).
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import hertzchain as hc

POINTS, BEADS, REPEATS = 40_000, 100, 5
MILLION = 1_000_000
SWEEP_SCRIPT = """
import sys, time
from pathlib import Path
import hertzchain as hc
points, at, folder = int(sys.argv[1]), sys.argv[2], sys.argv[3]
axes = {"rate": {"linspace": [0.01, 0.1, points]}}
chain = {"taper": "forward-exponential", "beads": 100}
begun = time.perf_counter()
hc.sweep({"chain": chain, "axes": axes, "sweep": {"at": at}}, folder + "/store")
seconds = time.perf_counter() - begun
# Peak memory of this process; getrusage may return that of its parent.
peak = next(line for line in Path("/proc/self/status").open() if line.startswith("VmHWM"))
print(seconds, int(peak.split()[1]) / 1024)
"""


def specification(points: int) -> dict[str, Any]:
    """Forward exponential tapers of a hundred beads; the velocities of all beads are kept."""
    axes = {"rate": {"linspace": [0.01, 0.1, points]}}
    return {"chain": {"taper": "forward-exponential", "beads": BEADS}, "axes": axes}


def time_call(action: Callable[[], object]) -> float:
    """Time of a call [s]."""
    begun = time.perf_counter()
    action()
    return time.perf_counter() - begun


def ratio() -> dict[str, float]:
    """Points per second of a sweep with a store, relative to `propagate_many`."""
    rates = np.linspace(0.01, 0.1, POINTS)
    radii = (1.0 + rates[:, np.newaxis]) ** -np.arange(BEADS)
    sweeps, bare = [], []
    for _ in range(REPEATS):
        with tempfile.TemporaryDirectory() as folder:
            store = Path(folder) / "store"
            sweeps.append(time_call(lambda to=store: hc.sweep(specification(POINTS), to)))
        bare.append(time_call(lambda: hc.propagate_many(radii)))
    return {
        "sweep_points_per_second": POINTS / statistics.median(sweeps),
        "bare_points_per_second": POINTS / statistics.median(bare),
        "ratio": statistics.median(bare) / statistics.median(sweeps),
    }


def run_in_process(points: int, at: str) -> tuple[float, float]:
    """Time [s] and memory [MiB] of a sweep in a separate process, without its start-up time."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", SWEEP_SCRIPT, str(points), at, folder],
            capture_output=True, text=True, check=True,
        )  # fmt: skip
    seconds, mebibytes = map(float, done.stdout.split())
    return seconds, mebibytes


def main() -> None:
    """Measure, print and save."""
    console = Console()
    hc.sweep(specification(16))  # compiles
    found: dict[str, float] = ratio()
    found["hundred_points_seconds"], _ = run_in_process(100, "every")
    found["million_points_seconds"], found["million_points_mebibytes"] = run_in_process(
        MILLION, "every"
    )
    table = Table(title=f"sweeps of forward tapers, {BEADS} beads, all beads kept")
    table.add_column("quantity")
    table.add_column("measured", justify="right")
    for name, value in found.items():
        table.add_row(name.replace("_", " "), f"{value:.3g}" if value < 1e4 else f"{value:.0f}")
    console.print(table)
    target = Path("benchmark") / "sweeps.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(found, indent=2) + "\n")
    console.print(f"written to {target}")


if __name__ == "__main__":
    main()
