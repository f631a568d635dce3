"""Notes on arrivals: pulses outside the record, in another order, or compared with a later one."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from ..collision import Array
from ..representation import listed, measure
from ..traces.amplitudes import ARRIVED, SAME_TIME, extreme, level_of
from ..traces.signals import Shot, Signal
from .crossings import reached
from .sensor_comparison import ABOVE_NOISE, SensorComparison, saturated_samples

# Part of the simulated peak that must be in the record for a comparison of peaks.
IN_RECORD: Final = 0.1
# Parts of the simulated peak at which the pulse begins and ends; losses leave a tail behind it.
FOOT, TAIL = 0.01, 0.05
# All arrivals differ by one time if the differences vary by less than this part of the least one,
# and if they exceed this part of the width of a pulse.
SPREAD, SHIFTED = 0.25, 0.1
ALL_ARRIVALS: Final = "all simulated arrivals are"
# The note on data in which a simulated pulse is not recognised.
NOTHING_EXPLAINED: Final = (
    "the simulation explains no more of the data than noise would, and the time offset has no "
    "meaning: check the sensors and the record, or give time_offset"
)


def order_notes(shot: Shot, columns: Sequence[Array], grid: Array) -> list[str]:
    """A note if the pulse arrives in another order than in the simulation."""
    least = SAME_TIME * float(np.median(np.diff(shot.times)))
    arrivals: list[tuple[Signal, float, float]] = []
    for signal, column in zip(shot.signals, columns, strict=True):
        ok = signal.valid | saturated_samples(signal)
        pairs = (shot.times[ok], (signal.values - level_of(signal))[ok]), (grid, column - column[0])
        seen, own = (reached(each, values, ARRIVED * extreme(values)) for each, values in pairs)
        if has_pulse(signal):
            arrivals.append((signal, seen, own))
    for (one, seen, own), (two, seen_later, own_later) in itertools.combinations(arrivals, 2):
        measured, simulated = seen_later - seen, own_later - own
        if measured * simulated < 0.0 and min(abs(measured), abs(simulated)) > least:
            early, late = (one, two) if measured > 0.0 else (two, one)
            return [
                f"the measured pulse arrives at {early.name} {measure(abs(measured), 's')} before "
                f"{late.name}, the simulated one {measure(abs(simulated), 's')} after it: check "
                "the names of these columns, and whether the record begins before the first pulse "
                "arrives"
            ]
    return []


def silent_notes(shot: Shot, inside: Array | None = None) -> list[str]:
    """Notes on data, or on the part of them that is compared, without a pulse."""
    return [
        f"the data of {signal.name} have no pulse above their noise"
        for signal in shot.signals if not has_pulse(signal, inside)
    ]  # fmt: skip


def has_pulse(signal: Signal, inside: Array | None = None) -> bool:
    """Whether a signal, or the part of it that is compared, clearly exceeds its noise."""
    ok = np.isfinite(signal.values) if inside is None else np.isfinite(signal.values) & inside
    return abs(extreme(signal.values[ok] - level_of(signal))) > ABOVE_NOISE * signal.sigma


def with_pulses(shot: Shot, columns: list[Array]) -> tuple[Shot, list[Array]]:
    """The signals that exceed their noise, and their models; all of them if none does."""
    seen = [has_pulse(signal) for signal in shot.signals]
    if not any(seen):
        return shot, columns
    signals = tuple(itertools.compress(shot.signals, seen))
    return replace(shot, signals=signals), list(itertools.compress(columns, seen))


def sensors_outside(shot: Shot, columns: Sequence[Array], models: Sequence[Array]) -> list[str]:
    """Sensors whose simulated signal in the record has less than a tenth of its peak."""
    return [
        signal.name
        for signal, column, model in zip(shot.signals, columns, models, strict=True)
        if np.nanmax(np.abs(model - column[0])) < IN_RECORD * np.abs(column - column[0]).max()
    ]


def outside_notes(
    shot: Shot, columns: Sequence[Array], grid: Array, begin: float, outside: Sequence[str]
) -> list[str]:
    """Notes on simulated first pulses that arrive before the record begins, or after it ends.

    ``begin`` is the time of the data at the first time of the grid, which is 0.
    """
    early, cut, missing = [], [], []
    record = float(shot.times[0]) - begin
    for signal, column in zip(shot.signals, columns, strict=True):
        own = column - column[0]
        foot, crest, end = _first_pulse(own, grid)
        if foot < record < end:
            cut.append(signal.name)
        if crest < record:
            early.append(signal.name)
        elif signal.name in outside and has_pulse(signal):
            missing.append(signal.name)
    notes = []
    if early:
        notes.append(
            f"the simulated first pulse arrives at {listed(early)} before the record begins, and "
            "later pulses, such as reflected ones, are compared; if the record contains the first "
            "pulse, give time_offset"
        )
    if cut:
        notes.append(
            f"the record begins during the first simulated pulse at {listed(cut)}, so the level "
            "before the pulse is not known, and the measured peak and arrival are not reliable: "
            "begin the record earlier, or give time_offset if the simulation is early"
        )
    if missing:
        notes.append(
            f"the simulated pulse of {listed(missing)} is not in the record; check the time offset"
        )
    return notes


def _first_pulse(values: Array, grid: Array) -> tuple[float, float, float]:
    """Foot, crest and end of the first pulse of a simulated signal; infinite without a pulse."""
    if not values.any():
        return np.inf, np.inf, np.inf
    height = values / extreme(values)
    first = int(np.argmax(height >= ARRIVED))
    falls, ends = (
        first + int(np.argmax(np.append(height[first:], 0.0) < part)) for part in (ARRIVED, TAIL)
    )
    crest = float(grid[first + int(np.argmax(height[first:falls]))])
    end = float(grid[ends]) if ends < len(grid) else np.inf
    return reached(grid, values, FOOT * extreme(values)), crest, end


def other_offset_notes(
    shot: Shot, time_offset: float, other: tuple[float, float] | None
) -> list[str]:
    """A note if another offset, with its larger differences, agrees almost as well."""
    if other is None or not any(map(has_pulse, shot.signals)):
        return []
    offset, larger = other
    return [
        f"with a time offset of about {measure(offset, 's', digits=3)} instead of "
        f"{measure(time_offset, 's', digits=3)}, the differences are only {larger - 1.0:.0%} "
        "larger: a reflected pulse may be compared with the first one; give time_offset if you "
        "know it"
    ]


def given_offset_notes(
    sensors: Sequence[SensorComparison], time_offset: float, width: float
) -> list[str]:
    """A note if all simulated arrivals differ by about one time, as from a wrong given offset."""
    delays = [each.delay for each in sensors if np.isfinite(each.delay)]
    if len(delays) < 2:
        return []
    low, high = sorted((min(delays), max(delays)), key=abs)
    if low * high <= 0.0 or abs(high - low) > SPREAD * abs(low) or abs(low) < SHIFTED * width:
        return []
    later = "late" if low > 0.0 else "early"
    least, most = (measure(abs(each), "s", digits=3) for each in (low, high))
    return [
        f"{ALL_ARRIVALS} {least} to {most} {later}: check the given time offset, "
        f"{measure(time_offset, 's')}, before all other differences, which depend on it"
    ]
