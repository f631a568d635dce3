"""Pareto fronts of two objectives, by limits on the second one (epsilon constraints)."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from .methods import Found, method_for, run_method
from .reference_chains import evaluated_references
from .requirements import Requirement
from .trials import Trials

if TYPE_CHECKING:
    from .problem import Design
    from .result import DesignResult

Finish = Callable[[Trials, Found, tuple[str, ...]], "DesignResult"]


def design_front(trials: Trials, method: str, points: int, finish: Finish) -> DesignResult:
    """Both ends of the front, then the points between them; the result is the first end."""
    problem = trials.problem
    first, second = (objective.single for objective in problem.objectives)
    if first is None or second is None or first == second:
        raise InputError("a Pareto front needs two different measures")
    trials.memory = {} if trials.draws is None else None
    shares = iter(np.arange(1, points + 1) / points)
    ends = [_solve(trials, problem._only(i), method, next(shares), finish) for i in (0, 1)]
    sign = float(np.sign(problem.objectives[1].weights[0]))
    values, scattered = [end.values[str(second)] for end in ends], problem.scatter is not None
    found = [ends[0]]
    for level in np.linspace(values[0], values[1], points)[1:-1]:
        limit = Requirement(second, float(level), int(sign), problem.chain.units)
        part, end = problem._with_limit(limit, 0), next(shares)
        # With a scatter, the chains to compare with need a large part of the budget.
        if not scattered or trials.used < min(end, 1.0):
            found.append(_solve(trials, part, method, end, finish, compare=not scattered))
    found.append(ends[1])
    kept = tuple(each for each in found if each.met and not _dominated(each, found, problem))
    return dataclasses.replace(
        ends[0], problem=problem, front=kept, runs=trials.runs, gradients=trials.gradients,
        rejected=trials.rejected, seconds=trials.journal.seconds,
    )  # fmt: skip


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
    trials.runs, trials.gradients, trials.rejected = part.runs, part.gradients, part.rejected
    return finish(part, found, ())


def _dominated(each: DesignResult, others: list[DesignResult], problem: Design) -> bool:
    def costs(result: DesignResult) -> list[float]:
        return [
            float(np.sign(o.weights[0])) * result.values[str(o.single)] for o in problem.objectives
        ]

    own = costs(each)
    return any(
        all(a <= b for a, b in zip(costs(other), own, strict=True)) and costs(other) != own
        for other in others if other.met
    )  # fmt: skip
