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
# Fused multiply-add is allowed.
CONTRACTED: dict[str, Any] = OPTIONS | {"fastmath": {"contract"}}

# Sums and maxima may be evaluated in any order, so that the compiler can vectorise their loops.
REDUCED: dict[str, Any] = OPTIONS | {"fastmath": {"contract", "reassoc", "nnan", "nsz"}}

compiled = njit(**OPTIONS)


def for_kernels(**options: Any) -> Callable[[Any], Any]:
    """Decorator of functions that only kernels call.

    In Python they are not compiled.  Numba compiles them with their callers, without the function
    that would convert arguments from Python, which takes a fifth of the time of compiling.
    """

    def decorate(function: Any) -> Any:
        # A function that is inlined is compiled for each value of a literal argument.
        overload(
            function,
            jit_options=options | {"no_cpython_wrapper": True},
            strict=False,
            prefer_literal=options.get("forceinline", False),
        )(lambda *_: function)
        return function

    return decorate


internal = for_kernels(**OPTIONS)
reduced = for_kernels(**REDUCED)

compile_notice.install()


def uncompiled(function: Any) -> Any:
    """The Python function, for a single call that takes less time than compiling it."""
    return getattr(function, "py_func", function)
