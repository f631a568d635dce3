"""Weights of correlated samples in the likelihood of the data.

Samples per independent one are estimated from residuals, and they divide the squares of the data
only: priors keep their weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..collision import Array
from ..representation import listed
from .goodness import Goodness, correlated_samples, far_below_noise, goodness_of
from .problem import Problem


def data_residuals(problem: Problem, residuals: Array) -> Array:
    """Residuals of the data as if samples were not correlated."""
    return np.asarray(residuals[: len(problem.data)] * problem.correlated**0.5)


def goodness_of_problem(problem: Problem, residuals: Array) -> Goodness:
    """Chi-squared of the residuals of a problem."""
    parameters = len(problem.model.parameters)
    own = data_residuals(problem, residuals)
    traces, used = problem.model.traces, ~problem.skipped
    good = goodness_of(traces, own, used, parameters)
    return replace(good, explained=_explained(problem, own, used))


def _explained(problem: Problem, residuals: Array, used: Array) -> float:
    """Reduction of the sum of squares from that of constant signals, of independent samples."""
    traces = problem.model.traces
    lengths = correlated_samples(traces, residuals, used)
    total, begin = 0.0, 0
    for _, signal in traces:
        own = slice(begin, begin := begin + int(signal.valid.sum()))
        mask = used[own]
        if mask.any():
            seen, sigma = problem.data[own][mask], problem.sigma[own][mask]
            rest = (seen - np.average(seen, weights=sigma**-2)) / sigma
            squares = float(rest @ rest) - float(np.sum(residuals[own][mask] ** 2))
            total += squares / float(lengths[own][0])
    return total


def correlations(problem: Problem, residuals: Array) -> Array:
    """Samples per independent one, for each sample."""
    own = data_residuals(problem, residuals)
    return correlated_samples(problem.model.traces, own, ~problem.skipped)


def remaining_weights(problem: Problem, residuals: Array) -> Array:
    """Factors of all residuals for correlated samples whose weights the problem does not include.

    A model that does not describe the data is fitted without them, because its residuals do not
    measure the noise; its errors include them.
    """
    weights = np.ones(len(residuals))
    if np.all(problem.correlated == 1.0):
        weights[: len(problem.data)] = correlations(problem, residuals) ** -0.5
    return weights


def small_residual_notes(problem: Problem, residuals: Array) -> list[str]:
    """A note on sensors whose residuals are far smaller than their noise."""
    own = data_residuals(problem, residuals)
    names = far_below_noise(problem.model.traces, own, ~problem.skipped)
    if not names:
        return []
    return [
        f"the residuals of {listed(names)} are far smaller than the noise, so the errors are those "
        "for independent noise of this size, as in a forecast of an experiment"
    ]


def chi2_by_sensor(problem: Problem, residuals: Array) -> dict[str, float]:
    """Mean of the squared residuals over their expectation, by sensor."""
    found: dict[str, Array] = {}
    begin, own = 0, data_residuals(problem, residuals)
    for _, signal in problem.model.traces:
        counts = signal.counted
        part = slice(begin, begin + len(counts))
        used = ~problem.skipped[part]
        sums = np.array([np.sum(own[part][used] ** 2), np.sum(1.0 / counts[used])])
        found[signal.name] = found.get(signal.name, 0.0) + sums
        begin += len(counts)
    return {name: float(square / count) for name, (square, count) in found.items()}


def residuals_by_sensor(
    problem: Problem, predicted: Sequence[Sequence[Array]]
) -> list[tuple[int, str, Array]]:
    """Shot, sensor, and data minus fit over the noise; NaN where a sample is not used."""
    found, skipped = [], problem.skipped
    for index, shot in enumerate(problem.model.traces.shots):
        for signal, fitted in zip(shot.signals, predicted[index], strict=True):
            count = int(signal.valid.sum())
            used = signal.valid.copy()
            used[signal.valid] = ~skipped[:count]
            skipped = skipped[count:]
            values = np.where(used, signal.values - fitted, np.nan) / signal.sigma
            found.append((index + 1, signal.name, values))
    return found
