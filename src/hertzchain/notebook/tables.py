"""HTML representations of tables of pulses and runs: distribution over the chains."""

from __future__ import annotations

import numpy as np

from ..collision import Array
from ..pulse.free_end import split_free_ends
from ..pulse.pulse_table import PulseTable
from ..pulse.quantities import QUANTITIES
from ..representation import counted, without_exponent
from ..simulation.ensemble_columns import TABLE_QUANTITIES
from ..simulation.run_table import RunTable
from .drawing import (
    COLOURS,
    Curve,
    Mark,
    axis_unit,
    chart,
    legend,
    note,
    numbers,
    page,
    table,
)

# Part of the chains in the band around the median.
PERCENTILES = (5.0, 50.0, 95.0)
SHOWN = ("velocity", "momentum", "arrival", "peak_force")


def pulse_table_html(pulses: PulseTable) -> str:
    """Median of the velocity along the chains with a band, and values of the last beads."""
    units, columns = pulses.units, pulses.columns()
    failed = len(pulses.reasons)
    shown = {"chains": f"{len(pulses)}", "failed": f"{failed}"}
    if len(pulses) == failed:
        return page("PulseTable", "", numbers(shown))
    velocity, ends = split_free_ends(pulses.velocity, pulses.beads, "velocity", PERCENTILES)
    place = np.flatnonzero(np.isfinite(velocity).any(axis=0))
    low, middle, high = np.nanpercentile(velocity[:, place], PERCENTILES, axis=0)
    factor, unit = axis_unit(np.append(high, [end[-1] for end in ends.values()]), "m/s", units)
    curves = [
        Curve(place + 1.0, factor * high, "5% to 95%", COLOURS[5], base=factor * low),
        Curve(place + 1.0, factor * middle, "median", COLOURS[0]),
    ]
    # The last beads of free ends are not part of the curve.
    curves += [
        Curve(np.full(2, float(k)), factor * end[[0, 2]], "", COLOURS[5]) for k, end in ends.items()
    ]
    marks = [Mark(float(k), factor * float(end[1]), "") for k, end in ends.items()]
    figure = chart(curves, "bead k", f"velocity{unit}", marks=marks, whole=True)
    entries = [("5% to 95% of the chains", COLOURS[5]), ("median", COLOURS[0])]
    if ends:
        figure += note("The last bead of a chain with a free end is shown as a separate point.")
    rows = []
    for name in SHOWN:
        if name in columns:
            known = [row[np.isfinite(row)] for row in columns[name]]
            last = np.array([row[-1] for row in known if len(row)])
            rows.append((f"{name}, last", *_summary(last, QUANTITIES[name].unit, units)))
    head = ("quantity", "smallest", "median", "largest")
    return page(
        "PulseTable", f"{counted(len(pulses), 'chain')} of up to {pulses._longest}",
        legend(entries), figure, numbers(shown), table(head, rows, numeric=True),
    )  # fmt: skip


def run_table_html(runs: RunTable) -> str:
    """Smallest, median and largest value of each kept quantity."""
    rows = []
    for name, values in runs.columns.items():
        known = values[np.isfinite(values)]
        where = "" if values.ndim == 1 else ", all places"
        if len(known):
            rows.append(
                (f"{name}{where}", *_summary(known, TABLE_QUANTITIES[name].unit, runs.units))
            )
        else:
            rows.append((name, "none", "", ""))
    shown = {
        "chains": f"{len(runs)}",
        "failed": f"{len(runs.reasons)}",
        "incomplete": f"{int((~runs.complete).sum())}",
    }
    parts = [numbers(shown)]
    first = next((name for name, values in runs.columns.items() if values.ndim == 1), "")
    if first and np.isfinite(runs[first]).sum() > 1:
        values = np.sort(runs[first][np.isfinite(runs[first])])
        factor, unit = axis_unit(values, TABLE_QUANTITIES[first].unit, runs.units)
        part = 100.0 * (np.arange(len(values)) + 0.5) / len(values)
        label = f"{first}{unit}"
        parts.insert(0, chart([Curve(part, factor * values)], "share of chains below [%]", label))
    parts.append(table(("quantity", "smallest", "median", "largest"), rows, numeric=True))
    notes = runs._peak_note, runs._wall_note, runs._range_note
    parts += [note(f"{each}.") for each in notes if each]
    return page("RunTable", counted(len(runs), "chain"), *parts)


def _summary(values: Array, unit: str, units: str) -> tuple[str, ...]:
    """Smallest, median and largest value, in one unit."""
    found = np.array([values.min(), np.median(values), values.max()])
    factor, shown = axis_unit(found, unit, units if unit != "1" else "scaled")
    return tuple(
        f"{without_exponent(factor * each)} {shown.strip(' []')}".strip() for each in found
    )
