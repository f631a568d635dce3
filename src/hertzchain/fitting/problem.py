"""Residuals of a fit and their derivatives by differences with steps that suit the parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..collision import Array
from ..errors import InputError, SimulationError
from .model import Model
from .names import Name


@dataclass(eq=False)
class Problem:
    """Weighted residuals of data and priors as a function of the variables of a fit."""

    model: Model
    data: Array = field(init=False)
    sigma: Array = field(init=False)
    last_failure: str = ""
    _latest: tuple[bytes, Array] | None = None

    def __post_init__(self) -> None:
        pairs = [signal for _, signal in self.model.traces]
        self.data = np.concatenate([each.values[each.valid] for each in pairs])
        self.sigma = np.concatenate([np.full(each.valid.sum(), each.sigma) for each in pairs])

    def predicted(self, values: Mapping[Name, float], shot: int | None = None) -> Array:
        """Predicted samples, those that are valid only; of one shot, or of all."""
        shots = range(len(self.model.chains)) if shot is None else (shot,)
        return np.concatenate([
            signal[about.valid]
            for each in shots
            for signal, about in zip(
                self.model.predict_shot(each, values), self.model.traces.shots[each].signals,
                strict=True,
            )
        ])  # fmt: skip

    def residuals(self, variables: Array) -> Array:
        """Residuals over their standard deviations, data first; infinite if a run fails."""
        key = variables.tobytes()
        if self._latest is not None and self._latest[0] == key:
            return self._latest[1]
        values = self.model.values(variables)
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                found = (self.predicted(values) - self.data) / self.sigma
        except (SimulationError, InputError) as error:
            self.last_failure = str(error)
            found = np.full(len(self.data), np.inf)
        found = np.concatenate((found, self.prior_residuals(values)))
        self._latest = key, found
        return found

    def prior_residuals(self, values: Mapping[Name, float]) -> Array:
        """Deviations from the priors over their standard deviations."""
        return np.array([
            (values[each.name] - each.prior[0]) / each.prior[1]
            for each in self.model.parameters
            if each.prior is not None
        ])  # fmt: skip

    def jacobian(self, variables: Array) -> Array:
        """Derivatives of the residuals by the variables."""
        here = self.residuals(variables)
        columns = [self._column(variables, here, j) for j in range(len(variables))]
        return np.column_stack(columns)

    def _column(self, variables: Array, here: Array, j: int) -> Array:
        step = self.step(variables, j)
        ends = [variables.copy(), variables.copy()]
        ends[0][j] += step
        ends[1][j] -= step
        low, high = self.bounds()
        inside = [bool(low[j] <= end[j] <= high[j]) for end in ends]
        values = [self.model.values(end) if ok else {} for end, ok in zip(ends, inside, strict=True)]
        shot = self.model.parameters[j].shot
        cheap = all(inside) and not any(
            self.model.needs_simulation(each, shot) for each in values
        )
        if cheap:
            plus, minus = (self._residuals_like(here, each, shot) for each in values)
            return (plus - minus) / (2.0 * step)
        for sign, each, ok in zip((1.0, -1.0), values, inside, strict=True):
            if not ok:
                continue
            try:
                return sign * (self._residuals_like(here, each, shot) - here) / step
            except (SimulationError, InputError) as error:
                self.last_failure = str(error)
        return np.zeros(len(here))

    def _residuals_like(self, here: Array, values: Mapping[Name, float], shot: int | None) -> Array:
        """Residuals near a point; only those of one shot are computed again."""
        data = here[: len(self.data)].copy()
        shots = self.model.traces.shots
        begin = 0
        for index, each in enumerate(shots):
            count = sum(int(signal.valid.sum()) for signal in each.signals)
            part = slice(begin, begin + count)
            if shot is None or index == shot:
                found = self.predicted(values, index)
                data[part] = (found - self.data[part]) / self.sigma[part]
            begin += count
        return np.concatenate((data, self.prior_residuals(values)))

    def step(self, variables: Array, j: int) -> float:
        """Step of a difference."""
        kind = self.model.parameters[j].kind
        return kind.step if kind.typical else kind.step * max(abs(float(variables[j])), 0.1)

    def bounds(self) -> tuple[Array, Array]:
        """Bounds of the variables."""
        low, high = [], []
        scales = self.model.scales
        for each, scale in zip(self.model.parameters, scales, strict=True):
            free = each.of_chain and each.kind.scale != "1"
            low.append(0.0 if free and each.kind.lower >= 0.0 else each.kind.lower / scale)
            high.append(np.inf if free else each.kind.upper / scale)
        return np.array(low), np.array(high)
