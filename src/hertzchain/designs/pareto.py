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
    from .result import DesignResult

Finish = Callable[[Trials, Found, tuple[str, ...]], "DesignResult"]


def design_front(trials: Trials, method: str, points: int, finish: Finish) -> DesignResult:
    """Both ends of the front, then the points between them; the result is the first end."""
    problem = trials.problem
    first, second = (objective.single for objective in problem.objectives)
    if first is None or second is None or first == second:
        raise InputError("a Pareto front needs two different measures")
    share = 1.0 / points
    ends = [_solve(trials, problem._only(i), method, share, finish) for i in (0, 1)]
    sign = float(np.sign(problem.objectives[1].weights[0]))
    values = [end.values[str(second)] for end in ends]
    found = [ends[0]]
    for level in np.linspace(values[0], values[1], points)[1:-1]:
        limit = Requirement(second, float(level), int(sign), problem.chain.units)
        found.append(_solve(trials, problem._with_limit(limit, 0), method, share, finish))
    found.append(ends[1])
    kept = tuple(each for each in found if each.met and not _dominated(each, found, problem))
    return dataclasses.replace(
        ends[0], problem=problem, front=kept, runs=trials.runs, gradients=trials.gradients,
        rejected=trials.rejected, seconds=trials.journal.seconds,
    )  # fmt: skip


def _solve(trials: Trials, problem, method: str, share: float, finish: Finish) -> DesignResult:  # type: ignore[no-untyped-def]
    part = dataclasses.replace(trials, problem=problem, best=[], history=[])
    part.clock = trials.clock
    part.references = evaluated_references(part)
    chosen = method if method in ("enumerate", "genetic") else method_for(problem, "auto", np.inf)
    if any(not each.measure.of_chain for each in problem.requirements) and chosen == "law":
        chosen = "hybrid"
    found = run_method(part, chosen, part.used + share)
    trials.runs, trials.gradients, trials.rejected = part.runs, part.gradients, part.rejected
    return finish(part, found, ())


def _dominated(each: DesignResult, others: list[DesignResult], problem) -> bool:  # type: ignore[no-untyped-def]
    def costs(result: DesignResult) -> list[float]:
        return [
            float(np.sign(o.weights[0])) * result.values[str(o.single)] for o in problem.objectives
        ]

    own = costs(each)
    return any(
        all(a <= b for a, b in zip(costs(other), own, strict=True)) and costs(other) != own
        for other in others if other.met
    )  # fmt: skip
