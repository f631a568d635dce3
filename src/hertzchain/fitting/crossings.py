"""Times at which signals reach a level, and their errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from ..collision import Array
from ..traces.amplitudes import ARRIVED, extreme

# Ratio of the second to the first difference of samples beyond which a signal rises in one step.
ABRUPT: Final = 0.8


def reached(times: Array, values: Array, level: float, longest: float = np.inf) -> float:
    """Time at which a signal first reaches a level, between samples.

    It is NaN if the signal does not reach the level, or in a gap that is longer than ``longest``
    and than the usual spacing of the samples.
    """
    height = values / level
    first = int(np.argmax(height >= 1.0))
    if height[first] < 1.0:
        return np.nan
    if first == 0:
        return float(times[0])
    pair = slice(first - 1, first + 1)
    if np.diff(times[pair])[0] > max(longest, 1.5 * float(np.median(np.diff(times)))):
        return np.nan
    return float(np.interp(1.0, height[pair], times[pair]))


def duration_above(times: Array, values: Array, level: float, longest: float = np.inf) -> float:
    """Time from the first crossing of a level to the last one before a fall to half of it.

    Noise may cross the level several times.  It is NaN if a crossing is outside the samples, or in
    a gap as for `reached`.
    """
    height = values / level
    first = int(np.argmax(height >= 1.0))
    fallen = np.flatnonzero(height[first:] < ARRIVED)
    if height[first] < 1.0 or first == 0 or not len(fallen):
        return np.nan
    last = first + int(np.flatnonzero(height[first : first + fallen[0]] >= 1.0)[-1])
    ends = slice(last, last + 2)
    end = reached(-times[ends][::-1], values[ends][::-1], level)
    if np.diff(times[ends])[0] > max(longest, 1.5 * float(np.median(np.diff(times)))):
        return np.nan
    return -end - reached(times, values, level, longest)


def half_width(times: Array, values: Array) -> float:
    """Time during which a signal exceeds half of its peak, around the peak."""
    height = values / extreme(values)
    peak = int(np.argmax(height))
    below = np.flatnonzero(height < ARRIVED)
    before, after = below[below < peak], below[below > peak]
    first = int(before[-1]) if len(before) else 0
    last = int(after[0]) if len(after) else len(times) - 1
    return float(times[last] - times[first])


def pulse_duration(times: Array, values: Array) -> float:
    """As `half_width`, with both ends between samples; NaN if one is outside them."""
    if not np.ptp(values):
        return np.nan
    height = values / extreme(values)
    peak = int(np.argmax(height))
    below = np.flatnonzero(height < ARRIVED)
    before, after = below[below < peak], below[below > peak]
    if not (len(before) and len(after)):
        return np.nan
    rise, fall = slice(before[-1], before[-1] + 2), slice(after[0] - 1, after[0] + 1)
    begin = np.interp(ARRIVED, height[rise], times[rise])
    end = np.interp(-ARRIVED, -height[fall], times[fall])
    return float(end - begin)


def later_until(sensors: Sequence[str], durations: Array) -> str:
    """Advice on forces that have not fallen to half of their maxima; empty if all have.

    The velocity of a last ball never falls.
    """
    pairs = zip(sensors, durations, strict=True)
    if all(math.isfinite(each) or name.endswith("velocity") for name, each in pairs):
        return ""
    return "; give a later until, at which all forces have fallen to half of their maxima"


def arrival_error(times: Array, model: Array, peak: float, sigma: float) -> float:
    r"""Standard error of the time at which a noisy signal first reaches half of its peak.

    The noise shifts the signal by one standard deviation and the level by half of that of the
    peak, so the time by :math:`\sqrt{1 + 1/4}\,\sigma/s`, where s is the slope there.
    Interpolation between samples h apart has an error of at most :math:`h^2 |f''| / 8s`, and the
    crest between two samples is missed by at most :math:`h^2 |f''| / 8`, which changes the level
    by half of it.  In a rise within one interval, the time is uniformly distributed.

    Slopes and curvatures are those of the ``model``, which has no noise, scaled to the measured
    ``peak``.  NaN if the model does not reach its half between samples.
    """
    height = model / extreme(model)
    after, top = int(np.argmax(height >= ARRIVED)), int(np.argmax(height))
    if not (1 < after < len(height) - 1 and top < len(height) - 1):
        return np.nan
    step, rise = float(times[after] - times[after - 1]), float(height[after] - height[after - 1])
    bends = np.abs(np.diff(height, 2)) / rise
    curved = float(bends[after - 2 : after].max())
    missed = curved + ARRIVED * float(bends[top - 1])
    sampling = 1.0 / np.sqrt(12.0) if curved > ABRUPT else missed / 8.0
    noise = np.hypot(1.0, ARRIVED) * sigma / abs(peak) / rise
    return step * float(np.hypot(noise, sampling))
