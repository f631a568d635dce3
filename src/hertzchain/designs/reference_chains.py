"""Chains with which a design is compared: equal beads, and the best taper or single ball."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ..collision import Array
from .ball_space import BallSpace
from .measures import places_of_balls
from .problem import Design
from .requirements import TOLERANCE
from .size_space import SizeSpace
from .trials import Reference, Trials

# Values of each end of the tapers.
ENDS: Final = 9
EQUAL_BALLS: Final = "row of equal balls"
# Of the balls that vary, where others than the arriving one are given.
EQUAL_PLACES: Final = "equal balls in the places that vary"
# Of a stock with too few balls of each kind.
SORTED_BALLS: Final = "row of balls sorted by size"
EQUAL: Final = "chain of equal sizes"
EQUAL_VARYING: Final = "chain with equal varying sizes"
CHANGING: Final = "fast change to equal sizes"
# Relative difference of equal sizes.
SAME: Final = 1e-9
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
        equal = {_equal_name(space): rows} if (rows := _equal_balls(space)) else {}
        equal = equal or {SORTED_BALLS: _sorted_balls(space)}
        # A stock may have too few balls for rows that are short or light enough.
        if space.limits is not None and not any(
            _meets_limits_of_chain(problem, row) for each in equal.values() for row in each
        ):
            allowed = _sorted_balls_within_limits(problem, space)
            equal = equal | ({SORTED_BALLS: allowed} if allowed else {})
        return start | equal
    levels = np.linspace(0.0, 1.0, ENDS)
    alike = [space.taper(level, level) for level in levels]
    if (given := _given_size(space)) is not None and not np.isclose(levels, given).any():
        alike.append(space.taper(given, given))
    found: dict[str, list[Any]] = {}
    for point in alike:
        found.setdefault(_kind(space, point), []).append(point)
    if sum(len(block.places) for block in space.blocks) == 1:
        found.pop(EQUAL_VARYING, None)
    tapers = [space.taper(one, other) for one in levels for other in levels if one != other]
    if not _single(space):
        found["taper"] = tapers
    return found


def _kind(space: SizeSpace, point: Any) -> str:
    """Whether all sizes of balls are equal at a point, or only those that vary.

    A spline that begins at a given bead of another size changes fast behind it.
    """
    values = space._changes(point)
    if all(_all_equal(each[places_of_balls(space.chain, field)]) for field, each in values.items()):
        return EQUAL
    varying = [
        values[field][np.concatenate([b.places for b in space.blocks if b.field == field])]
        for field in values
    ]
    return EQUAL_VARYING if all(map(_all_equal, varying)) else CHANGING


def _all_equal(sizes: Array) -> bool:
    return bool(np.ptp(sizes) <= SAME * np.abs(sizes).max())


def _given_size(space: SizeSpace) -> float | None:
    """Size of all given beads, as a place between the limits that is common to all blocks."""
    found = []
    for block in space.blocks:
        balls = np.arange(len(getattr(space.chain, block.field)))[
            places_of_balls(space.chain, block.field)
        ]
        given = getattr(space.chain, block.field)[np.setdiff1d(balls, block.places)]
        if not len(given) or not _all_equal(given) or not block.low <= given[0] <= block.high:
            return None
        low, high = block.ends
        found.append((float(np.log(given[0]) if block.log else given[0]) - low) / (high - low))
    return found[0] if np.ptp(found) <= SAME else None


def _equal_name(space: BallSpace) -> str:
    """Name of rows of equal balls, after none or only arriving balls."""
    given = np.setdiff1d(np.arange(space.chain._balls.stop), space.places)
    arrives = space.chain.velocities[given] != 0.0
    return EQUAL_BALLS if arrives.all() else EQUAL_PLACES


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


def _meets_limits_of_chain(problem: Design, row: Any) -> bool:
    """Whether a row of balls meets all limits that need no simulation, such as its length."""
    space = problem.space
    assert isinstance(space, BallSpace)
    chain, price = space.chain_of(row), space.price(row)
    return not any(
        each.excess(each.measure.from_chain(chain, price)) > TOLERANCE
        for each in problem.requirements
        if each.measure.of_chain
    )


def _sorted_balls(space: BallSpace) -> list[Any]:
    """Rows of the largest and of the smallest balls in stock, sorted by size in both directions."""
    assert space.limits is not None
    order = sorted(range(len(space.balls)), key=lambda i: space.balls[i].radius)
    stock = np.repeat(order, [space.limits[i] for i in order])
    used = min(space.size, len(stock))
    empty = np.full(space.size - used, len(space.balls))
    parts = (stock[-used:], stock[:used])
    rows = [np.concatenate([row, empty]) for part in parts for row in (part[::-1], part)]
    return list({row.tobytes(): row for row in rows}.values())


def _sorted_balls_within_limits(problem: Design, space: BallSpace) -> list[Any]:
    """For each material, rows of the largest balls in stock that meet the limits of the chain.

    They have neighbours in the sorted stock, and are sorted in both directions.
    """
    assert space.limits is not None
    kinds: dict[Any, list[int]] = {}
    for i in sorted(range(len(space.balls)), key=lambda i: space.balls[i].radius):
        kinds.setdefault(space.balls[i].material, []).extend([i] * space.limits[i])
    rows: list[Any] = []
    for stock in kinds.values():
        lengths = range(space.size, max(1, space.least) - 1, -1)
        empty = len(space.balls)
        windows = (
            np.array([*stock[first : first + length], *[empty] * (space.size - length)])
            for length in lengths if length <= len(stock)
            for first in range(len(stock) - length, -1, -1)
        )  # fmt: skip
        row = next((each for each in windows if _meets_limits_of_chain(problem, each)), None)
        if row is not None:
            used = int((row < empty).sum())
            rows += [np.concatenate([row[:used][::-1], row[used:]]), row]
    return rows


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
            rejected = sum(not np.isfinite(each.values).all() for each in outcomes)
            found[name] = Reference(best, len(outcomes), rejected)
    return found
