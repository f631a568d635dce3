"""Level, largest value and sign of a signal."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..collision import Array
from .noise import independent_samples
from .signals import Signal

# A signal has arrived at this fraction of its largest value, where its width is measured, too.
ARRIVED: Final = 0.5
# Arrivals that differ by less than this number of samples have no order.
SAME_TIME: Final = 3
# Levels, and static forces in them, are seen beyond this number of standard errors.
CERTAIN: Final = 5.0


def level_of(signal: Signal) -> float:
    """Level of a signal before the pulse; 0 if it is not known."""
    return signal.level if np.isfinite(signal.level) else 0.0


def error_of_level(signal: Signal) -> float:
    """Standard error of the level before the pulse.

    The mean of rounded samples has an additional error of up to the first term of the Fourier
    series in B. Widrow and I. Kollar, Quantization Noise, Cambridge, 2008.
    """
    error = float(signal.sigma / independent_samples(signal.quiet_values) ** 0.5)
    if signal.step == 0.0:
        return error
    smoothing = math.exp(-2.0 * (math.pi * signal.noise / signal.step) ** 2)
    return math.hypot(error, signal.step / math.pi * smoothing)


def level_of_model(signal: Signal, model: Array) -> float:
    """Mean of a simulated signal at the samples before the pulse, with the foot of the pulse.

    It is NaN without such samples.
    """
    quiet = (signal.valid & np.isfinite(model))[: signal.before]
    return float(model[: signal.before][quiet].mean()) if quiet.any() else math.nan


def level_differs(signal: Signal, expected: float, at_rest: float, allowed: float) -> bool:
    """Whether the level before the pulse is neither that of a model nor that of the model at rest.

    A signal at the level of the model at rest has the right zero: the pulse of the model is early.
    """
    return all(abs(signal.level - each) > allowed for each in (expected, at_rest))


def from_level(signal: Signal) -> Array:
    """Samples from the level before the pulse; 0 where they are missing."""
    return np.where(np.isfinite(signal.values), signal.values - level_of(signal), 0.0)


def polarity_of(signal: Signal) -> float:
    """-1 for a force whose largest value is negative, which contacts cannot exert; otherwise 1."""
    return -1.0 if signal.place.quantity == "force" and extreme(from_level(signal)) < 0.0 else 1.0


def first_sign(values: Array) -> float:
    """Sign of the first value beyond half of the largest; waves that return may have another."""
    size = np.abs(values)
    return math.copysign(1.0, values[np.argmax(size > ARRIVED * size.max())])


def ratio_of_amplitudes(seen: Array, own: Array) -> float:
    """Ratio of the largest values of two signals, with that of their first signs."""
    return first_sign(seen) * first_sign(own) * abs(extreme(seen) / extreme(own))


def extreme(values: Array) -> float:
    """The value that is largest without its sign."""
    return float(values[np.argmax(np.abs(values))])
