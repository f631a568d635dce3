"""The fit without sensors whose data lack a pulse that the model predicts, such as a cut cable."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from ..errors import InputError, SimulationError
from ..representation import listed
from ..traces.traces import Traces
from .causes import Cause, Refit
from .model import Model, make_model
from .problem import Problem
from .result import FitResult
from .sensor_comparison import ABOVE_NOISE
from .silent_sensors import silent_sensors
from .simulations import Simulator

# Least ratio of the predicted pulse to the limit below which data have none.
CLEAR: Final = 3.0
STARTS: Final = 3


def without_dead_channels(
    result: FitResult, start: Mapping[str, float], refit: Refit
) -> Cause | None:
    """The fit without these sensors; None without any, or if no sensor is left."""
    dead = _dead(result.model)
    if not dead or len(dead) == len(result.traces.names):
        return None
    known = {name: value for name, value in start.items() if not any(each in name for each in dead)}
    try:
        found = refit(Problem(_without(result.model, dead)), known, STARTS)
    except (InputError, SimulationError):
        return None
    several = len(dead) > 1
    return Cause(
        f"the column{'s' * several} of {listed(dead)} removed",
        f"{'these sensors show' if several else 'this sensor shows'} no pulse above the noise, so "
        "check cables, amplifiers and ranges, or remove the "
        f"column{'s' * several} from the file",
        found, 0,
    )  # fmt: skip


def _dead(model: Model) -> list[str]:
    """Sensors of known gain without the pulse that the nominal chain predicts clearly."""
    free = {each.name.item for each in model.parameters
            if each.name.key == "gain" and each.prior is None}  # fmt: skip
    nominal = {each.name: each.start for each in model.parameters}
    found = []
    silent = [each for each in silent_sensors(model.traces) if not free & {each, ""}]
    if not silent:
        return []
    signals = model.traces.shots[0].signals
    for signal, own in zip(signals, model.predict_shot(0, nominal), strict=True):
        predicted = float(np.abs(own - own[0]).max())
        if signal.name in silent and predicted > CLEAR * ABOVE_NOISE * signal.sigma:
            found.append(signal.name)
    return found


def _without(model: Model, names: list[str]) -> Model:
    """The model without some sensors and their parameters."""
    shots = tuple(
        replace(shot, signals=tuple(each for each in shot.signals if each.name not in names))
        for shot in model.traces.shots
    )
    parameters = [each for each in model.parameters if each.name.item not in names]
    traces = Traces(shots)
    places = list(dict.fromkeys(signal.place for _, signal in traces))
    return make_model(
        traces, model.chains, parameters, Simulator(places, model.simulator.count_one)
    )
