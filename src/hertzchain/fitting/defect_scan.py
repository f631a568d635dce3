"""Search for the gap, odd bead or loose contact that explains most of the residuals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from ..collision import Array
from ..errors import InputError, SimulationError
from ..representation import short
from ..validation.numbers import whole_number
from ..validation.objects import callback, check_choice, check_type
from .fit import fitted
from .model import Model
from .names import Name
from .parameters import Parameter, kind_and_value
from .problem import Problem
from .result import FitResult
from .symmetry import units_of

# Parameter of each kind of defect, and its trial change: a gap in units of the motion, a relative
# change of radius or stiffness.
KINDS: Final = {"gap": ("gap", 0.02), "bead": ("radius", 2e-3), "contact": ("stiffness", 0.02)}
# Least reduction of chi-squared by a defect that is reported.
FOUND: Final = 20.0


@dataclass(frozen=True, eq=False)
class DefectScan:
    """Part of chi-squared that a defect at each contact or bead would explain.

    Attributes
    ----------
    kind : str
        ``"gap"``, ``"bead"`` or ``"contact"``.
    names : tuple of str
        Parameters of the defects, such as ``"gap[8-9]"``.
    improvements : ndarray
        Reduction of chi-squared in the linearised fit.
    sizes : ndarray
        Values of the parameters [SI].
    result : FitResult
        The fit without a defect.
    """

    kind: str
    names: tuple[str, ...]
    improvements: Array = field(repr=False)
    sizes: Array = field(repr=False)
    result: FitResult = field(repr=False)

    @property
    def best(self) -> str:
        """Name of the defect that explains the largest part."""
        return self.names[int(np.argmax(self.improvements))]

    @property
    def found(self) -> bool:
        """Whether the best defect explains more than noise would."""
        return float(self.improvements.max()) > FOUND

    def fit(self, candidates: int = 2) -> FitResult:
        """Fit the defects that explain the largest parts, and return the best fit.

        Parameters
        ----------
        candidates : int
            Number of defects to try, each in a separate fit.

        Returns
        -------
        FitResult
            Fit with the defect as a further parameter.

        Raises
        ------
        SimulationError
            If no candidate can be simulated.

        Examples
        --------
        >>> import hertzchain as hc
        >>> scan = hc.scan_defects(hc.fit(*hc.example_experiment(), free=["time_offset"]))
        >>> fitted = scan.fit(candidates=1)  # doctest: +SKIP
        """
        count = whole_number("candidates", candidates, least=1, most=len(self.names))
        tried = []
        model = self.result.model
        for i in np.argsort(-self.improvements)[:count]:
            name = _name(self.kind, self.result, int(i))
            more = _with_parameter(model, name, float(self.sizes[i]))
            start = {**self.result.values, str(name): float(self.sizes[i])}
            more = replace(
                more,
                parameters=tuple(replace(each, start=start[str(each)]) for each in more.parameters),
            )
            try:
                tried.append(fitted(Problem(more), start, 1))
            except SimulationError:
                continue
        if not tried:
            raise SimulationError("no chain with one of the defects can be simulated")
        return min(tried, key=lambda each: each.chi2 + each.penalty)

    def __repr__(self) -> str:
        i = int(np.argmax(self.improvements))
        factor, unit = (1e6, " um") if self.kind == "gap" else (1.0, "")
        rest = float(np.sort(self.improvements)[-2]) if len(self.names) > 1 else 0.0
        text = (
            f"{self.best} of about {factor * self.sizes[i]:.3g}{unit} lowers chi2 by "
            f"{self.improvements[i]:.0f}"
        )
        other = f"the next by {rest:.0f}"
        if not self.found:
            text, other = f"no {self.kind} explains more than noise would", ""
        return short("DefectScan", self.kind, text, other)


def scan_defects(
    result: FitResult, kind: str = "gap", *, progress: Callable[[int, int], None] | None = None
) -> DefectScan:
    """Find the contact or bead where one defect explains most of the residuals of a fit.

    Each defect is added to the linearised fit: one simulation per contact or bead, in which all
    other parameters adjust.

    Parameters
    ----------
    result : FitResult
        A fit without the defect.
    kind : str
        ``"gap"`` between two balls, ``"bead"`` with another radius, or ``"contact"`` with another
        stiffness.
    progress : callable, optional
        Called as ``progress(done, total)`` after each simulation.

    Returns
    -------
    DefectScan

    Raises
    ------
    InputError
        For another kind, or a chain that cannot have such a defect.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.scan_defects(hc.fit(*hc.example_experiment()))
    DefectScan(gap: no gap explains more than noise would)
    """
    check_type("result", result, FitResult, "hc.fit returns one")
    check_choice("kind of defect", kind, KINDS)
    callback("progress", progress)
    model = result.model
    balls = model.chains[0].beads - model.chains[0].strikers
    count = balls if kind == "bead" else model.chains[0].beads - 1
    inverse = np.linalg.pinv(result.jacobian, rcond=1e-12)
    names, improvements, sizes = [], [], []
    for i in range(count):
        name = _name(kind, result, i)
        gained, size = _explained(result, name, inverse)
        names.append(str(name))
        improvements.append(gained)
        sizes.append(size)
        if progress is not None:
            progress(i + 1, count)
    return DefectScan(kind, tuple(names), np.array(improvements), np.array(sizes), result)


def _name(kind: str, result: FitResult, i: int) -> Name:
    key = KINDS[kind][0]
    if kind == "bead":
        return Name(key, str(i + 1))
    ball = i + 1 - result.model.chains[0].strikers
    return Name(key, f"{ball}-{ball + 1}")


def _with_parameter(model: Model, name: Name, start: float) -> Model:
    if name in model.names:
        raise InputError(f"{name} is free already; fit without it before the scan")
    kind, _ = kind_and_value(name, model.traces, model.chains)
    return replace(model, parameters=(*model.parameters, Parameter(name, kind, start)))


def _explained(result: FitResult, name: Name, inverse: Array) -> tuple[float, float]:
    """Reduction of chi-squared and size of one defect in the linearised fit."""
    model, problem = result.model, result.problem
    values = model.values(result.variables)
    trial = KINDS[{"gap": "gap", "radius": "bead", "stiffness": "contact"}[name.key]][1]
    _, nominal = kind_and_value(name, model.traces, model.chains)
    unit = units_of(result.chain).scales.length if name.key == "gap" else nominal
    changed = _with_parameter(model, name, nominal)
    try:
        shifted = Problem(changed).predicted({**values, name: nominal + trial * unit})
    except SimulationError:
        return 0.0, nominal
    difference = (shifted - problem.predicted(values)) / problem.sigma / (trial * unit)
    difference[problem.skipped] = 0.0
    column = np.concatenate((difference, np.zeros(len(result.residual_vector) - len(difference))))
    rest = column - result.jacobian @ (inverse @ column)
    along, size = -float(rest @ result.residual_vector), float(rest @ rest)
    change = along / size if size > 0.0 else 0.0
    if name.key == "gap" and nominal + change < 0.0:
        return 0.0, nominal
    return along * change, nominal + change
