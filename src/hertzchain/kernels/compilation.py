"""Options with which kernels are compiled."""

from __future__ import annotations

from typing import Any

from numba import njit

from . import compile_notice

# Reference counting is off (`_nrt`): it would take as long as the forces. No kernel is called
# from C.
OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
    "_nrt": False,
}
# Fused multiply-add is allowed.
CONTRACTED: dict[str, Any] = OPTIONS | {"fastmath": {"contract"}}

# Sums and maxima may be evaluated in any order, so that the compiler can vectorise their loops.
REDUCED: dict[str, Any] = OPTIONS | {"fastmath": {"contract", "reassoc", "nnan", "nsz"}}

compiled = njit(**OPTIONS)
reduced = njit(**REDUCED)

compile_notice.install()


def uncompiled(function: Any) -> Any:
    """The Python function, for a single call that takes less time than compiling it."""
    return getattr(function, "py_func", function)
