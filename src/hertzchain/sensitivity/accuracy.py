"""Estimate of the error of a gradient."""

from __future__ import annotations

from typing import Final

# The force of a contact that closes rises with an infinite curvature; a step across it has an error
# of order 5/2 in its length, and 3/2 in its derivative.
POWER: Final = 0.6
FACTOR: Final = 50.0


def relative_error(rtol: float) -> float:
    """Estimated error of the derivatives, relative to the largest one."""
    return float(FACTOR * rtol**POWER)
