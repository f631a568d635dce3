"""Calls of functions that are compiled without a wrapper for Python."""

from numba import njit


def callable_from_python(function):
    """A compiled function that passes its arguments on."""

    @njit
    def call(*arguments):
        return function(*arguments)

    return call
