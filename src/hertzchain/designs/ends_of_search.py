"""Sentences on a search whose result is at a limit: one that no trial meets, or that of sizes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..representation import listed
from .ball_space import BallSpace
from .comparison import best_reference, chosen_balls, given_chain
from .measures import in_words
from .requirements import TOLERANCE, Requirement
from .verified import Verified

if TYPE_CHECKING:
    from .result import DesignResult


def not_met_with_given(result: DesignResult) -> list[str]:
    """Lines on the limits that the closest trial does not meet, and on the given chain."""
    problem = result.problem
    if result.met or result.front or problem.scatter is not None:
        return []
    given, exceeded = given_chain(result), _exceeded(problem.requirements, result.verified)
    if given is None or not exceeded:
        return []
    shown = [f"{each} ({_value(each, result.verified)}; {_value(each, given)} in the given chain)"
             for each in exceeded]  # fmt: skip
    others = [each for each in _exceeded(problem.requirements, given) if each not in exceeded]
    broken = f", and does not meet {listed([*map(str, others)])}" if others else ""
    name = problem.objective.single or "score"
    value = result._shown(result.objective_of(given))
    return [f"not met: {listed(shown)}", f"the given chain has a {name} of {value}{broken}"]


def search_choices(result: DesignResult) -> tuple[int, int] | None:
    """Numbers of simulated and of all choices of an enumeration."""
    if not isinstance(result.problem.space, BallSpace) or result.method != "enumerate":
        return None
    scatter = result.problem.scatter
    done = result.runs // (1 if scatter is None else scatter.samples)
    return done, int(result.problem.space.count)


def no_better(result: DesignResult) -> list[str]:
    """A statement that the search has improved nothing, and what to try."""
    name = best_reference(result)
    if name is None or result.method == "scan":
        return []
    best = f"the {'best ' if result.compared[name] > 1 else ''}{name}"
    choices, limit = search_choices(result), _sizes_at_limit(result)
    if choices is not None and choices[0] >= choices[1]:
        simulated = " that has a value" if result.rejected else ""
        return [
            f"  no other choice{simulated} is better than {best}{f'; {limit}' if limit else ''}"
        ]
    advice = limit or "give a larger budget or another seed"
    return [f"  the search found nothing better than {best}; {advice}"]


def _sizes_at_limit(result: DesignResult) -> str:
    """A statement that all balls have the smallest or the largest allowed size; else empty."""
    space, chain = result.problem.space, result.chain
    if not isinstance(space, BallSpace) or space.order or not np.isfinite(result.value):
        return ""
    allowed = {ball.radius for ball in space.balls}
    first = int(space.places[0])
    chosen = {*chain.radii[first : first + chosen_balls(result, chain, space)].tolist()}
    if len(allowed) < 2 or len(chosen) != 1:
        return ""
    ends = {min(allowed): ("smallest", "smaller"), max(allowed): ("largest", "larger")}
    (size,) = chosen
    if size not in ends:
        return ""
    end, beyond = ends[size]
    shown = in_words(2.0 * size, "m", chain.units)
    return (f"all balls have the {end} allowed diameter, {shown}: allow {beyond} ones, which may "
            "be better")  # fmt: skip


def _exceeded(limits: tuple[Requirement, ...], found: Verified) -> list[Requirement]:
    """Limits that are not met, also because a value is not known."""
    return [each for each in limits
            if not each.excess(found.values[str(each.measure)]) <= TOLERANCE]  # fmt: skip


def _value(limit: Requirement, found: Verified) -> str:
    value = found.values[str(limit.measure)]
    return limit.shown(value) if np.isfinite(value) else "unknown"
