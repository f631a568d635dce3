"""Offsets, gains, delays and other effects of sensors that a fit does not include, in groups."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..collision import Array
from .model import Model
from .names import Name
from .systematics import EFFECTS, derivative

if TYPE_CHECKING:
    from .result import FitResult


def gained_by(result: FitResult, groups: Sequence[tuple[Name, ...]]) -> list[float]:
    """Reduction of chi-squared by each group of effects of sensors, in the linearised fit."""
    problem, values = result.problem, result.model.values(result.variables)
    # Samples count as if they were not correlated: the residuals of an effect are.
    weights = np.ones(len(result._residual_vector))
    weights[: len(problem.data)] = problem.correlated**0.5
    jacobian = weights[:, None] * result.jacobian
    residuals = weights * result._residual_vector
    inverse = np.linalg.pinv(jacobian, rcond=1e-12)
    columns: dict[Name, Array] = {}
    found = []
    for names in groups:
        for name in names:
            if name not in columns:
                own = derivative(problem, values, name, result._residual_vector)
                columns[name] = weights * own
        block = np.column_stack([columns[name] for name in names])
        rest = block - jacobian @ (inverse @ block)
        scale = np.linalg.norm(block, axis=0)
        scale[scale == 0.0] = 1.0
        left, sizes, _ = np.linalg.svd(rest / scale, full_matrices=False)
        left = left[:, sizes > 1e-6]
        found.append(float(np.sum((left.T @ residuals) ** 2)))
    return found


def groups_of_effects(result: FitResult) -> Iterator[tuple[Name, ...]]:
    """Effects of sensors that are not free: of one sensor, of all, and of single shots."""
    model = result.model
    keys = {name.key for name in model.names}
    shots = model.traces.shots
    several = any(len(shot.signals) > 1 for shot in shots)
    for key in EFFECTS:
        if key not in keys and (several or key != "crosstalk"):
            yield (Name(key),)
    # One sensor has no delay apart from the time offset, and all sensors have none in common.
    for key in ("offset", "gain", "delay") if several else ("offset", "gain"):
        if any(name.key == key and not name.item for name in model.names):
            continue
        names = [each for item in model.traces.names for each in _not_free(key, item, model)]
        yield from ((name,) for name in names)
        of_shots = {
            part: [each for each in names if each.shot == part]
            for part in dict.fromkeys(each.shot for each in names)
        }
        of_sensors = {
            part: [each for each in names if each.shot and each.item == part]
            for part in model.traces.names
        }
        groups = [*(of_shots.values() if key != "delay" else ()), *of_sensors.values()]
        yield from (tuple(group) for group in groups if len(group) > 1)


def _not_free(key: str, item: str, model: Model) -> Iterator[Name]:
    """A parameter of one sensor in all shots and in each shot, unless it is free there."""
    shots = model.traces.shots
    free = {each.shot for each in model.names if (each.key, each.item) == (key, item)}
    if not free:
        yield Name(key, item)
    # The common parameter needs a shot without its own.
    if len(shots) == 1 or ("" in free and len(free) == len(shots)):
        return
    common = [k for k in range(1, len(shots) + 1) if str(k) not in free]
    if "" in free and len(common) == 2:
        # One of them keeps the common parameter; that of the other gives the same fit either way.
        del common[0]
    for k in common:
        signals = shots[k - 1].signals
        seen = any(signal.name == item for signal in signals)
        if seen and (key != "delay" or len(signals) > 1):
            yield Name(key, item, str(k))
