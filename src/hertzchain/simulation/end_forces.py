"""Forces from outside on beads at ends, which a sensor in these beads measures, too."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..chain.chain import Chain
from ..collision import Array


def force_on_end(chain: Chain, contact: int, times: ArrayLike) -> Array:
    """Force at times on the end of a chain: of a drive, and of precompression without a wall.

    Forces of walls are those of contacts, and not included.
    """
    given = np.full(np.shape(times), static_force_on_end(chain, contact))
    if is_driven(chain, contact) and chain.drive is not None:
        given += chain.drive.value(times)
    return given


def static_force_on_end(chain: Chain, contact: int) -> float:
    """The part of the precompression."""
    free = contact in (0, chain.beads) and chain.contact_stiffness[contact] == 0.0
    return float(chain.precompression) if free and chain.held_by == "force" else 0.0


def static_forces_around(chain: Chain, bead: int) -> float:
    """Sum of the forces of precompression on both ends of a bead that are ends of the chain."""
    return static_force_on_end(chain, bead - 1) + static_force_on_end(chain, bead)


def is_driven(chain: Chain, contact: int) -> bool:
    """Whether the force on an end of the chain changes with time."""
    return contact == 0 and chain.drive is not None and chain.drive.of == "force"
