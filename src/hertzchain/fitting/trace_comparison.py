"""Comparison of data with a simulation, without any fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, overload

import numpy as np

from ..collision import Array
from ..errors import InputError
from ..representation import SUMMARY_WIDTH, folded, measure, short, usual_unit, with_error
from ..traces.signals import Clock
from ..traces.traces import Traces
from ..validation.entries import NoEntries
from ..validation.keywords import checked_methods
from .sensor_comparison import (
    HEADING,
    MEASURED_HEADINGS,
    NO_PULSE,
    SensorComparison,
    aligned,
    compared_sensor,
    scale_of,
    scaled,
)
from .summary_width import summary_width

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@checked_methods
@dataclass(frozen=True, eq=False)
class TraceComparison(NoEntries):
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
    def _durations(self) -> list[str]:
        """A line on the durations of the first pulses, if any is known."""
        pairs = [
            f"{each.name} {1e6 * each.measured_duration:.3g} and "
            f"{1e6 * each.simulated_duration:.3g} us"
            for each in self.sensors
            if np.isfinite(each.measured_duration) and np.isfinite(each.simulated_duration)
        ]
        if not pairs:
            return []
        return [f"first pulse above half of its peak, measured and simulated: {'; '.join(pairs)}"]

    @property
    def _peak_errors(self) -> list[str]:
        """A line on the standard errors of the measured peaks, if any is known."""
        errors = [
            each.peak_error / abs(each.measured_peak) for each in self.sensors
            if each.peak_error > 0.0 and not each.silent
        ]  # fmt: skip
        if not errors:
            return []
        ends = dict.fromkeys(f"{100.0 * each:.2g}%" for each in (min(errors), max(errors)))
        return [f"errors of measured peaks, from noise: {' to '.join(ends)}"]

    @property
    def _arrival_errors(self) -> list[str]:
        """Lines on the standard errors of the measured arrivals, if any is known."""
        errors = [
            each.arrival_error for each in self.sensors
            if np.isfinite(each.arrival_error) and not each.silent
        ]  # fmt: skip
        if not errors:
            return []
        ends = dict.fromkeys(measure(each, "s", digits=2) for each in (min(errors), max(errors)))
        text = f"errors of measured arrivals, from noise and sampling: {' to '.join(ends)}"
        if self.time_offset_given:
            return [text]
        return [text, "the error of the time offset assumes that the chain is right"]

    def summary(self, *, width: int | None = SUMMARY_WIDTH) -> str:
        """Table of peaks, arrivals and residuals, the compared interval, and notes.

        If columns are probably exchanged, the first line says so, and the others have measured
        values only.

        Parameters
        ----------
        width
            Number of columns at which lines are broken; None keeps each sentence on one line.

        Returns
        -------
        str

        Examples
        --------
        >>> import hertzchain as hc
        >>> traces, chain = hc.example_experiment()
        >>> run = hc.simulate(hc.load_chain(chain), until=600e-6, times=1201)
        >>> print(run.compare(traces).summary(width=None).splitlines()[0])
        data from 0 s to 639 us, 100% of the record; time offset 78.81 +- 0.44 us, by least squares
        """
        if self.exchanged:
            begin, end = self.traces.shots[0].times[[0, -1]].tolist()
            rows = [aligned(each.name, *each.measured_cells) for each in self.sensors]
            interval = f"data from {measure(begin, 's')} to {measure(end, 's')}"
            lines = [self._statement, interval, aligned(*MEASURED_HEADINGS), *rows, *self.notes[1:]]
            return folded("\n".join(lines), summary_width(width))
        begin, end = self.interval
        how = "by least squares" if self.clock is None else self.clock.reason
        lines = [
            f"data from {measure(begin, 's')} to {measure(end, 's')}, {self.covered:.0%} of the "
            f"record; time offset {self.time_offset_text}, {how}",
            HEADING,
            *(each.row for each in self.sensors),
            "peak: of the crest, from the level before the pulse; arrival: at half of the peak;",
            "residual: rms of data minus simulation over the measured peak",
            *self._durations,
            *self._peak_errors,
            *self._arrival_errors,
        ]
        factors = [
            f"{each.name} by {each.scaling}" for each in self.sensors
            if each.unit == "V" and not each.silent
        ]  # fmt: skip
        if factors:
            lines.append(f"without calibration, the simulation is scaled: {', '.join(factors)}")
        return folded("\n".join([*lines, *self.notes]), summary_width(width))

    @property
    def _statement(self) -> str:
        """The note that columns are exchanged, which is the first one; or nothing."""
        return f"{self.notes[0]}; the values below are measured" if self.exchanged else ""

    def to_dataframe(self) -> pd.DataFrame:
        """Table of peaks, arrivals and durations [s], and residuals, one row per sensor.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``sensor``; peaks are in the ``unit`` of their row, and ``attrs["units"]``
            has the units of the columns of times.

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
        table = pd.DataFrame(rows).set_index("name").rename_axis("sensor")
        times = (
            "measured_arrival", "simulated_arrival", "arrival_error", "delay",
            "measured_duration", "simulated_duration",
        )  # fmt: skip
        # Peaks are in the unit of each sensor, which is a column.
        table.attrs["units"] = dict.fromkeys(times, "s")
        return table

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
        rows = ", ".join(
            f"{each.name} {NO_PULSE if each.silent else f'{each.residual:.2%}'}"
            for each in self.sensors
        )
        offset = f"time offset {self.time_offset_text}"
        covered = f"{self.covered:.0%} of the record"
        about = "rms difference over measured peak"
        return short("TraceComparison", about, rows, covered, offset, *self.notes)
