"""Method, size and estimated time of a search, without the search."""

from __future__ import annotations

import dataclasses
import itertools
import math
import time
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..representation import counted, duration_in_words, without_exponent
from ..simulation.yielding import yields
from .ball_space import BallSpace
from .bounds import note_on_impact
from .genetic import BATCH, Population, search
from .measures import in_words
from .methods import run_method
from .problem import Design
from .reference_chains import reference_points
from .search_budget import Budget
from .trials import RTOL, Trials
from .verified import Verified
from .yielding import advice_with_yield

# Numbers of choices from which only two digits are printed.
MANY: Final = 1e7
# Largest number of trials that are timed, and their time [s].
TIMED, LONGEST = 32, 5.0
# Methods for sizes whose trials take much less time than their gradients.
WITH_GRADIENTS: Final = ("gradient", "hybrid", "law")
# Among balls, and with these methods, a short search is timed: its least and largest number of
# trials, and its time [s].
LEAST, MOST, TIME = 50, 2000, 0.7


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
    choices : float
        Number of choices; infinite for sizes, whose searches may end before the budget is used.
    impossible : str or None
        The reason why a constraint cannot be met, and the search would not begin.
    pressure : str
        Largest pressure over yield in this chain, in words; empty without materials.
    """

    method: str
    size: str
    compared: int
    budget: Budget
    given: dict[str, float]
    trial: float
    samples: int
    choices: float = math.inf
    impossible: str | None = None
    pressure: str = ""

    @property
    def seconds(self) -> float:
        """Time of the search [s], with one trial of each choice at most."""
        trials = min(self.budget.runs / self.samples, self.choices)
        return min(self.budget.seconds, trials * self.trial)


def estimate(
    problem: Design, method: str, budget: Budget, trials: Trials, impossible: str | None = None
) -> Estimate:
    """Evaluate the given chain, and time some of the chains to compare with."""
    groups = reference_points(problem)
    points: list[Any] = [*itertools.chain(*groups.values())]
    compared = len(points)
    # The longest chains, because good ones are seldom short.
    # Those that cannot be built, such as balls without the yield strength of a law, are rejected.
    chains = map(trials.chain_of, points)
    lengths = [0 if chain is None else chain.beads for chain in chains]
    timed = [points[i] for i in np.argsort(lengths, kind="stable")[-TIMED:]]
    each = _time_of_trials(trials, timed)
    space, choices = problem.space, math.inf
    searched = isinstance(space, BallSpace) or method in WITH_GRADIENTS
    if searched and problem.scatter is None and LEAST * each < LONGEST:
        # The first trials may need further kernels.
        for count in (LEAST, int(np.clip(TIME / each, LEAST, MOST))):
            each = _time_of_search(trials, method, count)
    if isinstance(space, BallSpace):
        choices = space.count
        many = f"about {space.count:.2g} choices"
        known = counted(space.count, "choice") if space.count < MANY else many
        size = f"{known} for {counted(space.size, 'place')}"
    else:
        size = counted(space.size, "variable")
    given = problem.evaluate(problem.chain)
    return Estimate(
        method, size, compared, budget, given.values, each, trials.samples, choices, impossible,
        _pressure(problem, given),
    )  # fmt: skip


def _pressure(problem: Design, given: Verified) -> str:
    """The largest pressure over yield in the given chain, and what the search assumes beyond it."""
    if given.hertz_range is None:
        return ""
    text = f"pressure / yield {given.hertz_range._pressure(' (limit 1)')}"
    if not yields(given.hertz_range):
        return text
    advice = advice_with_yield(problem)
    return f"{text}: contacts yield, but the search assumes elastic contacts: {advice}"


def _time_of_trials(trials: Trials, points: list[Any]) -> float:
    """Time per trial, of as many as take little time."""

    def timed(count: int) -> float:
        begun = time.perf_counter()
        trials._values(points[-count:], RTOL)
        return (time.perf_counter() - begun) / count

    # The first trial of each kind includes the compilation.
    each = min(timed(1) for _ in range(2))
    count = int(np.clip(LONGEST / each, 1, len(points)))
    return each if count == 1 else min(timed(count) for _ in range(2))


def _time_of_search(trials: Trials, method: str, count: int) -> float:
    """Time per trial of a short search, with its batches and the work between them.

    Smaller batches than that of the chains to compare with use several threads less well.
    """
    problem = trials.problem._only(0)
    part = dataclasses.replace(trials, problem=problem, budget=Budget(runs=count), best=[])
    space = problem.space
    begun = time.perf_counter()
    if method == "genetic":
        search(part, 1.0, part.seed)
    elif not isinstance(space, BallSpace):
        run_method(part, method, 1.0)
    else:
        made = Population(part, np.random.default_rng(part.seed))
        rows = list(filter(space.long_enough, (made.random() for _ in range(count))))
        part.evaluate_all(rows[i : i + BATCH] for i in range(0, len(rows), BATCH))
    return (time.perf_counter() - begun) / max(1, part.runs)


def in_lines(problem: Design, found: Estimate) -> str:
    """Text of several lines."""
    limit, text = found.budget, " against ".join(map(str, problem.objectives))
    budget = f"{limit.seconds:g} s" if limit.runs == float("inf") else f"{limit.runs} simulations"
    lines = [
        f"objective: {text}",
        f"{found.size}, method {found.method!r}",
        f"{counted(found.compared, 'chain')} to compare with, budget {budget}",
    ]
    if found.samples > 1:
        lines.append(f"each trial takes {found.samples} simulations, because of the scatter")
    units = {str(each): each.unit for each in problem.measures}
    if found.impossible is not None:
        lines.append(f"{found.impossible}, so no search is made")
    shown = (f"{name} {in_words(value, units[name], problem.chain.units)}"
             for name, value in found.given.items() if value == value)  # fmt: skip
    lines.append(f"the given chain: {', '.join(shown)}")
    lines += [f"  {found.pressure}"] if found.pressure else []
    lines += [f"note: {note}" for note in note_on_impact(problem)]
    if found.impossible is not None:
        return "\n".join(lines)
    whole = " for the whole budget," if found.choices == math.inf else ""
    each, total = without_exponent(1e3 * found.trial, 2), duration_in_words(found.seconds)
    lines.append(f"about {each} ms per trial on this machine, about {total}{whole} without the "
                 "verification")  # fmt: skip
    return "\n".join(lines)
