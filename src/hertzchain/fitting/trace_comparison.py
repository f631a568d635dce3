"""Comparison of data with a simulation, without any fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, overload

import numpy as np
from numpy.typing import NDArray

from ..collision import Array
from ..errors import InputError, InputWarning, warn_user
from ..representation import measure, short, usual_unit, with_error
from ..simulation.run import Run
from ..traces.amplitudes import level_of
from ..traces.coupling import Gain, coupling_notes, resolved_coupling, static_force
from ..traces.missing_rows import gap_notes, gaps_between, with_missing_samples
from ..traces.notes import missing_sample_notes, spike_notes
from ..traces.places import check_places
from ..traces.signals import Clock, Shot, Signal
from ..traces.spikes import without_spikes
from ..traces.traces import Traces, with_time_offset
from ..validation.keywords import checked_methods
from ..validation.objects import check_type
from .arrival_notes import (
    NOTHING_EXPLAINED,
    has_pulse,
    order_notes,
    other_offset_notes,
    outside_notes,
    sensors_outside,
    silent_notes,
    with_pulses,
)
from .compared_part import check_reached, covered_part
from .exchanged_columns import check_contained_or_exchanged, exchange_notes
from .goodness import EXPLAINED
from .misread_columns import inversion_notes
from .misread_times import time_notes
from .odd_sensors import odd_sensor_notes
from .sensor_comparison import (
    HEADING,
    SensorComparison,
    check_arrivals,
    check_contains_a_pulse,
    check_durations,
    check_resolved,
    compared_sensor,
    level_notes,
    missing_notes,
    pulse_notes,
    pulse_widths,
    scale_of,
    scaled,
    unit_notes,
)
from .sensors import sampled
from .time_offsets import best_offset, explained_by_offset, offset_error

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@checked_methods
@dataclass(frozen=True, eq=False)
class TraceComparison:
    """Measured signals and those of a run at the same times.

    Attributes
    ----------
    traces : Traces
        The data, of one shot.  Rows that are missing in an otherwise even record are rows of
        missing samples.
    signals : tuple of ndarray
        Simulated signals at the times of the data [N or m/s]; NaN beyond the end of the run.
    time_offset : float
        Time of the data at which the simulation begins [s].
    time_offset_given : bool
        Whether the time offset was given; otherwise, it is that of the least squares of the
        differences, with a free amplitude of each signal.
    time_offset_error : float
        Standard error of this time offset [s], from the differences as if they were noise; at least
        a thousandth of the step between samples.  NaN if the time offset was given.
    notes : tuple of str
        Remarks, one sentence each: samples that the run does not cover, missing rows, incomplete
        peaks, times and peaks that suggest another unit, arrivals in another order or outside the
        record, another time offset that agrees almost as well, saturated sensors, and sensors
        without the static force.
    exchanged : bool
        Whether columns are probably exchanged; amplitudes and signs then have no meaning.

    Examples
    --------
    >>> import hertzchain as hc
    >>> traces, chain = hc.example_experiment()
    >>> run = hc.simulate(hc.load_chain(chain), until=600e-6, times=1201)
    >>> ball = run.compare(traces).sensors[0]
    >>> ball.name, round(ball.measured_peak, 1), round(ball.simulated_peak, 1)
    ('ball 6', 29.3, 30.5)
    """

    traces: Traces
    signals: tuple[Array, ...] = field(repr=False)
    time_offset: float
    time_offset_given: bool = False
    time_offset_error: float = np.nan
    notes: tuple[str, ...] = ()
    exchanged: bool = False

    @cached_property
    def sensors(self) -> tuple[SensorComparison, ...]:
        """Peaks, arrivals and residual of each sensor."""
        shot = self.traces.shots[0]
        return tuple(
            compared_sensor(shot.times, signal, model)
            for signal, model in zip(shot.signals, self.signals, strict=True)
        )

    @property
    def differences(self) -> dict[str, float]:
        """Rms of data minus simulation, relative to the measured peak, by sensor.

        For uncalibrated sensors, the simulation is scaled to the data.
        """
        return {each.name: each.residual for each in self.sensors}

    @property
    def interval(self) -> tuple[float, float]:
        """First and last time of the data that are compared [s]."""
        times = self.traces.shots[0].times[np.isfinite(self.signals[0])]
        return float(times[0]), float(times[-1])

    @property
    def covered(self) -> float:
        """Part of the record that is compared."""
        times = self.traces.shots[0].times
        begin, end = self.interval
        return (end - begin) / float(times[-1] - times[0])

    @property
    def scales(self) -> tuple[float, ...]:
        """Factors of the simulation that fit the data best; 1 for calibrated sensors."""
        return tuple(map(scale_of, self.traces.shots[0].signals, self.signals))

    @property
    def scaled(self) -> tuple[Array, ...]:
        """Simulated signals, for uncalibrated sensors scaled and at the level of the data."""
        return tuple(map(scaled, self.traces.shots[0].signals, self.signals))

    @property
    def clock(self) -> Clock | None:
        """The time offset and its reason, if it was given."""
        return self.traces.shots[0].clock

    @property
    def time_offset_text(self) -> str:
        """Time offset with its error and unit."""
        error = self.time_offset_error
        if not np.isfinite(error):
            return measure(self.time_offset, "s")
        factor, unit = usual_unit(max(abs(self.time_offset), error), "s")
        return f"{with_error(factor * self.time_offset, factor * error)} {unit}"

    @property
    def _arrival_errors(self) -> list[str]:
        """Lines on the standard errors of the measured arrivals, if any is known."""
        errors = [each.arrival_error for each in self.sensors if np.isfinite(each.arrival_error)]
        if not errors:
            return []
        ends = dict.fromkeys(measure(each, "s", digits=2) for each in (min(errors), max(errors)))
        text = f"errors of measured arrivals, from noise and sampling: {' to '.join(ends)}"
        if self.time_offset_given:
            return [text]
        return [text, "the error of the time offset assumes that the chain is right"]

    def summary(self) -> str:
        """Table of peaks, arrivals and residuals, the compared interval, and notes.

        If columns are probably exchanged, the first line says so.

        Returns
        -------
        str

        Examples
        --------
        >>> import hertzchain as hc
        >>> traces, chain = hc.example_experiment()
        >>> run = hc.simulate(hc.load_chain(chain), until=600e-6, times=1201)
        >>> print(run.compare(traces).summary().splitlines()[0])
        data from 0 s to 639 us, 100% of the record; time offset 78.81 +- 0.44 us, by least squares
        """
        begin, end = self.interval
        how = "by least squares" if self.clock is None else self.clock.reason
        lines = [
            f"data from {measure(begin, 's')} to {measure(end, 's')}, {self.covered:.0%} of the "
            f"record; time offset {self.time_offset_text}, {how}",
            HEADING,
            *(each.row for each in self.sensors),
            "peak: from the level before the pulse; arrival: at half of the peak;",
            "residual: rms of data minus simulation over the measured peak",
            *self._arrival_errors,
        ]
        factors = [f"{each.name} by {each.scaling}" for each in self.sensors if each.unit == "V"]
        if factors:
            lines.append(f"without calibration, the simulation is scaled: {', '.join(factors)}")
        statement = [self._statement] if self._statement else []
        return "\n".join((*statement, *lines, *self.notes[len(statement) :]))

    @property
    def _statement(self) -> str:
        """The note that columns are exchanged, which is the first one; or nothing."""
        as_named = "the values below are those of the columns as they are named"
        return f"{self.notes[0]}; {as_named}" if self.exchanged else ""

    def to_dataframe(self) -> pd.DataFrame:
        """Table of peaks, arrivals [s], their differences and residuals, one row per sensor.

        Examples
        --------
        >>> import hertzchain as hc
        >>> traces, chain = hc.example_experiment()
        >>> run = hc.simulate(hc.load_chain(chain), until=600e-6, times=1201)
        >>> round(run.compare(traces).to_dataframe().measured_peak["ball 6"], 1).item()
        29.3
        """
        import pandas as pd

        rows = [asdict(each) | {"delay": each.delay} for each in self.sensors]
        return pd.DataFrame(rows).set_index("name").rename_axis("sensor")

    @overload
    def plot(self) -> Figure: ...
    @overload
    def plot(
        self, sensor: str, *, legend: bool = True, ax: Axes | Sequence[Axes] | None = None
    ) -> Axes: ...
    def plot(
        self, sensor: str | None = None, *, legend: bool = True,
        ax: Axes | Sequence[Axes] | None = None,
    ) -> Axes | Figure:  # fmt: skip
        """Plot data and simulation and, below them, their difference over the noise, by sensor.

        Parameters
        ----------
        sensor : str, optional
            Name of a sensor; by default, the figure has two panels per sensor.
        legend : bool
            Whether the axes of this sensor have a legend, which one of several sensors needs.
        ax : matplotlib.axes.Axes, or a pair of them, optional
            Axes to draw one sensor into; those of its difference are the second of a pair.  By
            default, a new figure has both.

        Returns
        -------
        matplotlib.figure.Figure or matplotlib.axes.Axes
            The figure of all sensors, or the axes of one.

        Raises
        ------
        InputError
            If there is no such sensor, or for axes without a sensor.

        Examples
        --------
        >>> import hertzchain as hc
        >>> traces, chain = hc.example_experiment()
        >>> run = hc.simulate(hc.load_chain(chain), until=600e-6, times=1201)
        >>> len(run.compare(traces).plot().axes)
        8
        """
        from ..plotting.fits import plot_sensor, plot_trace_comparison

        if sensor is not None:
            return plot_sensor(self, sensor, legend=legend, ax=ax)
        if ax is not None:
            names = [signal.name for signal in self.traces.shots[0].signals]
            raise InputError(f"ax takes one sensor; give it, such as {names[0]!r}")
        return plot_trace_comparison(self)

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        from ..notebook.fits import trace_comparison_html

        return trace_comparison_html(self)

    def __repr__(self) -> str:
        rows = ", ".join(f"{name} {value:.2%}" for name, value in self.differences.items())
        offset = f"time offset {self.time_offset_text}"
        covered = f"{self.covered:.0%} of the record"
        about = "rms difference over measured peak"
        return short("TraceComparison", about, rows, covered, offset, *self.notes)


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
    check_contained_or_exchanged(shot, inside, columns, spacing)
    check_reached(shot, moments, columns, grid, float(time_offset), "".join(unexplained))
    signals = tuple(_at(moments, inside, column, spacing) for column in columns)
    error = np.nan if given else offset_error(shot, signals)
    found = TraceComparison(traces, signals, float(time_offset), given, error)
    exchanged, other_places = _suspicious(found, columns, grid, begin, other)
    suspicious = [
        *other_places,
        *spike_notes(shot),
        *(silent_notes(shot, inside) or unexplained),
    ]
    for note in suspicious:
        warn_user(note, InputWarning)
    notes = (
        *suspicious,
        *gap_notes(gaps),
        *empty_notes,
        *inversion_notes({} if exchanged else {each.name: each.scale for each in found.sensors}),
        *level_notes(shot, signals, columns),
        *([] if exchanged else _crest_notes(found, run, columns, inside)),
        *coupling_notes(traces, [run.chain], gain),
    )
    return replace(found, notes=notes, exchanged=exchanged)


def _crest_notes(
    found: TraceComparison, run: Run, columns: Sequence[Array], inside: Array
) -> list[str]:
    """Sentences on crests, on the end of the run, and on a sensor that differs from the others."""
    (shot,) = found.traces.shots
    until = float(shot.times[-1]) - found.time_offset
    outside = sensors_outside(shot, columns, found.signals)
    return [
        *missing_notes(found.sensors), *pulse_notes(run, shot, columns, inside, until),
        *odd_sensor_notes(found.sensors, shot, inside, outside),
    ]  # fmt: skip


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
