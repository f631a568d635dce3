"""One quantity with a known value, and runs that several of them share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, Literal, TypeVar

Origin = Literal["derived", "computed", "recalled", "abstract"]
# How an expected value was obtained; printed below the table.
ORIGINS: Final[dict[Origin, str]] = {
    "derived": "closed form or limit, derived again for this list",
    "computed": "by other code: SciPy's DOP853 at rtol 1e-13, or the fixed point of the wave",
    "recalled": "published, recalled from memory: the full text was not at hand",
    "abstract": "stated in the abstract; the full text was not at hand",
}


@dataclass(frozen=True)
class Case:
    """One quantity with a known value.

    Attributes
    ----------
    group, name : str
        What it is.
    expected : float
        The known value.
    tolerance : float
        How far from it a result may be: half of the last known digit, or the known error of
        the approximation that the value is from.
    source : str
        Where the value is from, and what is known of its error.
    compute : callable
        Our value.
    origin : str
        How the value was obtained: a key of ``ORIGINS``.
    """

    group: str
    name: str
    expected: float
    tolerance: float
    source: str
    compute: Callable[[], float]
    origin: Origin = "derived"


F = TypeVar("F", bound=Callable[..., Any])
_SHARED: Final[list[Any]] = []


def shared(function: F) -> F:
    """Keep what a function returns until `forget_shared` is called.

    Parameters
    ----------
    function : callable
        A function of hashable arguments.

    Returns
    -------
    callable

    Examples
    --------
    >>> shared(lambda beads: [beads])(3)
    [3]
    """
    cached = cache(function)
    _SHARED.append(cached)
    return cached  # type: ignore[return-value]


def forget_shared() -> None:
    """Free the memory of everything that is shared.

    Examples
    --------
    >>> forget_shared()
    """
    for cached in _SHARED:
        cached.cache_clear()
