"""Predicted signals for values of the free parameters, and the variables of the fit.

Parameters with a dimension of motion, such as a relaxation time, are fitted in units of the
motion (`hertzchain.fitting.symmetry`).  In these variables a change of stiffness or velocity
requires no simulation if the scaling symmetry holds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..traces.places import check_places
from ..traces.signals import Signal
from ..traces.traces import Traces
from .chain_parameters import is_motion, with_motion, with_sizes
from .jumps import next_to_jumps
from .names import Name
from .parameters import Parameter, is_of_chain
from .sensors import Sensor, filtered, sampled, with_crosstalk
from .simulations import Signals, Simulator
from .symmetry import Units, units_of

Values = Mapping[Name, float]
Items = tuple[tuple[Name, float], ...]
# Largest logarithm of the ratio of a factor to its start.
MAX_LOGARITHM: Final = 20.0
# Number of sampled signals, and of chains, in the caches; a step of one gain changes neither the
# other signals nor the chain.
KEPT: Final = 64


@dataclass(frozen=True, eq=False)
class Model:
    """Signals predicted from chains and sensors.

    Attributes
    ----------
    traces : Traces
        The data; only times, places and units are used.
    chains : tuple of Chain
        One for each shot, with nominal values.
    parameters : tuple of Parameter
        Free parameters.
    simulator : Simulator
        Simulates the chains.
    reference : float
        Overlap at which the force does not depend on the exponent [m].
    """

    traces: Traces
    chains: tuple[Chain, ...]
    parameters: tuple[Parameter, ...]
    simulator: Simulator
    reference: float
    _sampled: dict[tuple[object, ...], Array] = field(default_factory=dict, init=False, repr=False)

    def __getstate__(self) -> dict[str, object]:
        """Fields without cached chains, which copies build again."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def values(self, variables: Array, shot: int = 0) -> dict[Name, float]:
        """Values of the parameters from variables in the units of the motion of a shot."""
        given: dict[Name, float] = {}
        for each, variable in zip(self.parameters, variables.tolist(), strict=True):
            if each.kind.factor:
                given[each.name] = each.start * math.exp(min(variable, MAX_LOGARITHM))
            else:
                given[each.name] = variable * each.kind.typical
        units: dict[int, Units] = {}
        for each in self.parameters:
            if self._moves(each):
                own = shot if each.shot is None else each.shot
                if own not in units:
                    units[own] = units_of(self._sized(own, given))
                given[each.name] *= self._unit(each, units[own], given)
        return given

    def variables(self, values: Values, shot: int = 0) -> Array:
        """Variables in the units of the motion of a shot from the values of the parameters."""
        out = np.zeros(len(self.parameters))
        for i, each in enumerate(self.parameters):
            value = values[each.name]
            if each.kind.factor:
                out[i] = math.log(value / each.start)
                continue
            out[i] = value / each.kind.typical
            if self._moves(each):
                own = shot if each.shot is None else each.shot
                out[i] /= self._unit(each, units_of(self._sized(own, values)), values)
        return out

    def bounds_of(self, parameter: Parameter) -> tuple[float, float]:
        """Bounds of the variable of a parameter."""
        kind = parameter.kind
        if kind.factor:
            ends = [
                math.log(bound / parameter.start) if 0.0 < bound / parameter.start < np.inf
                else sign * MAX_LOGARITHM
                for bound, sign in ((kind.lower, -1.0), (kind.upper, 1.0))
            ]  # fmt: skip
            return ends[0], ends[1]
        if self._moves(parameter):
            return (0.0 if kind.lower >= 0.0 else -np.inf), np.inf
        return kind.lower / kind.typical, kind.upper / kind.typical

    @property
    def names(self) -> tuple[Name, ...]:
        """Names of the parameters."""
        return tuple(each.name for each in self.parameters)

    @staticmethod
    def _moves(parameter: Parameter) -> bool:
        """Whether the variable is in units of the motion."""
        return parameter.of_chain and parameter.kind.scale != "1"

    @staticmethod
    def _unit(parameter: Parameter, units: Units, values: Values) -> float:
        scale = parameter.kind.scale
        if scale.startswith("force/velocity^"):
            key = parameter.name.key.rsplit(".", 1)[0] + ".alpha"
            for name, value in values.items():
                if name.key == key and name.item == parameter.name.item:
                    scale = f"force/velocity^{value!r}"
        return units.scales.unit(scale)

    def _sized(self, shot: int, values: Values) -> Chain:
        given = self._of_shot(shot, values).items()
        sizes = tuple(item for item in given if is_of_chain(item[0]) and not is_motion(item[0]))
        return self._cached_sized(shot, sizes)

    @cached_property
    def _cached_sized(self) -> Callable[[int, Items], Chain]:
        @lru_cache(KEPT)
        def sized(shot: int, sizes: Items) -> Chain:
            return with_sizes(self.chains[shot], dict(sizes), self.reference)

        return sized

    @staticmethod
    def _of_shot(shot: int, values: Values) -> dict[Name, float]:
        """Values of one shot; values of the shot replace common ones."""
        own = str(shot + 1)
        chosen = {name: value for name, value in values.items() if not name.shot}
        chosen |= {replace(n, shot=""): v for n, v in values.items() if n.shot == own}
        return chosen

    def chain(self, shot: int, values: Values) -> Chain:
        """The chain of a shot."""
        given = self._of_shot(shot, values).items()
        motion = tuple(item for item in given if is_motion(item[0]))
        return self._cached_moving(self._sized(shot, values), motion)

    @cached_property
    def _cached_moving(self) -> Callable[[Chain, Items], Chain]:
        return lru_cache(KEPT)(lambda chain, motion: with_motion(chain, dict(motion)))

    def needs_simulation(self, values: Values, shot: int) -> bool:
        """Whether the chain of a shot has not been simulated with these values."""
        return not self.simulator.knows(self.chain(shot, values))

    def predict(self, values: Values) -> list[list[Array]]:
        """Signals of each shot at all its times."""
        return [self.predict_shot(shot, values) for shot in range(len(self.chains))]

    def predict_shot(self, shot: int, values: Values) -> list[Array]:
        """Signals of one shot at all its times."""
        return self._signals_at(self.times_after_impact(shot, values), shot, values)

    def times_after_impact(self, shot: int, values: Values) -> Array:
        """Times of the samples of one shot, counted from the impact."""
        data = self.traces.shots[shot]
        offset = self._of_shot(shot, values).get(Name("time_offset"), data.time_offset)
        return np.asarray(data.times - offset)

    def at_rest(self, shot: int, values: Values) -> list[float]:
        """Signals of one shot before any pulse arrives."""
        return [float(each[0]) for each in self._signals_at(np.array([-np.inf]), shot, values)]

    def _signals_at(self, times: Array, shot: int, values: Values) -> list[Array]:
        """Signals of one shot at times after the impact."""
        given = self._of_shot(shot, values)
        data = self.traces.shots[shot]
        sensors = [self._sensor(signal.name, given) for signal in data.signals]
        last = float(times[-1]) - min(0.0, *(each.delay for each in sensors))
        run = self.simulator.signals(self.chain(shot, values), max(last, 1e-9))
        signals = [
            each.gain * self._seen(run, shot, signal, each, times) + each.offset
            for signal, each in zip(data.signals, sensors, strict=True)
        ]
        share = given.get(Name("crosstalk"), 0.0)
        return with_crosstalk(signals, [signal.unit for signal in data.signals], share)

    def next_to_jumps(self, shot: int, values: Values, least: float) -> list[Array]:
        """Samples of each signal next to jumps by more than a fraction of its noise."""
        given = self._of_shot(shot, values)
        data = self.traces.shots[shot]
        times = data.times - given.get(Name("time_offset"), data.time_offset)
        run = self.simulator.signals(self.chain(shot, values), float(times[-1]))
        found = []
        for signal in data.signals:
            sensor = self._sensor(signal.name, given)
            column = sensor.gain * self.simulator.column(run, signal)
            least_jump = least * signal.sigma
            found.append(next_to_jumps(times - sensor.delay, column, run.spacing, least_jump))
        return found

    def _seen(self, run: Signals, shot: int, signal: Signal, sensor: Sensor, times: Array) -> Array:
        """Signal of a sensor in a shot before its gain and offset."""
        key = (run.key, run.spacing, signal.name, signal.coupling,
               replace(sensor, gain=1.0, offset=0.0), shot, times[0])  # fmt: skip
        if key not in self._sampled:
            while len(self._sampled) >= KEPT:
                del self._sampled[next(iter(self._sampled))]
            column = self.simulator.column(run, signal)
            if signal.coupling == "AC":
                column = column - column[0]
            column = filtered(column, run.spacing, sensor)
            self._sampled[key] = sampled(column, run.spacing, times - sensor.delay)
        return self._sampled[key]

    def gain(self, shot: int, signal: Signal, values: Values) -> float:
        """Gain of a sensor in a shot."""
        return self._sensor(signal.name, self._of_shot(shot, values)).gain

    @staticmethod
    def _sensor(name: str, given: Values) -> Sensor:
        constants = {}
        for key in ("gain", "offset", "delay", "lag", "highpass"):
            for item in ("", name):
                if Name(key, item) in given:
                    constants[key] = given[Name(key, item)]
        return Sensor(**constants)


def make_model(
    traces: Traces,
    chains: Sequence[Chain],
    parameters: Sequence[Parameter],
    simulator: Simulator,
) -> Model:
    """A model of chains that have the places of all sensors; raises `InputError` otherwise."""
    for shot, chain in zip(traces.shots, chains, strict=True):
        check_places((signal.place for signal in shot.signals), chain)
    reference = 0.6 * units_of(chains[0]).scales.length
    return Model(traces, tuple(chains), tuple(parameters), simulator, reference)
