"""Choice of the integration method of a chain, and of the next step.

Each method is a module with functions `begin`, `take_step`, `interpolate` and `forces_within`:
`hertzchain.kernels.nystrom` if forces depend on positions and time only, otherwise
`hertzchain.kernels.dop853_step` or, if damping is stiff, `hertzchain.kernels.implicit`.  A step
writes derivatives of the state into rows of ``stages``: the one at the start into row 0, the one at
the end into row `STEP_STAGES`, and those in between into the rows from `first_row` on.

In compiled code the method is chosen when the caller is compiled, so that only this method has to
be compiled.
"""

from __future__ import annotations

from typing import Any

from numba import types
from numba.extending import overload

from . import dop853_step, implicit, nystrom
from .active_beads import WITHOUT_CACHE
from .compilation import compiled
from .forces import Contacts

# Choice of the next step from the error: exponents, safety factor, and bounds of the change.
EXPLICIT_ORDER, IMPLICIT_ORDER = -0.125, -1.0 / 6.0
SAFETY, SHRINKAGE, GROWTH = 0.9, 0.2, 10.0


def method_of(contacts: Any) -> Any:
    """The module of the method, from the contacts of a chain or from their numba type."""
    if contacts is None or isinstance(contacts, types.NoneType):
        return nystrom
    if isinstance(contacts, types.NamedTuple):
        contacts = Contacts(*contacts.types)
    if not isinstance(contacts.implicit, types.NoneType | None):
        return implicit
    return dop853_step if isinstance(contacts.on_positions, types.NoneType | None) else nystrom


def _of_method(name: str, place: int) -> Any:
    """Function ``name`` of the method; ``place`` is the index of the argument ``contacts``."""

    def function(*arguments: Any) -> Any:
        return getattr(method_of(arguments[place]), name)(*arguments)

    def implementation(*arguments: Any) -> Any:
        return getattr(method_of(arguments[place]), name).py_func

    overload(function, jit_options=WITHOUT_CACHE, strict=False)(implementation)
    return function


begin = _of_method("begin", 4)
take_step = _of_method("take_step", 4)
interpolate = _of_method("interpolate", 5)
forces_within = _of_method("forces_within", 5)


@compiled
def is_implicit(setup, contacts):
    """Whether the steps of this chain are implicit."""
    if contacts is not None:
        return setup.law.implicit
    return False


@compiled
def on_positions(contacts):
    """Whether forces depend on positions and time only."""
    if contacts is None:
        return True
    return contacts.on_positions is not None


@compiled
def first_row(contacts):
    """The first row of ``stages``, after row 0, that a step writes."""
    return nystrom.FIRST_ROW if on_positions(contacts) else 1


@compiled
def change_of_step(error, implicit):
    """Factor from the length of this step to that of the next."""
    if error == 0.0:
        return GROWTH
    order = IMPLICIT_ORDER if implicit else EXPLICIT_ORDER
    return min(GROWTH, max(SHRINKAGE, SAFETY * error**order))
