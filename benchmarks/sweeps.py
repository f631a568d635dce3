"""What a sweep costs beside the bare ensemble kernel: ``make benchmark``.

Prints a table and writes ``benchmark/sweeps.json``.  The ratio is between medians of runs side by
side; memory is the largest of a process of its own that sweeps a million chains, 0.8 GB on disk.
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
ALONE = """
import sys, time
from pathlib import Path
import hertzchain as hc
points, at, folder = int(sys.argv[1]), sys.argv[2], sys.argv[3]
axes = {"rate": {"linspace": [0.01, 0.1, points]}}
chain = {"taper": "forward-exponential", "beads": 100}
begun = time.perf_counter()
hc.sweep({"chain": chain, "axes": axes, "sweep": {"at": at}}, folder + "/store")
seconds = time.perf_counter() - begun
# Of this process alone; what getrusage tells may be of its parent.
peak = next(line for line in Path("/proc/self/status").open() if line.startswith("VmHWM"))
print(seconds, int(peak.split()[1]) / 1024)
"""


def specification(points: int) -> dict[str, Any]:
    """Forward exponential tapers of a hundred beads, the velocity of every bead kept."""
    axes = {"rate": {"linspace": [0.01, 0.1, points]}}
    return {"chain": {"taper": "forward-exponential", "beads": BEADS}, "axes": axes}


def timed(action: Callable[[], object]) -> float:
    """Seconds that something takes."""
    begun = time.perf_counter()
    action()
    return time.perf_counter() - begun


def ratio() -> dict[str, float]:
    """Points a second of a sweep into a store, over those of `propagate_many` alone."""
    rates = np.linspace(0.01, 0.1, POINTS)
    radii = (1.0 + rates[:, np.newaxis]) ** -np.arange(BEADS)
    sweeps, bare = [], []
    for _ in range(REPEATS):
        with tempfile.TemporaryDirectory() as folder:
            store = Path(folder) / "store"
            sweeps.append(timed(lambda to=store: hc.sweep(specification(POINTS), to)))
        bare.append(timed(lambda: hc.propagate_many(radii)))
    return {
        "sweep_points_per_second": POINTS / statistics.median(sweeps),
        "bare_points_per_second": POINTS / statistics.median(bare),
        "ratio": statistics.median(bare) / statistics.median(sweeps),
    }


def in_a_process(points: int, at: str) -> tuple[float, float]:
    """Seconds and MiB of a process that sweeps, its start left out of the seconds."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", ALONE, str(points), at, folder],
            capture_output=True, text=True, check=True,
        )  # fmt: skip
    seconds, mebibytes = map(float, done.stdout.split())
    return seconds, mebibytes


def main() -> None:
    """Measure, print and save."""
    console = Console()
    hc.sweep(specification(16))  # compiles
    found: dict[str, float] = ratio()
    found["hundred_points_seconds"], _ = in_a_process(100, "every")
    found["million_points_seconds"], found["million_points_mebibytes"] = in_a_process(
        MILLION, "every"
    )
    table = Table(title=f"sweeps of forward tapers, {BEADS} beads, every bead kept")
    table.add_column("what")
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
