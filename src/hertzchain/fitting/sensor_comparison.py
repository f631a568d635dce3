"""Peaks and arrivals of a measured and a simulated signal, and signs of mistakes in the data."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError
from ..representation import measure, shown_signal, usual_unit
from ..simulation.run import Run
from ..traces.amplitudes import (
    ARRIVED,
    CERTAIN,
    error_of_level,
    extreme,
    level_differs,
    level_of,
    level_of_model,
)
from ..traces.headers import GAIN_UNITS
from ..traces.signals import Shot, Signal
from .crossings import arrival_error, half_width, reached
from .misread_columns import POLARITY, PROBES, advice_on_amplitude, prefix_of, usual_factor
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


@dataclass(frozen=True)
class SensorComparison:
    """Measured and simulated signal of one sensor.

    Peaks are the largest deviations from the level before the pulse, arrivals the times of the
    data at which a signal reaches half of its peak, in the compared interval.  Both signals are
    compared at the times of the samples: few samples within a pulse lower both peaks equally, and
    the simulated one is then below that of `Run.wall_force` or `Run.sensor_force`.  If the crest of
    the measured signal is missing, its peak is a lower bound, such as the level of saturation, and
    both arrivals are those at half of it.

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
        difference = shown_difference(self.peak_ratio)
        if self.lower_bound:
            difference = "saturated" if self.saturated else "no crest"
        factor, unit = usual_unit(self.measured_peak, self.unit) if self.volts else (1.0, self.unit)
        return (
            f"{'>' * self.lower_bound}{factor * self.measured_peak:.4g} {unit}",
            f"{factor * self.simulated_peak:.4g} {unit}", difference,
            *(_time(each) for each in (self.measured_arrival, self.simulated_arrival)),
            _time(self.delay, "+"),
            shown_part(self.residual),
        )  # fmt: skip

    @property
    def row(self) -> str:
        """Row of a table."""
        return _aligned(self.name, *self.cells)


def _time(value: float, sign: str = "") -> str:
    if not np.isfinite(value):
        return "-"
    if abs(value) < MILLISECONDS:
        return f"{1e6 * value:{sign}z.2f} us"
    return f"{1e3 * value:{sign}z.2f} ms" if abs(value) < SECONDS else f"{value:{sign}.2f} s"


def _aligned(name: str, *cells: str) -> str:
    return f"  {name:<13}" + "".join(
        f" {cell:>{width}}" for cell, width in zip(cells, WIDTHS, strict=True)
    )


HEADINGS: Final = (
    "sensor", "peak", "simulated", "difference", "arrival", "simulated", "difference", "residual",
)  # fmt: skip
# Widths of the columns after the first; the table has 88 columns.
WIDTHS: Final = (10, 10, 10, 9, 9, 10, 8)
HEADING: Final = _aligned(*HEADINGS)


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
    peaks = extreme(measured), extreme(simulated)
    saturated = bool(clipped.any())
    width = half_width(times[covered], simulated)
    missing = not saturated and crest_is_missing(times[covered], seen[covered] / peaks[0], width)
    # A signal without a crest and its model are compared at the same height.
    half = ARRIVED * abs(peaks[0 if saturated or missing else 1])
    levels = ARRIVED * peaks[0], float(np.copysign(half, peaks[1]))
    arrival = reached(times[present], measured, levels[0], SHORT * width)
    known = not (saturated or missing) and np.isfinite(arrival)
    error = arrival_error(times[covered], simulated, peaks[0], signal.sigma) if known else np.nan
    return SensorComparison(
        signal.name, signal.unit, signal.place.quantity, *peaks,
        arrival, reached(times[covered], simulated, levels[1]), error,
        rest / abs(peaks[0]), scale_of(signal, model), saturated, missing,
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
                f"the measured pulse of {signal.name} lasts {least}{lasting:.3g} times as long as "
                "the simulated one; check the unit of the times of the data, such as 'time [us]'"
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


def unit_notes(sensors: Sequence[SensorComparison], outside: Collection[str]) -> list[str]:
    """Notes on peaks of calibrated sensors that differ by a power of ten, or much.

    ``outside`` has the sensors whose simulated pulse is not in the record.
    """
    notes = []
    for each in sensors:
        if each.name in outside:
            continue
        ratio = 1.0 / each.peak_ratio
        if each.quantity == "velocity":
            ratio = abs(ratio)  # reflected waves change the sign of the largest velocity
        if each.unit == "V" or 1.0 / NOTED < ratio < NOTED:
            continue
        problem = (
            f"the simulated peak of {each.name} is {shown_ratio(1.0 / ratio)} the measured one"
        )
        if ratio < 0.0:
            notes.append(f"{problem}: {POLARITY}")
        elif prefix_of(ratio) or usual_factor(ratio) in PROBES:
            notes.append(f"{problem}: {advice_on_amplitude(usual_factor(ratio))}")
        elif ratio > 1.0 or not each.lower_bound:
            notes.append(
                f"{problem}: check its gain and unit, and the velocity and sizes of the chain"
            )
    return notes


def level_notes(shot: Shot, signals: Sequence[Array], columns: Sequence[Array]) -> list[str]:
    """Notes on sensors whose level before the pulse is not that of the simulation."""
    notes = []
    for signal, model, column in zip(shot.signals, signals, columns, strict=True):
        expected = level_of_model(signal, model)
        if not np.isfinite(expected):
            continue
        error, level = error_of_level(signal), shown_signal(signal.level, signal.unit)
        if not signal.calibrated:
            # The scale is not accurate enough to compare the static force.
            scale, static = scale_of(signal, model), float(column[0])
            allowed = CERTAIN * error + 0.5 * abs(scale * static)
            if level_differs(signal, scale * expected, scale * static, allowed):
                notes.append(
                    f"before the pulse, {signal.name} is at {level}, to which the simulation is "
                    f"shifted; a fit needs 'offset[{signal.name}]'"
                )
            continue
        if level_differs(signal, expected, float(column[0]), CERTAIN * error):
            # The foot of the simulated pulse is not zero, but cannot be measured.
            shown = expected if abs(expected) > error else 0.0
            notes.append(
                f"before the pulse, {signal.name} is at {level}, the simulation at "
                f"{shown_signal(shown, signal.unit)}; the difference is part of the "
                "residual: check the zero of the sensor"
            )
    return notes


def missing_notes(sensors: Sequence[SensorComparison]) -> list[str]:
    """Notes on saturated and missing samples at the crest of a signal or at its arrival."""
    notes = []
    for each in sensors:
        peak = shown_signal(each.measured_peak, each.unit, digits=4)
        if each.saturated:
            notes.append(
                f"{each.name} is saturated at {peak}: its crest is missing, and is not part of the "
                "residual"
            )
        elif each.crest_missing:
            notes.append(
                f"samples of {each.name} are missing at its crest, or the data end before it: "
                f"{peak} is the largest of the others, a lower bound of the peak"
            )
        if np.isnan(each.measured_arrival):
            notes.append(
                f"samples of {each.name} are missing where it reaches half of its peak: its "
                "arrival is not known"
            )
    return notes


def pulse_notes(
    run: Run, shot: Shot, columns: Sequence[Array], inside: Array, until: float
) -> list[str]:
    """Notes on incomplete simulated peaks and on the end of the record."""
    notes = []
    for signal, column in zip(shot.signals, columns, strict=True):
        if np.argmax(np.abs(column - column[0])) >= len(column) - 2:
            notes.append(
                f"the simulated peak of {signal.name} is not complete, because the run ends first; "
                "simulate for longer to compare peaks and to find a more accurate time offset"
            )
    if np.mean(inside) < COMPLETE:
        notes.append(
            f"the run ends at {measure(float(run.times[-1]), 's')}, before the record ends; "
            f"simulate with until={measure(until, 's')!r} to compare the whole record"
        )
    return notes
