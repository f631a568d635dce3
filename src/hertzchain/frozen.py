"""Objects that do not change: equality, read-only arrays in copies, and results that are kept."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any, ClassVar, TypeVar

import numpy as np

Given = TypeVar("Given")
Result = TypeVar("Result")


class ShortDir:
    """Omits attributes that only other modules of the package use from `dir` and completion.

    Private names are omitted, too: Python suggests names of `dir` for unknown attributes.
    """

    _omitted: ClassVar[tuple[str, ...]] = ()

    def __dir__(self) -> list[str]:
        names = (name for name in super().__dir__() if name not in self._omitted)
        return [name for name in names if name[:1] != "_" or name[:2] == "__"]


class ShortClassDir(type):
    """Omits these attributes from `dir` and completion of the class, too."""

    _omitted: ClassVar[tuple[str, ...]]

    def __dir__(cls) -> list[str]:
        return [name for name in super().__dir__() if name not in cls._omitted]


def without_defaults(cls: type[Given]) -> type[Given]:
    """Decorate a dataclass, so that the class itself has no attributes with defaults of fields.

    Otherwise, fields would be completed as if they were builders, and calling one would raise that
    `None` is not callable.
    """
    for each in dataclasses.fields(cls):  # type: ignore[arg-type]
        if each.name in vars(cls):
            delattr(cls, each.name)
    return cls


class Compared:
    """Dataclass with arrays, compared by its fields; NaN is equal to NaN.

    Decorate it with ``eq=False``, because tuples of arrays cannot be compared.
    """

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(other) is not type(self):
            return NotImplemented
        return all(
            _same(getattr(self, each.name), getattr(other, each.name))
            for each in dataclasses.fields(self)  # type: ignore[arg-type]
            if each.compare
        )

    def __hash__(self) -> int:
        # Arrays of these results can be written to: only their shapes are constant.
        values = [
            getattr(self, each.name)
            for each in dataclasses.fields(self)  # type: ignore[arg-type]
            if each.compare
        ]
        return hash(tuple(
            each.shape if isinstance(each, np.ndarray) else _number_of(each) for each in values
        ))  # fmt: skip


class Frozen(Compared, ShortDir):
    """Frozen dataclass with arrays: compared by its fields, and read-only also in copies.

    Decorate it with ``eq=False``, because tuples of arrays cannot be compared.  Copies and
    unpickled arrays of NumPy are writable, even if the original is read-only.  The radii of a
    copied chain could then be changed without changing its masses.
    """

    def __hash__(self) -> int:
        # Kept, because caches call it often; that of numbers is the same in all processes.
        if "_hash" not in self.__dict__:
            values = [
                getattr(self, each.name)
                for each in dataclasses.fields(self)  # type: ignore[arg-type]
                if each.compare
            ]
            self.__dict__["_hash"] = hash(tuple(map(_number_of, values)))
        found: int = self.__dict__["_hash"]
        return found

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
        self.__dict__.update(state)


def name_replace(cls: type[Given]) -> type[Given]:
    """Decorate a frozen dataclass, so that the error of an assignment names its ``replace``."""

    def rejected(self: Given, name: str, _: object) -> None:
        raise dataclasses.FrozenInstanceError(
            f"a {type(self).__name__} does not change: {name} cannot be assigned; replace returns "
            f"a changed copy: {type(self).__name__.lower()}.replace({name}=...)"
        )

    # The class itself must not define it: `dataclass` does.
    cls.__setattr__ = rejected  # type: ignore[assignment, method-assign]
    return cls


def _same(one: Any, other: Any) -> bool:
    """Whether two values of a field are equal; NaN is equal to NaN."""
    if one is other:
        return True
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        if not (isinstance(one, np.ndarray) and isinstance(other, np.ndarray)):
            return False
        return np.array_equal(one, other, equal_nan=one.dtype.kind in "fc")
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, tuple | list) and isinstance(other, tuple | list):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return one == other or (one != one and other != other)
    return bool(one == other)


def _number_of(value: Any) -> Any:
    """A number that is equal for equal values of a field."""
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in "biuf":
            return value.shape
        with np.errstate(all="ignore"):
            return value.shape, _number_of(float(np.nansum(value)))
    if isinstance(value, float):
        return 0.0 if math.isnan(value) else value
    return value if isinstance(value, int) else 0


def once(function: Callable[[Given], Result]) -> Callable[[Given], Result]:
    """Decorate a function of an object that does not change, so that the object keeps the result.

    As with the cached properties of a chain, copies and unpickled objects compute it again.
    """
    key = f"_{function.__module__}.{function.__qualname__}"

    @wraps(function)
    def kept(given: Given) -> Result:
        results = given.__dict__
        if key not in results:
            results[key] = function(given)
        found: Result = results[key]
        return found

    return kept
