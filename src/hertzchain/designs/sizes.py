"""Continuous variables of a design: radii, masses and gaps, by bead or as splines."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..chain.bead_names import numbered_places
from ..chain.chain import Chain
from ..chain.input_checks import warn_large_limit
from ..chain.places import ball_places, places_from
from ..collision import Array
from ..errors import InputError
from ..representation import short
from ..validation.numbers import number, whole_number
from ..validation.objects import check_choice

UNITS: Final = {"radii": "m", "masses": "kg", "gaps": "m"}
NOUNS: Final = {"radii": "radius", "masses": "mass", "gaps": "gap"}
WAYS: Final = ("bead", "spline", "common")
DIRECTIONS: Final = ("increasing", "decreasing")
MIN_KNOTS, MAX_KNOTS = 4, 24
# Coefficients of a spline may exceed the limits by this fraction of their range, so that the spline
# can follow a limit; the sizes are clipped.
WIDER: Final = 0.5


@dataclass(frozen=True, repr=False)
class Sizes:
    """Sizes of some beads or contacts within limits; see `hertzchain.vary.radii`."""

    field: str
    low: Any
    high: Any
    beads: Any
    by: str
    knots: int | None
    symmetric: bool
    monotone: str | None

    def __post_init__(self) -> None:
        check_choice("way to vary", self.by, WAYS)
        if self.monotone is not None:
            check_choice("direction", self.monotone, DIRECTIONS)
            if self.symmetric:
                raise InputError("sizes that are symmetric and monotone are all equal: omit one")
        if self.knots is not None:
            if self.by != "spline":
                raise InputError(f"knots belong to by='spline', got by={self.by!r}")
            whole_number("knots", self.knots, least=MIN_KNOTS)

    def __repr__(self) -> str:
        knots = "" if self.knots is None else f" with {self.knots} knots"
        more = (", symmetric" if self.symmetric else "") + (
            f", {self.monotone}" if self.monotone else ""
        )
        about = f"{self.field} of {self.beads!r} from {self.low} to {self.high}"
        return short("Sizes", f"{about}, by {self.by}{knots}{more}")

    def block(self, chain: Chain) -> Block:
        """The variables for a chain."""
        gaps = self.field == "gaps"
        what, unit = NOUNS[self.field], chain._unit(UNITS[self.field])
        bound: dict[str, Any] = {"least": 0.0} if gaps else {"above": 0.0}
        low = number(f"smallest {what}", self.low, unit=unit, **bound)
        high = number(f"largest {what}", self.high, unit=unit, **bound)
        if not low < high:
            raise InputError(
                f"the {self.field} vary from {low:g} to {high:g}, which leaves nothing to vary: "
                "the first limit must be below the second"
            )
        places = (
            places_from(self.beads, chain.beads - 1, "contact") if gaps
            else ball_places(chain, numbered_places(chain, self.beads))
        )  # fmt: skip
        if chain.units == "SI" and self.field == "radii":
            warn_large_limit(low, high, chain.radii)
        if chain.units == "scaled" and self.field == "radii" and chain.strikers in places:
            raise InputError(
                f"the radius of bead {chain.strikers + 1} is the unit of length of a scaled chain "
                f"and cannot vary: use beads='{chain.strikers + 2}:'"
            )
        matrix, offset = self._matrix(chain, places, np.log if not gaps else np.asarray)
        wider = WIDER if self.by == "spline" else 0.0
        return Block(self.field, places, matrix, offset, low, high, not gaps, self.monotone, wider)

    def _matrix(self, chain: Chain, places: NDArray[np.int64], log: Any) -> tuple[Array, Array]:
        """Matrix from coefficients to (logarithms of) sizes, and the constant part."""
        count = len(places)
        if self.by == "common":
            return np.ones((count, 1)), np.zeros(count)
        if self.by == "bead":
            matrix, offset = np.eye(count), np.zeros(count)
        else:
            matrix, offset = self._spline(chain, places, log)
        if self.symmetric:
            size = matrix.shape[1]
            half = math.ceil(size / 2)
            fold = np.zeros((size, half))
            fold[np.arange(size), np.minimum(np.arange(size), np.arange(size)[::-1])] = 1.0
            matrix = matrix @ fold
        return matrix, offset

    def _spline(self, chain: Chain, places: NDArray[np.int64], log: Any) -> tuple[Array, Array]:
        count = len(places)
        if (np.diff(places) != 1).any():
            raise InputError("a spline needs successive beads: use beads='2:20', or by='bead'")
        # A spline of ordered coefficients is monotone only if none of them is given.
        # The radius of a striker need not be a size.
        anchored = places[0] > chain.strikers and not self.symmetric and self.monotone is None
        points = count + anchored
        knots = self.knots or min(MAX_KNOTS, max(MIN_KNOTS, count // 4))
        if knots > points:
            raise InputError(f"{knots} knots are too many for {points} beads: use at most {points}")
        basis = spline_basis(points, knots)
        if not anchored:
            return basis, np.zeros(count)
        behind = float(log(getattr(chain, self.field)[places[0] - 1]))
        return basis[1:, 1:], basis[1:, 0] * behind

    def with_knots(self, knots: int) -> Sizes:
        """The same sizes with another number of coefficients."""
        return dataclasses.replace(self, knots=knots)


def spline_basis(points: int, knots: int) -> Array:
    """Clamped cubic B-splines at evenly spaced points, shape (points, knots)."""
    from scipy.interpolate import BSpline

    inner = np.linspace(0.0, 1.0, knots - 2)
    ends = np.concatenate([np.zeros(3), inner, np.ones(3)])
    return np.asarray(BSpline.design_matrix(np.linspace(0.0, 1.0, points), ends, 3).toarray())


@dataclass(frozen=True, eq=False)
class Block:
    """Variables of one field of a chain; sizes are ``exp(offset + matrix @ c)`` if ``log``."""

    field: str
    places: NDArray[np.int64]
    matrix: Array
    offset: Array
    low: float
    high: float
    log: bool
    monotone: str | None
    wider: float

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return self.matrix.shape[1]

    @property
    def ends(self) -> tuple[float, float]:
        """Limits of the sizes, as logarithms if ``log``."""
        return (math.log(self.low), math.log(self.high)) if self.log else (self.low, self.high)

    @property
    def limits(self) -> tuple[float, float]:
        """Limits of each coefficient."""
        low, high = self.ends
        return low - self.wider * (high - low), high + self.wider * (high - low)

    def _order(self, coefficients: Array) -> NDArray[np.int64]:
        if self.monotone is None:
            return np.arange(self.size)
        order = np.argsort(coefficients, kind="stable")
        return order if self.monotone == "increasing" else order[::-1]

    def sizes(self, coefficients: Array) -> Array:
        """Sizes at the places; a spline of ordered coefficients is monotone."""
        values = self.free(coefficients)
        found = np.exp(values) if self.log else values
        return np.clip(found, self.low, self.high)

    def free(self, coefficients: Array) -> Array:
        """Sizes before they are clipped, as logarithms if ``log``."""
        return np.asarray(self.offset + self.matrix @ coefficients[self._order(coefficients)])

    def pull(self, coefficients: Array, slope: Array) -> Array:
        """Derivatives with respect to the coefficients, from those to the sizes of all places."""
        low, high = self.ends
        free = self.free(coefficients)
        found = slope[..., self.places] * ((free >= low) & (free <= high))
        if self.log:
            found = found * self.sizes(coefficients)
        back = np.empty((*found.shape[:-1], self.size))
        back[..., self._order(coefficients)] = found @ self.matrix
        return back

    def coefficients(self, sizes: Array) -> Array:
        """Coefficients whose sizes are nearest to the given ones, within the limits."""
        values = np.log(np.clip(sizes, self.low, self.high)) if self.log else sizes
        return np.clip(self._inverse @ (values - self.offset), *self.limits)

    @cached_property
    def _inverse(self) -> Array:
        """Matrix of the least-squares fit of coefficients."""
        return np.linalg.pinv(self.matrix)


def check_sizes_vary(chain: Chain, places: NDArray[np.int64]) -> None:
    """Raise `InputError` if the size of a striker or cap varies whose mass or face is given."""
    given = {k for k, each in chain._bodies.items() if each.mass is not None or each.flat}
    for k in sorted(given.intersection(places.tolist())):
        if k >= chain.strikers:
            raise InputError(
                f"the size of bead {k + 1}, the cap, cannot vary: choose beads up to {k}"
            )
        raise InputError(
            f"the size of bead {k + 1}, a striker, varies, but its mass is given and would "
            f"not follow: use beads='{chain.strikers + 1}:', or give the striker no mass"
        )
