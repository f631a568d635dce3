"""Tapers from sizes: radii of both ends, their ratio, or the length of the chain.

With the radii R_1 and R_N of both ends, the rate of a linear taper of N beads is

    S = |R_N / R_1 - 1| / (N - 1),

and that of an exponential one, with g = (R_N / R_1)^(1/(N - 1)), is q = 1 - 1/g if radii grow and
q = 1/g - 1 if they shrink (Eqs. (6), (7), (19) and (21) of the paper).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from ..collision import Array
from ..errors import InputError, short_repr
from ..validation.numbers import FRACTION, has_unit, number
from ..validation.objects import check_choice
from .input_checks import checked_beads
from .tapers import ROUNDING, TAPERS, taper_named, tapered_radii

# Names of a linear and of an exponential taper whose radii shrink, and grow.
SHAPES: Final[Mapping[str, tuple[str, str]]] = MappingProxyType(
    {
        "linear": ("forward-linear", "backward-linear"),
        "exponential": ("forward-exponential", "backward-exponential"),
    }
)
# The default if only sizes are given.
USUAL_SHAPE: Final = "exponential"


@dataclass(frozen=True)
class Sizes:
    """Sizes as given: radii or diameters of the ends, their ratio, length of the chain."""

    first: Any = None
    last: Any = None
    first_diameter: Any = None
    last_diameter: Any = None
    ratio: Any = None
    length: Any = None

    def first_radius(self, unit: str | None) -> float | None:
        """Radius of bead 1, or `None` if it is not given."""
        return _radius("first", self.first, self.first_diameter, unit)

    @property
    def last_given(self) -> bool:
        """Whether the last radius is given in any way."""
        ways = (self.last, self.last_diameter, self.ratio, self.length)
        return any(value is not None for value in ways)

    def last_radius(self, shape: str, beads: int, first: float, unit: str | None) -> float:
        """Radius of bead N, from itself, from R_N / R_1 or from the sum of the diameters."""
        last = _radius("last", self.last, self.last_diameter, unit)
        given = [value for value in (last, self.ratio, self.length) if value is not None]
        if len(given) != 1:
            raise InputError(
                "a taper of given sizes needs exactly one of last (or last_diameter), ratio and "
                f"length in addition to its first bead, got {len(given)} of them"
            )
        if last is not None:
            return last
        if self.ratio is not None:
            return first * number(
                "ratio of the last to the first radius", self.ratio, unit=FRACTION, above=0.0
            )
        return _last_of_length(shape, beads, first, number("length", self.length, unit=unit))


def _radius(end: str, radius: Any, diameter: Any, unit: str | None) -> float | None:
    if radius is not None and diameter is not None:
        raise InputError(f"give the radius of the {end} bead or its diameter, not both")
    if diameter is not None:
        return 0.5 * number(f"diameter of the {end} bead", diameter, unit=unit, above=0.0)
    if radius is not None:
        return number(f"radius of the {end} bead", radius, unit=unit, above=0.0)
    return None


def taper_of_sizes(
    taper: str | None, rate: float | None, parameters: Mapping[str, float], beads: int,
    sizes: Sizes, *, si: bool,
) -> tuple[str | None, dict[str, float], Array, float]:  # fmt: skip
    """Name, parameters and radii in units of the first one (which is the last result)."""
    unit = "m" if si else None
    if not si:
        _require_no_units(sizes)
    first = sizes.first_radius(unit)
    if si and first is None:
        raise InputError(
            "a taper with a material needs the size of its first bead: give first='10 mm', its "
            "radius, or first_diameter"
        )
    first = 1.0 if first is None else first
    if not sizes.last_given:
        if taper is None:
            raise InputError(
                f"Chain.tapered needs a taper and its rate ({', '.join(TAPERS)}), or sizes: first "
                "and last, ratio or length"
            )
        if isinstance(taper, str) and taper in SHAPES:
            raise InputError(
                f"a taper named {taper!r} needs sizes: last, ratio or length; with a rate, it is "
                f"{' or '.join(SHAPES[taper])}"
            )
        kind = taper_named(taper)
        if not si and sizes.first_radius(unit) is not None:
            raise InputError(
                "the first bead is the unit of a scaled taper with a rate: omit its size, or give "
                "materials"
            )
        given = parameters if rate is None else {"rate": rate, **parameters}
        if kind.is_uniform(given):
            return None, {}, np.ones(beads), first
        values = kind.parameters(given, beads)
        return kind.name, values, kind.radii_of(beads, values), first
    if rate is not None or parameters:
        raise InputError(
            "a taper has a rate or sizes (last, ratio or length), which determine the rate: give "
            "one of them"
        )
    shape = check_choice("taper of given sizes", taper or USUAL_SHAPE, SHAPES)
    last = sizes.last_radius(shape, beads, first, unit)
    if abs(last - first) < ROUNDING * first:
        return None, {}, np.ones(beads), first
    name, slope, radii = taper_between(shape, beads, first, last)
    return name, {"rate": slope}, radii, first


def _require_no_units(sizes: Sizes) -> None:
    """Ask for the material of beads whose sizes have units."""
    for name in ("first", "last", "first_diameter", "last_diameter", "length"):
        value = getattr(sizes, name)
        if has_unit(value):
            raise InputError(
                f"sizes with a unit ({name} = {short_repr(value)}) need the material of the beads: "
                "give materials, such as materials='steel-52100', or sizes without units for a "
                "scaled chain"
            )


def si_radii(
    taper: str | None,
    beads: int,
    sizes: Sizes,
    parameters: Mapping[str, float] = MappingProxyType({}),
) -> Array:
    """Radii [m] of a taper of given sizes, or of the size of its first bead and its parameters."""
    count = checked_beads(beads, 2)
    _, _, radii, first = taper_of_sizes(taper, None, parameters, count, sizes, si=True)
    return first * radii


def _last_of_length(shape: str, beads: int, first: float, total: float) -> float:
    least = (beads if shape == "linear" else 2.0) * first
    if total <= least:
        raise InputError(
            f"the length of {beads} beads that change {shape}ly from a radius of {first:g} must be "
            f"above {least:g}, where the last bead vanishes, got {total:g}; use fewer or smaller "
            "beads"
        )
    if shape == "linear":
        return total / beads - first
    return first * _ratio_of_exponential(0.5 * total / first, beads)


def _ratio_of_exponential(total: float, beads: int) -> float:
    """R_N / R_1 of an exponential taper whose radii have a given sum, in units of the first."""
    from scipy.optimize import brentq

    def excess(growth: float) -> float:
        return float(np.exp(growth * np.arange(beads)).sum()) / total - 1.0

    # Radii shrink at least until all but the first vanish, and the last one alone is the sum.
    low, high = -800.0, math.log(total) / (beads - 1)
    return math.exp((beads - 1) * brentq(excess, low, max(high, 0.0), xtol=1e-300, rtol=1e-15))


def taper_between(shape: str, beads: int, first: float, last: float) -> tuple[str, float, Array]:
    """Name, rate and radii (in units of the first one) of the taper between two radii."""
    growth = last / first
    name = SHAPES[shape][growth > 1.0]
    if shape == "linear":
        rate = abs(growth - 1.0) / (beads - 1)
    else:
        step = growth ** (1.0 / (beads - 1))
        rate = 1.0 - 1.0 / step if growth > 1.0 else 1.0 / step - 1.0
        if not rate < 1.0:
            raise InputError(
                f"radii from {first:g} to {last:g} in {beads} beads shrink by a factor of "
                f"{1.0 / step:.3g} from bead to bead, but a forward-exponential taper shrinks by "
                "less than a factor of 2; use more beads, or Chain.from_radii for any radii"
            )
    return name, rate, tapered_radii(name, rate, beads)
