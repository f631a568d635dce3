"""Samples of each sensor before its pulse, from which its noise and its level are estimated."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from ..collision import Array
from .noise import (
    MIN_QUIET,
    at_limits,
    base_level,
    digitiser_step,
    independent_samples,
    noise_of,
    onset,
    runs,
)

# Fraction of the time before the first onset of all sensors that is quiet in each of them.
COMMON_PART: Final = 0.8
# The foot of a pulse begins before the onset by this multiple of the time from the onset to half
# of the peak.  The force of a solitary wave has fallen below 0.1% of its peak there.
FOOT: Final = 2.0
# A signal is only noise if no mean of successive samples is further from the level, in its
# standard deviations, than the largest of as many normal values by this much.  The deviation of
# one sample is that of the quietest part of this number of parts, which is too small by this many
# of its errors, and at least this fraction of a step of rounded samples.
BEYOND_NOISE, PARTS, TOO_SMALL, OF_A_STEP = 1.0, 4, 1.0, 0.5
# Share of another signal that is not noise, in standard deviations.
PICKED_UP: Final = 3.0
# A pulse with fewer successive samples above this part of its largest value is coarsely sampled.
# It begins with the first sample beyond these multiples of a known noise and of a rounding step.
FEW_SAMPLES, PART, IN_NOISE, IN_STEPS = 3, 0.5, 5.0, 1.5


def quiet_counts(
    columns: Sequence[Array], noises: Sequence[float | None] | None = None
) -> tuple[list[int], tuple[int, int]]:
    """Number of samples at the beginning of each signal that contain only noise.

    The last values are the number of samples before the pulse arrives at any sensor, and the index
    of this sensor.

    A sensor is quiet until its own pulse begins, unless it picks up the pulses of other sensors.
    It is always quiet in the common part, before the pulse arrives at any of them.  Sensors with
    only noise, which the pulse has not reached, do not shorten the common part.  ``noises`` are
    those that are known, without which a pulse of a single sample cannot be recognised.
    """
    signals = [
        np.where(np.isnan(values), np.nanmedian(values), values)
        for values in map(at_limits, columns)
    ]
    known = noises or [None] * len(signals)
    onsets = [
        len(values) if only_noise(values) else _coarse_onset(values, onset(values), noise)
        for values, noise in zip(signals, known, strict=True)
    ]
    common = int(COMMON_PART * min(onsets))
    counts = []
    for values, begin in zip(signals, onsets, strict=True):
        end = begin - _foot(values, begin)
        others = [other for other, first in zip(signals, onsets, strict=True) if first < end]
        longer = end > common >= MIN_QUIET
        if longer and others and _picks_up(values[:end], others, common):
            longer = False
        counts.append(end if longer else common)
    return counts, (min(onsets), int(np.argmin(onsets)))


def _coarse_onset(values: Array, begin: int, noise: float | None) -> int:
    """Onset of a signal, which is earlier if its pulses have few samples and its noise is known."""
    if noise is None:
        return begin
    height = np.abs(values - base_level(values))
    parts = runs(height > PART * height.max())
    if any(part.stop - part.start >= FEW_SAMPLES for part in parts):
        return begin
    least = max(IN_NOISE * noise, IN_STEPS * digitiser_step(values))
    return min(begin, int(np.argmax(height > min(least, PART * height.max()))))


def only_noise(values: Array) -> bool:
    """Whether a signal is white noise from its first sample to its last, without any pulse.

    Means of 1, 2, 4, ... samples are compared, so that a weak pulse of any length is found.
    """
    if len(values) < PARTS * MIN_QUIET:
        return False
    parts = np.array_split(np.diff(values), PARTS)
    sigma = min(float(np.mean(part**2)) for part in parts) ** 0.5 / 2.0**0.5
    sigma *= 1.0 + TOO_SMALL / len(parts[-1]) ** 0.5
    levels = np.unique(values)
    step = float(np.ptp(levels)) if len(levels) == 2 else digitiser_step(values)
    sigma = max(sigma, OF_A_STEP * step)
    limit = (2.0 * math.log(len(values))) ** 0.5 + BEYOND_NOISE
    sums = np.cumsum(np.append(0.0, values - np.mean(values)))
    widths = [2**power for power in range(int(math.log2(len(values))))]
    return all(
        float(np.abs(sums[width:] - sums[:-width]).max()) <= limit * sigma * width**0.5
        for width in widths
    )


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
