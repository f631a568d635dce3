"""Tables of the local-rate law for any exponent, interpolated between those of ten exponents.

Tables have the same shape for all exponents.  They are interpolated entry by entry by the
polynomial in the logarithm of the exponent through the tables at its Chebyshev nodes, along lines
on which the rate is a fixed fraction of the lowest or the highest one.
"""

from __future__ import annotations

import functools
import math
from pathlib import Path
from typing import Final

import numpy as np

from ..collision import Array

# Chebyshev nodes in the logarithm of the exponent.
LOWEST, HIGHEST, COUNT = 1.25, 3.0, 10
FILE: Final = "exponents.npz"
# Tables that are interpolated as they are, and places whose negative ones are multiplied by
# `shrink_of`.
VALUES: Final = ("values", "response", "single", "end", "end_slopes")
PLACES: Final = ("nodes", "knots", "places", "fast_knots")

# Typical size of the factor of products of fast changes of Hertz contacts.
TYPICAL_GAIN: Final = 0.2


def _chebyshev() -> Array:
    angles = (2.0 * np.arange(COUNT, 0, -1) - 1.0) * np.pi / (2.0 * COUNT)
    low, high = math.log(LOWEST), math.log(HIGHEST)
    return np.asarray(np.exp(0.5 * (low + high) + 0.5 * (high - low) * np.cos(angles)))


EXPONENTS: Final = _chebyshev()


def shrink_of(exponent: float) -> float:
    """Factor of the negative rates of the tables of an exponent.

    For small exponents, steep forward tapers have no settled pulse: the range is narrower.
    """
    return math.tanh((exponent - 1.15) / 0.32)


def steady_gain(exponent: float) -> float:
    """Constant c of the products of fast changes: relative to |e|^(5/2), the size of e^2 terms.

    In equal beads, alternating rates attenuate the velocity by c_2 e^2 + c_3 |e|^(5/2).  The
    measured ratio of both is 0 for the exponent 3/2 and grows on both sides.
    """
    return (25.0 if exponent < 1.5 else 5.0) * (exponent - 1.5) ** 2


def scaled(rates: Array, shrink: float) -> Array:
    """Rates of which the negative ones are multiplied by a factor."""
    return np.where(rates < 0.0, shrink * rates, rates)


def weights(exponent: float) -> Array:
    """Weights of the tables in the interpolated ones (Lagrange polynomials)."""
    x, nodes = math.log(exponent), np.log(EXPONENTS)
    return np.array(
        [
            np.prod((x - np.delete(nodes, i)) / (nodes[i] - np.delete(nodes, i)))
            for i in range(COUNT)
        ]
    )


def interpolated_tables(folder: Path, exponent: float) -> dict[str, Array]:
    """Tables of an exponent: those of `VALUES` and `PLACES`, and the constants of the error."""
    stored, of = _stored(folder / FILE), weights(exponent)
    found = {name: np.tensordot(of, stored[name], 1) for name in VALUES}
    # The coefficients of products are interpolated times the factor of these products.
    factors = np.array([steady_gain(float(each)) for each in EXPONENTS]) + TYPICAL_GAIN
    products = np.tensordot(of * factors, stored["second"], 1)
    found["second"] = products / (steady_gain(exponent) + TYPICAL_GAIN)
    shrink = shrink_of(exponent)
    found |= {name: scaled(stored[name], shrink) for name in PLACES}
    at, errors = np.log(stored["error_exponents"]), stored["errors"]
    found["error"] = np.array([np.interp(math.log(exponent), at, each) for each in errors.T])
    return found


@functools.cache
def _stored(file: Path) -> dict[str, Array]:
    with np.load(file) as stored:
        return {name: stored[name].astype(float) for name in stored}
