"""Measure the time of a run of a hundred steel beads for each loss law: ``make benchmark``.

All beads are integrated until the pulse has left the chain, in SI units and at the default
tolerance, with and without 400 saved times.  The script prints a table and writes
``benchmark/losses.json``.  The times are the shortest of several runs, because the machine may be
shared.
"""

from __future__ import annotations

import json
import time
import warnings
from pathlib import Path

from rich.console import Console
from rich.table import Table

import hertzchain as hc

REPEATS, TIMES = 15, (400, 0)
STEEL = hc.Chain.from_materials(5e-3, "steel-52100", beads=100)
LAWS = {
    "none": None,
    "Restitution(0.9)": hc.Restitution(0.9),
    "Viscoelastic(1e-6)": hc.Viscoelastic(1e-6),
    "Dashpot(1)": hc.Dashpot(1.0),
    "VelocityPower(1, 1.5)": hc.VelocityPower(1.0, 1.5),
    "WaltonBraun(0.9)": hc.WaltonBraun(0.9),
    "UnloadingRatio(0.1)": hc.UnloadingRatio(0.1),
}


def milliseconds(chain: hc.Chain, times: int) -> float:
    """Shortest time of several runs, after one that is not measured."""
    seconds = []
    for _ in range(REPEATS + 1):
        begun = time.process_time()
        hc.simulate(chain, times=times)
        seconds.append(time.process_time() - begun)
    return 1e3 * min(seconds[1:])


def main() -> None:
    """Measure, print and save."""
    # Steel yields at 1 m/s, but this does not affect the computing time.
    warnings.simplefilter("ignore", hc.ModelRangeWarning)
    found = {
        name: {str(times): milliseconds(STEEL.replace(loss=law), times) for times in TIMES}
        for name, law in LAWS.items()
    }
    console = Console()
    table = Table(title=f"one passage of {STEEL.beads} steel beads [ms]")
    for heading in ("loss", "400 saved times", "none"):
        table.add_column(heading, justify="left" if heading == "loss" else "right")
    for name, values in found.items():
        table.add_row(name, *(f"{value:.1f}" for value in values.values()))
    console.print(table)
    target = Path("benchmark") / "losses.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(found, indent=2) + "\n")
    console.print(f"written to {target}")


if __name__ == "__main__":
    main()
