"""A gap, or a ball of another size, mass or material between sensors, as a cause of residuals.

It makes the signals of all sensors beyond it late, as a wrong delay of those before it does.  A fit
with a free delay of each sensor therefore shows between which of them it may be.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.materials import catalogue
from ..collision import Array
from ..errors import InputError, SimulationError
from .ball_counts import ball_count
from .causes import CLEAR, Cause, Refit
from .flat_valleys import GAPS as OF_GAPS
from .model import Model, make_model
from .names import Name, to_free
from .parameters import Parameter, kind_and_value
from .problem import Problem
from .result import FitResult
from .rough_gaps import contact_words, gap_names

# Gaps that are tried, in units of the time by which signals are late times the velocity of the
# impact, and relative changes of a radius.
GAPS: Final = (0.4, 0.6, 0.8, 1.0, 1.3)
NEAR_GAPS: Final = (0.95, 0.98, 1.01, 1.04)
RADII: Final = (0.02, 0.05)
# Fractions that a lighter ball lacks, as with a hole, and that a heavier one has in addition.
LIGHTER: Final = (0.1, 0.3, 0.5, 0.7)
HEAVIER: Final = (0.1, 0.3)
# Largest number of defects that are fitted.
MAX_FITS: Final = 4
# Balls of softer materials are seen without any measurement [Pa].
LEAST_MODULUS: Final = 40e9
# A further defect is fitted if its chi-squared in the linearised fit is below this multiple of that
# of the best fit, or if it is larger by less than this than that of a fit that describes the data.
SIMILAR, LESS_LIKELY = 4.0, 64.0
# The first one is fitted only below this multiple of that with delays, if these describe the data.
WORSE: Final = 4.0
# After a fit without an improvement, the search ends if the best one keeps more than this part of
# the chi-squared of the fit with delays.
POOR: Final = 0.1
# Balls on each side of the best place at which defects are tried again.
NEAR: Final = 4
# Parameters of one ball, whose effects are similar.
OF_BALL: Final = ("radius", "mass")
# Parameters without which the row is tried.
OF_ROW: Final = ("delay", *OF_GAPS, *OF_BALL)
TINY: Final = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class Base:
    """The fit with a delay of each sensor but the first, and the times between sensors."""

    fit: FitResult
    model: Model
    jacobian: Array
    inverse: Array
    # Balls at both ends of the part of the row in which the time differs most, and the difference.
    first: int
    last: int
    late: float
    # The gap of the best fit until now.
    gap: float = 0.0
    # Whether sizes and masses of all balls are tried, and nothing else.
    wide: bool = False

    @property
    def values(self) -> dict[Name, float]:
        """Values of all parameters but the delays."""
        found = self.fit.values
        return {name: found[str(name)] for name in self.model.names}

    def residuals(self, model: Model, values: Mapping[Name, float]) -> Array:
        """Residuals at these values that a linear adjustment of the others does not explain."""
        problem, fitted = Problem(model), self.fit.problem
        residuals = (problem.predicted(values) - fitted.data) / fitted.scale
        residuals[fitted.skipped] = 0.0
        residuals = np.concatenate((residuals, self.fit._residual_vector[len(residuals) :]))
        return np.asarray(residuals - self.jacobian @ (self.inverse @ residuals))

    @property
    def own_cost(self) -> float:
        """Chi-squared of the fit itself, without that of the priors."""
        return float(self.fit._residual_vector @ self.fit._residual_vector)

    def moved(self, fit: FitResult, ball: int) -> Base:
        """The base from the fit with a defect at a ball, and its neighbours."""
        extra = [i for i, name in enumerate(fit.model.names) if name not in self.model.names]
        jacobian = np.delete(fit.jacobian, extra, axis=1)
        return replace(
            self, fit=fit, jacobian=jacobian, inverse=np.linalg.pinv(jacobian, rcond=1e-12),
            gap=next((fit.values[str(each)] for each in fit.model.names if each.key in OF_GAPS),
                     0.0),
            first=max(self.first, ball - NEAR), last=min(self.last, ball + NEAR + 1),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Trial:
    """A defect of the row, the problem that fits it, and its chi-squared in the linearised fit."""

    cost: float
    ball: int
    what: str
    advice: str
    problem: Problem
    name: Name | None = None

    @property
    def label(self) -> str:
        """The effect, or else the name of the parameter."""
        return self.what or str(self.name)


def row_causes(result: FitResult, start: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The fits with a gap, an odd ball or a ball of another material between two sensors.

    If none of them describes the data, and separate delays do not either, odd balls are tried in
    the whole row: one beyond the last sensor in a ball reflects a part of the pulse.
    """
    if any(name.key in OF_ROW for name in result.model.names):
        return
    base = _base(result, start, refit)
    if base is None:
        return
    explained, tried = base.fit.describes, set[str]()
    for cause in _fits(base, refit, tried):
        explained = explained or cause.result.describes
        yield cause
    if not explained:
        yield from _fits(
            replace(base, wide=True, first=1, last=ball_count(base.fit.chain)), refit, tried
        )


def between_sensors(
    result: FitResult, start: Mapping[str, float], refit: Refit, *, only_gaps: bool = False
) -> Iterator[Cause]:
    """The fits with a gap, or an odd ball, between the two sensors with other delays."""
    if any(name.key in OF_ROW for name in result.model.names):
        return
    base = _base(result, start, refit)
    if base is not None:
        yield from _fits(base, refit, set[str](), _gaps if only_gaps else _trials)


def _fits(
    base: Base, refit: Refit, tried: set[str],
    trials_of: Callable[[Base], list[Trial]] | None = None,
) -> Iterator[Cause]:  # fmt: skip
    """The fits with these causes, of which the most likely one is fitted first.

    From each better fit, all of them are tried again.
    """
    best: Cause | None = None
    own_cost = base.own_cost
    for _ in range(MAX_FITS):
        trials = [each for each in (trials_of or _trials)(base) if each.label not in tried]
        trial = min(trials, key=lambda each: each.cost, default=None)
        if trial is None or trial.cost > _limit(base, best):
            break
        causes = []
        for each in (trial, *_alike(trial, trials)):
            tried.add(each.label)
            causes.append(_fitted(each, refit))
        found = [each for each in causes if each is not None]
        yield from found
        cause = min(found, key=lambda each: each.result.chi2, default=None)
        if cause is None or (best is not None and cause.result.chi2 > best.result.chi2):
            if best is not None and best.result.chi2 > POOR * own_cost:
                break
            continue
        best, base = cause, base.moved(cause.result, trial.ball)


def _alike(trial: Trial, trials: Sequence[Trial]) -> list[Trial]:
    """The trial of another mass of a ball beside that of another size, and vice versa."""
    if trial.name is None or trial.name.key not in OF_BALL:
        return []
    others = [
        each for each in trials
        if each.ball == trial.ball and each.name is not None
        and each.name.key in OF_BALL and each.name != trial.name
    ]  # fmt: skip
    return [min(others, key=lambda each: each.cost)] if others else []


def _limit(base: Base, best: Cause | None) -> float:
    """Chi-squared of the linearised fit beyond which a defect is not fitted."""
    if best is None:
        return WORSE * base.own_cost if base.fit.describes else np.inf
    return base.own_cost + LESS_LIKELY if best.result.describes else SIMILAR * base.own_cost


def _trials(base: Base) -> list[Trial]:
    return [*([] if base.wide else _gaps(base)), *_balls(base)]


def _base(result: FitResult, start: Mapping[str, float], refit: Refit) -> Base | None:
    """The fit with delays, if they differ between two sensors; it needs two of them."""
    model = result.model
    places = {signal.name: signal.place.bead(result.chain) for _, signal in model.traces}
    order = sorted(places, key=lambda name: places[name])
    if len(order) < 2 or places[order[0]] == 0:
        return None
    names = [Name("delay", each) for each in order[1:]]
    more = [Parameter(each, *kind_and_value(each, model.traces, model.chains)) for each in names]
    try:
        found = refit(Problem(replace(model, parameters=(*model.parameters, *more))), start, 1)
    except (InputError, SimulationError):
        return None
    own = [found.model.names.index(each) for each in names]
    jacobian = np.delete(found.jacobian, own, axis=1)
    delays = [0.0, *(found.values[str(each)] for each in names)]
    steps = np.diff(delays)
    errors = [found.errors[str(each)] for each in names]
    k = int(np.argmax(np.abs(steps)))
    if not abs(steps[k]) > CLEAR * min(errors[max(k - 1, 0) : k + 1]):
        return None
    strikers = result.chain.strikers
    first, last = (places[each] - strikers for each in order[k : k + 2])
    base = replace(found.model, parameters=model.parameters)
    inverse = np.linalg.pinv(jacobian, rcond=1e-12)
    return Base(found, base, jacobian, inverse, first, last, float(steps[k]))


def _gaps(base: Base) -> list[Trial]:
    """Gaps at the contacts of this part of the row, if the signals beyond it are late."""
    if base.late <= 0.0:
        return []
    travelled = base.late * float(np.abs(base.fit.chain.velocities).max())
    sizes = [part * travelled for part in GAPS]
    if base.gap > 0.0:
        sizes = [part * base.gap for part in NEAR_GAPS]
    trials = []
    for name in gap_names(base.fit.chain):
        # In front of a wall, there is the last ball.
        ball = int(name.item.split("-")[0]) if name.item else ball_count(base.fit.chain)
        trial = _of_size(base, name, ball, sizes) if base.first <= ball < base.last else None
        if trial is not None:
            advice = f"check for a gap between {contact_words(name, base.fit.chain)}"
            trials.append(replace(trial, advice=f"{advice}, or {to_free([name])}"))
    return trials


def _balls(base: Base) -> list[Trial]:
    """Balls of another size, and of other materials."""
    trials: list[Trial] = []
    for ball in range(base.first, min(base.last, ball_count(base.fit.chain)) + 1):
        name = Name("radius", str(ball))
        _, radius = kind_and_value(name, base.model.traces, base.model.chains)
        for sign in (1.0, -1.0):
            sizes = [radius * (1.0 + sign * part) for part in RADII]
            trial = _of_size(base, name, ball, sizes, radius)
            if trial is not None:
                advice = f"check the size of ball {ball}, or {to_free([name])}"
                trials.append(replace(trial, advice=advice))
        trials += _masses(base, ball)
        trials += [] if base.wide else _materials(base, ball)
    return trials


def _masses(base: Base, ball: int) -> Iterator[Trial]:
    """A lighter and a heavier ball of the same size, such as one with a hole."""
    name = Name("mass", str(ball))
    _, mass = kind_and_value(name, base.model.traces, base.model.chains)
    for sign, parts in ((-1.0, LIGHTER), (1.0, HEAVIER)):
        trial = _of_size(base, name, ball, [mass * (1.0 + sign * part) for part in parts], mass)
        if trial is not None:
            advice = f"check the mass of ball {ball}, or {to_free([name])}"
            yield replace(trial, advice=advice)


def _of_size(
    base: Base, name: Name, ball: int, sizes: Sequence[float], nominal: float = 0.0
) -> Trial | None:
    """The best of several sizes of a defect, between which residuals are linear."""
    best, values = None, base.values
    model = _with(base.model, name, nominal)
    last, before = nominal, base.residuals(base.model, values)
    for size in sizes:
        try:
            there = base.residuals(model, {**values, name: size})
        except (InputError, SimulationError):
            break
        step = there - before
        part = min(max(-float(before @ step) / max(float(step @ step), TINY), 0.0), 1.0)
        rest = before + part * step
        cost, value = float(rest @ rest), last + part * (size - last)
        if best is None or cost < best[0]:
            best = cost, value
        last, before = size, there
    if best is None:
        return None
    starts = {**values, name: best[1]}
    return Trial(best[0], ball, "", "", _starting(model, starts), name)


def _materials(base: Base, ball: int) -> Iterator[Trial]:
    """Chains in which a ball has another material of the catalogue, with their free parameters."""
    for name, other in catalogue().items():
        if other.young < LEAST_MODULUS:
            continue
        try:
            chains = tuple(_with_material(chain, ball, name) for chain in base.model.chains)
            model = make_model(
                base.model.traces, chains, base.model.parameters, base.model.simulator
            )
            rest = base.residuals(model, base.values)
        except (InputError, SimulationError):
            continue
        yield Trial(
            float(rest @ rest), ball, f"ball {ball} of {name}",
            f"check the material of ball {ball}", _starting(model, base.values),
        )  # fmt: skip


def _with_material(chain: Chain, ball: int, name: str) -> Chain:
    """The chain in which a ball has another material."""
    if chain.materials is None or {"masses", "stiffness"} & set(chain.given):
        raise InputError("the chain is not defined by its materials")
    materials, k = list(chain.materials), chain.strikers + ball - 1
    if materials[k] == catalogue()[name]:
        raise InputError(f"ball {ball} has this material")
    materials[k] = catalogue()[name]
    return chain.replace(materials=materials)


def _with(model: Model, name: Name, start: float) -> Model:
    """The model in which a defect is free, too."""
    kind, _ = kind_and_value(name, model.traces, model.chains)
    return replace(model, parameters=(*model.parameters, Parameter(name, kind, start)))


def _starting(model: Model, starts: Mapping[Name, float]) -> Problem:
    """The problem of a model whose parameters start from these values."""
    parameters = tuple(replace(each, start=starts[each.name]) for each in model.parameters)
    return Problem(replace(model, parameters=parameters))


def _fitted(trial: Trial, refit: Refit) -> Cause | None:
    """The fit with a defect; None if it fails."""
    starts = {str(each.name): each.start for each in trial.problem.model.parameters}
    try:
        found = refit(trial.problem, starts, 1)
    except (InputError, SimulationError):
        return None
    what = trial.what
    if trial.name is not None:
        what = f"{trial.name} = {dict(found.rows())[str(trial.name)]}"
    names = () if trial.name is None else (trial.name,)
    return Cause(what, trial.advice, found, len(names), row=True, names=names)
