"""Forces in sensors of chains at several speeds or heights."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ..representation import measure
from .marked_entries import FIRST, LARGEST

if TYPE_CHECKING:
    from ..simulation.run import Run
    from ..simulation.sensor_force import SensorForce
    from .repeated_impacts import Impacts


def with_sensors(
    rows: Mapping[str, dict[str, str]], runs: Mapping[str, Run],
    beads: Mapping[str, Sequence[int]], impacts: Impacts, *, first_is_peak: bool,
) -> dict[str, dict[str, str]]:  # fmt: skip
    """Rows of a table over impacts with columns of each sensor, in their order.

    These are the first maximum and, if it is not the largest force in all rows, the largest one,
    except of the first sensor if the peak is the largest force in it.
    """
    found: dict[str, dict[str, str]] = {name: {} for name in rows}
    for i in range(max(map(len, beads.values())) if impacts else 0):
        own = {name: runs[name].sensor_force(each[i]) for name, each in beads.items()
               if i < len(each)}  # fmt: skip
        # The same ball has another number in a chain with another number of strikers.
        label = " or ".join(dict.fromkeys(_label(runs[name], beads[name][i]) for name in own))
        later = any(map(_is_later, own.values()))
        is_peak = first_is_peak and i == 0
        for name, sensor in own.items():
            first, largest = _entries(sensor, runs[name].chain.units)
            if later or not is_peak:
                found[name][f"{FIRST}{label}"] = first
            if later and not is_peak:
                found[name][f"{LARGEST}{label}"] = largest
    # The columns of a wall follow those of sensors; those of the first sensor come before them.
    before = ("speed", "peak", "time") if first_is_peak else ("speed",)
    return {
        name: {key: row[key] for key in before if key in row} | found[name] | row
        for name, row in rows.items()
    }


def title_of_sensors(
    beads: Mapping[str, Sequence[int]], impacts: Impacts, *, first_is_peak: bool
) -> str:
    """Part of the title of a table over impacts, if it has columns of sensors besides the peak."""
    if not impacts or not any(each[first_is_peak:] for each in beads.values()):
        return ""
    return " (peak) and in other sensors" if first_is_peak else " (peak) and in sensors"


def _label(run: Run, bead: int) -> str:
    from ..chain.bead_names import bead_label

    return bead_label(run.chain, bead)


def forces_over_impacts(
    runs: Mapping[str, Run], beads: Mapping[str, Sequence[int]], impacts: Impacts
) -> dict[str, dict[str, list[float]]]:
    """First maxima in each sensor, by the names of sensors and chains; infinite if not known."""
    found: dict[str, dict[str, list[float]]] = {}
    if not all(beads.values()) or len({*map(len, beads.values())}) > 1:
        return found
    for i in range(len(next(iter(beads.values())))):
        # The same ball has another number in a chain with another number of strikers.
        labels = dict.fromkeys(_label(run, beads[name][i]) for name, run in runs.items())
        own = found.setdefault(" or ".join(labels), {})
        for names in impacts.names.values():
            for chain, name in names.items():
                first = runs[name].sensor_force(beads[name][i]).first_maximum
                own.setdefault(chain, []).append(math.inf if math.isnan(first) else first)
    return found


def _is_later(sensor: SensorForce) -> bool:
    """Whether the largest force of a sensor is not the first maximum."""
    return sensor.reached and sensor.largest_so_far_time != sensor.first_maximum_time


def _entries(sensor: SensorForce, units: str) -> tuple[str, str]:
    """First maximum and largest force."""
    if not sensor.reached:
        return "not reached", "not reached"
    known = not math.isnan(sensor.first_maximum)
    return (
        measure(sensor.first_maximum, "N", units, 5) if known else "not complete",
        measure(sensor.largest_so_far, "N", units, 5),
    )
