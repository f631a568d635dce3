"""Noise, digitiser step and saturation of a signal, from its own samples."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..collision import Array

# Fewest samples from which a noise is estimated.
MIN_QUIET: Final = 20
# A signal has begun when it exceeds this part of its range, or this multiple of its noise.
ONSET, ONSET_IN_NOISE = 0.02, 6.0
# Part of the time before the onset that is regarded as quiet: lags and crosstalk begin earlier.
QUIET_PART: Final = 0.8
# Equal extreme samples in a row, next to which the signal falls by more than this many steps, are
# saturated.
MIN_FLAT, FALL_IN_STEPS = 3, 2.5


def onset(values: Array) -> int:
    """Index of the first sample at which a signal has begun."""
    head = values[:MIN_QUIET]
    level, spread = float(np.median(head)), float(np.std(head))
    threshold = max(ONSET * float(np.ptp(values)), ONSET_IN_NOISE * spread)
    begun = np.abs(values - level) > threshold
    return int(np.argmax(begun)) if begun.any() else len(values)


def noise_of(quiet: Array) -> float:
    """Standard deviation of a quiet part about its mean."""
    return float(np.std(quiet, ddof=1))


def digitiser_step(values: Array) -> float:
    """Smallest distance between different values; 0 if they are not on a grid."""
    levels = np.unique(values)
    if len(levels) < 3:
        return 0.0
    gaps = np.diff(levels)
    step = float(gaps.min())
    on_grid = np.abs(gaps / step - np.round(gaps / step)) < 0.01 * np.maximum(gaps / step, 1.0)
    repeated = len(levels) < 0.9 * len(values)
    return step if step > 0.0 and repeated and bool(on_grid.all()) else 0.0


def saturated(values: Array, step: float) -> Array:
    """Mask of samples at a flat top or bottom that the signal reaches with a steep slope."""
    mask = np.zeros(len(values), bool)
    if not len(values) or np.ptp(values) == 0.0:
        return mask
    usual = max(step, 0.002 * float(np.ptp(values)))
    for extreme in (values.max(), values.min()):
        edges = np.diff(np.concatenate(([0], (values == extreme).astype(int), [0])))
        for begin, end in zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True):
            beside = [values[i] for i in (begin - 1, end) if 0 <= i < len(values)]
            fall = max((abs(extreme - each) for each in beside), default=0.0)
            if end - begin >= MIN_FLAT and fall > FALL_IN_STEPS * usual:
                mask[begin:end] = True
    return mask
