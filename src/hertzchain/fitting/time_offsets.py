"""Time offset of a run in traces by least squares over the samples that the run covers.

The pulse may be incomplete at the end of the record, and the run may end before it.  A correlation
that is not normalised would then prefer offsets at which more of the signals overlap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from ..collision import Array
from ..traces.amplitudes import extreme, level_of, polarity_of
from ..traces.signals import Shot, Signal
from .autocorrelation import correlation_length
from .crossings import half_width
from .misread_columns import prefix_of
from .sensor_comparison import ABOVE_NOISE, scaled

if TYPE_CHECKING:
    from collections.abc import Callable

# The amplitude of each sensor is free up to this factor, because the chain and its velocity are not
# known exactly.  A sensor without calibration may have seen only the beginning of a pulse.
FREE, CUT = 3.0, 10.0
# Part of the simulated peak of at least one sensor that the record must contain.
REACHED: Final = 0.1
# Part of the simulated energy below which the record contains no signal.
NOTHING: Final = 1e-12
# Offsets of the finer search, on each side, and their range as a part of the width of a pulse.
STEPS, RANGE = 16, 0.25
MAX_ROUNDS: Final = 8
# Offsets compare different pulses if they are further apart than this multiple of the width, and
# agree almost as well as the best one if the rms differences are larger by less than this factor.
APART, SIMILAR = 2.0, 1.15
# Least error of an offset, as a part of the step between samples.
MIN_ERROR: Final = 1e-3


@dataclass(frozen=True, eq=False)
class Pair:
    """Deviations of a measured and a simulated signal from their first levels.

    Attributes
    ----------
    times, seen : ndarray
        Valid samples, multiplied by -1 if the sensor is inverted.
    own : ndarray
        Simulated signal from the start of the run, evenly spaced.
    scales : tuple of float
        Smallest and largest factor of the simulated signal.
    signed : bool
        Whether the factor may be negative, too.
    """

    times: Array
    seen: Array
    own: Array
    scales: tuple[float, float]
    signed: bool

    @property
    def energy(self) -> float:
        """Sum of the squares of all samples."""
        return float(self.seen @ self.seen)

    @property
    def width(self) -> float:
        """Number of saved times at which the simulated signal exceeds half of its peak."""
        return half_width(np.arange(float(len(self.own))), self.own)

    def rest(self, inside: Array, product: Array, size: Array) -> Array:
        """Sums of squared differences, from those of the samples, products and simulated values."""
        nothing = NOTHING * float(self.own @ self.own)
        best = np.where(size > nothing, product, 0.0) / np.maximum(size, nothing)
        scale = np.clip(np.abs(best) if self.signed else best, *self.scales)
        if self.signed:
            scale = np.copysign(scale, best)
        return np.asarray(inside - 2.0 * scale * product + scale**2 * size)


def best_offset(
    shot: Shot, columns: Sequence[Array], spacing: float
) -> tuple[float, tuple[float, float] | None]:
    """Time of the data at which the simulated signals begin, by least squares.

    The amplitude of each signal is free within a factor.  If another offset, which compares other
    pulses, agrees almost as well, it is also returned, with the ratio of the rms differences.
    """
    pairs = _pairs(shot, columns)
    found, other, _ = _coarse(pairs, shot.times, spacing)
    reach = max(RANGE * min(pair.width for pair in pairs), 2.0) * spacing
    return _refined(pairs, found, reach, spacing), other


def coarse_offset(shot: Shot, columns: Sequence[Array], spacing: float) -> tuple[float, float]:
    """Rms difference over the rms of the data, and the best offset, a multiple of the spacing."""
    pairs = _pairs(shot, columns)
    if not pairs:
        return 1.0, 0.0
    offset, _, cost = _coarse(pairs, shot.times, spacing)
    return (cost / len(pairs)) ** 0.5, offset


def difference_at_best_offset(shot: Shot, columns: Sequence[Array], spacing: float) -> float:
    """Rms difference over the rms of the data, at the best offset that is a multiple of spacing."""
    return coarse_offset(shot, columns, spacing)[0]


def explained_by_offset(
    shot: Shot, columns: Sequence[Array], spacing: float, offset: float
) -> float:
    """Reduction of the squares of the data over their noise, of independent samples."""
    total = 0.0
    for signal, column in zip(shot.signals, columns, strict=True):
        pair = _pair(shot, signal, column)
        grid = offset + spacing * np.arange(len(pair.own))
        own = np.interp(pair.times, grid, pair.own, left=0.0, right=0.0)
        size = float(own @ own)
        if size > 0.0:
            rest = pair.seen - own * float(pair.seen @ own) / size
            noise = signal.sigma**2 * correlation_length(rest)
            total += float(pair.seen @ own) ** 2 / size / noise
    return total


def _pairs(shot: Shot, columns: Sequence[Array]) -> list[Pair]:
    pairs = [
        _pair(shot, signal, column) for signal, column in zip(shot.signals, columns, strict=True)
    ]
    return [pair for pair in pairs if pair.own.any() and pair.energy > 0.0]


def offset_error(shot: Shot, signals: Sequence[Array]) -> float:
    """Standard error of the best offset, if the differences from the model were noise [s].

    Correlated differences count less.  No offset is accurate to much less than a sample.
    """
    information = 0.0
    for signal, model in zip(shot.signals, signals, strict=True):
        ok = signal.valid & np.isfinite(model)
        own = scaled(signal, model)
        rest = (signal.values - level_of(signal) - own + own[ok][0])[ok]
        slope = np.gradient(own, shot.times)[ok]
        slope = slope[np.isfinite(slope)]
        noise = max(float(np.mean(rest**2)) * correlation_length(rest), np.finfo(float).tiny)
        information += float(slope @ slope) / noise
    least = MIN_ERROR * float(np.median(np.diff(shot.times)))
    return max(information**-0.5, least) if information > 0.0 else least


def _pair(shot: Shot, signal: Signal, column: Array) -> Pair:
    own = column - column[0]
    known = np.isfinite(signal.level) or not signal.calibrated
    level = level_of(signal) if known else float(column[0])
    seen = polarity_of(signal) * (signal.values[signal.valid] - level)
    ratio = abs(extreme(seen)) / max(abs(extreme(own)), np.finfo(float).tiny)
    if signal.calibrated:
        # A peak of another size may be in a wrong unit, or incomplete.
        wrong = prefix_of(ratio)
        ends = (wrong, wrong) if wrong else (min(1.0, ratio), max(1.0, ratio))
        if abs(extreme(seen)) < ABOVE_NOISE * signal.sigma:
            ends = 1.0, 1.0
        scales = ends[0] / FREE, ends[1] * FREE
    else:
        scales = ratio / FREE, ratio * CUT
    signed = signal.place.quantity == "velocity" and not signal.calibrated
    return Pair(shot.times[signal.valid], seen, own, scales, signed)


def _coarse(
    pairs: Sequence[Pair], times: Array, spacing: float
) -> tuple[float, tuple[float, float] | None, float]:
    """The best offset that is a multiple of the spacing, and the best far from it if it is similar.

    The last value is the sum of the squared differences over the squares of the data.

    Samples beyond the run count as differences: otherwise, few of them would agree best.
    """
    from scipy.signal import correlate

    count = int((times[-1] - times[0]) / spacing) + 1
    length = len(pairs[0].own)
    lags = np.arange(1 - length, count)
    grid = times[0] + spacing * np.arange(count)
    rest, covered = np.zeros(len(lags)), np.zeros(len(lags))
    reached = np.zeros(len(lags), bool)
    # First simulated value in the record, and the one after the last.
    first, last = np.clip(-lags, 0, length), np.clip(count - lags, 0, length)
    for pair in pairs:
        seen = np.interp(grid, pair.times, pair.seen)
        sums = np.concatenate(([0.0], np.cumsum(seen**2)))
        squares = np.concatenate(([0.0], np.cumsum(pair.own**2)))
        high = np.abs(pair.own) >= REACHED * np.abs(pair.own).max()
        counts = np.concatenate(([0], np.cumsum(high)))
        inside = sums[np.clip(lags + length, 0, count)]
        size = squares[last] - squares[first]
        rest += pair.rest(inside, correlate(seen, pair.own), size) / sums[-1]
        covered += inside / sums[-1]
        reached |= counts[last] > counts[first]
    # If the data agree exactly, only rounding errors remain, and they may be negative.
    cost = np.where(reached, np.maximum(rest - covered + len(pairs), 0.0), np.inf)
    offsets, best = times[0] + spacing * lags, int(np.argmin(cost))
    near = APART * max(pair.width for pair in pairs)
    cost_there = np.where(np.abs(lags - lags[best]) > near, cost, np.inf)
    second = int(np.argmin(cost_there))
    ratio = float(np.sqrt(cost_there[second] / max(cost[best], np.finfo(float).tiny)))
    other = (float(offsets[second]), ratio) if ratio < SIMILAR else None
    return float(offsets[best]), other, float(cost[best])


def _refined(pairs: Sequence[Pair], start: float, reach: float, spacing: float) -> float:
    """The best offset near a first one, with the same samples for all offsets."""
    from scipy.optimize import minimize_scalar

    for _ in range(MAX_ROUNDS):
        cost = _cost(pairs, start - reach, spacing)
        offsets = start + reach * np.linspace(-1.0, 1.0, 2 * STEPS + 1)
        best = int(np.argmin([cost(each) for each in offsets]))
        ends = offsets[max(best - 1, 0)], offsets[min(best + 1, 2 * STEPS)]
        found = float(minimize_scalar(
            cost, bounds=ends, method="bounded", options={"xatol": 1e-4 * spacing}
        ).x)  # fmt: skip
        near, start = abs(found - start) < 0.5 * reach, found
        if near:
            break
    return start


def _cost(pairs: Sequence[Pair], earliest: float, spacing: float) -> Callable[[float], float]:
    """Sum of squared differences of the samples that the run covers from an offset on."""
    from scipy.interpolate import make_interp_spline

    parts = []
    for pair in pairs:
        last = spacing * (len(pair.own) - 1)
        spline = make_interp_spline(spacing * np.arange(len(pair.own)), pair.own, k=3)
        used = pair.times <= earliest + last
        if used.any():
            parts.append((pair, pair.times[used], pair.seen[used], spline, last))

    def cost(offset: float) -> float:
        total = 0.0
        for pair, times, seen, spline, last in parts:
            own = np.where(times > offset, spline(np.clip(times - offset, 0.0, last)), 0.0)
            sums = (np.array(a @ b) for a, b in ((seen, seen), (seen, own), (own, own)))
            total += float(pair.rest(*sums)) / pair.energy
        return total

    return cost
