"""A table with one row per chain of several that were simulated."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

from ..representation import measure
from ..simulation.yield_range import depends_on_yield_pressure

if TYPE_CHECKING:
    from rich.table import Table

    from ..chain.bead_names import Side
    from ..simulation.run import Run

NONE: Final = "-"
OTHER: Final = "peak at 2.8 Y"


def compared_runs(
    runs: Mapping[str, Run], others: Mapping[str, Run | None], beads: Mapping[str, Sequence[int]]
) -> Table | None:
    """Table of the forces at one place of all chains, the smallest one marked.

    The place is the right wall, the left one or else the first sensor.  There is no table if the
    chains have none of them in common, or are in different units.  The ``others`` have the largest
    possible yield pressure.
    """
    from rich import box
    from rich.table import Table

    if len({run.chain.units for run in runs.values()}) > 1:
        return None
    side = _common_wall(runs)
    if side is None and not all(beads.values()):
        return None
    rows = {
        name: (_of_sensor(run, beads[name][0]) if side is None else _of_wall(run, side))
        | _of_contacts(run)
        for name, run in runs.items()
    }
    peaks = {name: _peak(run, beads[name], side) for name, run in runs.items()}
    _mark_smallest(rows, "peak", peaks)
    if any(others.values()):
        peaks = {name: _peak_at(run, others[name], beads[name], side) for name, run in runs.items()}
        for name, run in runs.items():
            known = math.isfinite(peaks[name])
            shown = measure(peaks[name], "N", run.chain.units, 5) if known else NONE
            rows[name][OTHER] = shown
        _mark_smallest(rows, OTHER, peaks)
    place = "the first sensor" if side is None else f"the {side} wall"
    columns = [
        key for key in dict.fromkeys(key for row in rows.values() for key in row)
        if any(row.get(key, NONE) != NONE for row in rows.values())
    ]  # fmt: skip
    title = f"{len(rows)} chains: force on {place}; * marks the smallest"
    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left")
    for key in ("chain", *columns):
        table.add_column(key, justify="left" if key == "chain" else "right")
    for name, row in rows.items():
        table.add_row(name, *(row.get(key, NONE) for key in columns))
    return table


def _common_wall(runs: Mapping[str, Run]) -> Side | None:
    sides: tuple[Side, ...] = ("right", "left")
    for side in sides:
        if all(getattr(run.chain, f"{side}_wall") is not None for run in runs.values()):
            return side
    return None


def _of_wall(run: Run, side: Side) -> dict[str, str]:
    wall = run.wall_force(side)
    if not wall.complete:
        return {"peak": "not complete"}
    found = {
        "peak": measure(wall.peak, "N", wall.units, 5),
        "time": measure(wall.peak_time, "s", wall.units, 5),
    }
    if wall.complete_since is not None:
        found["impulse"] = measure(wall.excess_impulse, "N s", wall.units)
        found["duration"] = measure(wall.duration, "s", wall.units)
    return found


def _of_sensor(run: Run, bead: int) -> dict[str, str]:
    sensor, units = run.sensor_force(bead), run.chain.units
    if not sensor.reached:
        return {"peak": "not reached"}
    return {
        "peak": measure(sensor.largest_so_far, "N", units, 5),
        "time": measure(sensor.largest_so_far_time, "s", units, 5),
    }


def _of_contacts(run: Run) -> dict[str, str]:
    """Largest overlap and pressure in comparison with limits, and the deepest dent."""
    import numpy as np

    from ..chain.contact_groups import dents
    from ..chain.hertz_range import hertz_range

    chain, found = run.chain, dict[str, str]()
    if chain.units == "SI" and chain.materials is not None:
        limits = hertz_range(chain, run.largest_overlaps)
        pressure = np.nan_to_num(np.fmax(limits.yield_ratio, limits.law_yield_ratio)).max()
        found["overlap/radius"] = f"{np.nan_to_num(limits.overlap_ratio).max():.2g}"
        found["pressure/yield"] = f"{pressure:.3g}" if pressure else NONE
    dent = float(dents(chain.contact_groups, run._furthest_overlaps).max())
    if dent:
        found["deepest dent"] = measure(dent, "m", chain.units, 3)
    return found


def _peak(run: Run, beads: Sequence[int], side: Side | None) -> float:
    """The peak of a row of the table; infinite if it is not known."""
    if side is None:
        sensor = run.sensor_force(beads[0])
        return sensor.largest_so_far if sensor.reached else math.inf
    wall = run.wall_force(side)
    return wall.peak if wall.complete else math.inf


def _peak_at(run: Run, other: Run | None, beads: Sequence[int], side: Side | None) -> float:
    """The peak at the largest possible yield pressure, or that of a run to which none applies."""
    if other is not None:
        return _peak(other, beads, side)
    return math.inf if depends_on_yield_pressure(run) else _peak(run, beads, side)


def _mark_smallest(
    rows: dict[str, dict[str, str]], column: str, peaks: Mapping[str, float]
) -> None:
    """Mark the smallest of the peaks in a column."""
    if math.isfinite(least := min(peaks.values())):
        for name in (name for name, peak in peaks.items() if peak == least):
            rows[name][column] = f"* {rows[name][column]}"
