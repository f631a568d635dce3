"""A quantity with a known value, and a cache for runs that several quantities share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, Literal, TypeVar

from ..representation import short

Origin = Literal["derived", "computed", "recalled", "abstract"]
# Origins of expected values, printed below the table.
ORIGINS: Final[dict[Origin, str]] = {
    "derived": "closed form or limit, derived independently for this list",
    "computed": "by other code: SciPy's DOP853 at rtol 1e-13, or iteration of the wave equation",
    "recalled": "published, recalled from memory without access to the full text",
    "abstract": "stated in the abstract, without access to the full text",
}
# Source of values that other code computed.
TWO_INTEGRATIONS: Final = "two integrations"
# Largest contact force of the pulse that an impact with velocity 1 creates in equal beads.
PULSE_FORCE: Final = 0.6395542321


@dataclass(frozen=True)
class Case:
    """A quantity with a known value.

    Attributes
    ----------
    group, name : str
        Group and name of the quantity.
    expected : float
        Known value.
    tolerance : float
        Largest difference that counts as agreement: half of the last known digit, or the known
        error of the approximation from which the value is derived.
    source : str
        Source of the value, and its known error.
    compute : callable
        Function that computes the value with hertzchain.
    origin : str
        Origin of the value, a key of ``ORIGINS``.
    """

    group: str
    name: str
    expected: float
    tolerance: float
    source: str
    compute: Callable[[], float]
    origin: Origin = "derived"

    def __repr__(self) -> str:
        known = f"{self.expected:.10g} within {self.tolerance:.2g}"
        return short("Case", f"{self.group}, {self.name}", known, self.origin)


F = TypeVar("F", bound=Callable[..., Any])
_SHARED: Final[list[Any]] = []


def shared(function: F) -> F:
    """Cache the result of a function until `forget_shared` is called."""
    cached = cache(function)
    _SHARED.append(cached)
    return cached  # type: ignore[return-value]


def forget_shared() -> None:
    """Clear the caches of all `shared` functions."""
    for cached in _SHARED:
        cached.cache_clear()
