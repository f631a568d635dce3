"""Notes on the peaks, levels and missing samples of signals that are compared with a simulation."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from ..collision import Array
from ..representation import listed, measure, shown_signal
from ..simulation.run import Run
from ..traces.amplitudes import CERTAIN, error_of_level, level_differs, level_of_model
from ..traces.signals import Shot
from .misread_columns import POLARITY, PROBES, advice_on_amplitude, prefix_of, usual_factor
from .sensor_comparison import COMPLETE, NOTED, SensorComparison, scale_of
from .shown_values import shown_ratio


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
    notes, shifted = [], {}
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
                shifted[signal.name] = level
            continue
        if level_differs(signal, expected, float(column[0]), CERTAIN * error):
            # The foot of the simulated pulse is not zero, but cannot be measured.
            shown = expected if abs(expected) > error else 0.0
            notes.append(
                f"before the pulse, {signal.name} is at {level}, the simulation at "
                f"{shown_signal(shown, signal.unit)}; the difference is part of the "
                "residual: check the zero of the sensor"
            )
    return [*_shift_notes(shifted, len(shot.signals)), *notes]


def _shift_notes(levels: Mapping[str, str], sensors: int) -> list[str]:
    """A note on uncalibrated sensors with an offset, which is not a part of the difference."""
    if not levels:
        return []
    several = len(levels) > 1
    names = ["*"] if several and len(levels) == sensors else levels
    shown = [
        f"{name} {'is ' * (k == 0)}at {level}" for k, (name, level) in enumerate(levels.items())
    ]
    return [
        f"before the pulse, {listed(shown)}; the comparison is without "
        f"{'these levels' if several else 'this level'}; in a fit, free "
        f"{listed([repr(f'offset[{name}]') for name in names])}"
    ]


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
