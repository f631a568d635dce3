"""Geometric tapers of balls of a catalogue, with which a design is compared."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np

from .ball_space import BallSpace
from .trials import RTOL, Reference, Trials

GEOMETRIC_TAPER: Final = "geometric taper"
# Largest number of tapers, of all ends, materials and lengths.
MAX_TAPERS: Final = 240
# Sizes of each material among which the ends are chosen.
MAX_ENDS: Final = 8


def geometric_tapers(space: BallSpace) -> list[Any]:
    """Rows of one material whose sizes are nearest to a geometric sequence between two of them."""
    if space.order or space.size < 3:
        return []
    kinds: dict[Any, list[int]] = {}
    for i in sorted(range(len(space.balls)), key=lambda i: space.balls[i].radius):
        kinds.setdefault(space.balls[i].material, []).append(i)
    pairs = []
    for own in kinds.values():
        ends = [own[i] for i in _spread(len(own), MAX_ENDS)]
        pairs += [(own, one, other) for one in ends for other in ends if one != other]
    lengths = [space.size]
    if space.optional and pairs:
        shortest = max(3, space.least)
        count = max(1, MAX_TAPERS // len(pairs))
        lengths = [shortest + i for i in _spread(space.size - shortest + 1, count)]
    rows: dict[bytes, Any] = {}
    for own, one, other in pairs:
        sizes = np.log([space.balls[i].radius for i in own])
        for length in lengths:
            wanted = np.linspace(
                np.log(space.balls[one].radius), np.log(space.balls[other].radius), length
            )
            row = np.full(space.size, len(space.balls))
            row[:length] = [own[int(np.argmin(np.abs(sizes - each)))] for each in wanted]
            if space.in_stock(row):
                rows[row.tobytes()] = row
    return list(rows.values())


def _spread(count: int, most: int) -> list[int]:
    """At most so many of the first numbers, evenly spaced, with the last one."""
    return np.unique(np.linspace(count - 1, 0, min(count, most)).round().astype(int)).tolist()


def geometric_reference(trials: Trials) -> dict[str, Reference]:
    """The best geometric taper; it is not counted in the budget and can become the design.

    With a scatter, whose trials take many simulations, it is the best one without deviations, and
    it does not become the design.  Of a Pareto front, it is the best one of the first objective,
    and all tapers can become points.
    """
    space = trials.problem.space
    if not isinstance(space, BallSpace) or not (rows := geometric_tapers(space)):
        return {}
    scattered = trials.draws is not None
    one = replace(trials, problem=replace(trials.problem, scatter=None)) if scattered else trials
    outcomes = one.outcomes(rows, one._values(rows, RTOL))
    known = [each for each in outcomes if np.isfinite(each.values).all()]
    if trials.memory is not None:
        trials.remember(known)
    elif not scattered:
        trials.note_without_cost(known)
    if not known:
        return {}
    best = min(known, key=lambda each: each.rank)
    return {GEOMETRIC_TAPER: Reference(best, len(outcomes), len(outcomes) - len(known))}
