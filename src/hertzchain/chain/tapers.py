"""Tapers: radii of a chain as a function of the bead number and a few parameters.

Each of the paper's four tapers has one parameter, the rate.  To add a taper, add a `Taper` to
`TAPERS`; chain files, sweeps and the command line then accept it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final, Literal

import numpy as np

from ..collision import Array
from ..errors import InputError, real_number, short_repr, unknown_name_error
from ..validation.numbers import FRACTION, plain_magnitude
from ..validation.objects import check_list

# Radii below this value are zero except for rounding errors.
ROUNDING: Final = 1e-12


@dataclass(frozen=True)
class Taper:
    r"""A family of tapers.

    Attributes
    ----------
    name : str
        Name, as in ``Chain.tapered(name, ...)``.
    radii : callable
        Function of the array of :math:`k - 1` and of the parameters (by name) that returns the
        radii of beads k = 1, 2, ...; the first must be 1.
    check : callable
        Function of the number of beads and of the parameters (by name) that raises
        `InputError` if a parameter is out of range.
    symbols : mapping of str to str
        Symbol of each parameter by its name.
    """

    name: str
    radii: Callable[..., Array] = field(repr=False)
    check: Callable[..., None] = field(repr=False)
    symbols: Mapping[str, str]

    def parameters(self, given: Mapping[str, Any], beads: int = 2) -> dict[str, float]:
        """Check the parameters for a number of beads."""
        names = " and ".join(self.symbols)
        for name in given:
            if name not in self.symbols:
                raise InputError(f"a {self.name} taper has no parameter {name!r}, only {names}")
        for name in self.symbols:
            if given.get(name) is None:
                raise InputError(f"a {self.name} taper requires {names}; give {name}")
        values = {
            name: _rate(f"{symbol} of a {self.name} taper", given[name])
            for name, symbol in self.symbols.items()
        }
        self.check(beads, **values)
        return values

    def is_uniform(self, given: Mapping[str, Any]) -> bool:
        """Whether all parameters are given and 0, so that all beads are equal."""
        return given.keys() == self.symbols.keys() and all(
            value is not None
            and _rate(f"{self.symbols[name]} of a {self.name} taper", value) == 0.0
            for name, value in given.items()
        )

    def radii_of(self, beads: int, values: Mapping[str, float]) -> Array:
        """Radii of beads 1 to N; the parameters are not checked."""
        with np.errstate(over="ignore", under="ignore"):
            return np.asarray(self.radii(np.arange(beads, dtype=float), **values))


def _rate(what: str, given: object) -> float:
    """Read a number or a percentage, whose range is checked by the taper."""
    return real_number(what, plain_magnitude(what, given, FRACTION))


def taper_named(name: str) -> Taper:
    """Find a taper by its name."""
    if not isinstance(name, str) or name not in TAPERS:
        uniform = isinstance(name, str) and name == "uniform"
        hint = "; for equal beads use Chain.uniform" if uniform else ""
        raise InputError(str(unknown_name_error("taper", name, TAPERS)) + hint)
    return TAPERS[name]


def checked_parameters(
    taper: str | None, given: Any, radii: Array
) -> tuple[tuple[str, float], ...]:
    """Parameters of the taper with these radii; none without a taper."""
    pairs = parameter_pairs(given)
    if taper is None:
        if pairs:
            raise InputError("taper_parameters require a taper; use Chain.tapered")
        return ()
    kind = taper_named(taper)
    values = kind.parameters(pairs, len(radii))
    if not np.array_equal(radii, kind.radii_of(len(radii), values)):
        raise InputError(f"these radii are not those of a {taper} taper; use Chain.tapered")
    return tuple(values.items())


def rate_symbol(taper: str) -> str:
    """Symbol of the rate of a taper: S if it is linear, q if it is exponential."""
    return taper_named(taper).symbols["rate"]


def check_taper(taper: str, rate: float, beads: int = 2) -> float:
    """Check the rate of a taper without other parameters for a number of beads."""
    return taper_named(taper).parameters({"rate": rate}, beads)["rate"]


def exponential_rate(taper: str, rate: float) -> float:
    """Check an exponential taper; the rate q of a backward taper, or -q of a forward one."""
    check_taper(taper, rate)
    if rate_symbol(taper) != "q":
        raise InputError(f"a {taper} taper has no constant rate; use an exponential taper")
    return rate if taper == "backward-exponential" else -rate


def tapered_radii(taper: str, rate: float, beads: int) -> Array:
    """Radii of a taper whose only parameter is its rate, which is not checked."""
    return TAPERS[taper].radii_of(beads, {"rate": rate})


def _advice(kind: str, direction: Literal["backward", "forward"], rate: float) -> str:
    """Advice for a rate that is out of range."""
    other = "forward" if direction == "backward" else "backward"
    if rate < 0.0:
        return f"for the other direction, use {other}-{kind} with {-rate:g}"
    if 1.0 <= rate < 100.0 and kind == "exponential":
        return f"for {rate:g}%, write {rate / 100.0:g}"
    example = 0.05 if kind == "exponential" else 0.005
    return f"try {example}, or a uniform chain for equal beads"


def _check_exponential(direction: Literal["backward", "forward"], rate: float) -> None:
    if not 0.0 < rate < 1.0:
        raise InputError(
            f"q of a {direction}-exponential taper must lie between 0 and 1, got {rate:g}; "
            + _advice("exponential", direction, rate)
        )


def _check_linear(direction: Literal["backward", "forward"], rate: float) -> None:
    if not 0.0 < rate < math.inf:
        raise InputError(
            f"S of a {direction}-linear taper must be positive and finite, got {rate:g}; "
            + _advice("linear", direction, rate)
        )


def _check_forward_linear(beads: int, rate: float) -> None:
    _check_linear("forward", rate)
    if _last_radius(rate, beads) > ROUNDING:
        return
    # Because 1/S is rounded, search down from it for the longest chain with positive radii.
    longest = math.ceil(1.0 + 1.0 / rate)
    while longest >= 2 and not _last_radius(rate, longest) > ROUNDING:
        longest -= 1
    advice = (
        f"use at most {longest} beads or a smaller S"
        if longest >= 2
        else "S must be below 1 even for two beads"
    )
    raise InputError(
        f"the radii of a forward-linear taper with S = {rate:g} reach zero at bead "
        f"{longest + 1}, but {beads} beads were requested; {advice}"
    )


def _last_radius(rate: float, beads: int) -> float:
    return 1.0 - rate * (beads - 1)


_BACKWARD_LINEAR: Final = Taper(
    "backward-linear",
    radii=lambda step, rate: 1.0 + rate * step,  # Eq. (6)
    check=lambda beads, rate: _check_linear("backward", rate),  # noqa: ARG005
    symbols={"rate": "S"},
)
_BACKWARD_EXPONENTIAL: Final = Taper(
    "backward-exponential",
    radii=lambda step, rate: (1.0 - rate) ** -step,  # Eq. (7)
    check=lambda beads, rate: _check_exponential("backward", rate),  # noqa: ARG005
    symbols={"rate": "q"},
)
_FORWARD_LINEAR: Final = Taper(
    "forward-linear",
    radii=lambda step, rate: 1.0 - rate * step,  # Eq. (19)
    check=_check_forward_linear,
    symbols={"rate": "S"},
)
_FORWARD_EXPONENTIAL: Final = Taper(
    "forward-exponential",
    radii=lambda step, rate: (1.0 + rate) ** -step,  # Eq. (21)
    check=lambda beads, rate: _check_exponential("forward", rate),  # noqa: ARG005
    symbols={"rate": "q"},
)
PAPER_TAPERS: Final = (
    _BACKWARD_LINEAR.name, _BACKWARD_EXPONENTIAL.name,
    _FORWARD_LINEAR.name, _FORWARD_EXPONENTIAL.name,
)  # fmt: skip
TAPERS: Final[Mapping[str, Taper]] = MappingProxyType(
    {
        taper.name: taper
        for taper in (
            _BACKWARD_LINEAR,
            _BACKWARD_EXPONENTIAL,
            _FORWARD_LINEAR,
            _FORWARD_EXPONENTIAL,
        )
    }
)
# Names of the parameters of all tapers.
PARAMETERS: Final = tuple(dict.fromkeys(name for each in TAPERS.values() for name in each.symbols))


def parameter_description(name: str) -> str:
    """Symbols of a parameter, each with the tapers that use it."""
    symbols: dict[str, list[str]] = {}
    for taper in TAPERS.values():
        if name in taper.symbols:
            symbols.setdefault(taper.symbols[name], []).append(taper.name)
    return "; ".join(f"{symbol} of {' and '.join(names)}" for symbol, names in symbols.items())


def parameter_pairs(given: Sequence[tuple[str, float]]) -> dict[str, float]:
    """Check a sequence of names and values of parameters."""
    pairs = check_list("taper_parameters", given, "pairs of name and value")
    for pair in pairs:
        if not (isinstance(pair, tuple | list) and len(pair) == 2 and isinstance(pair[0], str)):
            raise InputError(
                "taper_parameters must be pairs of name and value, such as ('rate', 0.05), got "
                f"{short_repr(pair)}"
            )
    return dict(pairs)
