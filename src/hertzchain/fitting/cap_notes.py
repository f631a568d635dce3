"""Data that are recorded after the cap of a load cell has left its wall."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from ..chain.chain import Chain
from ..errors import SimulationError
from ..recorded_warnings import ignore_warnings
from ..representation import measure
from ..simulation.simulate import simulate
from ..traces.traces import mapped
from .causes import Cause, Refit
from .model import Model
from .names import Name
from .problem import Problem
from .result import FitResult
from .simulations import RTOL

LEAVES: Final = (
    "the cap leaves the wall {} after the impact, because walls do not pull; if it is fixed to its "
    "cell, it then oscillates, and later signals are not described: "
)


def is_cap_note(note: str) -> bool:
    """Whether a note is one of `cap_notes`."""
    return note.startswith(LEAVES.partition("{")[0])


def departure(chain: Chain, duration: float) -> float:
    """Time from the impact at which the cap leaves its wall; infinite if it is after a duration."""
    if chain.cap is None:
        return math.inf
    with ignore_warnings():  # an incomplete peak, and contacts that yield
        run = simulate(chain, until=duration, times=2, rtol=RTOL, check=False)
        end = run.wall_force("right").first_contact_end
    return end if end and math.isfinite(end) and end < duration else math.inf


def planned_cap_notes(chain: Chain, duration: float) -> tuple[str, ...]:
    """A sentence if the cap leaves its wall during a planned record that begins at the impact."""
    end = departure(chain, duration)
    if end == math.inf:
        return ()
    time = measure(end, "s")
    return (f"{LEAVES.format(time)}give until='{time}' or an earlier one",)


def cap_notes(
    model: Model, chains: Sequence[Chain], values: Mapping[Name, float]
) -> tuple[str, ...]:
    """A sentence on the shot recorded longest after its impact, if its cap leaves the wall.

    Walls push, but do not pull, so that a cap that is bolted to its cell moves differently from
    then on.
    """
    ends = [_departures(model, chains, values, k) for k in range(len(chains))]
    known = [each for each in ends if each[1] < math.inf]
    if not known:
        return ()
    _, end, time = max(known)
    return (f"{LEAVES.format(measure(end, 's'))}fit only earlier samples, {_until(time)}",)


def before_departure(
    result: FitResult, start: Mapping[str, float], refit: Refit
) -> Iterator[Cause]:
    """The fit to the samples before the cap leaves its wall."""
    model, values = result.model, result.model.values(result.variables)
    found = [_departures(model, result.chains, values, k) for k in range(len(result.chains))]
    times = [time for *_, time in found]
    if min(times) == math.inf:
        return
    traces = mapped(model.traces, lambda k, each: replace(
        each, valid=each.valid & (model.traces.shots[k].times < times[k])
    ))  # fmt: skip
    try:
        other = refit(Problem(replace(model, traces=traces)), start, 1)
    except SimulationError:
        return
    first = min(found, key=lambda each: each[2])
    yield Cause(
        f"only the samples before t = {measure(first[2], 's')}",
        f"{LEAVES.format(measure(first[1], 's'))}{_until(first[2])}",
        other, 0, misread=True,
    )  # fmt: skip


def _departures(
    model: Model, chains: Sequence[Chain], values: Mapping[Name, float], shot: int
) -> tuple[float, float, float]:
    """Duration of a shot after its impact, and the departure after it and in times of the data."""
    after, last = model.times_after_impact(shot, values)[-1], model.traces.shots[shot].times[-1]
    recorded = float(after)
    end = departure(chains[shot], recorded) if recorded > 0.0 else math.inf
    return recorded, end, float(last) - recorded + end


def _until(time: float) -> str:
    """The advice to fit until a time of the data."""
    return f"give fit until='{measure(time, 's')}' or an earlier time of the data"
