"""Sentences on a search whose result is at a limit: one that no trial meets, or that of sizes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError, SimulationError
from ..representation import listed
from .ball_space import BallSpace
from .comparison import chosen_balls
from .requirements import TOLERANCE, Requirement
from .verified import Verified

if TYPE_CHECKING:
    from .result import DesignResult


def not_met_with_given(result: DesignResult) -> list[str]:
    """Lines on the limits that the closest trial does not meet, and on the given chain."""
    problem = result.problem
    if result.met or result.front or problem.scatter is not None:
        return []
    try:
        given = problem.evaluate(problem.chain)
    except (InputError, SimulationError):
        return []
    exceeded = _exceeded(problem.requirements, result.verified)
    if not exceeded:
        return []
    shown = [f"{each} ({_value(each, result.verified)}; {_value(each, given)} in the given chain)"
             for each in exceeded]  # fmt: skip
    others = [each for each in _exceeded(problem.requirements, given) if each not in exceeded]
    broken = f", and does not meet {listed([*map(str, others)])}" if others else ""
    name = problem.objective.single or "score"
    value = result._shown(result.objective_of(given))
    return [f"not met: {listed(shown)}", f"the given chain has a {name} of {value}{broken}"]


def _exceeded(limits: tuple[Requirement, ...], found: Verified) -> list[Requirement]:
    """Limits that are not met, also because a value is not known."""
    return [each for each in limits
            if not each.excess(found.values[str(each.measure)]) <= TOLERANCE]  # fmt: skip


def _value(limit: Requirement, found: Verified) -> str:
    value = found.values[str(limit.measure)]
    return limit.shown(value) if np.isfinite(value) else "unknown"
