"""Parameters that vary: where in the description of a chain they are, and their values."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from hertzchain.checks import number, whole_number
from hertzchain.errors import InputError, shown, unknown_name
from hertzchain.store.chain_schema import dimensions_of
from hertzchain.sweeps.plain import plain_json
from hertzchain.units import UNITS, converted, quantity

SPACINGS: Final = ("list", "linspace", "geomspace")
# Ends of a linspace, at most: their difference must be a number, too.
LARGEST: Final = 1e300
# Values of one axis, at most.
MOST_VALUES: Final = 10_000_000


@dataclass(frozen=True, eq=False)
class Axis:
    """One parameter and the values that it takes.

    Attributes
    ----------
    path : tuple of str
        Where it is: ``("rate",)`` is a key of ``[chain]``, ``("loss", "restitution")`` one of
        ``[chain.loss]``, ``("radii", "5")`` the radius of bead 5, ``("method", "rtol")`` an
        option of the integration.
    entry : mapping or sequence
        Values as specified: a list, or ``{"linspace": [first, last, number]}``, or geomspace;
        with ``"unit"`` if they are not in SI or scaled.

    Raises
    ------
    InputError
        If the entry is neither, or has no values, or one twice.

    Examples
    --------
    >>> axis = Axis(("rate",), {"linspace": [0.02, 0.1, 5]})
    >>> [round(value, 2) for value in axis.values], axis.name
    ([0.02, 0.04, 0.06, 0.08, 0.1], 'rate')
    >>> Axis(("radius",), {"list": [5, 10], "unit": "mm"}).values
    [0.005, 0.01]
    """

    path: tuple[str, ...]
    entry: Mapping[str, Any] | Sequence[Any]

    def __post_init__(self) -> None:
        object.__setattr__(self, "entry", plain_json(self.entry))
        if not self.values:
            raise InputError("has no values")

    def __len__(self) -> int:
        return len(self.values)

    @property
    def name(self) -> str:
        """The last name of the path, with the number of a bead after it."""
        words = [*self.path]
        numbers: list[str] = []
        while len(words) > 1 and words[-1].isdigit():
            numbers.insert(0, words.pop())
        return "_".join([words[-1], *numbers])

    @property
    def long_name(self) -> str:
        """The path, as in the specification."""
        return ".".join(self.path)

    @property
    def dimension(self) -> str | None:
        """Dimension of the values, a key of `hertzchain.units.UNITS`, if it is known."""
        possible = self._dimensions
        # The unit of a stiffness depends on the exponent of the chain.
        return possible[0] if len(possible) == 1 and possible[0] not in ("", "stiffness") else None

    @property
    def _dimensions(self) -> list[str]:
        """What the values can be: an amplitude is a force or a length."""
        if self.path == ("method", "until"):
            return ["time"]
        return sorted(dimensions_of(self.path))

    @property
    def unit(self) -> str | None:
        """The unit that the specification gives, if it does."""
        return self.entry.get("unit") if isinstance(self.entry, Mapping) else None

    @cached_property
    def values(self) -> list[Any]:
        """All values, in SI units or scaled."""
        if not isinstance(self.entry, Mapping):
            return self._plain(_listed(self.entry))
        known = (*SPACINGS, "unit")
        for key in self.entry:
            if key not in known:
                raise unknown_name("key of an axis", key, known)
        given = [key for key in SPACINGS if key in self.entry]
        if len(given) != 1:
            raise InputError(f"needs one of {', '.join(SPACINGS)}, has {len(given)} of them")
        found = self.entry[given[0]]
        values = _listed(found) if given[0] == "list" else _spaced(given[0], found)
        if "unit" not in self.entry:
            return self._plain(values)
        numbers = (number(f"value {i}", each) for i, each in enumerate(values, start=1))
        return [self._in_si(repr(each), self.unit) for each in numbers]

    @property
    def has_units(self) -> bool:
        """Whether the values were given with units: such chains cannot be scaled."""
        if isinstance(self.entry, Mapping):
            return "unit" in self.entry or _all_quantities(self.entry.get("list", []))
        return _all_quantities(self.entry)

    def _plain(self, values: list[Any]) -> list[Any]:
        """Text with units, such as "5 mm", as numbers; other values as they are."""
        if not _all_quantities(values) or self._dimensions == [""]:
            return values
        return [self._in_si(*found) for each in values if (found := quantity(each))]

    def _in_si(self, number: str, unit: Any) -> float:
        """A number with a unit, in SI."""
        possible = [each for each in self._dimensions if each]
        if not possible:
            raise InputError(f"has the unit {shown(unit)}, but {self.long_name} takes none")
        if not isinstance(unit, str):
            raise InputError(f"has the unit {shown(unit)}, which must be text")
        for place, dimension in enumerate(possible, start=1):
            try:
                return converted(possible[0], number, unit, UNITS[dimension][0])
            except InputError:
                if place == len(possible):
                    raise
        raise AssertionError

    def coordinate(self) -> np.ndarray[Any, np.dtype[Any]]:
        """The values as an array for a dataset; what is no number or text is text as JSON.

        Examples
        --------
        >>> Axis(("beads",), [20, 40]).coordinate()
        array([20, 40])
        """
        kinds = {type(value) for value in self.values}
        if kinds <= {int, float}:
            return np.array(self.values)
        texts = [value if isinstance(value, str) else json.dumps(value) for value in self.values]
        return np.array(texts, dtype=np.dtypes.StringDType())

    def twice(self) -> Any | None:
        """A value that is there twice, if one is.

        Examples
        --------
        >>> Axis(("rate",), [0.1, 0.2, 0.1]).twice()
        0.1
        """
        seen: set[Any] = set()
        for value in self.values:
            key = json.dumps(value) if isinstance(value, list | dict) else value
            if key in seen:
                return value
            seen.add(key)
        return None


def flattened(table: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Paths and entries of nested tables of axes.

    Parameters
    ----------
    table : mapping
        Tables within tables; dotted keys are paths too.
    path : tuple of str
        Where the table is.

    Yields
    ------
    path : tuple of str
        Path of the parameter.
    entry : object
        Its values as specified.

    Examples
    --------
    >>> [*flattened({"loss": {"restitution": [0.8, 0.9]}, "radii.2": [1.0]})]
    [(('loss', 'restitution'), [0.8, 0.9]), (('radii', '2'), [1.0])]
    """
    for key, entry in table.items():
        place = (*path, *str(key).split("."))
        if isinstance(entry, Mapping) and not set(entry) & {*SPACINGS, "unit"}:
            yield from flattened(entry, place)
        else:
            yield place, entry


def _all_quantities(values: Any) -> bool:
    texts = isinstance(values, list) and all(isinstance(each, str) for each in values)
    return texts and bool(values) and all(quantity(each) for each in values)


def _listed(values: Any) -> list[Any]:
    """The values of a list, all of one type."""
    if not isinstance(values, list):
        raise InputError(f"must be a list of values or a table with linspace, got {shown(values)}")
    if len(values) > MOST_VALUES:
        raise InputError(f"has {len(values)} values, and at most {MOST_VALUES} can be")
    kinds = {float if type(each) is int else type(each) for each in values}
    if len(kinds) > 1:
        names = sorted(kind.__name__ for kind in kinds)
        raise InputError(f"has values of different types: {', '.join(names)}")
    return values


def _spaced(kind: str, given: Any) -> list[float]:
    if not isinstance(given, list) or len(given) != 3:
        raise InputError(f"{kind} must be [first, last, number of values], got {shown(given)}")
    first, last = (
        number(f"{kind}'s {what}", value, least=-LARGEST, most=LARGEST)
        for what, value in zip(("first", "last"), given[:2], strict=True)
    )
    count = whole_number(f"{kind}'s number of values", given[2], least=1, most=MOST_VALUES)
    if kind == "geomspace":
        if not first * last > 0.0:
            raise InputError(f"geomspace needs ends of one sign, got {first:g} and {last:g}")
        values = np.geomspace(first, last, count)
    else:
        values = np.linspace(first, last, count)
    # Whole numbers stay whole: beads, seeds.
    if np.all(values == np.round(values)) and np.abs(values).max() < 2**53:
        return [int(value) for value in values]
    return [first, *(_decimal(value) for value in values[1:-1]), last][:count]


def _decimal(value: float) -> float:
    """Without the last digit's rounding: 0.85, not 0.8500000000000001; so it can be looked up."""
    return float(f"{value:.15g}")
