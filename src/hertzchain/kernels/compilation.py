"""Options with which kernels are compiled."""

from __future__ import annotations

from typing import Any

from numba import njit, types

from . import compile_notice

# Before it compiles a function, numba removes the branches of ``x is None`` that an argument x of
# this type cannot take, but only if x is None or its type has this attribute, which by default are
# the types of literals.  A tuple, an array or a truth value is never None, either.
NEVER_NONE: tuple[Any, ...] = (types.BaseTuple, types.Array, types.Boolean)
for each in NEVER_NONE:
    each.literal_type = property(lambda self: self)

# Reference counting is off (`_nrt`): it would take as long as the forces.
OPTIONS: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}
# Fused multiply-add is allowed.
CONTRACTED: dict[str, Any] = OPTIONS | {"fastmath": {"contract"}}

compiled = njit(**OPTIONS)

compile_notice.install()


def uncompiled(function: Any) -> Any:
    """The function as Python runs it, for a single call that is not worth compiling."""
    return getattr(function, "py_func", function)
