"""Rules for complete peaks on walls, which `hertzchain.simulation.wall_watch` states.

This module does not import numba, so that Python and compiled code share it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .state_layout import (
    IMPACT_END,
    IMPACT_END_IMPULSE,
    IMPACT_END_TOUCHES,
    LAST_END,
    LAST_IMPULSE,
    LAST_TOUCHES,
    PAUSE,
    WALL_PEAK_TIME,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

# Time for which the bound must have been below the peak, and number of checks, per transit.
HELD, CHECKS = 0.5, 16
# Maximum length of a run in transits, twice as long if motion can escape from the wall, or in
# rebounds of the whole chain, but not more than TRANSIT_LIMIT.  Impacts on soft walls and of heavy
# strikers end after up to 1.3 rebounds, those of heavy balls between soft ones after 16 transits.
MAX_TRANSITS, MAX_REBOUNDS, TRANSIT_LIMIT = 10, 2.0, 500
# Relative rounding of bounds and static forces; fraction of the peak to which the force of a
# contact that carries a static force, and need not open, falls when it releases the wall.
ROUNDING, RELEASED = 1e-9, 1e-3


def longest_watch(transit: float, rebounds: float, can_escape: bool) -> float:
    """Time after the first transit at which a run without a given end stops at the latest.

    The argument ``rebounds`` is the time of `MAX_REBOUNDS`.
    """
    transits = 2 * MAX_TRANSITS if can_escape else MAX_TRANSITS
    return min(max((transits - 1) * transit, rebounds), (TRANSIT_LIMIT - 1) * transit)


def time_between_checks(elapsed: float, transit: float, checks: int) -> float:
    """Time between checks of a wall that is watched for the time ``elapsed``.

    It doubles after `MAX_TRANSITS` and after twice as many, because on soft walls an impact may
    last hundreds of transits, but the time `HELD` always has two checks, if it has them at first.
    """
    spacing, limit = transit / checks, MAX_TRANSITS * transit
    while elapsed >= limit > 0.0 and 4.0 * spacing <= HELD * transit:
        spacing, limit = 2.0 * spacing, 2.0 * limit
    return spacing


def released_force(static: float, peak: float) -> float:
    """Largest force on a wall that is released: zero, or about the static force."""
    if not static > 0.0:
        return 0.0
    return (1.0 + ROUNDING) * static + RELEASED * max(0.0, peak - static)


def is_loaded(force: float, released: float) -> bool:
    """Whether a wall is loaded, given the force of `released_force`.

    A loss may pull at the end of a contact, which has then not ended.
    """
    return force > released or force < 0.0


def end_after_pause(side: int, time: float, walls: NDArray[np.float64]) -> None:
    """Record the last release as the end of the impact, if it follows the peak by long enough."""
    peak_time, last = walls[WALL_PEAK_TIME, side], walls[LAST_END, side]
    if walls[IMPACT_END, side] > peak_time:
        return
    walls[IMPACT_END, side] = 0.0
    if last > peak_time and time - last >= walls[PAUSE, side]:
        walls[IMPACT_END, side] = last
        walls[IMPACT_END_IMPULSE, side] = walls[LAST_IMPULSE, side]
        walls[IMPACT_END_TOUCHES, side] = walls[LAST_TOUCHES, side]
