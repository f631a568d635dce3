"""Pareto fronts of two objectives, by limits on the second one (epsilon constraints)."""

from __future__ import annotations

import dataclasses
import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from ..chain.hertz_ratios import OUTSIDE_LAW
from ..kernels.compile_notice import write_current
from ..representation import listed
from ..simulation.slow_run import INTERVAL
from .ball_space import BallSpace
from .ball_tapers import geometric_reference
from .dominance import undominated
from .front_search import search_front
from .methods import Found, method_for, run_method
from .reference_chains import evaluated_references
from .requirements import Requirement
from .trials import Outcome, Trials

if TYPE_CHECKING:
    from .problem import Design
    from .result import DesignResult

BEADS: Final = "beads"
Finish = Callable[[Trials, Found, tuple[str, ...]], "DesignResult"]


# Unless given: number of searches for points of sizes, and largest number of points of choices.
SEARCHES, MAX_CHOICES = 9, 100
# Largest number of points that can be given.
MAX_POINTS: Final = 200


def design_front(
    trials: Trials, method: str, points: int | None, finish: Finish
) -> DesignResult:  # fmt: skip
    """The Pareto front of two objectives, from the best of the first one to that of the second.

    The result is the first point.  Sizes, and balls with scatter, are searched at several levels
    of the second objective.  Choices of balls are those of all trials that no other trial beats.
    """
    problem = trials.problem
    second = problem.objectives[1].single
    trials.memory = {} if trials.draws is None else None
    if method == "enumerate":
        found = [_solve(trials, problem._only(0), method, 1.0, finish)]
    elif method == "genetic" and trials.memory is not None:
        found = [_searched_together(trials, finish)]
    else:
        found = _searched(trials, method, points or SEARCHES, finish)
    best, notes = found[0], list[str]()
    if problem.discrete and trials.memory is not None:
        front = _of_all_trials(trials)
        shown = _spread(front, points or MAX_CHOICES)
        if len(shown) < len(front):
            more = min(len(front), MAX_POINTS)
            notes = [f"{len(shown)} of the {len(front)} points of the Pareto front are shown, in "
                     f"about equal steps of {second}; points = {more} shows more"]  # fmt: skip
        notes += _absent_lengths(trials, front)
        found = _verified_points(trials, best.method, [each for each, _ in shown], finish)
    kept = _front(found, problem)
    return dataclasses.replace(
        kept[0] if kept else best, problem=problem, front=tuple(kept), runs=trials.runs,
        gradients=trials.gradients, rejected=trials.rejected, seconds=trials.journal.seconds,
        method=best.method, finals=best.finals, finals_met=best.finals_met, history=best.history,
        notes=(*best.notes, *notes, *_notes_on_yield(kept, problem)),
        references=best.references, compared=best.compared,
    )  # fmt: skip


def _searched(trials: Trials, method: str, points: int, finish: Finish) -> list[DesignResult]:
    """Both ends of the front, and the points between them by limits on the second objective."""
    problem, second = trials.problem, trials.problem.objectives[1]
    measure = second.single
    assert measure is not None
    shares = iter(np.arange(1, points + 1) / points)
    ends = [_solve(trials, problem._only(i), method, next(shares), finish) for i in (0, 1)]
    sign, scattered = second.sign, problem.scatter is not None
    found = [ends[0]]
    levels = [end.values[str(measure)] for end in ends]
    for level in np.linspace(levels[0], levels[1], points)[1:-1]:
        limit = Requirement(measure, float(level), int(sign), problem.chain.units)
        part, end = problem._with_limit(limit, 0), next(shares)
        # With a scatter, the chains to compare with need a large part of the budget.
        if not scattered or trials.used < min(end, 1.0):
            found.append(_solve(trials, part, method, end, finish, compare=not scattered))
    return [*found, ends[1]]


def _searched_together(trials: Trials, finish: Finish) -> DesignResult:
    """The best of the first objective, after a search for the whole front."""
    parts = []
    for i in (0, 1):
        part = dataclasses.replace(trials, problem=trials.problem._only(i), best=[], history=[])
        part.clock = trials.clock
        parts.append(part)
    first, second = parts
    first.references = evaluated_references(first)
    one, other = (each.sign for each in trials.problem.objectives)
    ends = search_front(first, second, trials.seed, (one, other))
    first.references |= geometric_reference(first)
    trials.add_counts(first)
    return finish(first, Found("genetic", ends), ())


def _of_all_trials(trials: Trials) -> list[tuple[Outcome, float]]:
    """Choices that no other trial beats, with the cost of the second objective."""
    assert trials.memory is not None
    known = {point.tobytes(): (point, values) for point, values in trials.memory.values()}
    part = dataclasses.replace(trials, problem=trials.problem._only(0))
    outcomes = part.outcomes(
        [point for point, _ in known.values()], np.array([values for _, values in known.values()])
    )
    good = [each for each in outcomes if each.met and np.isfinite(each.score)]
    measured = ((o.sign, trials.position[o.measures[0]]) for o in trials.problem.objectives)
    costs = np.column_stack([[s * each.values[p] for each in good] for s, p in measured])
    return [(good[i], float(costs[i, 1])) for i in undominated(costs)]


def _absent_lengths(trials: Trials, front: list[tuple[Outcome, float]]) -> list[str]:
    """Numbers of beads that no row of the front has, unless all rows were simulated."""
    problem, space = trials.problem, trials.problem.space
    beads = next((o for o in problem.objectives if str(o.single) == BEADS and o.sign > 0.0), None)
    if beads is None or not isinstance(space, BallSpace) or not front:
        return []
    assert trials.memory is not None
    at = trials.position[beads.measures[0]]
    known = Counter(int(values[at]) for _, values in trials.memory.values())
    balls = space.chain._balls
    fixed = balls.stop - balls.start - space.size
    most = space.size if space.limits is None else min(space.size, sum(space.limits))
    there = {int(outcome.values[at]) for outcome, _ in front}
    absent = [n for n in range(fixed + space.least, fixed + most + 1) if n not in there]
    if not absent or trials.runs >= space.count:
        return []
    ranges: list[str] = []
    for group in np.split(absent, np.flatnonzero(np.diff(absent) > 1) + 1):
        few = len(group) < 3
        ranges += map(str, group) if few else [f"{group[0]} to {group[-1]}"]
    tried = sorted(known[n] for n in absent)
    count = f"{tried[0]}" if tried[0] == tried[-1] else f"{tried[0]} to {tried[-1]}"
    count += f" of {'this number' if len(absent) == 1 else 'each number'} simulated"
    return [f"the Pareto front has no rows of {listed(ranges)} beads ({count}), "
            "because shorter ones are better; a larger budget may find such rows"]  # fmt: skip


def _spread(front: list[tuple[Outcome, float]], points: int) -> list[tuple[Outcome, float]]:
    """All points or, of many, those closest to equal steps of the second objective."""
    if len(front) <= points:
        return front
    values = np.array([value for _, value in front])
    levels = np.linspace(values[0], values[-1], points)
    return [front[i] for i in np.unique(np.abs(values - levels[:, np.newaxis]).argmin(axis=1))]


def _verified_points(
    trials: Trials, method: str, outcomes: list[Outcome], finish: Finish
) -> list[DesignResult]:
    """Results of all points; a line states the progress, which the budget does not include."""
    found: list[DesignResult] = []
    written = time.monotonic()
    for outcome in outcomes:
        part = dataclasses.replace(trials, problem=trials.problem._only(0), best=[outcome])
        found.append(finish(part, Found(method, [outcome]), ()))
        if trials.progress is not None and time.monotonic() - written >= INTERVAL:
            written = time.monotonic()
            write_current(
                f"hertzchain: verified {len(found)} of {len(outcomes)} points of the Pareto front"
            )
    return found


def _notes_on_yield(front: list[DesignResult], problem: Design) -> list[str]:
    """Which points are not on the Pareto front of contacts that yield."""
    if not any(point.verified.yielding for point in front):
        return []
    beaten = len(beaten_if_yielding(front, problem))
    outside = sum(point.verified.yielding_outside_range for point in front)
    parts = [
        f"{count} of the {len(front)} points {'is' if count == 1 else 'are'} {what}"
        for count, what in ((beaten, "beaten by others"), (outside, OUTSIDE_LAW)) if count
    ]  # fmt: skip
    changed = f"; with contacts that yield, {' and '.join(parts)}" if parts else ""
    return [f"the Pareto front is that of elastic contacts{changed}; the constraint yield_ratio = "
            "'<= 1' keeps it within the range of Hertz's law"]  # fmt: skip


def beaten_if_yielding(front: Sequence[DesignResult], problem: Design) -> list[int]:
    """Places of the points that another point beats if contacts yield.

    Points outside the range of the law of yield are neither beaten nor beat others.
    """
    names = [str(each.single) for each in problem.objectives]
    places = [i for i, point in enumerate(front) if not point.verified.yielding_outside_range]
    values = [front[i].values | front[i].verified.yielding for i in places]
    signs = [each.sign for each in problem.objectives]
    costs = [[s * row[n] for s, n in zip(signs, names, strict=True)] for row in values]
    best = undominated(np.array(costs).reshape(-1, 2))
    return sorted(set(places) - {places[int(i)] for i in best})


def _front(found: list[DesignResult], problem: Design) -> list[DesignResult]:
    """Designs that meet the constraints and that no other one beats, once each."""
    met = [each for each in found if each.met]
    costs = [[o.sign * each.values[str(o.single)] for o in problem.objectives] for each in met]
    return [met[i] for i in undominated(np.array(costs).reshape(-1, 2))]


def compared_points(problem: Design) -> int:
    """Number of points whose chains to compare with are simulated; without a scatter, once."""
    return 1 if problem.scatter is None else 2


def _solve(
    trials: Trials,
    problem: Design,
    method: str,
    end: float,
    finish: Finish,
    *,
    compare: bool = True,
) -> DesignResult:
    part = dataclasses.replace(trials, problem=problem, best=[], history=[])
    part.clock = trials.clock
    part.references = evaluated_references(part) if compare else {}
    chosen = method if method in ("enumerate", "genetic") else method_for(problem, "auto", np.inf)
    if any(not each.measure.of_chain for each in problem.requirements) and chosen == "law":
        chosen = "hybrid"
    found = run_method(part, chosen, end)
    if compare:
        part.references = part.references | geometric_reference(part)
    trials.add_counts(part)
    return finish(part, found, ())
