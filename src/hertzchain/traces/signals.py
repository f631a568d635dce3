"""Signals of sensors in one shot of an experiment."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError
from ..frozen import Frozen
from ..representation import short
from .noise import correlation_of_rounding, counted_once
from .places import Place

# Errors of rounding are hardly correlated if the step is smaller than this multiple of the noise.
COARSE: Final = 3.0
# Reason of a time offset that a user gives.
GIVEN: Final = "given"
# Largest difference of times that are the same, as a part of the least step.
SAME_TIMES: Final = 0.01


@dataclass(frozen=True, eq=False)
class Signal(Frozen):
    """The samples of one sensor in one shot.

    Attributes
    ----------
    place : Place
        Position of the sensor, and its quantity.
    unit : str
        ``"N"``, ``"m/s"`` or, without a calibration, ``"V"``.
    values : ndarray, shape (n,)
        Samples, in this unit; NaN where one is missing.  Samples beyond the range of the digitiser
        have the largest or smallest of the other values.
    valid : ndarray of bool, shape (n,)
        Samples that a fit uses: neither missing nor saturated.
    noise : float
        Standard deviation of the noise, in the same unit; if it is smaller than the step of the
        digitiser, without the errors of rounding.
    quiet : int
        Number of samples from which the noise was estimated; 0 if it was given.
    step : float
        Step of the digitiser; 0 if the samples are not on a grid.
    level : float
        Mean of the samples before the pulse, in the same unit; NaN without such samples.
    before : int
        Number of these samples.
    coupling : str
        ``"DC"`` if the signal contains the static force, ``"AC"`` if it does not, or empty if this
        is decided by the level, once a chain has a static force.
    noiseless : bool
        Whether the samples before the pulse have less noise than the simulated signals of a fit
        have errors, so that ``noise`` is the accuracy of these.
    spikes : tuple of int
        Indices of samples that are missing because they were far from both neighbours.
    """

    place: Place
    unit: str
    values: Array = field(repr=False)
    valid: Array = field(repr=False)
    noise: float
    quiet: int
    step: float
    level: float = np.nan
    before: int = 0
    coupling: str = ""
    noiseless: bool = False
    spikes: tuple[int, ...] = ()

    @property
    def name(self) -> str:
        """Name of the place."""
        return self.place.name

    @property
    def sigma(self) -> float:
        """Standard deviation of a sample: its noise and, if this is smaller than a step, rounding.

        The noise before the pulse contains the errors of rounding to smaller steps.
        """
        rounded = self.step > self.noise
        return float(np.hypot(self.noise, self.step / 12.0**0.5)) if rounded else self.noise

    @property
    def coarse(self) -> bool:
        """Whether the errors of rounding are correlated, because the noise is small."""
        return self.step > COARSE * self.noise

    @property
    def counted(self) -> Array:
        """Number of samples for which each valid sample stands: 1 if it is not coarse."""
        values = self.values[self.valid]
        if not self.coarse:
            return np.ones(len(values))
        return counted_once(values, correlation_of_rounding(self.noise, self.step))

    @property
    def quiet_values(self) -> Array:
        """Valid samples before the pulse."""
        return self.values[: self.before][self.valid[: self.before]]

    @property
    def calibrated(self) -> bool:
        """Whether the signal is in the unit of its quantity."""
        return self.unit != "V"


@dataclass(frozen=True)
class Clock:
    """A known time offset of a shot.

    Attributes
    ----------
    time_offset : float
        Time of the data at which the simulation begins [s].
    reason : str
        Why it is known, in words.
    """

    time_offset: float
    reason: str = GIVEN


@dataclass(frozen=True, eq=False)
class Shot(Frozen):
    """Signals that were recorded together.

    Attributes
    ----------
    times : ndarray, shape (n,)
        Increasing times [s].
    signals : tuple of Signal
        Signals, in the order of the columns.
    clock : Clock or None
        Its time offset, if this is known.
    files : tuple of str
        Files from which the signals were read.
    """

    times: Array = field(repr=False)
    signals: tuple[Signal, ...]
    clock: Clock | None = None
    files: tuple[str, ...] = field(default=(), compare=False)

    @property
    def time_offset(self) -> float:
        """Time of the data at which the simulation begins [s]; 0 if it is not known."""
        return 0.0 if self.clock is None else self.clock.time_offset

    def with_scaled_times(self, factor: float) -> Shot:
        """The shot with all its times multiplied by a factor."""
        clock = self.clock and replace(self.clock, time_offset=factor * self.time_offset)
        return replace(self, times=factor * self.times, clock=clock)

    def __repr__(self) -> str:
        every = f"every {1e6 * float(np.median(np.diff(self.times))):.3g} us"
        names = ", ".join(f"{each.name} [{each.unit}]" for each in self.signals)
        return short("Shot", names, f"{len(self.times)} samples, {every}")


def merged_shots(first: Shot, second: Shot, what: str = "shots") -> Shot:
    """A shot with the signals of two shots or channels that were recorded together."""
    if len(first.times) != len(second.times):
        raise InputError(
            f"{what} have {len(first.times)} and {len(second.times)} samples; to be merged, both "
            "must have the same times"
        )
    apart = float(np.abs(first.times - second.times).max())
    if apart > SAME_TIMES * float(np.diff(first.times).min()):
        raise InputError(
            f"times of {what} differ by up to {apart:.3g} s; to be merged, both must have the same "
            "times"
        )
    names = [each.name for each in first.signals]
    for each in second.signals:
        if each.name in names:
            raise InputError(f"{each.name} is in both traces to merge; leave it out of one")
    files = (*first.files, *(each for each in second.files if each not in first.files))
    return replace(first, signals=first.signals + second.signals, files=files)
