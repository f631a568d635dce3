"""Curves of a measured record at the times of a simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, SimulationError
from ..fitting.compare_traces import compare_traces
from ..fitting.compared_run import run_to_compare
from ..fitting.trace_comparison import TraceComparison
from ..recorded_warnings import ignore_warnings
from ..representation import listed
from ..traces.amplitudes import level_of
from ..traces.coupling import static_force
from ..traces.places import Place
from ..traces.signals import Signal
from .records import Record

# Largest number of saved times of the run for the comparison, and of samples that are drawn.
MAX_TIMES: Final = 40_000
MAX_SAMPLES: Final = 6000
# Scaled samples beyond this multiple of the largest simulated force belong to another signal: they
# are not drawn, because all other curves would lie on the axis.
ABSURD: Final = 30.0


def record_curves(
    chain: Chain, record: Record, end: float, progress: Callable[..., None]
) -> tuple[dict[str, Any], dict[str, Array]]:
    """Header and arrays of a record, shifted as `Run.compare` does.

    The samples are those from one duration ``end`` of the shown run before its begin to one after
    its end.  If the record cannot be compared with the chain, it is not shifted.
    """
    (shot,) = record.traces.shots
    found, notes = None, [record.note] if record.note else []
    try:
        with ignore_warnings():
            begin = float(shot.times[0])
            run = run_to_compare(chain, record.traces, begin, most=MAX_TIMES, progress=progress)
            found = compare_traces(run, record.traces)
        # The page marks all remarks as an error if one of them is an error.
        notes = [found.notes[0]] if found.exchanged else [*notes, *found.notes]
    except (InputError, SimulationError) as error:
        notes = [f"not aligned: {error}"]
    offset = 0.0 if found is None else found.time_offset
    times, curves = shot.times - offset, []
    near = (times >= -end) & (times <= 2.0 * end) if found is not None else np.isfinite(times)
    arrays: dict[str, Array] = {}
    if found is None or found.exchanged:
        notes += _unscaled(shot.signals, exchanged=found is not None)
    for i, signal in enumerate(shot.signals):
        values, label = _in_newton(chain, signal, found, i)
        if values is None:
            notes += [label] if label else []
            continue
        arrays[f"record.times.{i}"], arrays[f"record.{i}"] = _thinned(times[near], values[near])
        static = static_force(signal.place, chain) if found is not None else 0.0
        place = _curve_at(signal.place, chain)
        note = "" if found is None else _agreement(found, i)
        curves.append(
            {"key": str(i), "label": label, "note": note, "static": static, "place": place}
        )
    automatic, given = ([], []) if found is None else _starts(found)
    header = {
        "name": record.name, "offset": offset, "curves": curves, "notes": notes + automatic,
        # Remarks if the user gives the time at which the simulation begins.
        "given": notes + given,
        "aligned": found is not None,
        "exchanged": found is not None and found.exchanged,
    }  # fmt: skip
    return header, arrays


def _in_newton(
    chain: Chain, signal: Signal, found: TraceComparison | None, number: int
) -> tuple[Array | None, str]:
    """Samples as a force and the name of their curve, or a reason why they are not shown.

    The reason is empty for signals that `_unscaled` names.
    """
    if signal.place.quantity != "force":
        return None, f"{signal.name} is not shown, because it is a velocity"
    label, values = signal.name, signal.values
    if found is None or (found.exchanged and not signal.calibrated):
        return (values, label) if signal.calibrated else (None, "")
    resolved = found.traces.shots[0].signals[number]
    if not signal.calibrated:
        scale, model = found.scales[number], found.signals[number]
        if not scale:
            return None, f"{signal.name} is in V and has no pulse to which it can be scaled"
        scaling, largest = found.sensors[number].scaling, float(np.nanmax(np.abs(model)))
        reached = float(np.nanmax(np.abs(values - level_of(resolved)))) / abs(scale)
        if reached > ABSURD * largest:
            return None, (f"{signal.name} is not shown: with the fitted scale of {scaling}, "
                          f"it would reach {1e-3 * reached:.3g} kN")  # fmt: skip
        first = model[resolved.valid & np.isfinite(model)][0]
        values = first + (values - level_of(resolved)) / scale
        label += f" in V ({scaling})"
    if resolved.coupling == "AC":
        values = values + static_force(signal.place, chain)
    return values, label


def _unscaled(signals: Sequence[Signal], *, exchanged: bool) -> list[str]:
    """One sentence on the forces in V, which have no scale if the record is not aligned.

    If columns are exchanged, it would be that of another signal.
    """
    names = [
        each.name for each in signals if each.place.quantity == "force" and not each.calibrated
    ]
    if not names:
        return []
    verb, they = ("is", "it") if len(names) == 1 else ("are", "they")
    if exchanged:
        return [f"{listed(names)} {verb} in V, and {verb} not shown until this is corrected"]
    return [
        f"{listed(names)} {verb} in V, and {verb} shown only if {they} can be aligned and scaled"
    ]


def _starts(found: TraceComparison) -> tuple[list[str], list[str]]:
    """Remarks on the start of the simulation by least squares, and on one that the user gives."""
    if found.exchanged:
        return [], []
    given = "the time at which the simulation begins is given"
    if found.time_offset_given or not np.isfinite(found.time_offset_error):
        return [], [given]
    begin = found.time_offset_text.replace("+-", "±").replace(" us", " µs")
    return (
        [f"by least squares, the simulation begins at {begin}",
         "the error of this time assumes that the chain is right"],
        [f"{given}; by least squares, it is {begin}"],
    )  # fmt: skip


def _agreement(found: TraceComparison, number: int) -> str:
    """Peak, arrival and residual of a signal for the legend, as `TraceComparison.summary` has them.

    If columns are probably exchanged, or without a pulse, it has the measured peak alone.
    """
    each = found.sensors[number]
    peak, _, difference, _, _, delay, residual = each.cells
    if found.exchanged or each.silent:
        return f": {peak}"
    simulated = "" if each.lower_bound else "simulated "
    arrival = f"; arrival {delay}".replace(" us", " µs") * bool(np.isfinite(each.delay))
    return f": {peak}, {simulated}{difference}{arrival}; residual {residual}"


def _curve_at(place: Place, chain: Chain) -> str:
    """Name of the simulated force at this place in `places_of`; empty if the chain has none."""
    if place.body in ("left", "right"):
        return place.body
    try:
        return str(place.bead(chain))
    except InputError:
        return ""


def _thinned(times: Array, values: Array) -> tuple[Array, Array]:
    """At most about `MAX_SAMPLES` samples: the smallest and the largest of equal groups."""
    known = np.isfinite(values)
    times, values = times[known], values[known]
    groups = MAX_SAMPLES // 2
    if len(values) <= MAX_SAMPLES:
        return times, values
    edges = np.linspace(0, len(values), groups + 1).astype(int)
    kept = [
        begin + each
        for begin, end in pairwise(edges)
        for each in sorted((np.argmin(values[begin:end]), np.argmax(values[begin:end])))
    ]
    return times[kept], values[kept]
