"""Predicted signals for values of the free parameters, and the variables in which a fit moves.

Parameters with a dimension of motion, such as a relaxation time, are fitted in units of the
motion (`hertzchain.fitting.symmetry`).  In these variables a change of stiffness or velocity
needs no simulation where the scaling symmetry holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from .chain_parameters import is_motion, with_motion, with_sizes
from .names import Name
from .parameters import Parameter
from .sensors import Sensor, filtered, sampled, with_crosstalk
from .simulations import Simulator
from .symmetry import Units, units_of
from .traces import Traces

Values = Mapping[Name, float]


@dataclass(frozen=True, eq=False)
class Model:
    """Signals that chains and sensors predict.

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
        Overlap at which a change of the exponent keeps the force [m].
    """

    traces: Traces
    chains: tuple[Chain, ...]
    parameters: tuple[Parameter, ...]
    simulator: Simulator
    reference: float

    def values(self, variables: Array) -> dict[Name, float]:
        """Values of the parameters from the variables of the fit."""
        scales = self.scales
        given = dict(zip(self.names, (variables * scales).tolist(), strict=True))
        units: dict[int, Units] = {}
        for each in self.parameters:
            if self._moves(each):
                shot = each.shot or 0
                if shot not in units:
                    units[shot] = units_of(self._sized(shot, given))
                given[each.name] *= self._unit(each, units[shot], given)
        return given

    def variables(self, values: Values) -> Array:
        """Variables of the fit from the values of the parameters."""
        out = np.array([values[name] for name in self.names])
        for i, each in enumerate(self.parameters):
            if self._moves(each):
                units = units_of(self._sized(each.shot or 0, values))
                out[i] /= self._unit(each, units, values)
        return np.asarray(out / self.scales)

    @property
    def names(self) -> tuple[Name, ...]:
        """Names of the parameters."""
        return tuple(each.name for each in self.parameters)

    @property
    def scales(self) -> Array:
        """Sizes of the variables, so that all are of order 1."""
        return np.array([each.kind.typical or abs(each.start) or 1.0 for each in self.parameters])

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
        return with_sizes(self.chains[shot], self._of_shot(shot, values), self.reference)

    @staticmethod
    def _of_shot(shot: int, values: Values) -> dict[Name, float]:
        """Values of one shot; its own replace those that shots have in common."""
        own = str(shot + 1)
        chosen = {name: value for name, value in values.items() if not name.shot}
        chosen |= {replace(n, shot=""): v for n, v in values.items() if n.shot == own}
        return chosen

    def chain(self, shot: int, values: Values) -> Chain:
        """The chain of a shot."""
        given = self._of_shot(shot, values)
        motion = {name: value for name, value in given.items() if is_motion(name)}
        return with_motion(self._sized(shot, values), motion)

    def needs_simulation(self, values: Values, shot: int | None = None) -> bool:
        """Whether a chain with these values has not been simulated yet."""
        shots = range(len(self.chains)) if shot is None else (shot,)
        return not all(self.simulator.knows(self.chain(each, values)) for each in shots)

    def predict(self, values: Values) -> list[list[Array]]:
        """Signals of each shot at all its times."""
        return [self.predict_shot(shot, values) for shot in range(len(self.chains))]

    def predict_shot(self, shot: int, values: Values) -> list[Array]:
        """Signals of one shot at all its times."""
        given = self._of_shot(shot, values)
        data = self.traces.shots[shot]
        times = data.times - given.get(Name("time_offset"), 0.0)
        sensors = [self._sensor(signal.name, given) for signal in data.signals]
        last = float(times[-1]) - min(0.0, *(each.delay for each in sensors))
        spacing, columns = self.simulator.signals(self.chain(shot, values), max(last, 1e-9))
        places = [place.name for place in self.simulator.places]
        signals = []
        for signal, sensor in zip(data.signals, sensors, strict=True):
            column = columns[:, places.index(signal.name)]
            seen = sampled(filtered(column, spacing, sensor), spacing, times - sensor.delay)
            signals.append(sensor.gain * seen + sensor.offset)
        share = given.get(Name("crosstalk"), 0.0)
        return with_crosstalk(signals, [signal.unit for signal in data.signals], share)

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
    for shot, signal in traces:
        signal.place.bead(chains[shot])
    reference = 0.6 * units_of(chains[0]).scales.length
    return Model(traces, tuple(chains), tuple(parameters), simulator, reference)
