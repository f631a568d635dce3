"""Tables of the local-rate law for any exponent, interpolated between those of ten exponents.

Tables have the same shape for all exponents.  They are interpolated entry by entry by the
polynomial in the logarithm of the exponent through the tables at its Chebyshev nodes, along lines
on which the rate is a fixed fraction of the lowest or the highest one.  The coefficients of its
Chebyshev polynomials are stored.
"""

from __future__ import annotations

import functools
import math
from pathlib import Path
from typing import Final

import numpy as np
from numpy.polynomial.chebyshev import chebval, chebvander

from ..collision import Array
from .packed_tables import STEPS, Bytes, pack, unpack

# Chebyshev nodes in the logarithm of the exponent.
LOWEST, HIGHEST, COUNT = 1.25, 3.0, 10
FILE: Final = "exponents.npz"
# Tables that are interpolated, with the axis of the rate, and places whose negative ones are
# multiplied by `shrink_of`.  The response is stored as its linear terms and products.
AXES: Final = {
    "values": 1, "linear": 3, "products": 3, "single": 1, "early": 1, "end": 1,
    "end_slopes": 1, "second": 1,
}  # fmt: skip
PLACES: Final = ("nodes", "knots", "places", "fast_knots")

# Typical size of the factor of products of fast changes of Hertz contacts.
TYPICAL_GAIN: Final = 0.2


def _chebyshev() -> Array:
    angles = (2.0 * np.arange(COUNT, 0, -1) - 1.0) * np.pi / (2.0 * COUNT)
    low, high = math.log(LOWEST), math.log(HIGHEST)
    return np.asarray(np.exp(0.5 * (low + high) + 0.5 * (high - low) * np.cos(angles)))


EXPONENTS: Final = _chebyshev()


def place_of(exponent: Array | float) -> Array:
    """Argument of the Chebyshev polynomials, from -1 to 1."""
    low, high = math.log(LOWEST), math.log(HIGHEST)
    return np.asarray((2.0 * np.log(exponent) - low - high) / (high - low))


def coefficients(tables: Array) -> Array:
    """Coefficients of the Chebyshev polynomials through the tables at `EXPONENTS`."""
    matrix = np.linalg.inv(chebvander(place_of(EXPONENTS), COUNT - 1))
    return np.asarray(np.tensordot(matrix, tables, 1))


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


def pack_tables(found: dict[str, Array]) -> dict[str, Bytes]:
    """Tables in the form in which they are stored; those at all exponents are stacked."""
    gains = np.array([product_gain(float(each)) for each in EXPONENTS])
    found = found | {"second": found["second"] * gains[:, None, None]}
    return {name: pack(coefficients(found[name]), STEPS[name], axis) for name, axis in AXES.items()}


def product_gain(exponent: float) -> float:
    """Size of the factor of products of fast changes, with which their coefficients are stored."""
    return steady_gain(exponent) + TYPICAL_GAIN


def interpolated_tables(folder: Path, exponent: float) -> dict[str, Array]:
    """Tables of an exponent, their places, and the constants of the error."""
    stored, place = _stored(folder / FILE), place_of(exponent)
    found = {name: np.asarray(chebval(place, stored[name])) for name in AXES}
    found["second"] /= product_gain(exponent)
    found["response"] = np.concatenate([found.pop("linear"), found.pop("products")], axis=1)
    shrink = shrink_of(exponent)
    found |= {name: scaled(stored[name], shrink) for name in PLACES}
    at, errors = np.log(stored["error_exponents"]), stored["errors"]
    found["error"] = np.array([np.interp(math.log(exponent), at, each) for each in errors.T])
    return found


@functools.cache
def _stored(file: Path) -> dict[str, Array]:
    with np.load(file) as stored:
        return {
            name: unpack(stored[name], STEPS[name], AXES[name]) if name in AXES else stored[name]
            for name in stored
        }
