"""Check the times at which a run saves its state."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, short_repr
from ..validation.memory import check_memory
from ..validation.numbers import real_numbers


def checked_times(chain: Chain, times: ArrayLike, begin: float, until: float | None) -> Array:
    """Check increasing times between the start and the end of a run."""
    values = increasing_times(chain, times, "a whole number or a list of increasing numbers")
    check_memory_for(chain, values.size)
    if values[0] < begin:
        raise InputError(
            f"the run resumes from time {begin:g}, but the first time to save at is {values[0]:g}"
        )
    if until is not None and values[-1] > until:
        raise InputError(
            f"the last time to save at is {values[-1]:g}, but the run stops at until = {until:g}"
        )
    return values


def increasing_times(
    chain: Chain, times: ArrayLike, expected: str = "a list of increasing numbers"
) -> Array:
    """Check that times are finite, increasing and not negative."""
    one = isinstance(times, str | bool | float | None)
    if (
        one
        or (values := real_numbers("time", times, unit=chain._unit("s"))).ndim != 1
        or not values.size
    ):
        raise InputError(f"times must be {expected}, got {short_repr(times)}")
    good = np.isfinite(values) & (np.diff(values, prepend=-np.inf) > 0.0) & (values >= 0.0)
    if not good.all():
        bad = int(np.argmin(good))
        raise InputError(
            f"times must be finite, increasing and not negative, but time {bad + 1} is "
            f"{values[bad]:g}"
        )
    return values


def check_memory_for(chain: Chain, frames: int) -> None:
    """Raise `InputError` if the states at the saved times do not fit in memory."""
    # Positions and velocities, 8 bytes each, and a second copy while they are combined.
    check_memory(
        f"{frames} saved times of {chain.beads} beads", frames * chain.beads * 2 * 8 * 2,
        "save fewer times",
    )  # fmt: skip
