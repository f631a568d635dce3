"""Noise, digitiser step and saturation of a signal, from its own samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from ..collision import Array
from ..errors import unknown_name_error
from .places import by_usual_name, usual_name

# Smallest number of samples from which a noise is estimated.
MIN_QUIET: Final = 20
# Correlations above this many times their error are significant.
SIGNIFICANT: Final = 2.5
# Least number of independent samples of a quiet part.
MIN_INDEPENDENT: Final = 2.0
# Number of samples at the beginning with which later ones are compared.
FIRST: Final = 7
# Number of successive samples that must differ from the first ones when a signal has begun.
IN_A_ROW: Final = 3
# Least difference: this fraction of the range, and these multiples of the noise and of the step of
# rounded samples, or the last fraction of the range.
ONSET, ONSET_IN_NOISE, ONSET_IN_STEPS, CERTAIN_PART = 0.02, 5.0, 1.5, 0.3
# Least number of samples with the same extreme value that may be saturated, and the relative
# difference of samples that are regarded as equal.
MIN_FLAT, EQUAL = 3, 1e-7
# Depth of a crest as a fraction of its height, and at least this many steps of rounded samples.
CREST, STEPS_OF_CREST = 0.1, 6.0
# Rounded samples are saturated if there are this many times as many as at the top of a parabola,
# and as one step below.
WIDER, STEEPER = 1.5, 2.5
# Saturated samples are omitted with this many neighbours on each side, because noise decides which
# of these are saturated, too.
BESIDE: Final = 1
# Fraction of the height above which samples belong to a pulse.
PULSE: Final = 0.05
# Name of all sensors that have no noise of their own.
OTHERS: Final = "*"
# Accuracy of the simulated signals of a fit: rms error over the largest sample.  It is due to the
# interpolation in time next to contacts that close or open; a smaller noise cannot be seen.
ACCURACY: Final = 2e-5
# Significant digits of the largest samples of a file that are fewer than this accuracy requires,
# the least number of these samples, and the part of the largest from which they are counted.
FEW_DIGITS, MIN_LARGE, LARGE = range(2, 6), 8, 0.5
# Trial steps of a digitiser are the smallest gaps between different values and these quantiles of
# all; the step is then refined with gaps of up to the widest numbers of steps.  Values on the
# grid are nearer to it than a part of the step, which allows for printed digits; most are on it.
# Fewer values than a number of levels may be near a grid by chance, so that they must be nearer.
GAPS: Final = (0.1, 0.25, 0.5)
SMALLEST: Final = 4
WIDEST: Final = (4.5, 20.5, 100.5, np.inf)
NEAR, MOST = 0.25, 0.9
MIN_LEVELS, MAX_COUNTED, ROUNDED = 20, 3, 0.02
# Trial values, in steps, of a noise that is smaller than a step, and of the level within a step.
TRIAL_NOISES: Final = np.linspace(0.01, 1.2, 120)
TRIAL_LEVELS: Final = np.linspace(-0.5, 0.5, 100, endpoint=False)


def check_names_of_noise(noise: object, names: Sequence[str]) -> None:
    """Reject the noise of sensors that the traces do not have."""
    if isinstance(noise, Mapping):
        for name in noise:
            if usual_name(name) not in (*names, OTHERS):
                raise unknown_name_error("sensor of noise", str(name), names)


def given_noise(noise: Any, sensor: str) -> Any:
    """The noise that is given for a sensor, or for the others; None if there is none."""
    if not isinstance(noise, Mapping):
        return noise
    given = by_usual_name(noise)
    return given.get(sensor, given.get(OTHERS))


def onset(values: Array) -> int:
    """Index of the first sample at which a signal has begun.

    The threshold follows from differences of successive samples.  Slow noise may therefore exceed
    it for several samples; a signal also exceeds the noise before it.
    """
    level, size = base_level(values), float(np.ptp(values))
    # The median of the differences is determined by the noise even if there is a pulse.
    noise = robust_sigma(np.diff(values[: MIN_QUIET + 1]), 0.0) / 2.0**0.5
    # It is not if most samples are rounded to the same value and others to the next one.
    least = max(ONSET_IN_NOISE * noise, ONSET_IN_STEPS * digitiser_step(values))
    threshold = min(max(ONSET * size, least), CERTAIN_PART * size)
    for part in runs(np.abs(values - level) > threshold):
        if part.stop - part.start >= IN_A_ROW and not _is_slow_noise(values, part, size):
            return part.start
    return len(values)


def _is_slow_noise(values: Array, part: slice, size: float) -> bool:
    """Whether samples far from the first ones are not further away than slow noise may be."""
    before = values[: max(part.start, 2 * MIN_QUIET)]
    level = float(np.median(before))
    # The median is determined by the noise even if a pulse has begun.
    noise = robust_sigma(before, level)
    independent = independent_samples(before)
    noise *= (independent / (independent - 1.0)) ** 0.5 * (1.0 + (2.0 / independent) ** 0.5)
    height = float(np.abs(values[part] - level).max())
    return height < min(ONSET_IN_NOISE * noise, CERTAIN_PART * size)


def noise_of(quiet: Array) -> float:
    """Standard deviation of a quiet part, whose mean absorbs a part of slow noise."""
    independent = independent_samples(quiet)
    return float(np.std(quiet) * (independent / (independent - 1.0)) ** 0.5)


def robust_sigma(values: Array, centre: float | None = None) -> float:
    """Standard deviation of normal values from their median distance to their median, or a centre.

    A few values that are far from the others hardly change it.
    """
    middle = np.median(values) if centre is None else centre
    return float(np.median(np.abs(values - middle))) / 0.6745


def noise_before_rounding(quiet: Array, step: float) -> float:
    """Standard deviation of a quiet part without the errors of rounding to a large step.

    The standard deviation of rounded samples depends on the position of their mean within a step,
    which is unknown.  This is the maximum of their likelihood, averaged over all positions.
    """
    from scipy.special import logsumexp, ndtr

    levels, counts = np.unique(np.round((quiet - np.median(quiet)) / step), return_counts=True)
    if len(levels) == 1:
        return 0.0
    distance = (levels[:, None] - TRIAL_LEVELS)[:, None, :]
    ends = [ndtr((distance + side) / TRIAL_NOISES[:, None]) for side in (-0.5, 0.5)]
    chances = np.log(np.maximum(ends[1] - ends[0], np.finfo(float).tiny))
    part = independent_samples(quiet) / len(quiet)
    likelihood = logsumexp(np.tensordot(part * counts, chances, 1), axis=1)
    return step * float(TRIAL_NOISES[np.argmax(likelihood)])


def correlation_of_rounding(noise: float, step: float) -> float:
    """Correlation of the errors of two rounded samples with the same value before the noise.

    This is the mean over all positions within a step, from the Fourier series of the error (B.
    Widrow and I. Kollar, Quantization Noise, Cambridge, 2008).
    """
    orders = np.arange(1.0, 200.0)
    series = np.exp(-((2.0 * np.pi * orders * noise / step) ** 2)) / orders**2
    common = step**2 / (2.0 * np.pi**2) * float(series.sum())
    return common / (noise**2 + step**2 / 12.0)


def level_runs(values: Array) -> Array:
    """First samples of the runs of equal rounded samples.

    Runs are one if the samples return to the same value after another one, as noise makes them.
    """
    first = np.concatenate(([0], 1 + np.flatnonzero(np.diff(values))))
    begins = np.ones(len(first), bool)
    returns = values[first[2:]] == values[first[:-2]]
    begins[1:-1] &= ~returns
    begins[2:] &= ~returns
    return np.asarray(first[begins])


def counted_once(values: Array, part: float) -> Array:
    """Number of samples for which each sample of a run of equal ones stands.

    ``part`` of the variance of their errors is common to all of them.
    """
    lengths = np.diff(np.append(level_runs(values), len(values)))
    return np.repeat(1.0 + part * (lengths - 1.0), lengths)


def autocorrelation(values: Array) -> Array:
    """Autocorrelation of values from lag 0; only lag 0 if they are all equal."""
    centred = values - values.mean()
    if not (largest := float(np.abs(centred).max())):
        return np.ones(1)
    centred = centred / largest  # squares of numbers such as 1e-200 are zero
    size = float(centred @ centred)
    return np.asarray(np.correlate(centred, centred, "full")[len(values) - 1 :] / size)


def unbiased_first_lag(rho: float, count: int) -> float:
    """Autocorrelation of lag 1, corrected for the mean of first-order noise.

    The bias is that of M. G. Kendall, Biometrika 41, 403 (1954), doi:10.1093/biomet/41.3-4.403, for
    sums over n - 1 and n samples that are not divided by these numbers.
    """
    return rho + (1.0 + 4.0 * rho) / count


def independent_samples(quiet: Array) -> float:
    """Number of independent samples of a quiet part: the variance of one over that of the mean.

    This is the larger of two estimates, because each is too small for some noise: that of
    first-order noise if a filter makes the noise smooth, that from all lags if the noise drifts.
    """
    count = len(quiet)
    if count < MIN_QUIET or np.ptp(quiet) == 0.0:
        return max(float(count), MIN_INDEPENDENT)
    rho = autocorrelation(quiet)
    if rho[1] < SIGNIFICANT / count**0.5:
        return float(count)
    return max(_from_first_lag(float(rho[1]), count), _from_all_lags(rho), MIN_INDEPENDENT)


def _from_first_lag(rho: float, count: int) -> float:
    """Independent samples of first-order noise, n (1 - rho)/(1 + rho)."""
    rho = min(unbiased_first_lag(rho, count), 1.0)
    return count * (1.0 - rho) / (1.0 + rho)


def _from_all_lags(rho: Array) -> float:
    """Independent samples from the correlations up to the lag at which they vanish.

    Each covariance of centred samples is too small by the variance of the mean.  The relative
    variance of a sum over m lags of both signs is 2m/n (N. Madras and A. D. Sokal, J. Stat. Phys.
    50, 109 (1988), doi:10.1007/BF01022990); the logarithm of the sum is too small by half of it.
    """
    count, lags = len(rho), int(np.argmax(rho <= 0.0))
    both = 2.0 * lags - 1.0
    seen = count - both + lags * (lags - 1.0) / count
    mean = (2.0 * float(rho[:lags].sum()) - 1.0) / seen * (1.0 + both / count)
    return 1.0 + 1.0 / mean


def digitiser_step(values: Array) -> float:
    """Largest common spacing of the different values; 0 if they are not on a grid.

    Printed values are near the grid only, and single ones, such as interpolated samples, may be
    anywhere.
    """
    levels, counts = np.unique(values, return_counts=True)
    if len(levels) < 3 or len(values) < MIN_QUIET or len(levels) >= 0.9 * len(values):
        return 0.0
    # Values that are equal except for rounding in binary are one.
    first = np.flatnonzero(np.diff(levels, prepend=-np.inf) > EQUAL * np.abs(levels).max())
    levels, weights = levels[first], np.minimum(np.add.reduceat(counts, first), MAX_COUNTED)
    if len(levels) < 3:
        return 0.0
    gaps = np.sort(np.diff(levels))
    trials = np.unique([*gaps[:SMALLEST], *np.quantile(gaps, GAPS, method="lower")])
    return max(_spacing(levels, weights, each) for each in trials.tolist())


def _spacing(levels: Array, weights: Array, trial: float) -> float:
    """Spacing of the grid on which levels are, from an estimate; 0 if they are not on one."""
    gaps = np.diff(levels)
    step = float(gaps[np.abs(gaps - trial) < NEAR * trial].mean())
    for most in WIDEST:  # a wide gap has a whole number of steps only if the step is accurate
        some = gaps[gaps < most * step]
        step = float(some.sum() / max(np.round(some / step).sum(), 1.0))
    phase = np.exp(2j * np.pi * (levels - levels[0]) / step)
    distance = np.abs(np.angle(phase * np.conj(weights @ phase))) / (2.0 * np.pi)
    few = weights.sum() < MIN_LEVELS
    near = np.average(distance < (ROUNDED if few else NEAR), weights=weights)
    return step if near > (1.0 - 1e-9 if few else MOST) else 0.0


def printed_step(values: Array) -> float:
    """Step of the largest samples if they have few significant digits; 0 otherwise.

    Samples that are printed with a number of significant digits are not on one grid.
    """
    size = np.abs(values)
    large = size[size > LARGE * size.max()]
    if len(large) < MIN_LARGE:
        return 0.0
    power = np.floor(np.log10(size.max()))
    for digits in FEW_DIGITS:
        step = float(10.0 ** (power + 1.0 - digits))
        if np.all(np.abs(large / step - np.round(large / step)) < 1e-6):
            return step
    return 0.0


def base_level(values: Array) -> float:
    """Level of a signal before it begins."""
    return float(np.median(values[:FIRST]))


def at_limits(values: Array) -> Array:
    """Samples in which infinite ones, which are beyond the range, are at its limits.

    A single one among low samples is a spike, which counts as missing.
    """
    seen = values[np.isfinite(values)]
    level = base_level(seen)
    low = np.abs(values - level) < CERTAIN_PART * np.abs(seen - level).max()
    limited = np.where(values == np.inf, seen.max(), values)
    limited = np.where(values == -np.inf, seen.min(), limited)
    spikes = np.isinf(values[1:-1]) & low[:-2] & low[2:]
    limited[1:-1][spikes] = np.nan
    return np.asarray(limited)


def saturated(values: Array) -> Array:
    """Mask of samples at a flat top or bottom where the signal would have a crest.

    The noise of a real crest makes its samples different.  If they are rounded, a crest has several
    samples with the largest value, but few more than a parabola would have.
    """
    mask = np.zeros(len(values), bool)
    if len(values) < MIN_FLAT or np.ptp(values) == 0.0:
        return mask
    level = base_level(values)
    for sign in (1.0, -1.0):
        height = sign * (values - level)
        if height.max() > CERTAIN_PART * np.abs(values - level).max():
            mask |= _flat_top(height)
    return mask


def _flat_top(height: Array) -> Array:
    """Mask of the samples at a flat top, and between and next to them."""
    top = float(height.max())
    flat = height >= top * (1.0 - EQUAL)
    mask = np.zeros(len(height), bool)
    below = np.unique(height[(height > CERTAIN_PART * top) & ~flat])
    step = float(np.diff(np.append(below, top)).min()) if len(below) else 0.0
    if not step and flat.sum() < MIN_FLAT * len(runs(flat)):
        return mask  # single samples one step above the level are noise
    depth = max(CREST * top, STEPS_OF_CREST * step)
    crests = [part for part in runs(height > top - depth) if flat[part].any()]
    if not _is_clipped(np.concatenate([height[part] for part in crests]), top, step, depth):
        return mask
    for part in crests:
        inside = part.start + np.flatnonzero(flat[part])
        mask[max(int(inside[0]) - BESIDE, 0) : int(inside[-1]) + BESIDE + 1] = True
    return mask


def _is_clipped(crest: Array, top: float, step: float, depth: float) -> bool:
    """Whether more samples of crests have the largest value than rounding explains."""
    flat = crest >= top * (1.0 - EQUAL)
    count, others = int(flat.sum()), crest[~flat]
    if count < MIN_FLAT:
        return False
    # A parabola is within one step of its top for this part of its width at the depth.
    parabola = len(crest) * (step / depth) ** 0.5
    next_to_top = int(np.sum(others > top - 1.5 * step))
    return count > max(WIDER * parabola + 1.0, STEEPER * next_to_top)


def runs(mask: Array) -> list[slice]:
    """Successive samples of a mask."""
    edges = np.diff(np.concatenate(([0], mask.astype(int), [0])))
    pairs = zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True)
    return [slice(int(begin), int(end)) for begin, end in pairs]


def clipped_part(values: Array, mask: Array) -> tuple[int, int]:
    """Number of saturated samples, and of all samples of the pulses that they belong to."""
    height = np.abs(values - base_level(values))
    pulses = [part for part in runs(height > PULSE * height.max()) if mask[part].any()]
    clipped = sum(int(mask[part].sum()) for part in pulses)
    return clipped, sum(part.stop - part.start for part in pulses)
