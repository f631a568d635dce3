"""Compare measured traces with a simulation, without any fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..collision import Array
from ..errors import InputError, InputWarning, warn_user
from ..simulation.run import Run
from ..traces.amplitudes import level_of
from ..traces.coupling import Gain, coupling_notes, resolved_coupling, static_force
from ..traces.missing_rows import gap_notes, gaps_between, with_missing_samples
from ..traces.notes import missing_sample_notes, spike_notes
from ..traces.places import check_places
from ..traces.signals import Shot, Signal
from ..traces.spikes import without_spikes
from ..traces.traces import Traces, with_time_offset
from ..validation.objects import check_type
from .arrival_notes import (
    NOTHING_EXPLAINED,
    given_offset_notes,
    has_pulse,
    order_notes,
    other_offset_notes,
    outside_notes,
    sensors_outside,
    silent_notes,
    with_pulses,
)
from .ball_count_notes import OUTSIDE, count_note
from .coarse_sampling import sampling_notes
from .compared_part import check_reached, covered_part
from .comparison_notes import level_notes, missing_notes, pulse_notes, unit_notes
from .exchanged_columns import MUCH_BETTER, exchange_notes
from .first_pulses import shape_notes
from .goodness import EXPLAINED
from .misread_columns import inversion_notes
from .misread_places import ALIKE, other_balls
from .misread_times import time_notes
from .odd_sensors import odd_sensor_notes
from .sensor_comparison import (
    check_arrivals,
    check_contained,
    check_contains_a_pulse,
    check_durations,
    check_resolved,
    pulse_widths,
)
from .sensors import sampled
from .time_offsets import (
    SIMILAR,
    best_offset,
    difference_at_best_offset,
    explained_by_offset,
    offset_error,
)
from .trace_comparison import TraceComparison

# A cause that leaves a larger part of the rms of the signals does not describe the data alone.
REMAINING: Final = 0.2


def compare_traces(
    run: Run, traces: Traces, *, time_offset: float | None = None
) -> TraceComparison:
    """Compare a run with measured traces of one shot; `hertzchain.Run.compare` documents it."""
    _require_comparable(run, traces)
    check_places((signal.place for signal in traces.shots[0].signals), run.chain)
    gaps = gaps_between(traces.shots[0].times)
    gain = _gain(run)
    empty_notes = missing_sample_notes(traces.shots[0])
    complete = map(with_missing_samples, with_time_offset(traces, time_offset).shots)
    traces = resolved_coupling(Traces(tuple(complete)), [run.chain], gain)
    shot = traces.shots[0]
    grid, columns = _columns(run, shot)
    check_arrivals(run, shot, columns, grid)
    check_resolved(shot, columns)
    spacing = float(grid[1] - grid[0])
    shot = without_spikes(shot, pulse_widths(columns, grid))
    traces = Traces((shot,))
    given, other, unexplained = shot.clock is not None, None, list[str]()
    # The run may have been saved from a time after the impact.
    first_saved = float(run.times[0])
    if given:
        time_offset = shot.time_offset
        begin = time_offset + first_saved
    else:
        check_contains_a_pulse(shot, columns, spacing)
        aligned = with_pulses(shot, columns)
        begin, other = best_offset(*aligned, spacing)
        time_offset, other = begin - first_saved, other and (other[0] - first_saved, other[1])
        least = EXPLAINED + 4.0 * len(columns)
        if explained_by_offset(*aligned, spacing, begin) < least:
            unexplained = [NOTHING_EXPLAINED]
    moments = shot.times - begin
    inside = covered_part(moments, float(grid[-1]), time_offset)
    _check_in_record(shot, begin, time_offset, inside, grid, columns, "".join(unexplained))
    signals = tuple(_at(moments, inside, column, spacing) for column in columns)
    error = np.nan if given else offset_error(shot, signals)
    found = TraceComparison(traces, signals, float(time_offset), given, error)
    exchanged, other_places = _suspicious(found, columns, grid, begin, other)
    suspicious = [
        *other_places,
        *spike_notes(shot),
        *(silent_notes(shot, inside) or unexplained),
    ]
    # A sensor in another ball may be the reason why a reflected pulse agrees as well.
    excluding = {*suspicious}.difference(other_offset_notes(shot, found.time_offset, other))
    for note in suspicious:
        warn_user(note, InputWarning)
    notes = (
        *suspicious,
        *sampling_notes(shot, columns, grid),
        *gap_notes(gaps),
        *empty_notes,
        *inversion_notes({} if exchanged else {each.name: each.scale for each in found.sensors}),
        *level_notes(shot, signals, columns),
        *([] if exchanged else _crest_notes(found, run, columns, inside)),
        *([] if excluding else _count_notes(found, run, columns, grid)),
        *coupling_notes(traces, [run.chain], gain),
    )
    return replace(found, notes=notes, exchanged=exchanged)


def _check_in_record(
    shot: Shot, begin: float, time_offset: float, inside: NDArray[np.bool_], grid: Array,
    columns: Sequence[Array], unexplained: str,
) -> None:  # fmt: skip
    """Raise `InputError` if the record or the run misses a pulse, unless columns are exchanged."""
    try:
        check_contained(shot, inside)
        check_reached(shot, shot.times - begin, columns, grid, float(time_offset), unexplained)
    except InputError:
        # If columns are exchanged, the time offset is wrong, and the comparison names them.
        if not exchange_notes(shot, columns, float(grid[1] - grid[0])):
            raise


def _crest_notes(
    found: TraceComparison, run: Run, columns: Sequence[Array], inside: Array
) -> list[str]:
    """Sentences on crests, on the end of the run, and on a sensor that differs from the others."""
    (shot,) = found.traces.shots
    until = float(shot.times[-1]) - found.time_offset
    outside = sensors_outside(shot, columns, found.signals)
    return [
        *missing_notes(found.sensors), *pulse_notes(run, shot, columns, inside, until),
        *shape_notes(shot, found.signals, found.sensors, outside),
        *odd_sensor_notes(found.sensors, shot, inside, outside),
    ]  # fmt: skip


def _count_notes(
    found: TraceComparison, run: Run, columns: Sequence[Array], grid: Array
) -> list[str]:
    """Notes on the number of balls or a place, if arrivals differ and the run is complete."""
    (shot,) = found.traces.shots
    delays = [abs(each.delay) for each in found.sensors if np.isfinite(each.delay)]
    late = max(delays, default=0.0) > OUTSIDE * min(pulse_widths(columns, grid))
    if run.times[0] != 0.0 or len(shot.signals) < 2 or not late:
        return []
    own = difference_at_best_offset(shot, columns, float(grid[1]))
    count = count_note(run, own, lambda other: difference_at_best_offset(
        shot, _columns(other, shot)[1], float(grid[1])
    ))  # fmt: skip
    causes = [each for each in (count, _place_note(run, shot, own, float(grid[1]))) if each]
    limit = SIMILAR * min((best for best, _ in causes), default=0.0)
    return [note for best, note in sorted(causes) if best < limit]


def _place_note(run: Run, shot: Shot, own: float, spacing: float) -> tuple[float, str] | None:
    """The difference of a run, and a note, if one sensor in another ball halves it."""
    found, places = [], {each.name: each.place for each in shot.signals}
    for name, place in other_balls(places, [run.chain]):
        signals = (replace(s, place=place) if s.name == name else s for s in shot.signals)
        other = replace(shot, signals=tuple(signals))
        best = difference_at_best_offset(other, _columns(run, other)[1], spacing)
        found.append((best, name, place.name))
    found.sort()
    if not found or not found[0][0] < MUCH_BETTER * own:
        return None
    best, name, there = found[0]
    also = [f"in {place}, to {rms / own:.0%}" for rms, _, place in found[1:] if rms < ALIKE * best]
    return best, (
        f"if the sensor named {name} is in {there}, the rms difference falls to "
        f"{best / own:.0%} of its value{f' ({also[0]})' if also else ''}: check the place of this "
        f"sensor and the delay of its channel{_remaining(best)}"
    )


def _remaining(best: float) -> str:
    """That a cause does not explain the data alone, if a large difference remains with it."""
    if best < REMAINING:
        return ""
    return f"; a difference of {best:.0%} of the signals remains, so it is not the only cause"


def _suspicious(
    found: TraceComparison,
    columns: Sequence[Array],
    grid: Array,
    begin: float,
    other: tuple[float, float] | None,
) -> tuple[bool, list[str]]:
    """Whether columns are probably exchanged, and sentences on this, on units and on places."""
    (shot,) = found.traces.shots
    outside = sensors_outside(shot, columns, found.signals)
    silent = [signal.name for signal in shot.signals if not has_pulse(signal)]
    units = unit_notes(found.sensors, [*outside, *silent])
    # Wrong times, or columns that are exchanged, cause most of the other differences.
    if notes := time_notes(shot, columns, grid):
        return False, [*notes, *units]
    spacing = float(grid[1] - grid[0])
    if notes := exchange_notes(shot, columns, spacing) or order_notes(shot, columns, grid):
        return True, notes
    return False, [
        *units,
        *outside_notes(shot, columns, grid, begin, outside),
        *other_offset_notes(shot, found.time_offset, other),
        *(
            given_offset_notes(found.sensors, found.time_offset, min(pulse_widths(columns, grid)))
            if found.time_offset_given
            else ()
        ),
    ]


def _gain(run: Run) -> Gain:
    """Gains of sensors without calibration: ratios of measured to simulated changes."""

    def gain(_: int, signal: Signal) -> float:
        if signal.calibrated:
            return 1.0
        seen, simulated = signal.values[signal.valid], signal.place.signal(run)
        size = float(np.abs(simulated - simulated[0]).max())
        return float(np.abs(seen - level_of(signal)).max()) / size if size > 0.0 else 0.0

    return gain


def check_unit_of_times(run: Run, traces: Traces) -> None:
    """Raise `InputError` if measured pulses last much longer or shorter than those of a run."""
    _require_comparable(run, traces)
    shot = resolved_coupling(traces, [run.chain], _gain(run)).shots[0]
    grid, columns = _columns(run, shot)
    check_durations(shot, columns, grid)


def _columns(run: Run, shot: Shot) -> tuple[Array, list[Array]]:
    """Evenly spaced times since the first saved one, and the simulated signals at them."""
    times = run.times - run.times[0]
    grid = np.linspace(0.0, times[-1], len(times))
    return grid, [np.interp(grid, times, _signal_of(run, each)) for each in shot.signals]


def _require_comparable(run: Run, traces: Traces) -> None:
    check_type("traces", traces, Traces, "hc.load_traces returns them")
    if run.chain.scaled:
        raise InputError(
            "traces are in SI units, but the run is in scaled variables; simulate a chain of "
            "Chain.from_materials"
        )
    if len(run.times) < 20:
        raise InputError(
            f"the run has {len(run.times)} saved times, too few to compare; give simulate times of "
            "at least 20"
        )
    if len(traces.shots) != 1:
        raise InputError(
            f"there are {len(traces.shots)} shots; compare a run with one shot, such as "
            "hc.Traces(traces.shots[:1]), or merge the channels of one shot: first.merge(second)"
        )


def _at(moments: Array, inside: NDArray[np.bool_], column: Array, spacing: float) -> Array:
    """A simulated signal at the times of the data; NaN beyond the end of the run."""
    values = np.full(len(moments), np.nan)
    values[inside] = sampled(column, spacing, moments[inside])
    return values


def _signal_of(run: Run, signal: Signal) -> Array:
    """Simulated signal of a sensor; with AC coupling, without the static force."""
    found = signal.place.signal(run)
    return found - static_force(signal.place, run.chain) if signal.coupling == "AC" else found
