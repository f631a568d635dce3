"""Contact forces and overlaps of a chain before the impact."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from ..collision import Array
from ..errors import InputError
from .contact_groups import ContactGroup, loading_forces, loading_overlaps
from .walls import Wall

# Largest static overlap of a scaled chain, in units of the overlaps of an impact.  With larger
# ones, velocities would lose more than half of their digits to rounding.
MAX_SCALED_OVERLAP: Final = 1e6


class Loads(NamedTuple):
    """Quantities that determine the static contact forces of a chain."""

    masses: Array
    gaps: Array
    strikers: int
    precompression: float
    gravity: float
    walls: tuple[Wall | None, Wall | None]


def static_forces(loads: Loads) -> Array:
    """Static force of each contact, walls included, shape (N + 1,)."""
    forces = np.zeros(len(loads.masses) + 1)
    if not (loads.precompression > 0.0 or _rests_on_wall(loads)):
        return forces
    first = loads.strikers
    weights = np.abs(loads.gravity) * loads.masses[first:]
    from_top = weights if loads.gravity >= 0.0 else weights[::-1]
    carried = loads.precompression + np.concatenate(([0.0], np.cumsum(from_top)))
    forces[first:] = carried if loads.gravity >= 0.0 else carried[::-1]
    return forces


def check_static_overlaps(
    loads: Loads, forces: Array, groups: Sequence[ContactGroup], radii: Array | None
) -> None:
    """Reject forces that press beads through each other; the radii are None in scaled chains."""
    overlaps = loading_overlaps(groups, forces)
    limits = np.full(len(forces), MAX_SCALED_OVERLAP)
    if radii is not None:
        row = np.concatenate((radii[:1], radii, radii[-1:]))
        limits = np.minimum(row[:-1], row[1:])
    excess = overlaps / limits
    worst = int(np.argmax(excess))
    if excess[worst] <= 1.0:
        return
    # Rounded down: otherwise the advised value might be rejected.
    largest = 0.995 * float(loading_forces(groups, limits)[worst])
    what = "precompression" if loads.precompression > 0.0 else "gravity"
    unit, limit = "", f"{limits[worst]:g} times that of an impact"
    if radii is not None:
        unit, limit = " N", f"the bead radius, {limits[worst]:g} m"
    raise InputError(
        f"{what} exerts {forces[worst]:g}{unit} on contact {worst}, which gives an overlap larger "
        f"than {limit}; reduce {what} so that this force is at most {largest:.3g}{unit}"
    )


def _rests_on_wall(loads: Loads) -> bool:
    """Whether gravity presses the touching chain against a wall that it touches."""
    left, right = loads.walls
    down = right if loads.gravity > 0.0 else left
    on_wall = loads.gravity != 0.0 and down is not None and down.gap == 0.0
    from_strikers = loads.strikers > 0 and loads.gravity < 0.0
    return on_wall and not from_strikers and not loads.gaps[loads.strikers :].any()
