"""Notes on trials that have no value of an objective or a constraint."""

from __future__ import annotations

import numpy as np

from ..chain.chain import Chain
from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings
from ..representation import counted
from ..simulation.run_table import RunTable
from ..simulation.simulate import simulate
from ..simulation.simulate_many import tabulate_runs
from .exact_gradients import PEAK
from .measures import LARGEST_ON_WALL, in_words
from .problem import Design
from .trials import MAX_FAILURES, RTOL, Trials
from .verified import RTOL as VERIFIED_RTOL
from .verified import Verified


def notes_on_rejections(trials: Trials, best: Verified) -> list[str]:
    """Why trials were rejected, and whether they could be better than the design."""
    if not trials.rejected:
        return []
    which = "one trial was" if trials.rejected == 1 else f"{trials.rejected} trials were"
    first = "" if trials.rejected == 1 else "the first one "
    notes = [f"{which} rejected, {first}because {why_rejected(trials)}"]
    for name, each in trials.references.items():
        if each.rejected:
            verb = "were" if each.rejected > 1 else "was"
            which = f"{each.rejected} of {counted(each.tried, 'chain')}"
            notes.append(f"{which} for the comparison with {name!r} {verb} rejected")
    compared = trials.problem.objective.single == PEAK and trials.problem.objective.weights[0] > 0.0
    simulated = trials.problem.model == "simulation" and trials.problem.scatter is None
    if compared and simulated and trials.best[0].met and trials.rejected <= MAX_FAILURES:
        notes += _compared_with(trials, best.values[str(PEAK)])
    return notes


def why_rejected(trials: Trials) -> str:
    """Why the first rejected trial has no value, and what to try."""
    problem, point = trials.problem, trials.failures[0]
    trials.reasons.clear()
    values = trials._values([point], RTOL)[0]
    if trials.reasons:
        return next(iter(trials.reasons))
    unknown = [each for each, value in zip(trials.measures, values, strict=True)
               if not np.isfinite(value)]  # fmt: skip
    if PEAK not in unknown:
        return f"it has no {' and no '.join(map(str, unknown))}"
    advice = f"{_advice(problem)}use {LARGEST_ON_WALL}, the largest force in the run"
    if problem.scatter is not None:
        return f"{PEAK} is not complete for some of its samples; {advice}"
    chain = problem.space.chain_of(point)
    table = _repeated(problem, [chain])
    reached = in_words(float(table["wall_largest_so_far"][0]), "N", chain.units)
    if np.isfinite(table["wall_peak_force"][0]):
        return (
            f"{PEAK} was not complete at the tolerance of the search; repeated at rtol "
            f"{VERIFIED_RTOL:g}, it is {reached}"
        )
    with ignore_warnings():
        wall = simulate(chain, times=0, until=problem.until, rtol=VERIFIED_RTOL).wall_force()
    # A bound that is not larger is not proven.
    exceeds = wall.bound > wall.largest_so_far
    most = f", at most {in_words(wall.bound, 'N', chain.units)}" if exceeds else ""
    return f"{PEAK} is not complete: largest so far {reached}{most}; {advice}"


def _repeated(problem: Design, chains: list[Chain]) -> RunTable:
    """Forces of rejected chains on the wall, simulated as accurately as the design."""
    keep = ["wall_largest_so_far", "wall_peak_force"]
    return tabulate_runs(chains, keep=keep, until=problem.until, rtol=VERIFIED_RTOL)


def _advice(problem: Design) -> str:
    """How the peaks may become complete, or nothing if beads always fall back to the wall."""
    if problem.until is not None:
        return "omit until, set another one, or "
    return "" if problem.chain.gravity else "set until, or "


def _compared_with(trials: Trials, value: float) -> list[str]:
    """Whether the forces that rejected trials have reached exceed the smallest peak."""
    chains = []
    for point in trials.failures:
        try:
            chains.append(trials.problem.space.chain_of(point))
        except InputError:
            continue  # There is no such chain.
    if not chains:
        return []
    try:
        table = _repeated(trials.problem, chains)
    except SimulationError:
        return []
    reached = table["wall_largest_so_far"]
    # Forces that are not known may be smaller.
    better = int((~(reached >= value)).sum())
    unit = trials.problem.chain.units
    if not better:
        smallest = in_words(float(reached.min()), "N", unit)
        return [f"no rejected trial is better: the force on the wall reached at least {smallest}"]
    advice = "set until" if trials.problem.until is None else "set another until"
    which = counted(better, "rejected trial")
    return [f"{which} reached less than {in_words(value, 'N', unit)} and may be better; {advice}"]
