"""Least squares from one or several starts; trial runs that fail are rejected steps."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import SimulationError
from ..representation import measure
from .model import Model
from .names import Name
from .parameters import Parameter
from .problem import Problem
from .starts import (
    MASSES,
    SCAN,
    aligned,
    further_starts,
    scaled_losses,
    with_other_losses,
)
from .weights import goodness_of_problem

FTOL, XTOL, GTOL = 1e-7, 1e-9, 1e-10
# Tolerance before the samples next to jumps are known, when chi-squared is not smooth.
ROUGH_FTOL: Final = 1e-3
# Largest number of searches without the samples next to jumps.
MAX_ROUNDS: Final = 8
MAX_EVALUATIONS: Final = 60
# Evaluations from each start of a scan of the loss, which are enough to recognise the best optimum.
SCAN_EVALUATIONS: Final = 4
# Sum of squares, over its expectation, above which further starts are tried even if the noise is
# too uncertain to reject the fit.
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
    scan : str
        Losses from which other starts were tried, in words; empty without a scan.
    note : str
        Sentence on the start that the scan has found, if it led to the best solution.
    """

    variables: Array
    residuals: Array
    jacobian: Array
    converged: bool
    reason: str
    starts: int
    scan: str = ""
    note: str = ""

    @property
    def cost(self) -> float:
        """Sum of squares."""
        return float(self.residuals @ self.residuals)


def solve(problem: Problem, values: dict[Name, float], starts: int, *, align: bool) -> Solution:
    """The best solution of at most this many starts; more than one only if the first is poor."""
    first = aligned(problem.model, values) if align else dict(values)
    best = _from(problem, problem.model.variables(first))
    tried, scan, note = 1, "", ""
    # A mass has one optimum above and one below that of the other balls.
    least = 2 if any(name.key in MASSES for name in problem.model.names) else 1
    if not _accepted(problem, best):
        others = further_starts(problem.model, first, starts)
        if starts > 1 and (lossy := scaled_losses(problem.model)):
            scan = _between(lossy[0], problem.model, first)
            others = itertools.chain(_scanned(problem, first, align=align), others)
        for start in others:
            found = _from(problem, problem.model.variables(start))
            tried += 1
            # Two starts with the same optimum have probably found the global one.
            same = abs(found.cost - best.cost) < SAME * best.cost
            if found.cost < best.cost:
                if found.cost < (1.0 - SAME) * best.cost:
                    moved = bool(scan) and start[lossy[0].name] != first[lossy[0].name]
                    note = _start_note(lossy[0], first, start) if moved else ""
                best = found
            if (same and tried > least) or _accepted(problem, best):
                break
    if problem.jumps:
        best = _without_jumps(problem, best)
    return replace(best, starts=tried, scan=scan, note=note)


def _accepted(problem: Problem, found: Solution) -> bool:
    """Whether no better minimum is sought: the search has ended, and the data do not reject it."""
    if not found.converged or found.cost > GOOD * problem.expected:
        return False
    if problem.jumps and not problem.smooth:
        return True  # residuals next to jumps are not those of noise
    good = goodness_of_problem(problem, found.residuals)
    return good.accepted or good.only_noise


def _scanned(
    problem: Problem, first: dict[Name, float], *, align: bool
) -> Iterator[dict[Name, float]]:
    """The start with another loss whose first steps lead to the least chi-squared."""
    model = problem.model
    best, least = None, np.inf
    for factor in SCAN:
        start = with_other_losses(model, first, factor)
        try:
            start = aligned(model, start) if align else start
            found = _from(problem, model.variables(start), ROUGH_FTOL, SCAN_EVALUATIONS)
        except SimulationError:
            continue
        if found.cost < least:
            best, least = start, found.cost
    if best is not None:
        yield best


def _between(each: Parameter, model: Model, first: dict[Name, float]) -> str:
    """The losses from which a scan starts, in words."""
    ends = [with_other_losses(model, first, factor)[each.name] for factor in SCAN]
    return f"{each.name} from {_shown(each, min(ends))} to {_shown(each, max(ends))}"


def _start_note(each: Parameter, first: dict[Name, float], start: dict[Name, float]) -> str:
    """The loss from which a better solution was found than from the first start."""
    old, new = (_shown(each, values[each.name]) for values in (first, start))
    return (
        f"from {each.name} = {old}, the search ended at a larger chi2; this fit starts from "
        f"{each.name} = {new}"
    )


def _shown(each: Parameter, value: float) -> str:
    unit = each.kind.unit
    return measure(value, unit) if unit == "s" else f"{value:.4g} {unit}".rstrip()


def solve_again(problem: Problem, solution: Solution) -> Solution:
    """The solution with other weights of the samples, from one with the former weights."""
    again = _from(problem, solution.variables)
    return replace(again, starts=solution.starts, scan=solution.scan, note=solution.note)


def roughly_solved(problem: Problem, evaluations: int | None = None) -> Solution:
    """The solution from the starts of the parameters, whose sum of squares is 0.1% too large."""
    starts = {each.name: each.start for each in problem.model.parameters}
    return _from(problem, problem.model.variables(starts), ROUGH_FTOL, evaluations)


def _without_jumps(problem: Problem, best: Solution) -> Solution:
    """The solution without the samples next to jumps, which move with the solution."""
    for tried in range(MAX_ROUNDS):
        # From the third round on, omitted samples remain omitted: the rounds must end.
        if not problem.skip_next_to_jumps(best.variables, more=tried > 1):
            break
        best = _from(problem, best.variables)
    return best


def _from(
    problem: Problem, start: Array, tolerance: float = FTOL, evaluations: int | None = None
) -> Solution:
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
            ftol=ftol, xtol=XTOL, gtol=GTOL, max_nfev=evaluations or MAX_EVALUATIONS,
        )  # fmt: skip
    reason = found.message.rstrip(".").replace("`", "")
    if found.status == 0:
        reason = f"not converged after {MAX_EVALUATIONS} evaluations"
        if problem.last_failure:
            reason += f"; the last trial that failed: {problem.last_failure}"
    return Solution(found.x, found.fun, found.jac, found.status > 0, reason, 1)
