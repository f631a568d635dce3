"""Peaks and arrivals of a measured and a simulated signal, and signs of mistakes in the data."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError
from ..representation import measure, shown_signal, usual_unit
from ..simulation.run import Run
from ..traces.amplitudes import ARRIVED, extreme, level_of
from ..traces.crests import crest_of_record
from ..traces.headers import GAIN_UNITS
from ..traces.signals import Shot, Signal
from .crossings import arrival_error, duration_above, half_width, reached
from .misread_columns import prefix_of
from .shown_values import shown_difference, shown_part, shown_ratio

# A simulated signal that is still rising at the end of the run below this fraction of the measured
# peak, or of the largest value anywhere in the run, shows that the pulse has not arrived.
ARRIVING: Final = 0.1
# ... and so does any signal below this fraction.
NOTHING: Final = 1e-9
# Part of the measured peak that the compared samples must contain.
CONTAINED: Final = 0.3
# Part of the samples that a run must cover; otherwise, this is noted.
COMPLETE: Final = 0.995
# Ratio of peaks that is noted, and multiple of the noise below which data have no pulse.
NOTED, ABOVE_NOISE = 3.0, 6.0
# Times [s] from which they are shown in ms, and in s.
MILLISECONDS, SECONDS = 0.01, 10.0
# A simulated pulse shorter than this number of steps between saved times is not resolved; the
# measured one is then too long for the unit of its times if it lasts this many times as long.
RESOLVED, TOO_LONG = 3.0, 30.0
# Least number of saved times within the half width of a simulated pulse, for its peak to 1%.
MIN_TIMES: Final = 5.0
# A gap between samples, as a part of the width of a pulse, in which its crest may be higher than
# its ends by 1%.
SHORT: Final = 0.14
# Text of the peak of data without a pulse.
NO_PULSE: Final = "no pulse"
# Part of the error of a peak below which a simulated peak is shown as 0.
NEGLIGIBLE: Final = 1e-3
# Digits of peaks.
MAX_DIGITS: Final = 4


@dataclass(frozen=True)
class SensorComparison:
    """Measured and simulated signal of one sensor.

    Peaks are the largest deviations from the level before the pulse.  Noise makes the largest
    sample higher than the crest, so that the measured peak is the maximum of a polynomial through
    the samples around it, in the widest window in which it describes them; if these are few, it is
    the largest sample.  It does not depend on the simulation.  Arrivals are the times of the data
    at which a signal reaches half of its peak, in the compared interval.  Both signals are compared
    at the times of the samples: few samples within a pulse lower both peaks equally, and the
    simulated one is then below that of `Run.wall_force` or `Run.sensor_force`.  If the crest of the
    measured signal is missing, its peak is a lower bound, such as the level of saturation, and both
    arrivals are those at half of it.

    Attributes
    ----------
    name, unit : str
        Name of the sensor, and the unit of its signal.
    quantity : str
        ``"force"`` or ``"velocity"``.
    measured_peak, simulated_peak : float
        Peaks, in this unit.
    measured_arrival, simulated_arrival : float
        Arrivals [s]; NaN if samples are missing at the arrival of the measured signal.
    arrival_error : float
        Standard error of the measured arrival [s], from the noise and the sampling interval; the
        simulated one has none, and the error of the time offset is common to all sensors.
    residual : float
        Rms of data minus simulation, relative to the measured peak.
    scale : float
        Factor of the simulation; 1 for calibrated sensors.
    saturated : bool
        Whether the data are saturated, so that their crest is missing.
    crest_missing : bool
        Whether the crest is missing for another reason: samples are missing there, or the data end
        before it.
    peak_error : float
        Standard error of the measured peak from the noise, in the unit of the signal; NaN if the
        crest is missing, or if too few samples are near it.
    measured_duration, simulated_duration : float
        Time from the arrival until the signal falls below half of its peak again [s]: the width of
        the first pulse; NaN if an end or the crest is not in the data.
    silent : bool
        Whether the data have no pulse above their noise: the measured peak, arrival and residual
        then mean nothing, and are not shown.
    """

    name: str
    unit: str
    quantity: str
    measured_peak: float
    simulated_peak: float
    measured_arrival: float
    simulated_arrival: float
    arrival_error: float
    residual: float
    scale: float
    saturated: bool = False
    crest_missing: bool = False
    peak_error: float = np.nan
    measured_duration: float = np.nan
    simulated_duration: float = np.nan
    silent: bool = False

    @property
    def lower_bound(self) -> bool:
        """Whether the measured peak is a lower bound."""
        return self.saturated or self.crest_missing

    @property
    def peak_ratio(self) -> float:
        """Simulated over measured peak."""
        return self.simulated_peak / self.measured_peak

    @property
    def delay(self) -> float:
        """Simulated minus measured arrival [s]."""
        return self.simulated_arrival - self.measured_arrival

    @property
    def volts(self) -> bool:
        """Whether the sensor has no calibration."""
        return self.unit == "V"

    @property
    def scaling(self) -> str:
        """Factor of the simulation with its unit."""
        return shown_signal(self.scale, GAIN_UNITS[self.quantity], digits=4)

    @property
    def cells(self) -> tuple[str, ...]:
        """Peaks, arrivals and residual as text."""
        if self.silent:
            own = self.shown_peaks[1]
            arrival = "-" if own.startswith("0 ") else _time(self.simulated_arrival)
            return NO_PULSE, own, "-", "-", arrival, "-", "-"
        difference = shown_difference(self.peak_ratio)
        if self.lower_bound:
            difference = "saturated" if self.saturated else "no crest"
        return (
            *self.shown_peaks, difference,
            *(_time(each) for each in (self.measured_arrival, self.simulated_arrival)),
            _time(self.delay, "+"),
            shown_part(self.residual),
        )  # fmt: skip

    @property
    def measured_cells(self) -> tuple[str, str]:
        """Measured peak and arrival as text."""
        if self.silent:
            return NO_PULSE, "-"
        return self.shown_peaks[0], _time(self.measured_arrival)

    @property
    def shown_peaks(self) -> tuple[str, str]:
        """Measured and simulated peak, with digits that the error of the measured one allows."""
        factor, unit = usual_unit(self.measured_peak, self.unit) if self.volts else (1.0, self.unit)
        values = factor * self.measured_peak, factor * self.simulated_peak
        seen, own = (_rounded(each, factor * self.peak_error) for each in values)
        return f"{'>' * self.lower_bound}{seen} {unit}", f"{own} {unit}"

    @property
    def row(self) -> str:
        """Row of a table."""
        return aligned(self.name, *self.cells)


def _rounded(value: float, error: float) -> str:
    """A value to the first digit of its error, and to at most four digits."""
    if abs(value) < NEGLIGIBLE * error:
        return "0"
    if not error > 0.0 or abs(value) < 1e-3:
        return f"{value:.{MAX_DIGITS}g}"
    first = math.floor(math.log10(abs(value)))
    decimals = min(-math.floor(math.log10(error)), MAX_DIGITS - 1 - first)
    return f"{round(value, decimals):.{max(decimals, 0)}f}"


def _time(value: float, sign: str = "") -> str:
    if not np.isfinite(value):
        return "-"
    if abs(value) < MILLISECONDS:
        return f"{1e6 * value:{sign}z.2f} us"
    return f"{1e3 * value:{sign}z.2f} ms" if abs(value) < SECONDS else f"{value:{sign}.2f} s"


def aligned(name: str, *cells: str) -> str:
    """A row of a table from the name of a sensor and its first cells."""
    return f"  {name:<13}" + "".join(
        f" {cell:>{width}}" for cell, width in zip(cells, WIDTHS, strict=False)
    )


HEADINGS: Final = (
    "sensor", "peak", "simulated", "difference", "arrival", "simulated", "difference", "residual",
)  # fmt: skip
MEASURED_HEADINGS: Final = ("sensor", "peak", "arrival")
# Widths of the columns after the first; the table has 88 columns.
WIDTHS: Final = (10, 10, 10, 9, 9, 10, 8)
HEADING: Final = aligned(*HEADINGS)


def scale_of(signal: Signal, model: Array) -> float:
    """Factor of a simulated signal that fits an uncalibrated one best; otherwise 1."""
    if signal.calibrated:
        return 1.0
    ok = signal.valid & np.isfinite(model)
    seen, own = signal.values[ok] - level_of(signal), model[ok] - model[ok][0]
    size = float(own @ own)
    return float(seen @ own) / size if size > 0.0 else 0.0


def scaled(signal: Signal, model: Array) -> Array:
    """A simulated signal; for an uncalibrated one, scaled and from the level of the data on."""
    if signal.calibrated:
        return model
    first = model[signal.valid & np.isfinite(model)][0]
    return np.asarray(level_of(signal) + scale_of(signal, model) * (model - first))


def compared_sensor(times: Array, signal: Signal, model: Array) -> SensorComparison:
    """Peaks, arrivals and residual of a signal and its model at the same times."""
    ok = signal.valid & np.isfinite(model)
    seen, own = signal.values - level_of(signal), scaled(signal, model)
    rest = float(np.sqrt(np.mean((signal.values - own)[ok] ** 2)))
    clipped = saturated_samples(signal) & np.isfinite(model)
    covered = np.isfinite(model)
    present = covered & np.isfinite(signal.values)
    measured, simulated = seen[present], (own - own[0])[covered]
    largest = extreme(measured), extreme(simulated)
    saturated = bool(clipped.any())
    width = half_width(times[present], measured)
    missing = not saturated and crest_is_missing(times[covered], seen[covered] / largest[0], width)
    crest = crest_of_record(times[present], measured, signal.sigma)
    smooth = not (saturated or missing) and bool(np.isfinite(crest.error))
    own_crest = crest_of_record(times[covered], simulated, 0.0)
    # Samples may miss both crests, so that the same polynomials give both.
    both = smooth and bool(np.isfinite(own_crest.error))
    peaks = crest.height if smooth else largest[0], own_crest.height if both else largest[1]
    # A signal without a crest and its model are compared at the same height.
    half = ARRIVED * abs(peaks[0 if saturated or missing else 1])
    levels = ARRIVED * peaks[0], float(np.copysign(half, peaks[1]))
    arrival = reached(times[present], measured, levels[0], SHORT * width)
    known = not (saturated or missing) and np.isfinite(arrival)
    error = arrival_error(times[covered], simulated, peaks[0], signal.sigma) if known else np.nan
    # Noise may reach half of a small peak before the pulse arrives.
    clear = known and abs(levels[0]) > ABOVE_NOISE * signal.sigma
    durations = (
        duration_above(times[present], measured, levels[0], SHORT * width),
        duration_above(times[covered], simulated, levels[1]),
    ) if clear else (np.nan, np.nan)  # fmt: skip
    return SensorComparison(
        signal.name, signal.unit, signal.place.quantity, *peaks,
        arrival, reached(times[covered], simulated, levels[1]), error,
        rest / abs(peaks[0]), scale_of(signal, model), saturated, missing,
        crest.error if smooth else np.nan,
        *durations, abs(largest[0]) <= ABOVE_NOISE * signal.sigma,
    )  # fmt: skip


def crest_is_missing(times: Array, height: Array, width: float) -> bool:
    """Whether a signal may be higher in a gap between its samples, or after the last one.

    ``height`` is relative to the peak, and NaN where samples are missing; ``width`` is that of the
    pulse at half of its height.
    """
    present = np.flatnonzero(np.isfinite(height))
    times, height = times[present], height[present]
    if times[-1] - times[int(np.argmax(height))] < 0.5 * SHORT * width:
        return True
    lengths = np.diff(times)
    for before in np.flatnonzero((np.diff(present) > 1) & (lengths > SHORT * width)):
        ends, length = (before, before + 1), lengths[before]
        near = (times >= times[ends[0]] - length) & (times <= times[ends[1]] + length)
        top = int(np.argmax(np.where(near, height, -np.inf)))
        if top in ends and height[top] > ARRIVED:
            return True
    return False


def saturated_samples(signal: Signal) -> Array:
    """Mask of the saturated samples; the others that a fit does not use are missing."""
    return ~signal.valid & np.isfinite(signal.values)


def pulse_widths(columns: Sequence[Array], grid: Array) -> list[float]:
    """Half widths of simulated pulses; 0 without a pulse."""
    return [half_width(grid, column - column[0]) if np.ptp(column) else 0.0 for column in columns]


def check_arrivals(run: Run, shot: Shot, columns: Sequence[Array], grid: Array) -> None:
    """Raise `InputError` if the run has no pulse at a sensor, or one of another duration."""
    for signal, column in zip(shot.signals, columns, strict=True):
        own, seen = column - column[0], (signal.values - level_of(signal))[signal.valid]
        here, measured = np.abs(own).max(), abs(extreme(seen))
        there = run.forces if signal.place.quantity == "force" else run.velocities
        needed = measured if signal.calibrated else float(np.abs(there).max())
        rising = np.argmax(np.abs(own)) >= len(own) - 2
        if here <= NOTHING * needed or (rising and here < ARRIVING * needed):
            raise InputError(_too_short(run, shot, signal, here, measured))
    check_durations(shot, columns, grid)


def check_resolved(shot: Shot, columns: Sequence[Array]) -> None:
    """Raise `InputError` if too few times of a run are within the pulse at a sensor."""
    widths = {
        signal.name: half_width(np.arange(float(len(column))), column - column[0])
        for signal, column in zip(shot.signals, columns, strict=True)
        if np.ptp(column) > 0.0
    }
    name = min(widths, key=lambda each: widths[each], default="")
    if name and widths[name] < MIN_TIMES:
        needed = math.ceil(2.0 * len(columns[0]) * MIN_TIMES / max(widths[name], 1.0))
        raise InputError(
            f"too few saved times to compare: {widths[name]:.0f} are within the half width of the "
            f"pulse at {name}, but at least {MIN_TIMES:.0f} are required; give simulate at least "
            f"times={needed}"
        )


def check_contains_a_pulse(shot: Shot, columns: Sequence[Array], spacing: float) -> None:
    """Raise `InputError` if the record is too short to determine the time offset and gains."""
    record = float(shot.times[-1] - shot.times[0])
    widths = {
        signal.name: spacing * half_width(np.arange(float(len(column))), column - column[0])
        for signal, column in zip(shot.signals, columns, strict=True)
        if 0 < np.argmax(np.abs(column - column[0])) < len(column) - 2
    }
    name = min(widths, key=lambda each: widths[each], default="")
    if name and record < widths[name]:
        raise InputError(
            f"the record lasts {measure(record, 's')}, less than the pulse at {name}, which "
            f"exceeds half of its peak for {measure(widths[name], 's')}: the time offset and gains "
            "cannot be determined from it; record the whole pulse, or give time_offset"
        )


def check_durations(shot: Shot, columns: Sequence[Array], grid: Array) -> None:
    """Raise `InputError` if a measured pulse has another duration than the simulated one."""
    spacing = float(grid[1] - grid[0])
    for signal, column in zip(shot.signals, columns, strict=True):
        own, seen = column - column[0], (signal.values - level_of(signal))[signal.valid]
        if not own.any():
            continue
        width = half_width(grid, own)
        lasting = half_width(shot.times[signal.valid], seen) / max(width, spacing)
        unresolved = width < RESOLVED * spacing and lasting > TOO_LONG
        if unresolved or prefix_of(lasting):
            least = "at least " if unresolved else ""
            raise InputError(
                f"the measured pulse of {signal.name} lasts {least}{shown_ratio(lasting)} as long "
                "as the simulated one; check the unit of the times of the data, such as 'time [us]'"
            )


def _too_short(run: Run, shot: Shot, signal: Signal, here: float, measured: float) -> str:
    unit = "N" if signal.place.quantity == "force" else "m/s"
    end, record = float(run.times[-1]), float(shot.times[-1] - shot.times[0])
    advice = (
        "check the unit of the times of the data, such as 'time [us]', the place of the sensor, "
        "and the chain"
    )
    if end < record:
        advice = (
            f"simulate for longer, for example with until={measure(record, 's')!r}, the duration "
            "of the record, and check the unit of the times of the data"
        )
    return (
        f"the simulated pulse does not arrive at {signal.name} before the run ends at "
        f"{measure(end, 's')}: the signal is {here:.2g} {unit}, the measured one "
        f"{shown_signal(measured, signal.unit)}; {advice}"
    )


def check_contained(shot: Shot, inside: Array) -> None:
    """Raise `InputError` if the run ends before the measured pulse of a sensor."""
    end = float(shot.times[inside][-1])
    for signal in shot.signals:
        seen = np.where(signal.valid, np.abs(signal.values - level_of(signal)), 0.0)
        if seen[inside].max() < CONTAINED * seen.max():
            raise InputError(
                f"the largest signal of {signal.name} is at "
                f"{measure(float(shot.times[np.argmax(seen)]), 's')} of the data, but the run ends "
                f"at {measure(end, 's')} of the data; simulate for longer, or check time_offset "
                "and the unit of the times"
            )
