"""Durations of first pulses, and notes on measured ones that are broader or have another crest."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Final

import numpy as np

from ..collision import Array
from ..representation import listed, measure
from ..traces.amplitudes import ARRIVED, extreme, level_of
from ..traces.signals import Shot, Signal
from .crossings import reached
from .sensor_comparison import SensorComparison

# Ratio of the durations of a measured and a simulated pulse that is noted.
BROAD: Final = 1.3
# Crests are sought from the arrival on for these multiples of the simulated and the measured
# duration, the longer of both, in signals averaged over this part of the simulated one.
SOUGHT, LONGER, AVERAGED = 2.5, 1.2, 0.2
# Depth of the dip between two crests, as a part of the peak and in standard errors of the noise.
DIP, ABOVE_NOISE = 0.1, 6.0


def shape_notes(
    shot: Shot, models: Sequence[Array], sensors: Sequence[SensorComparison],
    outside: Collection[str],
) -> list[str]:  # fmt: skip
    """Notes on measured first pulses that are broader than the simulated ones, or double.

    ``outside`` has the sensors whose simulated pulse is not in the record.
    """
    double = {}
    for signal, model, each in zip(shot.signals, models, sensors, strict=True):
        if each.name not in outside and np.isfinite(each.simulated_duration):
            double[each.name] = _time_to_crest(shot.times, signal, model, each)
    double = {name: time for name, time in double.items() if np.isfinite(time)}
    ratios = {each.name: each.measured_duration / each.simulated_duration for each in sensors}
    broad = {
        name: ratio for name, ratio in ratios.items()
        if ratio > BROAD and name not in double and name not in outside
    }  # fmt: skip
    notes = []
    if broad:
        ends = dict.fromkeys(f"{each:.2g}" for each in (min(broad.values()), max(broad.values())))
        notes.append(
            f"the measured first pulse of {listed(list(broad))} lasts {' to '.join(ends)} times as "
            "long as the simulated one: a slow amplifier or a filter (free 'lag' in a fit), or a "
            "striker or contacts softer than in the chain may broaden it"
        )
    if double:
        ends = dict.fromkeys(measure(each, "s", digits=2) for each in
                             (min(double.values()), max(double.values())))  # fmt: skip
        notes.append(
            f"the measured first pulse of {listed(list(double))} has a second crest, "
            f"{' to '.join(ends)} after the first one, which the simulated pulse does not have: "
            "check for a second impact, a heavier striker, and a gap between balls"
        )
    return notes


def _time_to_crest(times: Array, signal: Signal, model: Array, each: SensorComparison) -> float:
    """Time from the first to a second crest of the data that the model does not have, or NaN."""
    ok = signal.valid & np.isfinite(model)
    seen, own = (signal.values - level_of(signal))[ok], (model - model[np.isfinite(model)][0])[ok]
    smooth = AVERAGED * each.simulated_duration
    width = float(np.nanmax([SOUGHT * each.simulated_duration, LONGER * each.measured_duration]))
    found = _second_crest(times[ok], seen, signal.sigma, smooth, width)
    has_one = np.isfinite(_second_crest(times[ok], own, 0.0, smooth, width))
    return np.nan if has_one else found


def _second_crest(times: Array, values: Array, sigma: float, smooth: float, width: float) -> float:
    """Time from the first to the second crest of the first pulse; NaN if it has only one."""
    from scipy.ndimage import uniform_filter1d
    from scipy.signal import find_peaks

    count = max(int(smooth / float(np.median(np.diff(times)))), 1)
    height = uniform_filter1d(values * np.sign(extreme(values)), count)
    peak = float(height.max())
    begin = reached(times, height, ARRIVED * peak)
    if not np.isfinite(begin):
        return np.nan
    near = times <= begin + width
    dip = max(DIP * peak, ABOVE_NOISE * sigma / count**0.5)
    found, _ = find_peaks(height[near], prominence=dip, height=ARRIVED * peak)
    return float(times[found[1]] - times[found[0]]) if len(found) > 1 else np.nan
