"""Height of the crest of a noisy signal, from a polynomial through the samples around it.

The window is the widest in which the polynomial describes the samples to their noise, so that the
height depends on the record only, also if narrow crests stand on a broad signal.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.polynomial import polyvander
from scipy.signal import oaconvolve

from ..collision import Array
from .amplitudes import ARRIVED, extreme

# Degrees of polynomials, and the least number of samples for each.
DEGREES: Final = ((2, 5), (4, 11), (6, 17))
# Ratio of successive windows, and the largest one in times that the signal exceeds half its peak.
GROWTH, LARGEST = 1.3, 1.5
# Largest fall of chi-squared by two further degrees, largest difference between the heights in
# two windows and largest excess of chi-squared, in standard errors, of a polynomial that describes
# the samples; and the relative error of their noise.
FALL, DIFFERENT, EXCESS, OF_NOISE = 4.0, 5.0, 4.0, 0.1
# Largest relative error of a polynomial that does not describe samples of little noise.
MAX_ERROR: Final = 2e-3


@dataclass(frozen=True)
class Crest:
    """Height of a crest and its standard error, NaN if it is the largest of few samples."""

    height: float
    error: float


@dataclass(frozen=True)
class _Fitted:
    """A polynomial through a window: its height, the factor of its noise, and its misfit.

    The height is that by two further degrees, which have less bias; they reduce the sum of squares,
    ``rest``, by ``fall``, and differ from the height without them by ``bias``.
    """

    height: float
    factor: float
    bias: float
    fall: float
    rest: float
    freedom: int

    def describes(self, sigma: float) -> bool:
        """Whether samples with this noise show no misfit."""
        allowed = self.freedom * (1.0 + OF_NOISE) ** 2 + EXCESS * math.sqrt(2.0 * self.freedom)
        return self.fall <= FALL * sigma**2 and self.rest <= allowed * sigma**2


def crest_of_record(times: Array, values: Array, sigma: float) -> Crest:
    """The highest crest of samples with this noise.

    Of the polynomials that describe the samples around their crest, and of which no narrower window
    shows another height, it is the one with the least noise.  If there is none, because the noise
    is small, it is that of the least error.
    """
    size = np.abs(values)
    most = min(LARGEST * np.count_nonzero(size > ARRIVED * size.max()), len(times))
    found = [
        [each for count in _windows(most, least)
         for each in _fits(times, values, count, degree)]
        for degree, least in DEGREES
    ]  # fmt: skip
    all_of_them = [each for some in found for each in some]
    good = [
        each
        for each in all_of_them
        if each.describes(sigma) and not any(_differ(each, one, sigma) for one in all_of_them)
    ]
    if good:
        best = min(good, key=lambda each: each.factor)
        return Crest(best.height, sigma * best.factor)
    errors = [math.hypot(sigma * each.factor, each.bias) for each in all_of_them]
    least = int(np.argmin(errors)) if errors else 0
    if not errors or errors[least] > MAX_ERROR * abs(all_of_them[least].height):
        return Crest(extreme(values), math.nan)
    return Crest(all_of_them[least].height, errors[least])


def _differ(one: _Fitted, narrow: _Fitted, sigma: float) -> bool:
    """Whether the height in a window is not that in a narrower one."""
    if narrow.factor <= one.factor:
        return False
    allowed = DIFFERENT * sigma * narrow.factor + (narrow.fall > FALL * sigma**2) * narrow.bias
    return abs(one.height - narrow.height) > allowed


def _windows(most: float, least: int) -> Iterator[int]:
    """Odd numbers of samples in windows, the narrowest first."""
    count = float(least)
    while count <= max(most, least):
        odd = 2 * int(count / 2.0) + 1
        yield odd
        count = max(odd + 2.0, GROWTH * odd)


def _fits(times: Array, values: Array, count: int, degree: int) -> Iterator[_Fitted]:
    """The polynomial through the window with the highest crest, if the record contains it."""
    if count > len(times):
        return
    middle = _highest(values, count, degree)
    near = slice(middle - count // 2, middle + count // 2 + 1)
    yield _fitted(times[near] - times[middle], values[near], degree)


def _highest(values: Array, count: int, degree: int) -> int:
    """The sample at which the polynomial through its neighbours is largest."""
    places = np.linspace(-1.0, 1.0, count)
    weights = np.linalg.pinv(polyvander(places, degree))[0]
    return int(np.argmax(np.abs(oaconvolve(values, weights[::-1], "valid")))) + count // 2


def _fitted(times: Array, values: Array, degree: int) -> _Fitted:
    """The polynomial through a window, compared with one of two further degrees."""
    places = times / np.abs(times).max()
    sign = np.sign(extreme(values))
    height, _, rest = _polynomial(places, values, degree, sign)
    better, factor, least = _polynomial(places, values, degree + 2, sign)
    return _Fitted(
        better, factor, abs(better - height), rest - least, rest, len(times) - degree - 1
    )


def _polynomial(
    places: Array, heights: Array, degree: int, sign: float
) -> tuple[float, float, float]:
    """Extreme of a polynomial, the factor of its noise, and the sum of squares that it leaves."""
    columns = polyvander(places, degree)
    inverse = np.linalg.pinv(columns)
    coefficients = inverse @ heights
    curve = Polynomial(coefficients)
    inside = np.linspace(places[0], places[-1], 401)
    top = float(inside[np.argmax(sign * curve(inside))])
    weights = polyvander(np.array([top]), degree)[0] @ inverse
    rest = heights - columns @ coefficients
    return float(curve(top)), float(np.linalg.norm(weights)), float(rest @ rest)
