"""Constraints of a design: a measure and its limit."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, short_repr
from ..representation import measure as shown
from ..units import converted
from ..validation.numbers import number
from .measures import Measure, check_name, measure_of

_FORM: Final = re.compile(r"\s*(<=|>=|≤|≥|<|>)\s*([^\s<>=].*?)\s*")
_VALUE: Final = re.compile(r"[-+]?[\d.]+([eE][-+]?\d+)?(\s*[a-zA-Zµ][\w/^* ]*)?")
_PLAIN: Final = re.compile(r"[-+]?[\d.]+([eE][-+]?\d+)?")
# Units that examples in messages use instead of SI units.
_USUAL: Final = {"m": "mm", "s": "us"}
# Relative violation that is regarded as rounding of the simulation.
TOLERANCE: Final = 1e-6


@dataclass(frozen=True)
class Requirement:
    """A measure that must be at most, or with sign -1 at least, a limit."""

    measure: Measure
    limit: float
    sign: int
    units: str
    # Unit in which the limit was given; empty if it was a number.
    unit: str = ""
    # Whether it was not given.
    default: bool = False

    def __str__(self) -> str:
        return f"{self.measure} {'<=' if self.sign > 0 else '>='} {self.shown(self.limit)}"

    @property
    def preference(self) -> str:
        """The side of the measure that is farther from the limit, in words."""
        return f"{'the smallest' if self.sign > 0 else 'the largest'} {self.measure}"

    def shown(self, value: float) -> str:
        """A value of the measure, in the unit in which the limit was given."""
        unit = "" if self.measure.unit == "1" else self.measure.unit
        if self.unit:
            one = converted(str(self.measure), 1.0, self.unit, unit.replace(" ", "*"))
            return shown(value / one, self.unit)
        return shown(value, unit, self.units).strip()

    def excess(self, values: Any) -> Any:
        """Relative amount by which values violate the limit; negative if they meet it."""
        return self.sign * (np.asarray(values) - self.limit) / (abs(self.limit) or 1.0)


def requirements_from(given: object, chain: Chain) -> tuple[Requirement, ...]:
    """Read constraints such as ``{"length": "<= 60 mm"}``; several may be in a list."""
    if not isinstance(given, Mapping):
        raise InputError(
            f"subject_to must be a mapping, such as {{'length': '<= 60 mm'}}, got "
            f"{short_repr(given)}"
        )
    found = []
    for name, texts in given.items():
        check_name(name, texts)
        measure = measure_of(chain, name)
        listed = texts if isinstance(texts, list | tuple) else [texts]
        found += [_requirement(measure, text, chain) for text in listed]
    _check_consistent(found)
    return tuple(found)


def _requirement(measure: Measure, text: object, chain: Chain) -> Requirement:
    form = _FORM.fullmatch(text) if isinstance(text, str) else None
    if form is None:
        bare = text.strip("=<> ") if isinstance(text, str) else ""
        fixed = bare if _VALUE.fullmatch(bare) else ""
        raise InputError(
            f"the constraint on {measure} must look like '<= 5' or '>= 5', got {short_repr(text)}; "
            f"for a fixed value, give both: ['<= {fixed or 5}', '>= {fixed or 5}']"
        )
    if _PLAIN.fullmatch(form[2]) and measure.unit != "1" and not chain.scaled:
        raise InputError(
            f"the constraint on {measure} needs a unit, such as '{form[1]} {form[2]} "
            f"{_usual_unit(measure)}', got {text!r}"
        )
    sign = 1 if form[1] in ("<=", "≤", "<") else -1
    limit = limit_from(str(measure), form[2], measure, chain)
    return Requirement(
        measure, limit, sign, chain.units, form[2].lstrip("+-.0123456789eE ").strip()
    )


def _usual_unit(measure: Measure) -> str:
    return _USUAL.get(measure.unit, measure.unit)


def limit_from(what: str, text: Any, measure: Measure, chain: Chain) -> float:
    """Read a number, with the unit of a measure if the chain is in SI units."""
    try:
        value: Any = float(text)
    except (TypeError, ValueError):
        value = text
    unit = None if measure.unit == "1" else chain._unit(measure.unit.replace(" ", "*"))
    return number(f"limit of {what}", value, unit=unit)


def _check_consistent(found: list[Requirement]) -> None:
    for one in found:
        for other in found:
            opposite = one.measure == other.measure and one.sign > 0 > other.sign
            if opposite and one.limit < other.limit:
                raise InputError(f"the constraints {one} and {other} exclude each other")


def violation(requirements: tuple[Requirement, ...], values: Array) -> Array:
    """Total relative violation of rows of values, shape (C,); NaN if one of them is unknown."""
    total = np.zeros(len(values))
    for i, each in enumerate(requirements):
        excess = each.excess(values[:, i])
        total += np.where(excess <= TOLERANCE, 0.0, excess)
    return total
