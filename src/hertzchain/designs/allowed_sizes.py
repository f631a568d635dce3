"""Sentences on sizes at the limits of a search, and on those of the given chain beyond them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

import numpy as np

from .ball_space import BallSpace
from .measures import in_words
from .size_space import IN_FILES, SizeSpace
from .sizes import UNITS

if TYPE_CHECKING:
    from ..chain.chain import Chain
    from .result import DesignResult

# Relative difference of sizes that are the same: sizes of results are rounded to nine digits.
SAME: Final = 1e-6
# Longer lists of sizes are shortened.
MAX_SIZES: Final = 4


def at_bounds(result: DesignResult) -> list[str]:
    """Lines on continuous sizes that are the smallest or the largest allowed ones."""
    space, chain = result.problem.space, result.chain
    if not isinstance(space, SizeSpace):
        return []
    lines = []
    for block in space.blocks:
        values = getattr(chain, block.field)[block.places]
        what = "diameters" if _has_diameters(block.field, chain) else block.field
        for bound, end, beyond in ((block.low, "smallest", "smaller"),
                                   (block.high, "largest", "larger")):  # fmt: skip
            count = int(np.isclose(values, bound, rtol=SAME, atol=0.0).sum())
            # A gap cannot be smaller than 0.
            if count and bound > 0.0:
                verb = "is" if count == 1 else "are"
                lines.append(
                    f"{count} of the {len(values)} {what} that vary {verb} the {end} allowed, "
                    f"{_shown(bound, block.field, chain)}: {beyond} ones may be better"
                )
    return lines


def given_beyond_allowed(result: DesignResult) -> list[str]:
    """A reason why the given chain is better than the design, if the search does not allow it."""
    space, given = result.problem.space, result.problem.chain
    shown: Iterable[str]
    if isinstance(space, SizeSpace):
        shown = [
            _shown(value, block.field, given)
            for block in space.blocks
            for value in getattr(given, block.field)[block.places].tolist()
            if not block.low * (1.0 - SAME) <= value <= block.high * (1.0 + SAME)
        ]
    else:
        shown = _other_balls(space, given) if isinstance(space, BallSpace) else []
    sizes = [*dict.fromkeys(shown)]
    if not sizes:
        return []
    more = [*sizes[:MAX_SIZES], "..."] if len(sizes) > MAX_SIZES else sizes
    return [f"the given chain has sizes outside of the allowed ones: {', '.join(more)}"]


def _other_balls(space: BallSpace, given: Chain) -> list[str]:
    """Diameters, or balls of a material, of the given chain that no place can have."""
    if space.order:
        return []
    allowed = {ball.radius for ball in space.balls}
    radii = given.radii[space.places].tolist()
    return [_shown(radius, "radii", given) for radius in radii
            if not any(abs(radius - each) <= SAME * each for each in allowed)]  # fmt: skip


def _has_diameters(field: str, chain: Chain) -> bool:
    return field == "radii" and chain.units == "SI"


def _shown(value: float, field: str, chain: Chain) -> str:
    factor = IN_FILES[field] if _has_diameters(field, chain) else 1.0
    return in_words(factor * value, UNITS[field], chain.units)
