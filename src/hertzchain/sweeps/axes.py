"""Axes of a sweep: the parameters that vary and their values."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..errors import InputError, short_repr, unknown_name_error
from ..representation import counted, short
from ..store.schema_paths import dimensions_of, is_count, is_fraction, is_place, names_beside
from ..units import PERCENT, UNITS, converted, quantity, unit_of_stiffness
from ..validation.json_types import to_json_types
from ..validation.keywords import FIELD_ALIASES
from ..validation.numbers import FRACTION, has_unit, number, whole_hint, whole_number

if TYPE_CHECKING:
    from ..chain.chain import Chain

SPACINGS: Final = ("list", "linspace", "geomspace")
# Largest first or last value of a linspace: their difference must be finite, too.
MAX_END: Final = 1e300
# Largest numbers of values of one axis, and of points in every combination of values.
MAX_VALUES: Final = 10_000_000
MAX_COMBINATIONS: Final = 10**10


@dataclass(frozen=True, eq=False)
class Axis:
    """One parameter and the values that it takes.

    Attributes
    ----------
    path : tuple of str
        Its place in the specification: ``("rate",)`` is a key of ``[chain]``,
        ``("loss", "coefficient")`` a key of ``[chain.loss]``, ``("radii", "5")`` the radius of
        bead 5, ``("radii", "10-20")`` the common radius of beads 10 to 20, ``("method", "rtol")``
        an option of the simulation.
    entry : mapping or sequence
        Values as specified: a list, or ``{"linspace": [first, last, number]}``, or the same with
        ``"geomspace"``; with ``"unit"`` if they are neither scaled nor in SI units.  The first and
        last value may be text with the same unit.
    exponent : float or None
        Exponent p of the contact of an axis of stiffness, whose unit is N/m^p; `None` if it is
        unknown, as when it varies, too.

    Raises
    ------
    InputError
        If the entry is neither a list nor such a table, or has no values.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.sweeps.axes import Axis
    >>> axis = Axis(("rate",), {"linspace": [0.02, 0.1, 5]})
    >>> [round(value, 2) for value in axis.values], axis.name
    ([0.02, 0.04, 0.06, 0.08, 0.1], 'rate')
    >>> Axis(("radius",), {"list": [5, 10], "unit": "mm"}).values
    [0.005, 0.01]
    """

    path: tuple[str, ...]
    entry: Mapping[str, Any] | Sequence[Any]
    exponent: float | None = None

    def __repr__(self) -> str:
        ends = repr(self.values[0])
        if len(self) > 1:
            ends += f" .. {self.values[-1]!r}"
        return short("Axis", self.long_name, counted(len(self), "value"), ends)

    def __post_init__(self) -> None:
        object.__setattr__(self, "entry", _with_unit(to_json_types(self.entry)))
        if not self.values:
            raise InputError("has no values")
        if is_count(self.path):
            _check_whole(self.values)

    def __len__(self) -> int:
        return len(self.values)

    @property
    def name(self) -> str:
        """The last name of the path, followed by the number of a bead, or those of a range."""
        words = [*self.path]
        numbers: list[str] = []
        while len(words) > 1 and is_place(words[-1]):
            numbers.insert(0, words.pop().replace("-", "_"))
        return "_".join([words[-1], *numbers])

    @property
    def long_name(self) -> str:
        """The path, as in the specification."""
        return ".".join(self.path)

    @property
    def si_unit(self) -> str | None:
        """SI unit of values without a unit; `None` if it is not unique."""
        possible = self._dimensions
        if possible == ["stiffness"] and self.exponent is None:
            return None
        return self._si_unit(possible[0]) if len(possible) == 1 and possible[0] else None

    def _si_unit(self, dimension: str) -> str:
        """SI unit of a dimension, a key of `hertzchain.units.UNITS`."""
        if dimension == "stiffness" and self.exponent is not None:
            return unit_of_stiffness(self.exponent)
        return UNITS[dimension][0]

    @property
    def _dimensions(self) -> list[str]:
        """Possible dimensions of the values: an amplitude is a force or a length."""
        if self.path == ("method", "until"):
            return ["time"]
        return sorted(dimensions_of(self.path))

    @cached_property
    def unit(self) -> Any:
        """The unit of all values as specified; `None` if there is none, or if they have several."""
        if isinstance(self.entry, Mapping) and "unit" in self.entry:
            return self.entry["unit"]
        found = [self._quantity(each) for each in self._given]
        units = {each[1] for each in found if each is not None}
        return units.pop() if None not in found and len(units) == 1 else None

    @cached_property
    def values(self) -> list[Any]:
        """All values, in SI units or scaled."""
        if isinstance(self.entry, Mapping) and "unit" in self.entry:
            return [self._in_si(repr(each), self.unit) for each in self.typed]
        return self._plain(self._given)

    @property
    def typed(self) -> list[Any]:
        """All values in the unit of the specification, or in SI units if they have several."""
        if self.unit is None:
            return self.values
        if isinstance(self.entry, Mapping) and "unit" in self.entry:
            return [number(f"value {i}", each) for i, each in enumerate(self._given, start=1)]
        return [float(found[0]) for each in self._given if (found := self._quantity(each))]

    @cached_property
    def _given(self) -> list[Any]:
        """All values as specified, numbers or text."""
        if not isinstance(self.entry, Mapping):
            return _checked_list(self.entry)
        known = (*SPACINGS, "unit")
        for key in self.entry:
            if key not in known:
                raise unknown_name_error("key of an axis", key, known)
        given = [key for key in SPACINGS if key in self.entry]
        if len(given) != 1:
            raise InputError(f"must have one of {', '.join(SPACINGS)}, has {len(given)} of them")
        found = self.entry[given[0]]
        return _checked_list(found) if given[0] == "list" else _spaced(given[0], found)

    def _quantity(self, value: Any) -> tuple[str, str] | None:
        """Number and unit of text such as "5 mm" or "5%", if the parameter takes such a unit."""
        found = quantity(value) if isinstance(value, str) else None
        takes = self._is_fraction if found and found[1] == PERCENT else self._dimensions != [""]
        return found if takes else None

    @property
    def _is_fraction(self) -> bool:
        return is_fraction(self.path)

    @property
    def has_units(self) -> bool:
        """Whether the values have units; the chains are then in SI units."""
        if isinstance(self.entry, Mapping):
            listed = self.entry.get("list", [])
            return self.entry.get("unit", PERCENT) != PERCENT or _all_quantities(listed)
        return _all_quantities(self.entry)

    def _plain(self, values: list[Any]) -> list[Any]:
        """Convert text with units, such as "5 mm", to numbers; keep other values."""
        found = [self._quantity(each) for each in values]
        if None in found:
            return values
        return [self._in_si(*each) for each in found if each is not None]

    def _in_si(self, number: str, unit: Any) -> float:
        """Convert a number with a unit to SI units."""
        if unit == PERCENT and self._is_fraction:
            return converted(self.long_name, number, unit, FRACTION)
        possible = [each for each in self._dimensions if each]
        if not possible:
            if known := names_beside(self.path):
                raise unknown_name_error(f"key of [chain.{self.path[0]}]", self.path[-1], known)
            raise InputError(f"has the unit {short_repr(unit)}, but {self.long_name} takes none")
        if not isinstance(unit, str):
            raise InputError(f"has the unit {short_repr(unit)}, which must be text")
        for place, dimension in enumerate(possible, start=1):
            try:
                return converted(possible[0], number, unit, self._si_unit(dimension))
            except InputError:
                if place == len(possible):
                    raise
        raise AssertionError

    def coordinate(self) -> np.ndarray[Any, np.dtype[Any]]:
        """Values as an array for a dataset, in the unit of the specification.

        Lists and tables become JSON text.

        Examples
        --------
        >>> import hertzchain as hc
        >>> from hertzchain.sweeps.axes import Axis
        >>> Axis(("beads",), [20, 40]).coordinate()
        array([20, 40])
        >>> Axis(("radius",), ["4 mm", "5 mm"]).coordinate()
        array([4., 5.])
        """
        values = self.typed
        if {type(value) for value in values} <= {int, float}:
            return np.array(values, None if self.unit is None else float)
        texts = [value if isinstance(value, str) else json.dumps(value) for value in values]
        return np.array(texts, dtype=np.dtypes.StringDType())

    def duplicate(self) -> Any | None:
        """Find a value that occurs twice.

        Returns
        -------
        value or None
            The first value that equals an earlier one.

        Examples
        --------
        >>> import hertzchain as hc
        >>> from hertzchain.sweeps.axes import Axis
        >>> Axis(("rate",), [0.1, 0.2, 0.1]).duplicate()
        0.1
        """
        seen: set[Any] = set()
        for value in self.values:
            key = json.dumps(value) if isinstance(value, list | dict) else value
            if key in seen:
                return value
            seen.add(key)
        return None


def path_of(name: Any) -> tuple[str, ...]:
    """Path of a parameter from its name with dots."""
    return tuple(FIELD_ALIASES.get(str(name), str(name)).split("."))


def flattened(table: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path and the entry of each axis in nested tables."""
    for key, entry in table.items():
        place = (*path, *str(key).split(".")) if path else path_of(key)
        if isinstance(entry, Mapping) and not set(entry) & {*SPACINGS, "unit"}:
            yield from flattened(entry, place)
        else:
            yield place, entry


def conflicts(paths: Sequence[tuple[str, ...]]) -> list[str]:
    """Find axes that would replace a value that an earlier axis has set."""
    return [
        f"axes.{'.'.join(path)}: would undo axes.{'.'.join(earlier)}: remove one of them, or put "
        "this one first"
        for place, path in enumerate(paths)
        for earlier in paths[:place]
        if _undoes(path, earlier)
    ]


def _undoes(path: tuple[str, ...], earlier: tuple[str, ...]) -> bool:
    """Whether a path leads to the same items as an earlier one, or to a table that has these.

    Some of the items of an earlier range, such as bead 40 of 39-41, may be changed again.
    """
    both = [*zip(path, earlier, strict=False)]
    if len(path) > len(earlier) or not all(
        a == b or (is_place(a) and is_place(b) and not _items(a).isdisjoint(_items(b)))
        for a, b in both
    ):
        return False
    return not any(is_place(a) and is_place(b) and _items(a) < _items(b) for a, b in both)


def _items(word: str) -> set[int]:
    first, _, last = word.partition("-")
    return {*range(int(first), int(last or first) + 1)}


def second_strikers(paths: Iterable[tuple[str, ...]], chain: Chain | None) -> list[str]:
    """Find axes that would add a striker to a given chain that has one."""
    return [
        f"axes.{'.'.join(path)}: would add a further striker, because the given chain has one "
        "already: give the chain as a table with 'struck_by' or, in SI units, vary 'velocity'"
        for path in paths
        if path[0] == "struck_by" and chain is not None and chain.strikers
    ]


def fixed_by_others(paths: Iterable[tuple[str, ...]], chain: Chain | None) -> list[str]:
    """Find axes of single masses or contacts that would fix those of all beads, as radii vary."""
    each = list(paths)
    sizes = [".".join(path) for path in each if path[0] in ("radii", "diameters")]
    return [
        f"axes.{'.'.join(path)}: would fix the {path[0]} of the whole chain, which then would not "
        f"follow axes.{sizes[0]}: vary one of them"
        for path in each
        if path[0] in ("masses", "stiffness") and len(path) > 1 and sizes
        if chain is not None and path[0] not in chain.given
    ]


def unequal_lengths(axes: Sequence[Axis]) -> list[str]:
    """Find out whether axes that vary together have different numbers of values."""
    if len({len(axis) for axis in axes}) < 2:
        return []
    lengths = ", ".join(f"{axis.long_name} has {len(axis)}" for axis in axes)
    return [f"axes: zip needs axes of the same length, but {lengths} values"]


def too_many_points(entries: Mapping[tuple[str, ...], Any]) -> list[str]:
    """Find out whether all combinations are too many, without making the values."""
    sizes = {".".join(path): _size(entry) for path, entry in entries.items()}
    points = prod(sizes.values())
    if points <= MAX_COMBINATIONS:
        return []
    lengths = " x ".join(f"{size} ({name})" for name, size in sizes.items() if size > 1)
    return [
        f"axes: every combination of values gives {points} points, {lengths}; at most "
        f"{MAX_COMBINATIONS} are allowed: use fewer values, or combine = 'zip'"
    ]


def _size(entry: Any) -> int:
    """Number of values of an entry; 1 of an invalid one, which is reported later."""
    if not isinstance(entry, Mapping):
        return max(1, len(entry)) if isinstance(entry, Sequence) else 1
    for key in ("linspace", "geomspace"):
        match entry.get(key):
            case [_, _, int(count)] if 0 < count <= MAX_VALUES:
                return count
    return _size(entry["list"]) if "list" in entry else 1


def duplicates(axes: Sequence[Axis]) -> list[str]:
    """Find axes on which a value occurs twice."""
    found = ((axis.long_name, axis.duplicate()) for axis in axes)
    return [f"axes.{name}: has the value {value!r} twice" for name, value in found
            if value is not None]  # fmt: skip


def _all_quantities(values: Any) -> bool:
    texts = isinstance(values, list) and all(isinstance(each, str) for each in values)
    return texts and bool(values) and all(has_unit(each) for each in values)


def _with_unit(entry: Any) -> Any:
    """Write ``{linspace = ["1 mm", "2 mm", 5]}`` as ``{linspace = [1, 2, 5], unit = "mm"}``."""
    spaced = entry if isinstance(entry, Mapping) and "unit" not in entry else {}
    kind = next((kind for kind in SPACINGS[1:] if isinstance(spaced.get(kind), list)), None)
    if kind is None:
        return entry
    found = [quantity(end) for end in spaced[kind][:2] if isinstance(end, str)]
    ends = [end for end in found if end is not None]
    if len(ends) < 2:
        return entry
    (first, unit), (last, other) = ends
    if unit != other:
        raise InputError(f"{kind}'s first and last must have the same unit, got {unit} and {other}")
    return {
        **entry,
        kind: [_plain_number(first), _plain_number(last), *spaced[kind][2:]],
        "unit": unit,
    }


def _plain_number(digits: str) -> float:
    value = float(digits)
    return int(value) if value == round(value) and abs(value) < 2**53 else value


def _checked_list(values: Any) -> list[Any]:
    """Check that the values are a list of one type."""
    if not isinstance(values, list):
        raise InputError(
            f"must be a list of values or a table with linspace, got {short_repr(values)}"
        )
    if len(values) > MAX_VALUES:
        raise InputError(f"has {len(values)} values; at most {MAX_VALUES} are allowed")
    kinds = {float if type(each) is int else type(each) for each in values}
    if len(kinds) > 1:
        names = sorted(kind.__name__ for kind in kinds)
        raise InputError(
            f"has values of different types: {', '.join(names)}{_linspace_hint(values)}"
        )
    return values


def _linspace_hint(values: list[Any]) -> str:
    """Advice for a list that is probably the first value, the last value and their number."""
    match values:
        case [str(first), str(last), int(_)] if has_unit(first) and has_unit(last):
            return f"; for evenly spaced values, give {{linspace = {json.dumps(values)}}}"
    return ""


def _spaced(kind: str, given: Any) -> list[float]:
    if not isinstance(given, list) or len(given) != 3:
        raise InputError(f"{kind} must be [first, last, number of values], got {short_repr(given)}")
    first, last = (
        number(f"{kind}'s {what}", value, least=-MAX_END, most=MAX_END)
        for what, value in zip(("first", "last"), given[:2], strict=True)
    )
    count = whole_number(f"{kind}'s number of values", given[2], least=1, most=MAX_VALUES)
    if kind == "geomspace":
        if not first * last > 0.0:
            raise InputError(
                f"geomspace needs first and last of the same sign, got {first:g} and {last:g}"
            )
        values = np.geomspace(first, last, count)
    else:
        values = np.linspace(first, last, count)
    # Numbers of beads and seeds must stay whole numbers.
    if np.all(values == np.round(values)) and np.abs(values).max() < 2**53:
        return [int(value) for value in values]
    return [first, *(_decimal(value) for value in values[1:-1]), last][:count]


def _check_whole(values: Sequence[Any]) -> None:
    """Raise `InputError` for the first value between whole numbers, or else the first float."""
    floats = [i for i, value in enumerate(values) if isinstance(value, float)]
    if floats:
        i = next((i for i in floats if not values[i].is_integer()), floats[0])
        raise InputError(
            f"value {i + 1} must be a whole number, got {values[i]!r}{whole_hint(values[i])}"
        )


def _decimal(value: float) -> float:
    """Round to 15 digits: users select 0.85 and not 0.8500000000000001."""
    return float(f"{value:.15g}")
