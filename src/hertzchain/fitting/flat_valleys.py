"""Derivatives by gaps along valleys of chi-squared that are flatter than small steps show.

If the beads separate before they cross a gap, a larger gap only delays the signals, exactly as the
time offset does.  The grid of a simulation changes interpolated signals by a small part of their
noise, but within a fraction of its spacing, so that their derivatives seem to distinguish a gap
from the time offset.  Steps of a standard error show that they do not.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from ..collision import Array
from .least_squares import Solution
from .problem import Problem

# Part of a derivative that differs from those by other parameters, below which it is checked.
INDEPENDENT: Final = 0.03
# Change of the residuals by one standard error, which is 1 if the derivatives are accurate.
FLAT: Final = 0.5
# Largest ratio of the error of a check to that of the one before, and number of checks.
GROWTH, CHECKS = 4.0, 6
GAPS: Final[tuple[str, ...]] = ("gap", "left_wall.gap", "right_wall.gap")


def along_valleys(problem: Problem, solution: Solution) -> Solution:
    """The solution with derivatives by gaps from steps of a standard error in flat valleys."""
    parameters = problem.model.parameters
    for j, each in enumerate(parameters):
        if each.name.key in GAPS:
            solution = replace(solution, jacobian=_with_secant(problem, solution, j))
    return solution


def derivatives_at(problem: Problem, variables: Array) -> Array:
    """Derivatives of the residuals at variables that need not be those of an optimum."""
    residuals, jacobian = problem.residuals(variables), problem.jacobian(variables)
    return along_valleys(problem, Solution(variables, residuals, jacobian, True, "", 1)).jacobian


def _with_secant(problem: Problem, solution: Solution, j: int) -> Array:
    """The derivatives, with that by one gap from steps along its valley if this is flat."""
    jacobian = solution.jacobian.copy()
    longest = np.inf
    for _ in range(CHECKS):
        step = _one_error(jacobian, j)
        if step is None:
            break
        step *= min(1.0, longest / abs(step[j]))
        longest = GROWTH * abs(step[j])
        change = _change(problem, solution, step)
        expected = jacobian @ step
        if change is None or np.linalg.norm(change) > FLAT * np.linalg.norm(expected):
            break
        jacobian[:, j] += (change - expected) / step[j]
    return jacobian


def _one_error(jacobian: Array, j: int) -> Array | None:
    """Changes of all variables if one changes by its error; none if it is independent of others."""
    size = np.linalg.norm(jacobian[:, j])
    others = np.delete(jacobian, j, axis=1)
    used = np.linalg.norm(others, axis=0)
    used[used == 0.0] = 1.0
    response = np.linalg.lstsq(others / used, -jacobian[:, j], rcond=1e-12)[0] / used
    rest = np.linalg.norm(jacobian[:, j] + others @ response)
    if rest == 0.0 or rest > INDEPENDENT * size:
        return None
    return np.asarray(np.insert(response, j, 1.0) / rest)


def _change(problem: Problem, solution: Solution, step: Array) -> Array | None:
    """Half of the change of the residuals between both ends of a step, or from the optimum."""
    low, high = problem.bounds()
    ends = []
    for sign in (1.0, -1.0):
        variables = solution.variables + sign * step
        if np.all((low <= variables) & (variables <= high)):
            ends.append(sign * (problem.residuals(variables) - solution.residuals))
    ends = [each for each in ends if np.all(np.isfinite(each))]
    return np.mean(ends, axis=0) if ends else None
