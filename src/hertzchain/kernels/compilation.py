"""How functions here are compiled."""

from __future__ import annotations

from typing import Any

from numba import njit

# References to arrays are not counted (`_nrt`): that would cost as much as the forces do.
OPTIONS: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}
# Products may be added without rounding in between.
CONTRACTED: dict[str, Any] = OPTIONS | {"fastmath": {"contract"}}

compiled = njit(**OPTIONS)


def uncompiled(function: Any) -> Any:
    """The function as Python runs it, for a single call that is not worth compiling."""
    return getattr(function, "py_func", function)
