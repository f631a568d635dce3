"""All quantities with exact or published values."""

from __future__ import annotations

from . import attenuation, collisions, ends, linear_waves, tapers, unequal_beads, waves
from .case import Case


def cases() -> list[Case]:
    """All cases, by group."""
    return [
        *waves.cases(), *ends.cases(), *unequal_beads.cases(), *tapers.cases(),
        *linear_waves.cases(), *collisions.cases(), *attenuation.cases(),
    ]  # fmt: skip
