"""Find the small beads between large ones, and warn where theories of such chains do not hold."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..collision import Array
from ..errors import ModelRangeWarning, warn_user

# A bead is small if its radius is below this fraction of the large radii on both sides.
SMALL: Final = 0.8
# Relative error of the spacing over the change of the radius per large bead where radii shrink and
# grow, from simulations of exponential tapers with q from 0.01 to 0.05 and ratios 0.3 to 0.5.
ERROR_PER_CHANGE: Final = (1.0, 0.8)
# Estimated error above which there is a warning, and contacts of a pulse, over which it is a mean.
MAX_ERROR, PULSE_CONTACTS = 0.02, 5


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


def warn_if_steep(masses: Array) -> None:
    """Warn if the sizes of the large beads change too fast for the time of a solitary wave."""
    # The beads at the ends have only half the share of the small beads.
    change = np.diff(np.log(masses[1:-1])) / 3.0
    if not len(change):
        return
    width = min(PULSE_CONTACTS, len(change))
    change = np.convolve(change, np.full(width, 1.0 / width), "valid")
    shrinking, growing = ERROR_PER_CHANGE
    error = np.where(change < 0.0, shrinking, growing) * np.abs(change)
    if error.max() > MAX_ERROR:
        warn_user(
            f"the times from large bead to large bead have an estimated error of {error.max():.1%},"
            f" because the radii of the large beads change by up to {np.abs(change).max():.1%} per "
            "bead, and the times are those of the solitary wave in equal beads; use propagate or "
            "simulate with the decorated chain",
            ModelRangeWarning,
        )
