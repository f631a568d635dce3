"""Samples of each sensor before its pulse, from which its noise and its level are estimated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..collision import Array
from .noise import MIN_QUIET, at_limits, base_level, independent_samples, noise_of, onset

# Fraction of the time before the first onset of all sensors that is quiet in each of them.
COMMON_PART: Final = 0.8
# The foot of a pulse begins before the onset by this multiple of the time from the onset to half
# of the peak.  The force of a solitary wave has fallen below 0.1% of its peak there.
FOOT: Final = 2.0
# Share of another signal that is not noise, in standard deviations.
PICKED_UP: Final = 3.0


def quiet_counts(columns: Sequence[Array]) -> tuple[list[int], int]:
    """Number of samples at the beginning of each signal that contain only noise.

    The last value is the number of samples before the pulse arrives at any sensor.

    A sensor is quiet until its own pulse begins, unless it picks up the pulses of other sensors.
    It is always quiet in the common part, before the pulse arrives at any of them.
    """
    signals = [
        np.where(np.isnan(values), np.nanmedian(values), values)
        for values in map(at_limits, columns)
    ]
    onsets = [onset(values) for values in signals]
    common = int(COMMON_PART * min(onsets))
    counts = []
    for values, begin in zip(signals, onsets, strict=True):
        end = begin - _foot(values, begin)
        others = [other for other, first in zip(signals, onsets, strict=True) if first < end]
        longer = end > common >= MIN_QUIET
        if longer and others and _picks_up(values[:end], others, common):
            longer = False
        counts.append(end if longer else common)
    return counts, min(onsets)


def _foot(values: Array, begin: int) -> int:
    """Number of samples before the onset of a pulse that may belong to it."""
    if begin == len(values):
        # A pulse that does not rise above the noise may be anywhere.
        return begin
    height = np.abs(values - base_level(values))
    half = begin + int(np.argmax(height[begin:] >= 0.5 * height.max()))
    return int(np.ceil(FOOT * (half - begin))) + 1


def _picks_up(values: Array, others: Sequence[Array], common: int) -> bool:
    """Whether a signal after the common part contains a share of another one."""
    quiet = values[:common]
    # Slow noise imitates a share of a smooth signal more often than white noise does.
    sigma = noise_of(quiet) * (common / independent_samples(quiet)) ** 0.5
    rest = values[common:]
    for other in others:
        shape = other[common : len(values)]
        shape = shape - shape.mean()
        if abs(float(rest @ shape)) > PICKED_UP * sigma * float(shape @ shape) ** 0.5:
            return True
    return False
