"""A sensor that may be in another ball than its column names."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from ..chain.chain import Chain
from ..errors import InputError
from ..traces.places import Place, check_places, place_named
from ..traces.traces import mapped
from .exchanged_columns import MUCH_BETTER
from .misread_times import nominal_pulses
from .model import Model, make_model
from .simulations import Simulator
from .time_offsets import difference_at_best_offset

# Another place is tried if it reduces the rms difference from the nominal chain, whose parameters
# are not yet fitted, to less than this part.
BETTER: Final = 0.9
# Further places are tried up to this multiple of the difference of the best one, and this number in
# all: another parameter, such as a free gap, may distort the order.
ALIKE, MOST_PLACES = 1.5, 3


@dataclass(frozen=True, eq=False)
class OtherPlace:
    """The name of a sensor, its other place, and the model with this place."""

    name: str
    place: Place
    model: Model


def likely_places(model: Model) -> list[OtherPlace]:
    """The other balls of one sensor that agree best with the nominal chain, the best first."""
    signals = {signal.name: signal.place for _, signal in model.traces}
    others = list(other_balls(signals, model.chains))
    places = [*signals.values(), *dict.fromkeys(place for _, place in others)]
    simulator = Simulator(places, model.simulator.count_one)
    found = [
        OtherPlace(name, place, _with_place(model, name, place, simulator))
        for name, place in others
    ]  # fmt: skip
    differences = {each: rms_difference(each.model) for each in found}
    found.sort(key=lambda each: differences[each])
    most = BETTER * rms_difference(model)
    if found:
        most = min(most, ALIKE * differences[found[0]])
    return [each for each in found if differences[each] < most][:MOST_PLACES]


def other_balls(signals: dict[str, Place], chains: Sequence[Chain]) -> Iterator[tuple[str, Place]]:
    """Names of sensors, each with another place that the chains have and no other sensor."""
    for name, place in signals.items():
        if place.body not in ("ball", "bead"):
            continue
        rest = [each for each in signals.values() if each != place]
        numbers = range(1, min(chain.beads for chain in chains) + 1)
        for number in (each for each in numbers if each != place.number):
            try:
                other = place_named(place.name.replace(str(place.number), str(number)))
                for chain in chains:
                    check_places([*rest, other], chain)
            except InputError:
                continue
            yield name, other


def _with_place(model: Model, name: str, place: Place, simulator: Simulator) -> Model:
    """The model with another place of a sensor, which the names of parameters follow."""
    traces = mapped(
        model.traces, lambda _, each: replace(each, place=place) if each.name == name else each
    )
    parameters = [
        replace(each, name=replace(each.name, item=place.name)) if each.name.item == name else each
        for each in model.parameters
    ]
    return make_model(traces, model.chains, parameters, simulator)


def rms_difference(model: Model) -> float:
    """Rms difference of the data from the nominal chain at the best time offset."""
    shot, columns, grid = nominal_pulses(model)
    return difference_at_best_offset(shot, columns, float(grid[1] - grid[0]))


def agrees_much_better(other: Model, model: Model) -> bool:
    """Whether the data of another model agree much better with the nominal chain."""
    return rms_difference(other) < MUCH_BETTER * rms_difference(model)
