"""Notes on trials that have no value of an objective or a constraint."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings
from ..representation import counted, listed
from ..representation import measure as shown
from ..simulation.run_table import RunTable
from ..simulation.simulate import simulate
from ..simulation.simulate_many import tabulate_runs
from .exact_gradients import PEAK
from .measures import LARGEST_ON_WALL, in_words
from .problem import Design
from .requirements import TOLERANCE
from .trials import MAX_FAILURES, RTOL, Trials
from .verified import RTOL as VERIFIED_RTOL
from .verified import Verified

# Multiples of the duration of runs that are tried to complete peaks.
LONGER_RUNS: Final = (2.0, 5.0, 10.0, 30.0)


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
    other = f"use {LARGEST_ON_WALL}, the largest force in the run"
    if problem.scatter is not None:
        times = "another until" if problem.until is not None else "until"
        advice = "" if problem.chain.gravity else f"set {times}, or "
        return f"{PEAK} is not complete for some of its samples; {advice}{other}"
    chain = problem.space.chain_of(point)
    if exceeded := _violated_limits(problem, values):
        return f"{PEAK} is not complete; it violates {listed(exceeded)}, too"
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
    advice = f"{text}, or " if (text := _advice(problem, [chain])) else ""
    return f"{PEAK} is not complete: largest so far {reached}{most}; {advice}{other}"


def _violated_limits(problem: Design, values: Array) -> list[str]:
    """Limits that values violate; values that are not known may meet them."""
    known = dict(zip(problem.measures, values, strict=True))
    return [str(each) for each in problem.requirements
            if each.excess(known[each.measure]) > TOLERANCE]  # fmt: skip


def _repeated(problem: Design, chains: list[Chain]) -> RunTable:
    """Forces of rejected chains on the wall, simulated as accurately as the design."""
    keep = ["wall_largest_so_far", "wall_peak_force", "end_time"]
    return tabulate_runs(chains, keep=keep, until=problem.until, rtol=VERIFIED_RTOL)


def _advice(problem: Design, chains: list[Chain]) -> str:
    """The end of runs at which the peaks of all chains are complete, or nothing if none is."""
    if problem.until is not None and _complete(chains, None):
        return "omit until"
    if problem.chain.gravity:
        # Beads fall back to the wall, which later runs do not end.
        return ""
    end = problem.until
    if end is None:
        end = float(_repeated(problem, chains)["end_time"].max())
    for factor in LONGER_RUNS:
        until = float(f"{factor * end:.1g}")
        if until > end and _complete(chains, until):
            return f"set until = {shown(until, 's', problem.chain.units)!r}"
    return ""


def _complete(chains: list[Chain], until: float | None) -> bool:
    """Whether the peaks on the wall are complete in runs with the tolerance of the search."""
    try:
        with ignore_warnings():
            table = tabulate_runs(chains, keep=["wall_peak_force"], until=until, rtol=RTOL)
    except SimulationError:
        return False
    return bool(np.isfinite(table["wall_peak_force"]).all())


def _compared_with(trials: Trials, value: float) -> list[str]:
    """Whether the forces that rejected trials have reached exceed the smallest peak."""
    chains, broken = _candidates(trials)
    if not chains:
        limits = listed([*broken]) if broken else ""
        return (
            [f"all rejected trials violate {limits}"] if limits and len(trials.failures) > 1 else []
        )
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
        which = "rejected trial that may meet the other limits" if broken else "rejected trial"
        return [f"no {which} is better: the force on the wall reached at least {smallest}"]
    possible = [chain for chain, force in zip(chains, reached, strict=True) if not force >= value]
    advice = _advice(trials.problem, possible) or (
        f"use {LARGEST_ON_WALL}, because longer runs do not complete the peaks of all of them"
    )
    meets = f", may meet {listed([*broken])}," if broken else ""
    which = counted(better, "rejected trial")
    least = in_words(value, "N", unit)
    return [f"{which} reached less than {least}{meets} and may be better; {advice}"]


def _candidates(trials: Trials) -> tuple[list[Chain], dict[str, None]]:
    """Chains of rejected trials that may meet all limits, and limits that others violate."""
    chains: list[Chain] = []
    broken: dict[str, None] = {}
    values = trials._values(trials.failures, RTOL)
    for point, row in zip(trials.failures, values, strict=True):
        if exceeded := _violated_limits(trials.problem, row):
            broken |= dict.fromkeys(exceeded)
            continue
        try:
            chains.append(trials.problem.space.chain_of(point))
        except InputError:
            continue  # There is no such chain.
    return chains, broken
