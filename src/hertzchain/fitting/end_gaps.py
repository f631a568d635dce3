"""Gaps behind the last ball with a sensor, from values that do not depend on them.

A gap near the end of the row changes the signal of a wall and all waves that return from the end.
A fit without it therefore distorts the other parameters, so that no search from its values leads to
the gap.  The samples before these waves return determine the other parameters without it; with
them, simulations with gaps of many sizes show the best one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, SimulationError
from ..simulation.time_scales import transit_times
from ..traces.amplitudes import extreme
from ..traces.signals import Shot
from ..traces.traces import Traces
from .ball_counts import ball_count
from .crossings import reached
from .least_squares import roughly_solved
from .model import Model, Values
from .names import Name
from .parameters import Parameter, kind_and_value
from .problem import Problem
from .result import FitResult
from .rough_gaps import WALL_GAP, RoughGap, gap_names, solved_from
from .starts import aligned
from .symmetry import units_of

# Part of the peak of a signal at which it arrives: that of the first pulse, not of a later one.
ARRIVING: Final = 0.25
# Part of the time from the last sensor to the end of the row and back whose samples are used.
USED: Final = 0.75
# Sizes of gaps that are simulated, in units of the motion.
SIZES: Final = tuple(np.geomspace(0.05, 20.0, 25).tolist())
# Evaluations of the fit to the first samples, and of that with a gap.
EVALUATIONS: Final = 12

# Largest number of contacts at which gaps are fitted.
MAX_FITS: Final = 3


@dataclass(frozen=True, eq=False)
class Trial:
    """The size of a gap with the least sum of squares, and the model that has it."""

    cost: float
    name: Name
    size: float
    model: Model


def end_gaps(result: FitResult) -> dict[Name, RoughGap]:
    """The rough fits of a gap at the most likely contacts behind the last ball with a sensor."""
    if len(result.traces.names) < 2:
        return {}  # a single sensor hardly shows on which side of it a gap is
    last = max(_sensors(result.traces.shots[0], result.chain).values(), default=0)
    names = [
        name for name in gap_names(result.chain)
        if name == WALL_GAP or int(name.item.split("-")[0]) >= max(last, 1)
    ]  # fmt: skip
    if not last or not names or result.chain.drive is not None:
        return {}
    values = values_before_waves_return(result)
    if values is None:
        return {}
    trials = [each for each in (_best_size(result, name, values) for name in names) if each]
    likely = sorted(trials, key=lambda each: each.cost)[:MAX_FITS]
    gaps = {
        each.name: solved_from(
            result.problem, each.model, {**values, each.name: each.size}, each.name, EVALUATIONS
        )
        for each in trials if each in likely
    }  # fmt: skip
    return {name: gap for name, gap in gaps.items() if gap is not None}


def values_before_waves_return(result: FitResult) -> Values | None:
    """Values from the samples before waves from the end of the row; none if a fit fails."""
    model = result.model
    try:
        shots = tuple(
            _before(shot, chain)
            for shot, chain in zip(result.traces.shots, model.chains, strict=True)
        )
        early = replace(model, traces=Traces(shots))
        starts = aligned(early, {each.name: each.start for each in model.parameters})
        parameters = tuple(replace(each, start=starts[each.name]) for each in model.parameters)
        early = replace(early, parameters=parameters)
        solution = roughly_solved(Problem(early), EVALUATIONS)
    except (InputError, SimulationError):
        return None
    return early.values(solution.variables)


def _sensors(shot: Shot, chain: Chain) -> dict[str, int]:
    """Numbers of the balls with sensors, by the names of the sensors."""
    numbers = {each.name: each.place.bead(chain) - chain.strikers for each in shot.signals}
    return {name: ball for name, ball in numbers.items() if 1 <= ball <= ball_count(chain)}


def _before(shot: Shot, chain: Chain) -> Shot:
    """The shot whose samples end before waves return from the end of the row."""
    balls = _sensors(shot, chain)
    times = transit_times(chain)[chain.strikers :]  # from ball 1 to 2, and so on
    arrived = {
        each.name: _arrival(shot.times[each.valid], (each.values - each.level)[each.valid])
        for each in shot.signals if each.name in balls
    }  # fmt: skip
    order = sorted(balls, key=lambda name: balls[name])
    first, last = order[0], order[-1]
    expected = float(times[balls[first] - 1 : balls[last] - 1].sum())
    stretch = (arrived[last] - arrived[first]) / expected if expected > 0.0 else 1.0
    rest = float(times[balls[last] - 1 : ball_count(chain) - 1].sum())
    if not (stretch > 0.0 and rest > 0.0):
        raise InputError("no sample is known to be before waves return from the end of the row")
    ends = dict.fromkeys(order, 2.0 * USED * rest)
    signals = []
    for each in shot.signals:
        # The signal of a wall is used until shortly before the pulse reaches the last ball.
        end = arrived[last] + stretch * ends.get(each.name, 0.5 * rest)
        signals.append(replace(each, valid=each.valid & (shot.times < end)))
    return replace(shot, signals=tuple(signals))


def _arrival(times: Array, values: Array) -> float:
    return reached(times, values, ARRIVING * extreme(values))


def _best_size(result: FitResult, name: Name, values: Values) -> Trial | None:
    """The best of many sizes of a gap, without any fit."""
    model = result.model
    kind, _ = kind_and_value(name, model.traces, model.chains)
    unit = units_of(result.chain).scales.length
    changed = replace(model, parameters=(*model.parameters, Parameter(name, kind, unit)))
    costs = dict(_costs(result, Problem(changed), name, values, unit))
    if not costs:
        return None
    size = min(costs, key=lambda each: costs[each])
    return Trial(costs[size], name, size, changed)


def _costs(
    result: FitResult, problem: Problem, name: Name, values: Values, unit: float
) -> Iterator[tuple[float, float]]:
    """Sums of squares with gaps of several sizes, each with the size."""
    fitted = result.problem
    for part in SIZES:
        size = part * unit
        try:
            predicted = problem.predicted({**values, name: size})
        except (InputError, SimulationError):
            continue
        residuals = np.where(fitted.skipped, 0.0, (predicted - fitted.data) / fitted.scale)
        yield size, float(residuals @ residuals)
