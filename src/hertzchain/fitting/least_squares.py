"""Least squares from one or several starts; trial runs that fail are rejected steps."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import SimulationError
from .names import Name
from .problem import Problem
from .starts import MASSES, aligned, further_starts

FTOL, XTOL, GTOL = 1e-7, 1e-9, 1e-10
# Tolerance before the samples next to jumps are known, when chi-squared is not smooth.
ROUGH_FTOL: Final = 1e-3
# Largest number of searches without the samples next to jumps.
MAX_ROUNDS: Final = 8
MAX_EVALUATIONS: Final = 60
# No further start is tried if chi-squared per sample is below this value.
GOOD: Final = 1.3
# Sums of squares whose relative difference is less than this belong to the same optimum.
SAME: Final = 1e-3


@dataclass(frozen=True, eq=False)
class Solution:
    """Best variables found, with residuals and derivatives there.

    Attributes
    ----------
    variables, residuals : ndarray
        Best variables; weighted residuals, those of the priors last.
    jacobian : ndarray
        Derivatives of the residuals.
    converged : bool
        Whether the search ended at a minimum.
    reason : str
        Reason for the end of the search.
    starts : int
        Number of starts.
    """

    variables: Array
    residuals: Array
    jacobian: Array
    converged: bool
    reason: str
    starts: int

    @property
    def cost(self) -> float:
        """Sum of squares."""
        return float(self.residuals @ self.residuals)


def solve(problem: Problem, values: dict[Name, float], starts: int, *, align: bool) -> Solution:
    """The best solution of at most this many starts; more than one only if the first is poor."""
    first = aligned(problem.model, values) if align else dict(values)
    best = _from(problem, problem.model.variables(first))
    tried = 1
    # A mass has one optimum above and one below that of the other balls.
    least = 2 if any(name.key in MASSES for name in problem.model.names) else 1
    if best.cost > GOOD * problem.expected:
        for start in further_starts(problem.model, first, starts):
            found = _from(problem, problem.model.variables(start))
            tried += 1
            # Two starts with the same optimum have probably found the global one.
            same = abs(found.cost - best.cost) < SAME * best.cost
            if found.cost < best.cost:
                best = found
            if (same and tried > least) or best.cost <= GOOD * problem.expected:
                break
    if problem.jumps:
        best = _without_jumps(problem, best)
    return replace(best, starts=tried)


def solve_again(problem: Problem, solution: Solution) -> Solution:
    """The solution with other weights of the samples, from one with the former weights."""
    return replace(_from(problem, solution.variables), starts=solution.starts)


def roughly_solved(problem: Problem) -> Solution:
    """The solution from the starts of the parameters, whose sum of squares is 0.1% too large."""
    starts = {each.name: each.start for each in problem.model.parameters}
    return _from(problem, problem.model.variables(starts), ROUGH_FTOL)


def _without_jumps(problem: Problem, best: Solution) -> Solution:
    """The solution without the samples next to jumps, which move with the solution."""
    for tried in range(MAX_ROUNDS):
        # From the third round on, omitted samples remain omitted: the rounds must end.
        if not problem.skip_next_to_jumps(best.variables, more=tried > 1):
            break
        best = _from(problem, best.variables)
    return best


def _from(problem: Problem, start: Array, tolerance: float = FTOL) -> Solution:
    from scipy.optimize import least_squares

    low, high = problem.bounds()
    margin = 1e-9 * np.maximum(1.0, np.abs(start))
    start = np.clip(start, low + margin, high - margin)
    if not np.all(np.isfinite(problem.residuals(start))):
        raise SimulationError(
            f"the chain cannot be simulated with the values from which the fit starts: "
            f"{problem.last_failure}"
        )
    ftol = ROUGH_FTOL if problem.jumps and not problem.smooth else tolerance
    with warnings.catch_warnings():
        # Rejected trials have infinite residuals.
        warnings.simplefilter("ignore", RuntimeWarning)
        found = least_squares(
            problem.residuals, start, jac=problem.jacobian, bounds=(low, high), x_scale="jac",
            ftol=ftol, xtol=XTOL, gtol=GTOL, max_nfev=MAX_EVALUATIONS,
        )  # fmt: skip
    reason = found.message.rstrip(".").replace("`", "")
    if found.status == 0:
        reason = f"not converged after {MAX_EVALUATIONS} evaluations"
        if problem.last_failure:
            reason += f"; the last trial that failed: {problem.last_failure}"
    return Solution(found.x, found.fun, found.jac, found.status > 0, reason, 1)
