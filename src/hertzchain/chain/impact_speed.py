"""The velocity of the impact of a chain, replaced by another one."""

from __future__ import annotations

import numpy as np

from ..errors import InputError
from ..validation.numbers import number
from .chain import Chain


def at_impact_speed(chain: Chain, speed: object, what: str = "speed") -> Chain:
    """The chain with another velocity of the impact.

    In a chain at rest, the strikers or bead 1 get the velocity.
    """
    if chain.drive is not None:
        raise InputError(
            f"{what} is the velocity of an impact, but the chain has a drive: change the drive, or "
            "remove it"
        )
    moving = chain.velocities != 0.0
    if not moving.any():
        moving = np.arange(chain.beads) < max(chain.strikers, 1)
    if np.ptp(chain.velocities[moving]) > 0.0:
        raise InputError(
            f"{what} replaces the velocity of the impact, but beads of the chain have different "
            "velocities: change them there"
        )
    value = number(what, speed, unit=chain._unit("m/s"), above=0.0)
    return chain.replace(velocities=np.where(moving, value, 0.0))
