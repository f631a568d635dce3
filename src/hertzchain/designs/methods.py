"""Methods of search, and the choice between them.

==============  ===================================================================================
method          search
==============  ===================================================================================
``law``         splines by the local-rate law, then descent with gradients of the simulation
``scan``        one variable: a grid, and refinement of all local optima
``hybrid``      evolution strategy and descent from many starts with equal budgets; the best result
                is polished by descent
``gradient``    descent from many starts
``evolution``   evolution strategy
``enumerate``   all choices of balls, or all orders
``genetic``     genetic search among choices, completed by exchanges
==============  ===================================================================================
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError
from ..validation.objects import check_choice
from . import smooth_tapers
from .ball_space import BallSpace
from .bundle_descent import descend
from .evolution import evolve
from .exact_gradients import covered
from .genetic import MAX_ENUMERATED, enumerate_all, search
from .problem import Design
from .quasi_newton import quasi_newton
from .scanning import scan
from .search_budget import Spent, simulations_within
from .size_space import SizeSpace
from .trials import Outcome, Trials

# Those whose results depend on the seed.
SEEDED: Final = ("genetic", "evolution", "gradient", "hybrid")
METHODS: Final = ("auto", "law", "scan", "hybrid", "gradient", "evolution", "enumerate", "genetic")
# More variables need more memory and time than these methods can use.
MAX_VARIABLES: Final = {"hybrid": 500, "evolution": 500, "gradient": 2000}
# Ratio of the limits of radii from which, and number of variables up to which, an evolution
# strategy is better than descents alone.
WIDE, MAX_EVOLVED = 2.25, 30
MIDDLE: Final = 0.5
# A smooth objective is not searched further if this many descents have the best score.
AGREEING, AGREE = 4, 1e-9
# With a scatter: part of the budget of the search without it, and starts that are compared; for
# choices, the part of the budget, and the number of the best ones that are tried with the scatter.
NOMINAL, MAX_ENDS = 0.5, 20
FEW, CHOICES = 0.3, 100


@dataclass(eq=False)
class Found:
    """Report of a method in addition to the trials.

    ``ends`` are the trials at the ends of all starts, ``optima`` all local optima of a scan, and
    ``promise`` the prediction of the law.
    """

    method: str
    ends: list[Outcome] = field(default_factory=list)
    optima: list[Outcome] = field(default_factory=list)
    promise: smooth_tapers.Promise | None = None

    @property
    def finals(self) -> list[float]:
        """Scores at the ends."""
        return [each.score for each in self.ends]

    @property
    def finals_met(self) -> list[bool]:
        """Whether the ends meet all constraints."""
        return [each.met for each in self.ends]


def method_for(problem: Design, given: str, budget_runs: float) -> str:
    """Check the method of a problem, or choose it."""
    check_choice("method", given, METHODS)
    space = problem.space
    discrete = isinstance(space, BallSpace)
    if given == "auto":
        if isinstance(space, BallSpace):
            samples = 1 if problem.scatter is None else problem.scatter.samples
            few = space.count <= min(MAX_ENUMERATED, budget_runs / samples)
            given = "enumerate" if few else "genetic"
        elif smooth_tapers.covers(problem):
            given = "law"
        else:
            given = "scan" if space.size == 1 else _for_sizes(problem)
    if discrete != (given in ("enumerate", "genetic")):
        kind = "balls or their order" if discrete else "sizes"
        raise InputError(f"method {given!r} cannot vary {kind}; omit method")
    if given == "law" and not smooth_tapers.covers(problem):
        raise InputError(
            "method 'law' needs one spline of radii, and one quantity of the leading pulse (no "
            "ratio) of a chain that hc.local_rate accepts; omit method"
        )
    if given == "scan" and space.size > 1:
        raise InputError(f"method 'scan' has one variable, got {space.size}; omit method")
    most = MAX_VARIABLES.get(given, math.inf)
    if space.size > most:
        raise InputError(
            f"{space.size} variables are too many for method {given!r}, which can use {most}; "
            "vary splines (by='spline') or fewer beads"
        )
    most_choices = 100 * MAX_ENUMERATED
    if isinstance(space, BallSpace) and given == "enumerate" and space.count > most_choices:
        raise InputError(
            f"there are more than {most_choices / 1e6:g} million choices, too many to enumerate; "
            "use method='genetic'"
        )
    return given


def _for_sizes(problem: Design) -> str:
    """Descents alone if derivatives are exact, and limits are close or variables are many.

    For the force on a wall behind beads whose radii vary by a factor of two, they end as low as
    with an evolution strategy at equal processor time (20 beads), or 4% to 5% lower (60).  If radii
    vary by a factor of five, they end in poor local minima with 12 and 19 variables, but not with
    26 and 39 (`benchmarks/designs.py ranges`).  At gaps that just close, derivatives jump.
    """
    space = problem.space
    if not isinstance(space, SizeSpace) or "gaps" in space.fields or not covered(problem):
        return "hybrid"
    close = _largest_range(space) < WIDE or space.size > MAX_EVOLVED
    return "gradient" if close else "hybrid"


def _largest_range(space: SizeSpace) -> float:
    """Largest ratio of the limits of radii, or of those of equal density for masses."""
    powers = {"masses": 1.0 / 3.0}
    return max((each.high / each.low) ** powers.get(each.field, 1.0) for each in space.blocks)


def run_method(trials: Trials, method: str, end: float) -> Found:
    """Search with a method until a part of the budget is used."""
    if trials.problem.scatter is not None and method not in ("enumerate", "scan"):
        return _robust(trials, method, end)
    return _SEARCHES[method](trials, end)


def _law(trials: Trials, end: float) -> Found:
    promise = smooth_tapers.promise(trials.problem)
    first = trials.evaluate([promise.x])
    final = polish(trials, promise.x, end)
    return Found("law", [final] if final is not None else first, promise=promise)


def _scan(trials: Trials, end: float) -> Found:
    optima = scan(trials, end)
    return Found("scan", optima, optima=optima)


def _evolution(trials: Trials, end: float) -> Found:
    return Found("evolution", _evolved(trials, end))


def _gradient(trials: Trials, end: float) -> Found:
    return Found("gradient", _descended(trials, end))


def _hybrid(trials: Trials, end: float) -> Found:
    begin = trials.used
    ends = _descended(trials, begin + 0.45 * (end - begin))
    if not _agree(trials, ends):
        ends += _evolved(trials, begin + 0.85 * (end - begin))
    if trials.best and np.isfinite(trials.best[0].score):
        polish(trials, trials.best[0].x, end)
    return Found("hybrid", ends)


def polish(trials: Trials, point: Array, end: float) -> Outcome | None:
    """Descend from a good point with a method that follows from the objective, if possible."""
    try:
        if trials.problem.has_kinks:
            return descend(trials, point, end, box=0.02)
        return quasi_newton(trials, point, end)
    except Spent:
        return None


def _evolved(trials: Trials, end: float) -> list[Outcome]:
    """Runs of the evolution strategy, whose population follows from the budget; their best."""
    rng, size = np.random.default_rng([trials.seed, 1]), trials.problem.space.size
    total = simulations_within(trials.budget, trials.problem)
    share = max(0.0, (end - trials.used) * total)
    if trials.draws is not None:
        share /= len(trials.draws)
    usual = 4 + int(3.0 * math.log(size))
    population = int(np.clip(share / 150.0, usual, 40 * usual))
    ends: list[Outcome] = []
    while trials.used < end:
        start = np.full(size, MIDDLE) if not ends else rng.random(size)
        best = evolve(trials, start, end, rng, population=population)
        if best is not None:
            ends.append(best)
    return ends


def _descended(trials: Trials, end: float) -> list[Outcome]:
    """Descents from the best points so far and from quasi-random ones; their ends."""
    starts = _starts(trials)
    ends: list[Outcome] = []
    while trials.used < end and not _agree(trials, ends):
        start = next(starts, None)
        if start is None:
            break
        search_from = descend if trials.problem.has_kinks else quasi_newton
        try:
            ends.append(search_from(trials, start, end))
        except Spent:
            break
    return ends


def _agree(trials: Trials, ends: list[Outcome]) -> bool:
    """Whether the latest descents of a smooth objective have ended at the best score."""
    finals = [each.score for each in ends]
    latest = finals[-AGREEING:]
    close = max(latest) - min(finals) <= AGREE * abs(min(finals)) if latest else False
    return len(latest) == AGREEING and close and not trials.problem.has_kinks


def _starts(trials: Trials) -> Iterator[Array]:
    """The best point so far, then the best of each group of quasi-random ones."""
    from scipy.stats import qmc

    yield from [each.x for each in trials.best[:1] if np.isfinite(each.score)]
    sampler = qmc.Sobol(trials.problem.space.size, seed=trials.seed)
    while True:
        # Of several points, the best one is a better start than any of them.
        points = list(sampler.random(16))
        found = trials.evaluate(points)
        if not found:
            return
        yield min(found, key=lambda each: each.rank).x


def _robust(trials: Trials, method: str, end: float) -> Found:
    """Search without scatter first, and continue from its best trials with scatter.

    A descent with scatter hardly leaves the valley in which it starts, and one trial takes as long
    as a search without it takes for many.
    """
    nominal, found = _search_without_scatter(trials, method, end)
    if method == "genetic":
        # Only some of the best choices meet the constraints with scatter, too.
        start = [each.x for each in nominal.best if np.isfinite(each.score)]
        return Found(found.method, search(trials, end, trials.seed, start))
    tops = {each.x.tobytes(): each for each in [*nominal.best[:1], *found.ends]
            if np.isfinite(each.score)}  # fmt: skip
    ranked = sorted(tops.values(), key=lambda each: each.rank)[:MAX_ENDS]
    starts = trials.evaluate([each.x for each in ranked]) if ranked else []
    ends: list[Outcome] = []
    for start_at in sorted(starts, key=lambda each: each.rank):
        if trials.used >= end:
            break
        try:
            ends.append(descend(trials, start_at.x, end))
        except Spent:
            break
    # Those of the search without scatter have values of another objective.
    return Found(found.method, ends or starts)


def _search_without_scatter(trials: Trials, method: str, end: float) -> tuple[Trials, Found]:
    """Search with a part of the budget without the scatter; the trials, and their ends."""
    problem = trials.problem._with(scatter=None)
    genetic = method == "genetic"
    nominal = replace(
        trials, problem=problem, best=[], history=[], kept=CHOICES if genetic else trials.kept
    )
    nominal.clock = trials.clock
    begin = trials.used
    found = _SEARCHES[method](nominal, begin + (FEW if genetic else NOMINAL) * (end - begin))
    trials.add_counts(nominal)
    return nominal, found


def _enumerate(trials: Trials, end: float) -> Found:
    enumerate_all(trials, end)
    return Found("enumerate", trials.best[:1])


def _genetic(trials: Trials, end: float) -> Found:
    return Found("genetic", search(trials, end, trials.seed))


_SEARCHES: Final[dict[str, Callable[[Trials, float], Found]]] = {
    "law": _law, "scan": _scan, "hybrid": _hybrid, "gradient": _gradient,
    "evolution": _evolution, "enumerate": _enumerate, "genetic": _genetic,
}  # fmt: skip
