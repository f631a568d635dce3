"""Options with which kernels are compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit
from numba.core.registry import CPUDispatcher

from . import compile_notice
from .deferred_code import deferring

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


class Internal(CPUDispatcher):
    """A compiled function that only other kernels can call."""

    def __call__(self, *arguments: object, **options: object) -> None:  # noqa: ARG002
        """Without a wrapper, numba would call address 0."""
        raise TypeError(
            f"{self.py_func.__name__} has no wrapper for Python; call it from a function compiled "
            "by numba.njit, or declare it as an entry point if Python has to call it"
        )


def internal(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Decorate a function that only kernels call.

    Conversion of its arguments from Python, many of which are tuples of arrays, would take a
    quarter of the time of compiling.
    """
    own = {"no_cpython_wrapper": True} | deferring()

    def decorate(function: Callable[..., Any]) -> Any:
        dispatcher: Any = njit(**(options | own))(function)
        # With NUMBA_DISABLE_JIT, it is the function itself.
        if isinstance(dispatcher, CPUDispatcher):
            dispatcher.__class__ = Internal
        return dispatcher

    return decorate


# For functions that Python calls, and for those that only kernels call.
entry_point = njit(**OPTIONS)
compiled = internal(**OPTIONS)
reduced = internal(**REDUCED)

compile_notice.install()


def uncompiled(function: Any) -> Any:
    """The Python function, for a single call that takes less time than compiling it."""
    return getattr(function, "py_func", function)
