"""Shots from the columns of a file: checked times and samples, with the noise of each signal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError
from ..representation import counted, measure
from .headers import positive_noise
from .noise import (
    ACCURACY,
    MIN_QUIET,
    at_limits,
    clipped_part,
    digitiser_step,
    given_noise,
    noise_before_rounding,
    noise_of,
    printed_step,
    robust_sigma,
    saturated,
)
from .places import Place
from .quiet_parts import COMMON_PART, quiet_counts
from .signals import Shot, Signal

# Samples before the pulse of which enough are clear of it.
MIN_BEFORE = math.ceil(MIN_QUIET / COMMON_PART)
# Larger samples are not of a sensor, and their squares would overflow.
MAX_SAMPLE: Final = 1e30
# Part of the samples of a pulse that may be saturated.
MAX_CLIPPED = 0.5


def make_shot(
    times: Array,
    columns: Mapping[tuple[Place, str], Array],
    noise: float | Mapping[str, float] | None,
) -> Shot:
    """A shot from its samples, with noise and saturation of each signal."""
    if not columns:
        raise InputError("there is no signal; add a column such as 'ball 6 [N]'")
    for (place, _), values in columns.items():
        _check_values(place, values, len(times))
    known = [_known_noise(noise, *key) for key in columns]
    quiet, (begin, sensor) = quiet_counts([*columns.values()], known)
    first = (begin, [place.name for place, _ in columns][sensor])
    pairs = zip(columns.items(), quiet, strict=True)
    return Shot(
        times, tuple(_signal(*key, values, (count, first), noise) for (key, values), count in pairs)
    )


def made_again(shot: Shot) -> Shot:
    """The shot with levels, and noises that were not given, estimated from its present samples.

    Samples that are not valid remain so: the limit of the range is no longer known.
    """
    columns = {(each.place, each.unit): each.values for each in shot.signals}
    given = {each.name: each.noise for each in shot.signals if not (each.quiet or each.noiseless)}
    made = make_shot(shot.times, columns, given).signals
    pairs = zip(made, shot.signals, strict=True)
    return replace(shot, signals=tuple(
        replace(new, valid=new.valid & old.valid, coupling=old.coupling, spikes=old.spikes)
        for new, old in pairs
    ))  # fmt: skip


def shot_between(shot: Shot, begin: float, until: float) -> Shot:
    """The samples of a shot from one time to another."""
    first = int(np.searchsorted(shot.times, begin, side="left"))
    end = int(np.searchsorted(shot.times, until, side="right"))
    part, count = slice(first, end), end - first
    if count < 2:
        ends = measure(float(shot.times[0]), "s"), measure(float(shot.times[-1]), "s")
        raise InputError(
            f"{counted(max(count, 0), 'sample')} would remain between begin and until; the times "
            f"of the data are from {ends[0]} to {ends[1]}"
        )
    found = replace(shot, times=shot.times[part], signals=tuple(
        replace(
            each, values=each.values[part], valid=each.valid[part],
            before=min(max(each.before - first, 0), count), quiet=min(each.quiet, count),
            spikes=tuple(i - first for i in each.spikes if first <= i < end),
        )
        for each in shot.signals
    ))  # fmt: skip
    # The noise was measured before the pulse, so that later samples do not change it.
    return made_again(found) if first else found


def check_times(times: Array, unit: str = "s", lines: Array | None = None) -> None:
    """Check that there are several times of samples, and that they increase.

    ``lines`` are the numbers of the lines from which the times were read.
    """
    if times.ndim != 1 or len(times) < 2:
        raise InputError(f"a trace needs at least 2 samples, got {times.size}")
    what, numbers = ("sample", np.arange(len(times)) + 1) if lines is None else ("line", lines)
    if not np.all(np.isfinite(times)):
        number = numbers[np.argmin(np.isfinite(times))]
        raise InputError(f"the time of {what} {number} is missing; each sample needs one")
    if np.all(np.diff(times) > 0.0):
        return
    row = int(np.argmax(np.diff(times) <= 0.0)) + 1
    if times[row] == times[row - 1]:
        raise InputError(
            f"times must increase, but {what}s {numbers[row - 1]} and {numbers[row]} are both at "
            f"{times[row]:.15g} {unit}; write the times with more digits, or give each shot its "
            "own file"
        )
    raise InputError(
        f"times must increase, but {what} {numbers[row]} is at {times[row]:.9g} {unit} and the one "
        f"before it at {times[row - 1]:.9g} {unit}; sort the rows, or give each shot its own file"
    )


def _check_values(place: Place, values: Array, count: int) -> None:
    if values.shape != (count,):
        raise InputError(f"there are {count} times, but {values.size} samples of {place.name}")
    seen = values[np.isfinite(values)]
    if not len(seen) or np.ptp(seen) == 0.0:
        raise InputError(
            f"{place.name} has no signal: all {len(seen)} samples are equal; remove the column"
        )
    if (largest := float(np.abs(seen).max())) > MAX_SAMPLE:
        raise InputError(
            f"{place.name} has a sample of size {largest:.3g}, but samples must be below "
            f"{MAX_SAMPLE:g}; check the unit and the format of the numbers, and leave the cells of "
            "missing samples empty"
        )


def _signal(
    place: Place,
    unit: str,
    values: Array,
    counts: tuple[int, tuple[int, str]],
    noise: float | Mapping[str, float] | None,
) -> Signal:
    quiet, first = counts
    beyond = np.isinf(values)
    values = at_limits(values)
    present = np.isfinite(values)
    beyond &= present
    step = max(digitiser_step(values[present]), printed_step(values[present]))
    valid = present & ~beyond
    flat = saturated(values[present]) | beyond[present]
    valid[present] = ~flat
    clipped, pulse = clipped_part(values[present], flat)
    if clipped > MAX_CLIPPED * pulse:
        raise InputError(
            f"{place.name} is saturated at {np.nanmax(np.abs(values)):.4g} {unit} during most of "
            f"its pulse ({clipped} of {pulse} samples); record with a larger range, or remove the "
            "column"
        )
    known = _known_noise(noise, place, unit)
    before = values[:quiet][valid[:quiet]]
    level, used, noiseless = float(before.mean()) if len(before) else np.nan, 0, False
    if known is None:
        used = len(before)
        known = _estimated_noise(place, before, step, first)
        least = ACCURACY * float(np.abs(values[present] - level).max())
        if known < least or (step <= least and robust_sigma(before) < least):
            # This noise is known, not estimated; only the first rise of the pulse may be larger.
            known, used, noiseless = least, 0, step <= least
    for each in (values, valid):
        each.setflags(write=False)
    return Signal(
        place, unit, values, valid, known, used, step, level, len(before), noiseless=noiseless
    )


def _known_noise(
    noise: float | Mapping[str, float] | None, place: Place, unit: str
) -> float | None:
    """Noise of a sensor that was given, in the unit of its signal."""
    known = given_noise(noise, place.name)
    return None if known is None else positive_noise(place.name, known, unit)


def _estimated_noise(place: Place, before: Array, step: float, first: tuple[int, str]) -> float:
    """Noise of the samples before the pulse, without rounding errors that are larger.

    ``first`` is the number of samples before the first pulse, and the sensor that it reaches.
    """
    if len(before) < MIN_QUIET:
        begin, sensor = first
        where = f" in the signal of {sensor}" if sensor != place.name else ""
        raise InputError(
            f"the noise of {place.name} cannot be estimated: a pulse, or slow noise, begins{where} "
            f"after {counted(begin, 'sample')}{_missing(before, begin)}; record at least "
            f"{MIN_BEFORE} samples before the pulse, or give noise"
        )
    found = noise_of(before)
    return found if found >= step else noise_before_rounding(before, step)


def _missing(before: Array, begin: int) -> str:
    """That samples are missing, if there would be enough of them without."""
    if begin < MIN_BEFORE:
        return ""
    return f", and only {len(before)} of those before its foot are valid"
