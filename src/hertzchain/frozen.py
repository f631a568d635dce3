"""Objects that do not change: read-only arrays, also in copies, and results that are kept."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, ClassVar, TypeVar

import numpy as np

Given = TypeVar("Given")
Result = TypeVar("Result")


class ShortDir:
    """Omits attributes that only other modules of the package use from `dir` and completion."""

    _omitted: ClassVar[tuple[str, ...]] = ()

    def __dir__(self) -> list[str]:
        return [name for name in super().__dir__() if name not in self._omitted]


class Frozen(ShortDir):
    """Keeps the arrays of a frozen dataclass read-only in copies and after unpickling.

    Copies and unpickled arrays of NumPy are writable, even if the original is read-only.  The
    radii of a copied chain could then be changed without changing its masses.
    """

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
        self.__dict__.update(state)


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
