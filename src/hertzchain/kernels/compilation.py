"""Options with which kernels are compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit
from numba.extending import overload

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
# Functions that only kernels call need no function that converts their arguments from Python,
# which would take a fifth of the time of compiling.
INTERNAL: Any = OPTIONS | {"no_cpython_wrapper": True}

# Fused multiply-add is allowed.
CONTRACTED: dict[str, Any] = OPTIONS | {"fastmath": {"contract"}}

# Sums and maxima may be evaluated in any order, so that the compiler can vectorise their loops.
REDUCED: dict[str, Any] = OPTIONS | {"fastmath": {"contract", "reassoc", "nnan", "nsz"}}

compiled = njit(**OPTIONS)


def for_kernels(**options: Any) -> Callable[[Any], Any]:
    """Decorator of functions that only kernels call; Python runs them uncompiled."""
    used: Any = options | {"no_cpython_wrapper": True}

    def decorate(function: Any) -> Any:
        # A function that is inlined is compiled for each value of a literal argument.
        literal = options.get("forceinline", False)
        overload(function, jit_options=used, strict=False, prefer_literal=literal)(
            lambda *_: function
        )
        return function

    return decorate


internal = for_kernels(**OPTIONS)
reduced = for_kernels(**REDUCED)

compile_notice.install()
