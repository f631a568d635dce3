"""Single samples far from their neighbours, which are not part of a pulse."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from ..collision import Array
from .noise import robust_sigma
from .notes import FAR_IN_NOISE
from .shots import made_again
from .signals import Shot, Signal

# A spike differs from both neighbours by more than this multiple of their own differences from the
# samples next to them, and by more than `FAR_IN_NOISE`.
IN_SLOPES: Final = 4.0
# Least half width of the simulated pulse in samples: a shorter one may look like a spike.
MIN_WIDTH: Final = 4.0
# Number of spikes of a sensor that are named; more of them are not single errors.
MAX_NAMED: Final = 5


def spikes(signal: Signal) -> Array:
    """Indices of the samples that are spikes."""
    values = signal.values
    steps = np.diff(values)
    before, after = steps[1:-2], -steps[2:-1]
    # The differences of the two samples on each side show how steep the signal is.
    slopes = np.maximum(np.abs(steps[:-3]), np.abs(steps[3:]))
    least = np.maximum(FAR_IN_NOISE * _noise_without_spikes(signal), IN_SLOPES * slopes)
    alone = (before * after > 0.0) & (np.minimum(np.abs(before), np.abs(after)) > least)
    return np.flatnonzero(alone) + 2


def _noise_without_spikes(signal: Signal) -> float:
    """Noise of a signal, from the median if spikes before the pulse would contribute."""
    quiet = signal.quiet_values
    if not signal.quiet or not len(quiet):
        return signal.sigma
    return min(max(robust_sigma(quiet), signal.step), signal.sigma)


def without_spikes(shot: Shot, widths: Sequence[float]) -> Shot:
    """The shot with spikes as missing samples, which its signals name.

    ``widths`` are the half widths of the simulated pulses, in seconds.
    """
    step = float(np.median(np.diff(shot.times)))
    found = [
        spikes(signal) if width > MIN_WIDTH * step else np.zeros(0, int)
        for signal, width in zip(shot.signals, widths, strict=True)
    ]
    few = [0 < len(places) <= MAX_NAMED for places in found]
    if not any(few):
        return shot
    signals = tuple(
        _without(signal, places) if named else signal
        for signal, places, named in zip(shot.signals, found, few, strict=True)
    )
    # Levels and estimated noises change, too.
    return made_again(replace(shot, signals=signals))


def _without(signal: Signal, places: Array) -> Signal:
    """The signal in which the samples at these indices are missing."""
    values = signal.values.copy()
    values[places] = np.nan
    named = tuple(sorted({*signal.spikes, *places.tolist()}))
    return replace(signal, values=values, spikes=named)
