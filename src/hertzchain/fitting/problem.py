"""Residuals of a fit, and their derivatives by finite differences."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError, SimulationError
from .law_parameters import JUMPING
from .model import Model
from .names import Name

# Step of differences of functions that require no simulation, for variables of order 1.
SMALL: Final = 1e-6
# Least step of parameters of a chain whose forces jump, before the samples next to jumps are known:
# a difference must move the jumps by a sample.
MIN_JUMPING_STEP: Final = 5e-3
# Smaller derivatives, whose squares would underflow, are those of parameters without any effect.
NEGLIGIBLE: Final = 1e-100
# Smallest jump that matters, as a fraction of the noise: differences divide it by the small step.
MIN_JUMP: Final = 0.01


def differences(function: Callable[[Array], Array], variables: Array) -> Array:
    """Central differences of a function that requires no simulation."""
    columns = []
    for j, variable in enumerate(variables):
        step = SMALL * max(abs(float(variable)), 1.0)
        ends = []
        for sign in (1.0, -1.0):
            moved = variables.copy()
            moved[j] += sign * step
            ends.append(function(moved))
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.column_stack(columns)


@dataclass(eq=False)
class Problem:
    """Weighted residuals of data and priors as a function of the variables of a fit.

    A sample that is not independent of others counts less: in the likelihood of the data, not in
    that of the priors.
    """

    model: Model
    data: Array = field(init=False)
    # Standard deviation of a sample times the root of the number of samples for which it stands.
    sigma: Array = field(init=False)
    # Samples per independent sample, because noise is correlated; known only after a fit.
    correlated: Array = field(init=False)
    last_failure: str = ""
    # Samples that are not used because they are next to a jump, once these have been determined.
    skipped: Array = field(init=False)
    smooth: bool = False
    _latest: tuple[bytes, Array] | None = None

    def __post_init__(self) -> None:
        pairs = [signal for _, signal in self.model.traces]
        self.data = np.concatenate([each.values[each.valid] for each in pairs])
        self.sigma = np.concatenate([each.sigma * each.counted**0.5 for each in pairs])
        self.correlated = np.ones(len(self.data))
        self.skipped = np.zeros(len(self.data), bool)

    @property
    def scale(self) -> Array:
        """Deviations of samples whose residuals are 1."""
        return np.asarray(self.sigma * self.correlated**0.5)

    @property
    def expected(self) -> float:
        """Expected sum of the squared residuals of data and priors at the true values."""
        pairs = [signal for _, signal in self.model.traces]
        priors = sum(each.prior is not None for each in self.model.parameters)
        return priors + float(sum(np.sum(1.0 / each.counted) for each in pairs))

    def set_correlated(self, correlated: Array) -> None:
        """Set the number of samples per independent one, for each sample."""
        self.correlated, self._latest = correlated, None

    def skip_next_to_jumps(self, variables: Array, *, more: bool) -> bool:
        """Skip the samples next to jumps, alone or in addition; return whether any mask changes.

        These are the jumps at the variables and at the ends of the differences there, because a
        small change of a parameter can add a jump or move it by several samples.
        """
        values = self.model.values(variables)
        shots = range(len(self.model.chains))
        found = np.concatenate([self._next_to_jumps(shot, values) for shot in shots])
        if more:
            found |= self.skipped
        changed = not self.smooth or bool((found != self.skipped).any())
        self.skipped, self.smooth, self._latest = found, True, None
        return changed

    def _next_to_jumps(self, shot: int, values: Mapping[Name, float]) -> Array:
        """Mask of the valid samples of a shot next to jumps, also at the ends of differences."""
        own = self.model.variables(values, shot)
        signals = self.model.traces.shots[shot].signals
        mask = np.zeros(sum(int(each.valid.sum()) for each in signals), bool)
        points = [values]
        for j, each in enumerate(self.model.parameters):
            if each.shot in (None, shot):
                ends = list(self._ends(shot, own, j, self.step(j)).values())
                cheap = not any(self.model.needs_simulation(end, shot) for end in ends)
                points += ends if cheap else ends[:1]
        for point in points:
            try:
                parts = self.model.next_to_jumps(shot, point, MIN_JUMP)
            except (SimulationError, InputError) as error:
                self.last_failure = str(error)
                continue
            pairs = zip(parts, signals, strict=True)
            mask |= np.concatenate([part[signal.valid] for part, signal in pairs])
        return mask

    def predicted(self, values: Mapping[Name, float], shot: int | None = None) -> Array:
        """Predicted values of the valid samples of one shot, or of all shots."""
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
                found = (self.predicted(values) - self.data) / self.scale
        except (SimulationError, InputError) as error:
            self.last_failure = str(error)
            found = np.full(len(self.data), np.inf)
        found[self.skipped] = 0.0
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
        """Derivatives of the residuals with respect to the variables.

        Each shot is differentiated in the units of its motion, in which changes of stiffness and
        velocity require no simulation; then the derivatives are converted.
        """
        values = self.model.values(variables)
        rows = []
        for shot in range(len(self.model.chains)):
            own = self.model.variables(values, shot)
            columns = self._shot_jacobian(shot, own)
            if shot:
                columns = columns @ self._conversion(variables, shot)
            rows.append(columns)
        used = ~self.skipped[:, None]
        rows = [np.where(used, np.concatenate(rows) / self.scale[:, None], 0.0)]
        priors = differences(lambda u: self.prior_residuals(self.model.values(u)), variables)
        found = np.concatenate((*rows, priors))
        return np.where(np.abs(found) < NEGLIGIBLE, 0.0, found)

    def _conversion(self, variables: Array, shot: int) -> Array:
        """Derivatives of the variables of a shot with respect to those of the fit."""
        return differences(lambda u: self.model.variables(self.model.values(u), shot), variables)

    def _shot_jacobian(self, shot: int, variables: Array) -> Array:
        """Derivatives of the predicted values of one shot with respect to its variables."""
        here = self.predicted(self.model.values(variables, shot), shot)
        columns = [
            self._column(shot, variables, here, j)
            if each.shot in (None, shot) else np.zeros(len(here))
            for j, each in enumerate(self.model.parameters)
        ]  # fmt: skip
        return np.column_stack(columns)

    def _column(self, shot: int, variables: Array, here: Array, j: int) -> Array:
        """Derivatives for one variable: central differences if they require no simulation."""
        step = self.step(j)
        ends = self._ends(shot, variables, j, step)
        cheap = not any(self.model.needs_simulation(each, shot) for each in ends.values())
        rough = self.jumps and not self.smooth
        if not cheap and rough:
            step = max(step, MIN_JUMPING_STEP)
            ends = self._ends(shot, variables, j, step)
        found = {}
        for sign, each in ends.items():
            try:
                found[sign] = self.predicted(each, shot)
            except (SimulationError, InputError) as error:
                self.last_failure = str(error)
            if not (cheap or rough) and found:
                break
        if len(found) == 2:
            return np.asarray((found[1.0] - found[-1.0]) / (2.0 * step))
        for sign, signal in found.items():
            return np.asarray(sign * (signal - here) / step)
        return np.zeros(len(here))

    def _ends(
        self, shot: int, variables: Array, j: int, step: float
    ) -> dict[float, dict[Name, float]]:
        """Values one step above and below, where the bounds allow them."""
        low, high = self.bounds()
        ends = {}
        for sign in (1.0, -1.0):
            moved = variables.copy()
            moved[j] += sign * step
            if low[j] <= moved[j] <= high[j]:
                ends[sign] = self.model.values(moved, shot)
        return ends

    def step(self, j: int) -> float:
        """Step of a difference."""
        return self.model.parameters[j].kind.step

    @cached_property
    def jumps(self) -> bool:
        """Whether forces jump during a contact."""
        laws = {law for chain in self.model.chains for law in chain.contact_losses}
        return any(isinstance(law, JUMPING) for law in laws)

    def bounds(self) -> tuple[Array, Array]:
        """Bounds of the variables."""
        ends = [self.model.bounds_of(each) for each in self.model.parameters]
        low, high = zip(*ends, strict=True)
        return np.array(low), np.array(high)
