"""Search for a chain that does what a problem requires, and verify it."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np

from ..errors import IncompleteWarning, InputError, InputWarning, ModelRangeWarning
from ..recorded_warnings import ignore_warnings
from ..representation import counted, listed
from ..store.digests import document_digest
from ..store.file_lock import lock
from ..store.journal import Journal
from ..validation.keywords import checked_arguments
from ..validation.numbers import whole_number, worker_count
from ..validation.objects import Progress, callback, check_type, file_path
from .ball_space import BallSpace
from .ball_tapers import geometric_reference
from .balls import Ball
from .bounds import bounds_of, impossible, note_on_impact
from .dry_run import Estimate, estimate
from .measures import in_words, notes_on
from .methods import SEEDED, Found, method_for, run_method
from .neighbours import notes_on_neighbours
from .pareto import MAX_POINTS, SEARCHES, compared_points, design_front
from .problem import Design
from .reference_chains import evaluated_references, reference_count
from .rejections import notes_on_rejections, why_rejected
from .result import DesignResult
from .search_budget import Budget, budget_from, simulations_within
from .trials import Outcome, Reference, Trials
from .verification import Verification
from .verified import Verified, excess_with_scatter, met
from .yield_range import with_yield_range

RUNNERS_UP: Final = 4
# Relative difference of an objective between search and verification that causes a note.
DIFFERENT: Final = 0.01


@checked_arguments("design")
def design(
    problem: Design,
    *,
    budget: int | str | None = None,
    method: str = "auto",
    seed: int = 0,
    points: int | None = None,
    store: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> DesignResult:
    """Search for a chain that does what a problem requires, and verify it.

    The result is the best chain that was found, with numbers from a new simulation; local optima
    are common, and a better chain may exist.

    Parameters
    ----------
    problem : Design
        Chain, objective, variables and constraints.
    budget : int or str, optional
        Largest number of simulations, 20 000 by default, or a time such as ``"60 s"``.  Chains to
        compare with are counted, and an exact gradient as two simulations; geometric tapers of
        balls and the verification of the result are not.  With a number, the result does not depend
        on the speed of the computer.  A time does not include the verification.
    method : str
        ``"auto"``, or a method of `hertzchain.designs.methods`.
    seed : int
        Seed of the random numbers.
    points : int, optional
        Largest number of points of a Pareto front of two objectives.  For sizes, and for balls with
        a scatter, it is the number of searches among which the budget is divided, 9 by default.
        The search among balls or orders does not depend on it: at most 100 points are reported by
        default, and of more points those closest to equal steps of the second objective.
    store : path-like, optional
        Folder of journals of all trials: a folder for each problem, with a journal for each method,
        budget and seed.  A search that was interrupted resumes from its journal and gives the
        result that it would have given.
    threads : int, optional
        Number of threads.  The default is one per processor.
    progress : callable, optional
        Called as ``progress(done, total)`` in simulations, or in seconds.

    Returns
    -------
    DesignResult
        Check ``result.met`` if there are constraints.

    Raises
    ------
    InputError
        If the method cannot solve the problem, the budget is too small for the chains to compare
        with and one trial, or the store belongs to another version of hertzchain.

    Notes
    -----
    Trial chains that cannot be simulated are rejected and counted.  Derivatives are those of
    `hertzchain.gradient` where it covers the problem, and central differences of simulations
    otherwise.

    Examples
    --------
    The peak force on a wall behind ten beads of radius 0.5 to 1:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(10).replace(right_wall=hc.Wall())
    >>> problem = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)])
    >>> result = hc.design(problem, budget=500)
    >>> result.value < 0.7 * min(map(result.objective_of, result.references.values()))
    True
    """
    check_type("problem", problem, Design, "hc.Design(chain, minimise=..., vary=[...]) is one")
    callback("progress", progress)
    limit = budget_from(budget)
    seed = whole_number("seed", seed, least=0)
    if points is not None:
        points = whole_number("points", points, least=2, most=MAX_POINTS)
    count = points or SEARCHES
    chosen = _chosen_method(problem, method, limit)
    reason = impossible(problem)
    _check_budget(problem, limit, 0 if reason is not None else count)
    name = _journal_name(chosen, limit, seed, count if len(problem.objectives) == 2 else 0)
    with (
        _journal(store, problem.identity, name) as journal,
        ignore_warnings(InputWarning, ModelRangeWarning, IncompleteWarning),
    ):
        # The limits of the models are notes of the chains that are reported.
        trials = Trials(problem, limit, journal, seed, worker_count("threads", threads), progress)
        trials.scores = [] if chosen == "enumerate" else None
        if reason is not None:
            return _result(trials, Found("none"), _given(trials), {}, (reason,))
        if len(problem.objectives) == 2:
            return design_front(trials, chosen, points, finish)
        return finish(trials, run_with_references(trials, chosen, 1.0), ())


def dry_run(
    problem: Design, *, budget: int | str | None = None, method: str = "auto", seed: int = 0,
    points: int | None = None, threads: int | None = None,
) -> Estimate:  # fmt: skip
    """Method, size and estimated time of `design` with these options, without the search."""
    limit = budget_from(budget)
    chosen = _chosen_method(problem, method, limit)
    _check_budget(problem, limit, points or SEARCHES)
    with ignore_warnings():
        count = worker_count("threads", threads)
        trials = Trials(
            problem, limit, Journal(None, ""), whole_number("seed", seed, least=0), count
        )
        return estimate(problem, chosen, limit, trials, impossible(problem))


def _chosen_method(problem: Design, method: str, limit: Budget) -> str:
    within = simulations_within(limit, problem)
    return method_for(problem, method, within)


def _check_budget(problem: Design, limit: Budget, points: int) -> None:
    """Raise `InputError` if a budget does not permit the references and a trial of each point."""
    compared = trials = 0
    if points:
        compared, trials = reference_count(problem), 1
        if isinstance(problem.space, BallSpace) and compared >= problem.space.count:
            trials = 0
        elif len(problem.objectives) == 2:
            compared, trials = compared * compared_points(problem), points
    samples = 1 if problem.scatter is None else problem.scatter.samples
    least = samples * max(1, compared + trials)
    if limit.runs < least:
        each = f", of {samples} samples each," if samples > 1 else ""
        raise InputError(
            f"a budget of {limit.runs:g} simulations is too small: {compared} chains to compare "
            f"with and {counted(max(1, trials), 'trial')}{each} need {least}; give at least this"
        )


def _journal_name(method: str, limit: Budget, seed: int, points: int) -> str:
    """Name of the journal of a search: searches with other options have their own."""
    budget = f"{limit.runs:g}-simulations" if limit.runs < math.inf else f"{limit.seconds:g}-s"
    front = f"-{points}-points" if points else ""
    return f"{method}-{budget}-seed-{seed}{front}.journal"


@contextmanager
def _journal(store: Any, identity: str, name: str) -> Iterator[Journal]:
    """The journal of a search, in the folder of its problem."""
    from .. import __version__

    if store is None:
        yield Journal(None, "")
        return
    folder = file_path("store", store)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"the store {os.fspath(store)!r} is a file; give the name of a folder")
    folder = Path(folder) / document_digest({"problem": identity})[:12]
    with lock(folder / "lock", store):
        journal = Journal(folder / name, f"version={__version__} {identity}")
        try:
            yield journal
        finally:
            journal.close()


def run_with_references(trials: Trials, method: str, end: float) -> Found:
    """Evaluate the chains to compare with, and search."""
    trials.references = evaluated_references(trials)
    found = run_method(trials, method, end)
    trials.references = trials.references | geometric_reference(trials)
    return found


def _given(trials: Trials) -> Outcome:
    """The chain of the problem itself, where nothing can be searched."""
    space = trials.problem.space
    if isinstance(space, BallSpace):
        point: Any = space.first
    else:
        point = space.point(space.chain)
    return trials.evaluate([point])[0]


def finish(trials: Trials, found: Found, notes: tuple[str, ...]) -> DesignResult:
    """Verify the best trials, and return the best one that keeps its promise."""
    # The search has ended, possibly before its budget.
    trials.report_progress()
    if not trials.best or not np.isfinite(trials.best[0].values).all():
        # There is nothing to resume.
        trials.journal.remove()
        failed = sorted(trials.reasons)[:2]
        reasons = f"{'; '.join(failed)}; allow other sizes" if failed else why_rejected(trials)
        raise InputError(
            f"none of {trials.runs} trial chains could be simulated with the required quantities: "
            f"{reasons}"
        )
    return _result(trials, found, None, trials.references, notes)


def _result(
    trials: Trials, found: Found, given: Outcome | None, references: dict[str, Reference],
    notes: tuple[str, ...],
) -> DesignResult:  # fmt: skip
    problem = trials.problem
    tops = [given] if given is not None else trials.tops[: RUNNERS_UP + 1]
    tops = [top for top in tops if np.isfinite(top.score)]
    if not tops:
        raise InputError(f"{'; '.join(notes)}, and the given chain has no value to report")
    compared = {name: each.outcome for name, each in references.items()
                if np.isfinite(each.outcome.score)}  # fmt: skip
    verification = Verification(trials, len(tops) + len(compared) + len(found.optima))
    best, verified, others = verification.best(tops)
    verified = with_yield_range(problem, verified)
    promise = found.promise
    space = problem.space
    parts: list[tuple[int, Ball]] = []
    if isinstance(space, BallSpace) and not space.order:
        parts = [(count, space.balls[i]) for i, count in space.parts(best.x).items()]
    exceeded = excess_with_scatter(problem, verified)
    notes = (
        *notes, *note_on_impact(problem), *_differs(trials, best, verified, found.method),
        *notes_on(verified.chain, problem.measures), *verified.notes,
        *notes_on_neighbours(verified.chain, space),
        *_notes_on_samples(trials, exceeded, met=best.met),
        *notes_on_rejections(trials, verified),
    )  # fmt: skip
    return DesignResult(
        problem, verified, met(problem, verified.values) and not exceeded, best.score,
        None if promise is None else (promise.value, promise.error),
        {name: with_yield_range(problem, verification.reference(each))
         for name, each in compared.items()},
        {name: each.tried for name, each in references.items()},
        bounds_of(problem), found.method, np.array(found.finals),
        np.array(found.finals_met, bool),
        tuple(map(verification.numbers, found.optima)), others,
        np.array(trials.history, float).reshape(-1, 2), (), trials.runs, trials.gradients,
        trials.rejected, trials.journal.seconds, notes,
        tuple((count, str(ball)) for count, ball in parts),
        tuple(ball.price for _, ball in parts), best.met,
        problem.objective.sign * np.array(trials.scores or [], float),
    )  # fmt: skip


def _notes_on_samples(trials: Trials, exceeded: dict[str, float], *, met: bool) -> list[str]:
    """Notes that limits kept in the samples of the search are not kept in new ones, or unknown.

    ``met`` is whether the samples of the search meet all limits.
    """
    violated = [name for name, amount in exceeded.items() if np.isfinite(amount)]
    unknown = [name for name in exceeded if name not in violated]
    notes = []
    if violated and met:
        notes.append(
            f"new samples of the scatter violate {listed(violated)}, although the "
            f"{trials.samples} samples of the search do not: set stricter limits, or give the "
            "scatter more samples"
        )
    if unknown:
        notes.append(
            f"{listed(unknown)} cannot be checked, because some new samples of the scatter have no "
            "value"
        )
    return notes


def _differs(trials: Trials, best: Outcome, verified: Verified, method: str) -> list[str]:
    """A note if the verified value of the objective is not that of the search."""
    problem = trials.problem
    measure = problem.objective.single
    if measure is None or problem.scatter is not None or problem.model != "simulation":
        return []
    searched = float(best.values[trials.terms][0])
    value = verified.values[str(measure)]
    # Other notes state why there is no value.
    if not abs(value - searched) > DIFFERENT * abs(searched):
        return []
    before, after = (in_words(each, measure.unit, verified.chain.units)
                     for each in (searched, value))  # fmt: skip
    advice = "; repeat the search with another seed" if method in SEEDED else ""
    return [
        f"{measure} was {before} in the search and is {after} in the verification: it jumps "
        f"between designs that hardly differ{advice}"
    ]
