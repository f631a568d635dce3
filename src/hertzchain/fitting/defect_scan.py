"""Search for the gap, odd bead or loose contact that explains most of the residuals."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from ..collision import Array
from ..errors import SimulationError
from ..representation import SUMMARY_WIDTH, counted, folded, short
from ..validation.keywords import checked_arguments, checked_methods
from ..validation.objects import Progress, callback, check_choice, check_type
from .ball_counts import ball_count
from .defect_fits import fit_of_defect, with_parameter
from .diagnosis import diagnosed
from .end_gaps import end_gaps
from .fit import fitted
from .flat_valleys import GAPS
from .names import Name
from .parameters import kind_and_value
from .problem import Problem
from .result import FitResult
from .rough_gaps import WIDE, RoughGap, better_of, gap_names, own_cost, rough_gap, sizes_of
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
    "bead": ("another radius of each of", "bead", "twelve sizes each, and half of the mass"),
    "contact": ("another stiffness of each of", "contact", "ten values each"),
}
# Mass of a ball, such as one of another material, that is tried once besides its small changes.
LIGHT: Final = 0.5
# Least reduction of chi-squared by a defect that is reported.
FOUND: Final = 20.0
# Defects are nearly as good as the best one if they explain this fraction of its part.
NEARLY: Final = 0.9
# Sizes agree worse if the sum of squares is larger than at the size before, and than this multiple
# of that without a defect; no larger size is tried after this number in succession.
WORSE, MAX_WORSE = 1.1, 2
# Larger gaps are tried if the best one leaves a chi-squared above this multiple of that of noise.
MUCH: Final = 1.5
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
    rough : dict of RoughGap
        Rough fits of gaps that explain more than the linear estimate.
    """

    kind: str
    names: tuple[str, ...]
    improvements: Array = field(repr=False)
    sizes: Array = field(repr=False)
    result: FitResult = field(repr=False)
    rough: Mapping[str, RoughGap] = field(repr=False, default_factory=dict)

    @property
    def chi2(self) -> float:
        """Chi-squared of the fit without a defect, in which correlated samples count less."""
        problem = self.result.problem
        own = self.result._residual_vector[: len(problem.data)]
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
    def nearly(self) -> tuple[str, ...]:
        """Names of other defects that explain at least 90% of the part of the best one."""
        if not self.found:
            return ()
        order = np.argsort(-self.improvements, kind="stable")[1:]
        least = NEARLY * float(self.improvements.max())
        return tuple(self.names[i] for i in order if self.improvements[i] >= least)

    @property
    def changes(self) -> Array:
        """Estimated gaps [m], or relative changes of radii or stiffnesses."""
        return self.sizes if self.kind == "gap" else self.sizes / self._nominal - 1.0

    @property
    def _nominal(self) -> Array:
        model = self.result.model
        names = _names(self.kind, self.result)
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
            if self._rivals:
                lines.append(f"the place is uncertain: {self._rivals}; fit() tries them")
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

    @property
    def _rivals(self) -> str:
        """Such as ``radius[6] explains nearly as much``, or ''."""
        if not self.nearly:
            return ""
        more = f" and {len(self.nearly) - 1} more" if len(self.nearly) > 1 else ""
        return f"{self.nearly[0]}{more} {'explain' if more else 'explains'} nearly as much"

    def _size_text(self, i: int) -> str:
        """Size of a defect, such as ``"0.4 um"`` or ``"+3%"``."""
        change = float(self.changes[i])
        return f"{1e6 * change:.3g} um" if self.kind == "gap" else f"{100.0 * change:+.2g}%"

    def _remark(self, i: int) -> str:
        """Whether the size is one of the largest that were tried."""
        tried, change = KINDS[self.kind][1], abs(float(self.changes[i]))
        if self.names[i] in self.rough:
            return ""
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

        For the best odd balls, another mass is tried instead of another radius, as of a ball with a
        hole.

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
        if self._rivals:
            other = f"{self._rivals}; call fit()"
        if not self.found:
            text, other = f"no {self.kind} explains more than noise would", ""
        return short("DefectScan", self.kind, text, other)


def defect_names(result: FitResult, kind: str) -> list[str]:
    """Names of the defects of a kind, in the order in which a scan tries them."""
    return list(map(str, _names(kind, result)))


def _rounded(chi2: float) -> str:
    return f"{chi2:.0f}" if abs(chi2) >= 100.0 else f"{chi2:.3g}"


@checked_arguments("scan_defects")
def scan_defects(
    result: FitResult, kind: str = "gap", *, progress: Progress | None = None
) -> DefectScan:
    """Find the contact or bead where one defect explains most of the residuals of a fit.

    Each defect is added to the fit, with up to seven sizes of a gap, twelve radii of a bead from
    6.4% smaller to 6.4% larger, or ten stiffnesses of a contact from 32% smaller to 32% larger; no
    larger change is tried after two that agree worse and worse.  A bead with half of its mass is
    tried, too; its size is that of a solid bead of this mass, 21% smaller.  All other parameters
    adjust linearly.  If a gap explains more than noise would, but not all residuals, rough fits
    that begin with larger gaps follow for the contacts in front of the first sensor and at the end
    of the row: a gap in front of all sensors delays the signals as the time offset does, which no
    linear estimate shows.

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
    tried = _names(kind, result)
    inverse = np.linalg.pinv(result.jacobian, rcond=1e-12)
    names, improvements, sizes = [], [], []
    for i, name in enumerate(tried):
        gained, size = _explained(result, name, inverse)
        names.append(str(name))
        improvements.append(gained)
        sizes.append(size)
        if progress is not None:
            progress(i + 1, len(tried))
    scan = DefectScan(kind, tuple(names), np.array(improvements), np.array(sizes), result)
    # Rough fits take more simulations than the scan.
    left = scan.chi2 - float(scan.improvements.max())
    further = kind == "gap" and scan.found and left > MUCH * scan.freedom
    return _with_rough(scan, progress) if further else scan


def _names(kind: str, result: FitResult) -> list[Name]:
    """Parameters of the defects; only a gap can be at a wall."""
    key, chain = KINDS[kind][0], result.model.chains[0]
    if kind == "bead":
        return [Name(key, str(k + 1)) for k in range(ball_count(chain))]
    return [each if kind == "gap" else replace(each, key=key)
            for each in gap_names(chain) if kind == "gap" or each.item]  # fmt: skip


def _with_rough(scan: DefectScan, progress: Progress | None) -> DefectScan:
    """The scan with rough fits of gaps that may be larger than those of the linear estimate."""
    result, count = scan.result, len(scan.names)
    far = [each for each in _names("gap", result) if WIDE[-1] in sizes_of(each, result)]
    gained, sizes, rough = scan.improvements.copy(), scan.sizes.copy(), {}
    cost, ends = own_cost(result), end_gaps(result)
    far += [name for name in ends if name not in far]
    for done, name in enumerate(far):
        i = scan.names.index(str(name))
        near = rough_gap(result, name, WIDE) if WIDE[-1] in sizes_of(name, result) else None
        found = better_of(near, ends.get(name))
        if found is not None and cost - found.cost > gained[i]:
            rough[str(name)] = found
            gained[i], sizes[i] = cost - found.cost, found.size
        if progress is not None:
            progress(count + done + 1, count + len(far))
    return replace(scan, improvements=gained, sizes=sizes, rough=rough)


def _explained(result: FitResult, name: Name, inverse: Array) -> tuple[float, float]:
    """Reduction of chi-squared by one defect, and its size there."""
    model, problem = result.model, result.problem
    values = model.values(result.variables)
    sizes = KINDS["gap"][1] if name.key in GAPS else next(
        sizes for key, sizes in KINDS.values() if key == name.key
    )  # fmt: skip
    _, nominal = kind_and_value(name, model.traces, model.chains)
    unit = units_of(result.chain).scales.length if name.key in GAPS else nominal
    changed = Problem(with_parameter(model, name, nominal))

    def unexplained(residuals: Array) -> Array:
        return np.asarray(residuals - result.jacobian @ (inverse @ residuals))

    def residuals_at(size: float, of: Name = name, problem_of: Problem = changed) -> Array:
        predicted = problem_of.predicted({**values, of: size})
        found = (predicted - problem.data) / problem.scale
        found[problem.skipped] = 0.0
        return np.concatenate((found, result._residual_vector[len(found) :]))

    without = unexplained(result._residual_vector)
    best = (0.0, nominal)
    for direction in (1.0,) if name.key in GAPS else (1.0, -1.0):
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
    mass = replace(name, key="mass")
    if name.key == "radius" and mass not in model.names:
        _, usual = kind_and_value(mass, model.traces, model.chains)
        lighter = Problem(with_parameter(model, mass, usual))
        with contextlib.suppress(SimulationError):
            there = unexplained(residuals_at(LIGHT * usual, mass, lighter))
            gained = float(without @ without) - float(there @ there)
            best = max(best, (gained, LIGHT ** (1.0 / 3.0) * nominal))
    return best
