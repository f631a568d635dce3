"""Chains with which a design is compared: equal beads, and the best taper or single ball."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from .ball_space import BallSpace
from .problem import Design
from .size_space import SizeSpace
from .trials import Reference, Trials

# Values of each end of the tapers.
ENDS: Final = 9
EQUAL_BALLS: Final = "row of equal balls"
GIVEN_ROW: Final = "given row"
# Number of rows of equal balls, of all lengths and balls.
MAX_EQUAL: Final = 200


def reference_points(problem: Design) -> dict[str, list[Any]]:
    """Points of the chains to compare with, by name."""
    space = problem.space
    if isinstance(space, BallSpace):
        if space.order:
            return {"given order": [space.given]}
        start = {} if space.start is None else {GIVEN_ROW: [space.start]}
        return {**start, EQUAL_BALLS: _equal_balls(space)}
    levels = np.linspace(0.0, 1.0, ENDS)
    equal = [space.taper(level, level) for level in levels]
    tapers = [space.taper(one, other) for one in levels for other in levels if one != other]
    found = {"chain of equal sizes": equal}
    if not _single(space):
        found["taper"] = tapers
    return found


def _equal_balls(space: BallSpace) -> list[Any]:
    """Rows of equal balls, of every length if places may be empty."""
    lengths = np.array([space.size])
    if space.optional:
        count = min(space.size, max(1, MAX_EQUAL // len(space.balls)))
        lengths = np.unique(np.linspace(max(1, space.least), space.size, count).round().astype(int))
    empty = len(space.balls)
    rows = [
        np.where(np.arange(space.size) < length, ball, empty)
        for ball in range(len(space.balls)) for length in lengths
    ]  # fmt: skip
    return [row for row in rows if space.in_stock(row)]


def _single(space: SizeSpace) -> bool:
    return all(block.size == 1 for block in space.blocks)


def reference_count(problem: Design) -> int:
    """Number of chains to compare with."""
    return sum(map(len, reference_points(problem).values()))


def evaluated_references(trials: Trials) -> dict[str, Reference]:
    """The best chain of each kind: the first rule that a person would try.

    At least one chain is simulated, even if a time budget is shorter.
    """
    found = {}
    for name, group in reference_points(trials.problem).items():
        if outcomes := trials.evaluate(group):
            best = min(outcomes, key=lambda each: each.rank)
            found[name] = Reference(best, len(outcomes))
    return found
