"""Fits of the defects of a scan, each in a separate fit."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from ..errors import InputError, SimulationError
from ..representation import listed
from ..validation.numbers import whole_number
from ..validation.objects import Progress, callback
from .fit import fitted
from .gap_causes import note_on_size
from .least_squares import roughly_solved
from .model import Model
from .names import Name, parse_name
from .parameters import Parameter, kind_and_value
from .problem import Problem
from .result import FitResult
from .systematics import PRESENT

if TYPE_CHECKING:
    from .defect_scan import DefectScan

# Defects are fitted to full accuracy if the sum of squares of a rough fit is below this multiple of
# the least one, or exceeds it by less than noise would.
CLOSE, NOISE = 1.01, 20.0
# Number of successive defects, in the order of the parts that they explain, after which no further
# one is fitted if none of them is better than one before.
PATIENCE: Final = 6
# Number of the best odd balls whose mass is fitted instead of the size.
WITH_MASS: Final = 3


def candidates_of(scan: DefectScan) -> list[str]:
    """Names of the defects of a scan, in the order in which they are fitted."""
    return [scan.names[i] for i in np.argsort(-scan.improvements, kind="stable")]


def fit_of_defect(
    scan: DefectScan, candidates: int | None = None, *, progress: Progress | None = None
) -> FitResult:
    """The best fit with one defect; `DefectScan.fit` also searches for further causes."""
    return fits_of_defect(scan, candidates, progress=progress)[0]


def fits_of_defect(
    scan: DefectScan, candidates: int | None = None, *, progress: Progress | None = None
) -> list[FitResult]:
    """The fits with one defect whose rough fits are similar to the best, the best first."""
    callback("progress", progress)
    total = len(scan.names)
    count = total if candidates is None else whole_number(
        "candidates", candidates, least=1, most=total
    )  # fmt: skip
    order = np.argsort(-scan.improvements, kind="stable")[:count].tolist()
    costs: list[float] = []
    found: list[Problem] = []
    for done, i in enumerate(order):
        if progress is not None and done:
            progress(done, count)
        problem = _problem_with(scan, i)
        with contextlib.suppress(SimulationError):
            solution = roughly_solved(problem)
            costs.append(solution.cost)
            found.append(_from(problem.model, problem.model.values(solution.variables)))
        if candidates is None and costs and len(costs) - int(np.argmin(costs)) > PATIENCE:
            break
    if not found:
        raise SimulationError("no chain with one of the defects can be simulated")
    if scan.kind == "bead":
        masses = _with_mass(scan, [found[i] for i in np.argsort(costs)[:WITH_MASS]])
        costs += [cost for cost, _ in masses]
        found += [problem for _, problem in masses]
    if progress is not None:
        progress(count, count)
    limit = CLOSE * min(costs) + NOISE
    near = [problem for cost, problem in zip(costs, found, strict=True) if cost <= limit]
    tried = [fitted(each, {str(p): p.start for p in each.model.parameters}, 1) for each in near]
    return sorted(tried, key=lambda each: each.chi2 + each._penalty)


def _with_mass(scan: DefectScan, problems: Sequence[Problem]) -> list[tuple[float, Problem]]:
    """Rough fits with another mass of a ball, as with a hole, instead of another size."""
    model, found = scan.result.model, []
    usual = dict(zip(model.names, scan.result.estimates.tolist(), strict=True))
    for sized in problems:
        radius = sized.model.parameters[-1]
        name = replace(radius.name, key="mass")
        if name in model.names:
            continue
        _, nominal = kind_and_value(radius.name, model.traces, model.chains)
        _, mass = kind_and_value(name, model.traces, model.chains)
        # The ball of the fitted size has this mass.
        start = mass * (radius.start / nominal) ** 3
        problem = _from(with_parameter(model, name, start), {**usual, name: start})
        with contextlib.suppress(SimulationError):
            solution = roughly_solved(problem)
            values = problem.model.values(solution.variables)
            found.append((solution.cost, _from(problem.model, values)))
    return found


def not_determined(scan: DefectScan, best: FitResult, others: Sequence[FitResult]) -> list[str]:
    """Sentences on other places that describe the data as well, and on the size of a gap."""
    name, limit = best.names[-1], best.chi2 + best._penalty + PRESENT
    near = [each for each in others if each.chi2 + each._penalty < limit]
    shown = [f"{each.names[-1]} = {each.rows()[-1][1]} (chi2 {each.chi2:.0f})" for each in near]
    lines = [
        f"not excluded: {listed(shown)} instead of {name} (chi2 {best.chi2:.0f}); the data hardly "
        f"distinguish these {'causes' if scan.kind == 'bead' else 'places'}"
    ] if shown else []  # fmt: skip
    rough = scan.rough.get(name)
    return [*lines, *([] if rough is None else note_on_size(rough, best))]


def with_parameter(model: Model, name: Name, start: float) -> Model:
    """The model in which the parameter of a defect is free, too."""
    if name in model.names:
        raise InputError(f"{name} is free already; fit without it before the scan")
    kind, _ = kind_and_value(name, model.traces, model.chains)
    return replace(model, parameters=(*model.parameters, Parameter(name, kind, start)))


def _problem_with(scan: DefectScan, i: int) -> Problem:
    """The problem with a defect as a further parameter, whose start is that of the scan."""
    if scan.names[i] in scan.rough:
        return Problem(scan.rough[scan.names[i]].problem.model)
    name, size = parse_name(scan.names[i]), float(scan.sizes[i])
    model = with_parameter(scan.result.model, name, size)
    starts = dict(zip(scan.result.model.names, scan.result.estimates.tolist(), strict=True))
    return _from(model, {**starts, name: size})


def _from(model: Model, starts: Mapping[Name, float]) -> Problem:
    """The problem of a model whose parameters start from these values."""
    parameters = tuple(replace(each, start=starts[each.name]) for each in model.parameters)
    return Problem(replace(model, parameters=parameters))
