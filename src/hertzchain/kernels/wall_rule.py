"""Numbers of the rule for complete peaks on walls, which `hertzchain.simulation.wall_watch` states.

This module does not import numba, so that Python and compiled code share it.
"""

from __future__ import annotations

# Time for which the bound must have been below the peak, and number of checks, per transit.
HELD, CHECKS = 0.5, 16
# Maximum length of a run in transits, twice as long if motion can escape from the wall, or in
# rebounds of the whole chain, but not more than TRANSIT_LIMIT.  Impacts on soft walls and of heavy
# strikers end after up to 1.3 rebounds, those of heavy balls between soft ones after 16 transits.
MAX_TRANSITS, MAX_REBOUNDS, TRANSIT_LIMIT = 10, 2.0, 500
# Relative rounding of the bound; fraction of the peak to which the force of a contact that carries
# a static force, and therefore need not open, falls when it releases the wall.
ROUNDING, RELEASED = 1e-9, 1e-3
# Fraction of the energy that a row may keep after the rebound of its first beads under gravity
# (`hertzchain.simulation.rebounds`).
REST = 0.05


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


def has_released(force: float, static: float, peak: float) -> bool:
    """Whether the force on a wall has fallen to zero, or to about the static force.

    A loss may pull at the end of a contact, which has then not ended.
    """
    return 0.0 <= force <= (static + RELEASED * (peak - static) if static > 0.0 else 0.0)
