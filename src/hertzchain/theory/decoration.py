"""Find the small beads between large ones."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..collision import Array
from ..errors import ModelRangeWarning, warn_user

# A bead is small if its radius is below this fraction of the large radii on both sides.
SMALL: Final = 0.8


def small_beads(radii: Array) -> NDArray[np.bool_]:
    """Find runs of beads that are smaller than both neighbours by a factor of more than 1/0.8."""
    small: NDArray[Any] = np.zeros(len(radii), dtype=bool)
    falls = np.flatnonzero(radii[1:] < SMALL * radii[:-1])
    rises = radii[1:] * SMALL > radii[:-1]
    end = 0
    for large in falls:
        if large < end or not rises[large + 1 :].any():
            continue
        found = _run_end(radii, int(large) + 1)
        if found is not None:
            end = found
            small[large + 1 : end] = True
    return small


def _run_end(radii: Array, first: int) -> int | None:
    """First bead that is larger than all from the given one on."""
    # The search is extended step by step, since runs are short.
    ahead = 8
    while True:
        part = radii[first : first + ahead]
        larger = np.flatnonzero(part[1:] * SMALL > np.maximum.accumulate(part[:-1]))
        if len(larger):
            return first + 1 + int(larger[0])
        if first + ahead >= len(radii):
            return None
        ahead *= 4


def warn_if_decorated(chain: Chain, theory: str) -> bool:
    """Warn that a theory of single collisions does not apply to a decorated chain, if it is one."""
    small = small_beads(chain.radii)
    if small.any():
        warn_user(
            f"{theory} assumes one collision at a time, but bead {int(np.argmax(small)) + 1} is "
            "small, between large beads, and collides many times; use effective_chain for times "
            "(its velocities are too large by about half), propagate, or a chain without radii "
            f"below {SMALL:g} of those on both sides",
            ModelRangeWarning,
        )
    return bool(small.any())
