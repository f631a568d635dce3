"""Effects of sensors that a fit does not include, and their influence on the parameters.

Each effect is added to the linearised fit as one more parameter, without a simulation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ..collision import Array
from .model import Model
from .names import Name, to_free
from .parameters import Parameter, kind_and_value
from .problem import Problem
from .sensors import SENSOR_KINDS

EFFECTS: Final = ("lag", "highpass", "crosstalk")
# An effect is reported as present if it would reduce chi-squared by more than this.
PRESENT: Final = 16.0
# Deviations of the largest effect that is not excluded.
DEVIATIONS: Final = 2.0
# It is reported as possible if the largest effect that is not excluded would shift a parameter by
# more than this number of standard deviations of the parameter.  Without a sign of the effect, the
# error of the parameter would be twice as large if the effect were free.
MOVES: Final = DEVIATIONS * 3.0**0.5
FACTORS: Final = {"lag": (1e6, "us"), "highpass": (1.0, "/s"), "crosstalk": (100.0, "%")}


@dataclass(frozen=True)
class Effect:
    """An effect of the sensors that a fit does not include.

    Attributes
    ----------
    name : str
        ``"lag"``, ``"highpass"`` or ``"crosstalk"``.
    value, error : float
        Value and standard deviation of the effect if it were free.
    improvement : float
        Expected reduction of chi-squared.
    limit : float
        Largest size that the data do not exclude, at two standard deviations: chi-squared is then
        larger by four than at the best value.  If it matters, it is determined by fits with the
        effect fixed, because the influence of a small lag grows with its square; otherwise it is
        that of the linearised fit.
    moved : str
        The parameter that an effect of this size would shift most.
    shift : float
        This shift, in standard deviations of the parameter.
    """

    name: str
    value: float
    error: float
    improvement: float
    limit: float
    moved: str
    shift: float

    @property
    def present(self) -> bool:
        """Whether the data show the effect."""
        return self.improvement > PRESENT

    @property
    def note(self) -> str:
        """A sentence; empty if the effect is excluded or hardly matters to the parameters."""
        factor, unit = FACTORS[self.name]
        if self.present:
            return (
                f"the residuals show a {self.name}, which moves {self.moved}: "
                f"{to_free([self.name])}"
            )
        if self.shift < MOVES:
            return ""
        return (
            f"a {self.name} of the sensors up to {factor * self.limit:.2g} {unit} cannot be "
            f"excluded and would move {self.moved} by {self.shift:.1f} sigma: free "
            f"{self.name!r}, with a prior from the data sheet"
        )


def effects_of(
    problem: Problem, values: Mapping[Name, float], jacobian: Array, residuals: Array
) -> tuple[Effect, ...]:
    """All effects that a fit does not include, in the linearised problem at its optimum."""
    model = problem.model
    included = {name.key for name in model.names}
    found = []
    for key in EFFECTS:
        neighbours = any(len(shot.signals) > 1 for shot in model.traces.shots)
        if key in included or (key == "crosstalk" and not neighbours):
            continue
        column = derivative(problem, values, Name(key), residuals)
        # There is no crosstalk between sensors in different units.
        if column.any():
            found.append(_effect(key, column, model, jacobian, residuals))
    return tuple(found)


def derivative(
    problem: Problem, values: Mapping[Name, float], name: Name, residuals: Array
) -> Array:
    """Derivative of all residuals with respect to an effect that the fit does not include."""
    more = extended(problem, values, name)
    kind, neutral = more.model.parameters[-1].kind, more.model.parameters[-1].start
    step = kind.step * (neutral if kind.factor else kind.typical)
    shifted = more.predicted({**values, name: neutral + step})
    change = (shifted - problem.predicted(values)) / problem.scale / step
    priors = np.zeros(len(residuals) - len(problem.data))
    return np.concatenate((np.where(problem.skipped, 0.0, change), priors))


def extended(problem: Problem, values: Mapping[Name, float], name: Name) -> Problem:
    """The problem with an effect as its last parameter, from a neutral value."""
    model = problem.model
    kind, ideal = kind_and_value(name, model.traces, model.chains)
    # The value of one shot differs from the common one, if that is free.
    neutral = values.get(replace(name, shot=""), ideal)
    more = Problem(Model(
        model.traces, model.chains,
        (*model.parameters, Parameter(name, kind, neutral)),
        model.simulator, model.reference,
    ))  # fmt: skip
    more.correlated, more.skipped, more.smooth = problem.correlated, problem.skipped, problem.smooth
    return more


def _effect(key: str, column: Array, model: Model, jacobian: Array, residuals: Array) -> Effect:
    inverse = np.linalg.pinv(jacobian, rcond=1e-12)
    response = inverse @ column
    rest = column - jacobian @ response
    size = float(rest @ rest)
    error = size**-0.5 if size > 0.0 else np.inf
    value = -float(rest @ residuals) * error**2
    if SENSOR_KINDS[key].lower == 0.0:
        value = max(value, 0.0)
    limit = abs(value) + DEVIATIONS * error
    moved, shift = most_shifted(model, inverse, limit * response)
    return Effect(key, value, error, (value / error) ** 2, limit, moved, shift)


def most_shifted(model: Model, inverse: Array, change: Array) -> tuple[str, float]:
    """The parameter of the chain that a change shifts most, in standard deviations."""
    spread = np.sqrt(np.sum(inverse**2, axis=1))
    # A parameter that does not affect the data cannot be shifted.
    spread[spread == 0.0] = np.inf
    shifts = np.abs(change) / spread
    chain = [i for i, each in enumerate(model.parameters) if each.of_chain] or [0]
    worst = chain[int(np.argmax(shifts[chain]))]
    return str(model.parameters[worst]), float(shifts[worst])
