"""Check of the values of a column of a pulse."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..collision import Array
from ..errors import InputError
from ..validation.numbers import real_numbers
from .quantities import Quantity

if TYPE_CHECKING:
    from .pulse import Pulse


def checked_column(pulse: Pulse, quantity: Quantity, given: ArrayLike) -> Array:
    """Read-only copy of a column, whose values are allowed or explained by a note."""
    name, place = quantity.name, quantity.per
    plain = type(given) is np.ndarray and given.dtype == float
    values = (given if plain else real_numbers(name, given, place)).copy()  # type: ignore[union-attr]
    length = quantity.count(pulse.chain.beads)
    if values.shape != (length,):
        raise InputError(f"{name} of a pulse must have shape ({length},), got {values.shape}")
    good = np.isfinite(values)
    if quantity.values == "nonzero":
        good &= values != 0.0
    elif quantity.values != "finite":
        # Strikers have their velocity from the start.
        first = max(1, pulse.chain.strikers) if quantity.values != "positive" else 0
        good[first:] &= values[first:] > 0.0
    if name in pulse.notes:
        good |= np.isnan(values)
    if not good.all():
        k = int(np.argmin(good))
        allowed = {"nonzero": "finite and not 0", "finite": "finite"}
        raise InputError(
            f"{name} of {place} {k + 1} is {values[k]:g} by {pulse.method} for the chain "
            f"{pulse.chain.description}: it must be "
            f"{allowed.get(quantity.values, 'positive and finite')}; if it underflows or "
            "overflows, use fewer beads or a weaker taper"
        )
    values.setflags(write=False)
    return values
