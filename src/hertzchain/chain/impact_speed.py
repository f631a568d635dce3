"""The velocity of the impact of a chain, replaced by another one or by random ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError
from ..validation.numbers import FRACTION, number
from .chain import Chain

# Largest standard deviation of the logarithm of the speed or of a constant of a material.
MAX_SCATTER: Final = 0.3


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


def relative_deviation(what: str, value: object) -> float:
    """Check a standard deviation of a logarithm, such as that of the speed."""
    whole = isinstance(value, int | float) and MAX_SCATTER < value < 100.0 * MAX_SCATTER
    hint = f"for a scatter of {value:g}%, give '{value:g}%'" if whole else ""
    return number(what, value, unit=FRACTION, above=0.0, most=MAX_SCATTER, hint=hint)


def check_impact(chain: Chain) -> None:
    """Raise `InputError` unless the speed of the impact of a chain can vary."""
    if chain.drive is not None or not chain.velocities.any():
        has = "has a drive" if chain.drive is not None else "is at rest"
        raise InputError(
            f"a scatter of the speed requires an impact, but the chain {has}: omit the scatter of "
            "the speed, or use a chain with a velocity"
        )


def at_other_speeds(chains: Sequence[Chain], spread: float, draws: Array) -> list[Chain]:
    """The chains with log-normal speeds, whose random numbers are normal."""
    return [
        chain.replace(velocities=chain.velocities * factor)
        for chain, factor in zip(chains, np.exp(spread * draws), strict=True)
    ]
