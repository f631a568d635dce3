"""Results that are computed once per chain."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

from ..chain.chain import Chain

Result = TypeVar("Result")


def per_chain(function: Callable[[Chain], Result]) -> Callable[[Chain], Result]:
    """Decorate a function of a chain, which never changes, so that the chain keeps the result.

    As with the cached properties of a chain, copies and pickled chains compute it again.
    """
    key = f"_{function.__module__}.{function.__qualname__}"

    @wraps(function)
    def kept(chain: Chain) -> Result:
        results = chain.__dict__
        if key not in results:
            results[key] = function(chain)
        found: Result = results[key]
        return found

    return kept
