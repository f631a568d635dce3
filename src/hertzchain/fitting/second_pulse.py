"""A second, later copy of all pulses in the data, such as that of a second blow of a hammer."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import SimulationError
from ..representation import measure
from ..traces.signals import Shot
from ..traces.traces import Traces
from .causes import Cause, Refit
from .crossings import half_width
from .problem import Problem
from .result import FitResult

# Part of the squared residuals that a copy of the fitted signals must explain.
EXPLAINED: Final = 0.5
# The copy is later by at least this number of half widths of the longest pulse, and this part of
# its squares is in the record.
APART, RECORDED = 2.0, 0.3
# Sizes of a second pulse relative to the first.
SIZES: Final = (0.05, 1.5)
# A pulse begins at this part of its peak.
ONSET: Final = 0.02


@dataclass(frozen=True)
class SecondPulse:
    """The sensor that it reaches first, its time there, its relative size, and data without it."""

    sensor: str
    time: float
    size: float
    traces: Traces

    @property
    def advice(self) -> str:
        """Sentence on the pulse, and the advice to end the record before it."""
        return (
            f"there is a second pulse at t = {measure(self.time, 's')} in {self.sensor}, about "
            f"{self.size:.0%} of the first, which the model does not have: end the record before "
            "it, and check for a second blow of the hammer or striker, or for a gap between balls"
        )


def without_second_pulse(
    result: FitResult, start: Mapping[str, float], refit: Refit
) -> Iterator[Cause]:
    """The fit to the samples before a second pulse, if the residuals show one."""
    found = second_pulse(result)
    if found is None:
        return
    try:
        other = refit(Problem(replace(result.model, traces=found.traces)), start, 1)
    except SimulationError:
        return
    what = "the samples of each sensor before a second pulse"
    yield Cause(what, found.advice, other, 0, misread=True)


def second_pulse(result: FitResult) -> SecondPulse | None:
    """The second pulse of the first shot that has one; None if a copy explains too little."""
    shots = list(result.traces.shots)
    for index, shot in enumerate(shots):
        rests = result.at_rest[index]
        own = [signal - rest for signal, rest in zip(result.predicted[index], rests, strict=True)]
        found = _copy(shot, own, rests)
        if found is None:
            continue
        delay, size = found
        onsets = [_onset(shot.times, f) for f in own]
        first = int(np.argmin(onsets))
        shots[index] = replace(shot, signals=tuple(
            replace(signal, valid=signal.valid & (shot.times < onset + delay))
            for signal, onset in zip(shot.signals, onsets, strict=True)
        ))  # fmt: skip
        time = onsets[first] + delay
        return SecondPulse(shot.signals[first].name, time, size, Traces(tuple(shots)))
    return None


def _onset(times: Array, signal: Array) -> float:
    """Time at which a signal begins; infinite if it vanishes."""
    if not signal.any():
        return math.inf
    return float(times[np.argmax(np.abs(signal) > ONSET * np.abs(signal).max())])


def _copy(shot: Shot, own: list[Array], rests: list[float]) -> tuple[float, float] | None:
    """Delay and relative size of the copy that explains most of the residuals of a shot."""
    from scipy.signal import correlate

    count = len(shot.times)
    step = float(shot.times[-1] - shot.times[0]) / (count - 1)
    least = APART * max((half_width(shot.times, f) for f in own if f.any()), default=math.inf)
    product, size, total = np.zeros(count), np.zeros(count), 0.0
    for signal, f, rest in zip(shot.signals, own, rests, strict=True):
        left = np.where(signal.valid, signal.values - rest - f, 0.0) / signal.sigma
        shape = f / signal.sigma
        product += correlate(left, shape)[count - 1 :]
        # Squares of the part of the delayed shape that is in the record.
        size += np.cumsum(shape**2)[::-1]
        total += float(left @ left)
    late = (step * np.arange(count) > least) & (size > RECORDED * size[0])
    if not late.any() or total == 0.0:
        return None
    gained = np.where(late, np.maximum(product, 0.0) ** 2 / np.maximum(size, 1e-300), 0.0)
    best = int(np.argmax(gained))
    ratio = float(product[best] / size[best])
    if gained[best] < EXPLAINED * total or not SIZES[0] < ratio < SIZES[1]:
        return None
    return step * best, ratio
