"""Search for the gap, odd bead or loose contact that explains most of the residuals."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from ..collision import Array
from ..errors import InputError, SimulationError
from ..representation import SUMMARY_WIDTH, counted, folded, short
from ..validation.keywords import checked_arguments, checked_methods
from ..validation.numbers import whole_number
from ..validation.objects import Progress, callback, check_choice, check_type
from .diagnosis import diagnosed
from .fit import fitted
from .least_squares import roughly_solved
from .model import Model
from .names import Name
from .parameters import Parameter, kind_and_value
from .problem import Problem
from .result import FitResult
from .summary_width import summary_width
from .symmetry import units_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Parameter of each kind of defect, and its trial sizes: for a gap in units of the motion, otherwise
# the relative change of a radius or stiffness, in both directions.  Large changes shift the signals
# by so much that a linear extrapolation from small ones may have the wrong sign.
KINDS: Final = {
    "gap": ("gap", tuple(0.02 * 2.0**power for power in range(7))),
    "bead": ("radius", tuple(2e-3 * 2.0**power for power in range(6))),
    "contact": ("stiffness", tuple(0.02 * 2.0**power for power in range(5))),
}
# The kind of defect, its places, and the sizes that are tried.
WORDS: Final = {
    "gap": ("a gap at each of", "contact", "seven sizes each"),
    "bead": ("another radius of each of", "bead", "twelve sizes each"),
    "contact": ("another stiffness of each of", "contact", "ten values each"),
}
# Least reduction of chi-squared by a defect that is reported.
FOUND: Final = 20.0
# Defects are fitted to full accuracy if the sum of squares of a rough fit is below this multiple of
# the least one.
CLOSE: Final = 1.01
# Number of successive defects, in the order of the parts that they explain, after which no further
# one is fitted if none of them is better than one before.
PATIENCE: Final = 6
# Sizes agree worse if the sum of squares is larger than at the size before, and than this multiple
# of that without a defect; no larger size is tried after this number in succession.
WORSE, MAX_WORSE = 1.1, 2
# Number of defects in a summary.
SHOWN: Final = 5


@checked_methods
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
        Estimated reduction of chi-squared, in which the other parameters adjust linearly.
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
    def chi2(self) -> float:
        """Chi-squared of the fit without a defect, in which correlated samples count less."""
        problem = self.result.problem
        own = self.result.residual_vector[: len(problem.data)]
        return float(own @ own)

    @property
    def freedom(self) -> float:
        """The chi-squared of noise alone: the number of its samples minus free parameters."""
        good = self.result.goodness
        return good.effective_samples - good.parameters if self._correlated else good.freedom

    @property
    def _correlated(self) -> bool:
        """Whether the residuals measure correlated noise, so that its samples count less."""
        return bool(np.any(self.result.problem.correlated != 1.0))

    @property
    def best(self) -> str:
        """Name of the defect that explains the largest part."""
        return self.names[int(np.argmax(self.improvements))]

    @property
    def found(self) -> bool:
        """Whether the best defect explains more than noise would."""
        return float(self.improvements.max()) > FOUND

    @property
    def changes(self) -> Array:
        """Estimated gaps [m], or relative changes of radii or stiffnesses."""
        return self.sizes if self.kind == "gap" else self.sizes / self._nominal - 1.0

    @property
    def _nominal(self) -> Array:
        model = self.result.model
        names = [_name(self.kind, self.result, i) for i in range(len(self.names))]
        return np.array([kind_and_value(n, model.traces, model.chains)[1] for n in names])

    def summary(self, *, width: int | None = SUMMARY_WIDTH) -> str:
        """Method, the defects that would explain the most, their sizes, and the conclusion.

        Parameters
        ----------
        width
            Number of columns at which lines are broken; None keeps each sentence on one line.

        Examples
        --------
        >>> import hertzchain as hc
        >>> scan = hc.scan_defects(hc.fit(*hc.example_experiment()))
        >>> print(scan.summary().splitlines()[-1])
        no gap explains more than noise would (a chi2 lower by 20)
        """
        what, place, tried = WORDS[self.kind]
        good = self.result.goodness
        samples = f"{good.samples} samples"
        if self._correlated:
            samples = f"{good.effective_samples:.0f} independent samples"
        lines = [
            f"scan for {what} {counted(len(self.names), place)}, {self.names[0]} to "
            f"{self.names[-1]}: {tried};",
            "the other parameters of the fit adjust linearly",
            f"the fit without it: chi2 {_rounded(self.chi2)} of {samples}",
            f"  {'defect':<16}{'lowers chi2 by':>16}{'size':>12}",
        ]
        order = np.argsort(-self.improvements, kind="stable")[:SHOWN]
        lines += [
            f"  {self.names[i]:<16}{_rounded(self.improvements[i]):>16}{self._size_text(i):>12}"
            + self._remark(i)
            for i in order
        ]
        if rest := len(self.names) - len(order):
            lines.append(f"  {counted(rest, f'other {place}')}: at most "
                         f"{_rounded(np.sort(self.improvements)[-SHOWN - 1])}")  # fmt: skip
        if self.found:
            lines.append(f"{self.best} explains more than noise would (a chi2 lower by {FOUND:g})")
        else:
            lines.append(f"no {self.kind} explains more than noise would (a chi2 lower by "
                         f"{FOUND:g})")  # fmt: skip
        return folded("\n".join(lines), summary_width(width))

    @property
    def places(self) -> Array:
        """Numbers of the balls, without the striker; for a contact, the mean of its two."""
        first = 1 if self.kind == "bead" else 1.5 - self.result.chain.strikers
        return first + np.arange(len(self.names))

    def _size_text(self, i: int) -> str:
        """Size of a defect, such as ``"0.4 um"`` or ``"+3%"``."""
        change = float(self.changes[i])
        return f"{1e6 * change:.3g} um" if self.kind == "gap" else f"{100.0 * change:+.2g}%"

    def _remark(self, i: int) -> str:
        """Whether the size is one of the largest that were tried."""
        tried, change = KINDS[self.kind][1], abs(float(self.changes[i]))
        if self.kind == "gap":
            largest = tried[-1] * units_of(self.result.chain).scales.length
            return "  largest gap that was tried" if change > 0.999 * largest else ""
        return "  largest change that was tried" if change > 0.999 * tried[-1] else ""

    def plot(self, *, legend: bool = True, ax: Axes | None = None) -> Axes:
        """Plot the estimated chi-squared of the fit with one defect against its place.

        The best defect has a larger symbol.  Scans of several kinds can share axes.

        Parameters
        ----------
        legend : bool
            Whether the axes have a legend.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; by default those of a new figure.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> import hertzchain as hc
        >>> scan = hc.scan_defects(hc.fit(*hc.example_experiment()))
        >>> scan.plot().get_ylabel()
        '$\\\\chi^2$ with one defect'
        """
        from ..plotting.defects import plot_defect_scans

        return plot_defect_scans([self], legend=legend, ax=ax)

    def fit(self, candidates: int | None = None, *, progress: Progress | None = None) -> FitResult:
        """Fit the defects, each in a separate fit, and return the best fit.

        Parameters
        ----------
        candidates : int, optional
            Number of defects to try, in the order of the parts that they explain; by default, until
            six in succession are no better than one before.  The first is often, but not always,
            the right one: a defect also changes the other parameters, which the scan takes into
            account only to first order.
        progress : callable, optional
            Called as ``progress(done, total)`` after each fit.

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
        >>> scan = hc.scan_defects(hc.fit(*hc.example_experiment()))
        >>> fitted = scan.fit(candidates=1)  # doctest: +SKIP
        """
        return diagnosed(fit_of_defect(self, candidates, progress=progress), {}, fitted)

    def _repr_html_(self) -> str:
        from ..notebook.fits import defect_scan_html

        return defect_scan_html(self)

    def __str__(self) -> str:
        return self.summary()

    def __repr__(self) -> str:
        i = int(np.argmax(self.improvements))
        change = "of about" if self.kind == "gap" else "changed by about"
        rest = float(np.sort(self.improvements)[-2]) if len(self.names) > 1 else 0.0
        size, lowers = self._size_text(i), f"lowers chi2 by {self.improvements[i]:.0f}"
        text = f"{self.best} {change} {size} {lowers}"
        other = f"the next by {rest:.0f}; call fit()"
        if not self.found:
            text, other = f"no {self.kind} explains more than noise would", ""
        return short("DefectScan", self.kind, text, other)


def defect_names(result: FitResult, kind: str) -> list[str]:
    """Names of the defects of a kind, in the order in which a scan tries them."""
    chain = result.model.chains[0]
    count = len(chain.radii[chain._balls]) if kind == "bead" else chain.beads - 1
    return [str(_name(kind, result, i)) for i in range(count)]


def candidates_of(scan: DefectScan) -> list[str]:
    """Names of the defects of a scan, in the order in which they are fitted."""
    return [scan.names[i] for i in np.argsort(-scan.improvements, kind="stable")]


def fit_of_defect(
    scan: DefectScan, candidates: int | None = None, *, progress: Progress | None = None
) -> FitResult:
    """The best fit with one defect; `DefectScan.fit` also searches for further causes."""
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
    if progress is not None:
        progress(count, count)
    if not found:
        raise SimulationError("no chain with one of the defects can be simulated")
    limit = CLOSE * min(costs) + FOUND
    near = [problem for cost, problem in zip(costs, found, strict=True) if cost <= limit]
    tried = [fitted(each, {str(p): p.start for p in each.model.parameters}, 1) for each in near]
    return min(tried, key=lambda each: each.chi2 + each.penalty)


def _problem_with(scan: DefectScan, i: int) -> Problem:
    """The problem with a defect as a further parameter, whose start is that of the scan."""
    name, size = _name(scan.kind, scan.result, i), float(scan.sizes[i])
    model = _with_parameter(scan.result.model, name, size)
    starts = dict(zip(scan.result.model.names, scan.result.estimates.tolist(), strict=True))
    return _from(model, {**starts, name: size})


def _from(model: Model, starts: Mapping[Name, float]) -> Problem:
    """The problem of a model whose parameters start from these values."""
    parameters = tuple(replace(each, start=starts[each.name]) for each in model.parameters)
    return Problem(replace(model, parameters=parameters))


def _rounded(chi2: float) -> str:
    return f"{chi2:.0f}" if abs(chi2) >= 100.0 else f"{chi2:.3g}"


@checked_arguments("scan_defects")
def scan_defects(
    result: FitResult, kind: str = "gap", *, progress: Progress | None = None
) -> DefectScan:
    """Find the contact or bead where one defect explains most of the residuals of a fit.

    Each defect is added to the fit, with up to seven sizes of a gap, twelve radii of a bead from
    6.4% smaller to 6.4% larger, or ten stiffnesses of a contact from 32% smaller to 32% larger; no
    larger change is tried after two that agree worse and worse.  All other parameters adjust
    linearly.

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
    count = len(defect_names(result, kind))
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
    """Reduction of chi-squared by one defect, and its size there."""
    model, problem = result.model, result.problem
    values = model.values(result.variables)
    sizes = next(sizes for key, sizes in KINDS.values() if key == name.key)
    _, nominal = kind_and_value(name, model.traces, model.chains)
    unit = units_of(result.chain).scales.length if name.key == "gap" else nominal
    changed = Problem(_with_parameter(model, name, nominal))

    def unexplained(residuals: Array) -> Array:
        return np.asarray(residuals - result.jacobian @ (inverse @ residuals))

    def residuals_at(size: float) -> Array:
        predicted = changed.predicted({**values, name: size})
        found = (predicted - problem.data) / problem.scale
        found[problem.skipped] = 0.0
        return np.concatenate((found, result.residual_vector[len(found) :]))

    without = unexplained(result.residual_vector)
    best = (0.0, nominal)
    for direction in (1.0,) if name.key == "gap" else (1.0, -1.0):
        last, rest, worse = nominal, without, 0
        for trial in sizes:
            if worse == MAX_WORSE:
                break
            size = nominal + direction * trial * unit
            try:
                rest_there = unexplained(residuals_at(size))
            except SimulationError:
                break
            # Between two sizes, the residuals are nearly linear.
            step = rest_there - rest
            part = -float(rest @ step) / max(float(step @ step), np.finfo(float).tiny)
            part = min(max(part, 0.0), 1.0)
            there = rest + part * step
            gained = float(without @ without) - float(there @ there)
            best = max(best, (gained, last + part * (size - last)))
            before, after = (float(each @ each) for each in (rest, rest_there))
            worse = worse + 1 if after > max(before, WORSE * float(without @ without)) else 0
            last, rest = size, rest_there
    return best
