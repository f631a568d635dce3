"""Method, size and estimated time of a search, without the search."""

from __future__ import annotations

import itertools
import time
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..representation import counted
from .ball_choice import BallSpace
from .measures import in_words
from .problem import Design
from .reference_chains import reference_points
from .search_budget import Budget
from .trials import RTOL, Trials

# Number of trials that are timed, the second time after the kernels were compiled.
TIMED: Final = 32


@dataclass(frozen=True)
class Estimate:
    """A search that was not begun.

    Attributes
    ----------
    method : str
        The method.
    size : str
        Numbers of choices, or of variables.
    compared : int
        Number of chains to compare with.
    budget : Budget
        The budget.
    given : dict
        Values of all objectives and constraints for the chain of the problem.
    trial : float
        Time of a trial on this machine [s].
    samples : int
        Simulations per trial.
    """

    method: str
    size: str
    compared: int
    budget: Budget
    given: dict[str, float]
    trial: float
    samples: int

    @property
    def seconds(self) -> float:
        """Time of the search [s]; small searches end earlier."""
        return min(self.budget.seconds, self.budget.runs / self.samples * self.trial)


def estimate(problem: Design, method: str, budget: Budget, trials: Trials) -> Estimate:
    """Evaluate the given chain, and time some of the chains to compare with."""
    groups = reference_points(problem)
    points: list[Any] = [*itertools.chain(*groups.values())]
    # The longest chains, because good ones are seldom short.
    lengths = [problem.space.chain_of(point).beads for point in points]
    timed = [points[i] for i in np.argsort(lengths, kind="stable")[-TIMED:]]
    for _ in range(2):
        begun = time.perf_counter()
        trials._values(timed, RTOL)
        spent = time.perf_counter() - begun
    space = problem.space
    if isinstance(space, BallSpace):
        size = f"{counted(space.count, 'choice')} for {counted(space.size, 'place')}"
    else:
        size = counted(space.size, "variable")
    return Estimate(
        method, size, len(points), budget, problem.evaluate(problem.chain).values,
        spent / len(timed), trials.samples,
    )  # fmt: skip


def in_lines(problem: Design, found: Estimate) -> str:
    """Text of several lines."""
    limit, text = found.budget, " against ".join(map(str, problem.objectives))
    budget = f"{limit.seconds:g} s" if limit.runs == float("inf") else f"{limit.runs} simulations"
    lines = [
        f"{text[:1].upper()}{text[1:]}: {found.size}, method {found.method!r}",
        f"{counted(found.compared, 'chain')} to compare with, budget {budget}",
    ]
    if found.samples > 1:
        lines.append(f"each trial takes {found.samples} simulations, because of the scatter")
    units = {str(each): each.unit for each in problem.measures}
    shown = (f"{name} {in_words(value, units[name], problem.chain.units)}"
             for name, value in found.given.items() if value == value)  # fmt: skip
    lines.append(f"the given chain: {', '.join(shown)}")
    lines.append(f"about {1e3 * found.trial:.2g} ms per trial on this machine, at most about "
                 f"{found.seconds:.2g} s without the verification")  # fmt: skip
    return "\n".join(lines)
