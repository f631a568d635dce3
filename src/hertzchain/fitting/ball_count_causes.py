"""One ball more or fewer, behind all sensors or between them, as a cause of residuals.

If this explains a part of them, it is also tried together with a gap.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Final

from ..chain.chain import Chain
from ..errors import InputError, SimulationError
from ..traces.places import Place, place_named
from ..traces.traces import mapped
from .ball_counts import ball_count, with_ball_fewer, with_ball_more
from .causes import Cause, Refit
from .misread_places import BETTER, rms_difference
from .model import Model, make_model
from .problem import Problem
from .result import FitResult
from .rough_gaps import contact_words
from .row_causes import between_sensors
from .simulations import Simulator

CHANGES: Final = ((1, with_ball_more, "one ball more"), (-1, with_ball_fewer, "one ball fewer"))
COUNT: Final = "check the number of balls"
# From a single start, a fit with the correct number of balls can end at a wrong loss.
STARTS: Final = 3
# A gap is tried with another number of balls that leaves less than this part of the excess.
LEFT: Final = 0.7


def likely_count(result: FitResult, start: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The fit with another number of balls, if this agrees better with the nominal chain."""
    least, best = BETTER * rms_difference(result.model), None
    for what, advice, model in _other_counts(result.model):
        difference = rms_difference(model)
        if difference < least:
            least, best = difference, (what, advice, model)
    for cause in () if best is None else _fits([best], start, refit):
        yield cause
        if not cause.result.describes and _excess(cause.result) < LEFT * _excess(result):
            yield from _with_gap(result, cause, start, refit)


def _excess(result: FitResult) -> float:
    """Chi-squared above that of a fit that describes the data."""
    return result.chi2 - result.goodness.freedom


def _with_gap(
    result: FitResult, cause: Cause, start: Mapping[str, float], refit: Refit
) -> Iterator[Cause]:
    """The fit with another number of balls and a gap, unless a gap or an odd ball suffices."""
    gaps = between_sensors(cause.result, start, refit, only_gaps=True)
    gap = next((each for each in gaps if each.result.describes), None)
    if gap is None or any(each.result.describes for each in between_sensors(result, start, refit)):
        return
    place = contact_words(gap.names[0], gap.result.chain)
    yield replace(
        gap, what=f"{cause.what}, and {gap.what}", count=True, row=False,
        advice=f"{cause.advice}, and for a gap between {place} of the row with that number",
    )  # fmt: skip


def other_counts(result: FitResult, start: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """Fits with one ball more and one fewer behind the last sensor in a ball."""
    yield from _fits(_at_end(result.model), start, refit)


def count_between(model: Model, behind: Place, step: int) -> Model | None:
    """The model with one ball more or fewer in front of a sensor, if its chains can have it."""
    change = next(each for each in CHANGES if each[0] == step)[1]
    later = {
        signal.place.name: signal.place for _, signal in model.traces
        if signal.place.body in ("ball", "bead") and behind.body in ("ball", "bead")
        and signal.place.number >= behind.number
    }  # fmt: skip
    try:
        return _changed(model, later.values(), step, change)
    except InputError:
        return None


def _changed(
    model: Model, later: Iterable[Place], step: int, change: Callable[[Chain], Chain]
) -> Model:
    """The model with another number of balls in front of these sensors, which move."""
    moved = {each.name: _moved(each, step) for each in later}
    chains = tuple(change(chain) for chain in model.chains)
    return _with_places(replace(model, chains=chains), moved)


def _fits(
    others: Iterator[tuple[str, str, Model]] | list[tuple[str, str, Model]],
    start: Mapping[str, float], refit: Refit,
) -> Iterator[Cause]:  # fmt: skip
    for what, advice, model in others:
        try:
            found = refit(Problem(model), start, STARTS)
        except SimulationError:
            continue
        yield Cause(what, advice, found, 0, count=True)


def _at_end(model: Model) -> Iterator[tuple[str, str, Model]]:
    """Models with another number of balls at the end, where no sensor in a ball moves."""
    for _, change, words in CHANGES:
        try:
            chains = tuple(change(chain) for chain in model.chains)
            other = make_model(model.traces, chains, model.parameters, model.simulator)
        except InputError:
            continue
        yield f"{words} ({ball_count(chains[0])})", COUNT, other


def _other_counts(model: Model) -> Iterator[tuple[str, str, Model]]:
    """Models with another number of balls behind a sensor, which moves all later ones."""
    yield from _at_end(model)
    places = {signal.name: signal.place for _, signal in model.traces}
    inside = [each for each in places.values() if each.body in ("ball", "bead")]
    inside.sort(key=lambda each: each.number)
    for k in range(1, len(inside)):
        before, later = inside[k - 1], inside[k:]
        if before.number == later[0].number:
            continue
        for step, change, words in CHANGES:
            try:
                other = _changed(model, later, step, change)
            except InputError:
                continue
            count = ball_count(other.chains[0])
            what = f"{words} ({count}), between {before.name} and {later[0].name}"
            yield what, f"{COUNT}, and in which of them the sensors are", other


def _moved(place: Place, step: int) -> Place:
    return place_named(place.name.replace(str(place.number), str(place.number + step)))


def _with_places(model: Model, places: Mapping[str, Place]) -> Model:
    """The model with other places of sensors, which the names of parameters follow."""
    traces = mapped(
        model.traces, lambda _, each: replace(each, place=places.get(each.name, each.place))
    )
    parameters = [
        replace(each, name=replace(each.name, item=places[each.name.item].name))
        if each.name.item in places else each
        for each in model.parameters
    ]  # fmt: skip
    kinds = list(dict.fromkeys(signal.place for _, signal in traces))
    return make_model(traces, model.chains, parameters, Simulator(kinds, model.simulator.count_one))
