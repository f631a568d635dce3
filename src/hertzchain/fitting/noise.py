"""Noise, digitiser step and saturation of a signal, from its own samples."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..collision import Array

# Smallest number of samples from which a noise is estimated.
MIN_QUIET: Final = 20
# Number of samples at the beginning with which later ones are compared.
FIRST: Final = 7
# Number of successive samples that must differ from the first ones when a signal has begun.
IN_A_ROW: Final = 3
# Least difference: this fraction of the range and this multiple of the noise, or the last fraction
# of the range.
ONSET, ONSET_IN_NOISE, CERTAIN = 0.02, 5.0, 0.3
# Fraction of the time before the onset that is regarded as quiet, because lags and crosstalk begin
# earlier.
QUIET_PART: Final = 0.8
# Samples are saturated if at least this many successive samples have the same extreme value and the
# signal next to them falls by more than this many steps.
MIN_FLAT, FALL_IN_STEPS = 3, 2.5


def onset(values: Array) -> int:
    """Index of the first sample at which a signal has begun."""
    level, size = float(np.median(values[:FIRST])), float(np.ptp(values))
    # The median of the differences is determined by the noise even if there is a pulse.
    noise = float(np.median(np.abs(np.diff(values[: MIN_QUIET + 1])))) / (0.6745 * 2.0**0.5)
    threshold = min(max(ONSET * size, ONSET_IN_NOISE * noise), CERTAIN * size)
    begun = np.abs(values - level) > threshold
    lasting = np.convolve(begun, np.ones(IN_A_ROW), "valid") == IN_A_ROW
    return int(np.argmax(lasting)) if lasting.any() else len(values)


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
