"""Height of the crest of a noisy signal, from a polynomial through the samples around it."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.polynomial import polyvander

from ..collision import Array
from .amplitudes import extreme

# Half of the window around the crest, in half widths of the pulse, the degrees of the polynomial,
# and the least number of samples for each.
PART: Final = 0.4
DEGREES: Final = ((4, 11), (2, 5))


def crest_of(times: Array, values: Array, width: float, middle: float) -> tuple[float, float]:
    """Height of the crest near a time, and its standard error over that of one sample.

    The largest sample is higher than the crest, because it is the largest of many errors.  It is
    returned, with a NaN, if too few samples are within the window, or none is missing on both
    sides.  ``width`` is the time during which the pulse exceeds half of its peak.
    """
    near = np.abs(times - middle) <= PART * width
    degree = next((degree for degree, least in DEGREES if near.sum() >= least), 0)
    if degree == 0:
        return extreme(values), np.nan
    places, heights = (times[near] - middle) / (PART * width), values[near]
    columns = polyvander(places, degree)
    inverse = np.linalg.pinv(columns)
    curve = Polynomial(inverse @ heights)
    sign = np.sign(extreme(heights))
    inside = np.linspace(places[0], places[-1], 401)
    top = float(inside[np.argmax(sign * curve(inside))])
    weights = polyvander(np.array([top]), degree)[0] @ inverse
    return float(curve(top)), float(np.linalg.norm(weights))
