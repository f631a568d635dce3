"""Forces in sensors, and their times, of chains at several speeds or heights."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ..representation import measure
from .marked_entries import NONE

if TYPE_CHECKING:
    from rich.table import Table

    from ..simulation.run import Run
    from ..simulation.sensor_force import SensorForce
    from .repeated_impacts import Impacts


def sensor_table(
    runs: Mapping[str, Run], beads: Mapping[str, Sequence[int]], impacts: Impacts
) -> Table | None:
    """First maximum and its time in each sensor, and the largest force where it is a later one.

    There is no table without several impacts or without sensors.
    """
    if not impacts or not any(beads.values()):
        return None
    from rich import box
    from rich.table import Table

    from ..chain.bead_names import bead_label

    table = Table(title="Forces in sensors", box=box.SIMPLE_HEAD, title_justify="left", padding=0)
    named = any(any(names) for names in impacts.names.values())
    left = ["sensor", impacts.kind, *["chain"] * named]
    forces = {name: [run.sensor_force(bead) for bead in beads[name]] for name, run in runs.items()}
    later = any(_is_later(force) for found in forces.values() for force in found)
    columns = ["first\nmaximum", "time", *["largest\nforce", "time"] * later]
    for key in (*left, *columns):
        table.add_column(key, justify="left" if key in left else "right", vertical="bottom")
    for i in range(max(map(len, beads.values()))):
        for label, names in impacts.names.items():
            for chain, name in names.items():
                if i >= len(beads[name]):
                    continue
                sensor = bead_label(runs[name].chain, beads[name][i])
                entries = _entries(forces[name][i], runs[name].chain.units)
                table.add_row(sensor, label, *[chain] * named, *entries[: len(columns)])
        table.add_section()
    return table


def forces_over_impacts(
    runs: Mapping[str, Run], beads: Mapping[str, Sequence[int]], impacts: Impacts
) -> dict[str, dict[str, list[float]]]:
    """First maxima in each sensor, by the names of sensors and chains; infinite if not known."""
    from ..chain.bead_names import bead_label

    found: dict[str, dict[str, list[float]]] = {}
    if not all(beads.values()) or len({*map(len, beads.values())}) > 1:
        return found
    for i in range(len(next(iter(beads.values())))):
        # The same ball has another number in a chain with another number of strikers.
        labels = dict.fromkeys(bead_label(run.chain, beads[name][i]) for name, run in runs.items())
        own = found.setdefault(" or ".join(labels), {})
        for names in impacts.names.values():
            for chain, name in names.items():
                first = runs[name].sensor_force(beads[name][i]).first_maximum
                own.setdefault(chain, []).append(math.inf if math.isnan(first) else first)
    return found


def _is_later(sensor: SensorForce) -> bool:
    """Whether the largest force of a sensor is not the first maximum."""
    return sensor.reached and sensor.largest_so_far_time != sensor.first_maximum_time


def _entries(sensor: SensorForce, units: str) -> list[str]:
    """First maximum and largest force, each with its time."""
    if not sensor.reached:
        return ["not reached", NONE, NONE, NONE]
    first = ["not complete", NONE]
    if not math.isnan(sensor.first_maximum):
        first = _with_time(sensor.first_maximum, sensor.first_maximum_time, units)
    if not _is_later(sensor):
        return [*first, NONE, NONE]
    return [*first, *_with_time(sensor.largest_so_far, sensor.largest_so_far_time, units)]


def _with_time(force: float, time: float, units: str) -> list[str]:
    return [measure(force, "N", units, 5), measure(time, "s", units, 5)]
