"""Forces from outside on beads at ends, which a sensor in these beads measures, too."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..chain.chain import Chain
from ..collision import Array


def force_on_end(chain: Chain, contact: int, times: ArrayLike) -> Array:
    """Force at times on the end of a chain from a drive; forces of walls are those of contacts."""
    if is_driven(chain, contact) and chain.drive is not None:
        return chain.drive.value(times)
    return np.zeros(np.shape(times))


def static_forces_around(chain: Chain, bead: int) -> float:
    """Sum of the static forces from outside on a bead, at free ends of a precompressed chain."""
    if chain.precompression == 0.0:
        return 0.0
    forces, found = chain.static_state.forces, 0.0
    if chain.left_wall is None and bead == chain.strikers + 1:
        found += float(forces[chain.strikers])
    if chain.right_wall is None and bead == chain.beads:
        found += float(forces[-1])
    return found


def has_free_face(chain: Chain, bead: int) -> bool:
    """Whether nothing acts on one face of a bead: a sensor has half of the force on the other."""
    left = bead == 1 and chain.left_wall is None and chain.drive is None
    right = bead == chain.beads and chain.right_wall is None
    return (left or right) and static_forces_around(chain, bead) == 0.0


def is_driven(chain: Chain, contact: int) -> bool:
    """Whether the force on an end of the chain changes with time."""
    return contact == 0 and chain.drive is not None and chain.drive.of == "force"
