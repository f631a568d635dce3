"""Fits of all loss laws to the same data, and their comparison."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.laws import Loss
from ..chain.laws.elastic import Elastic
from ..chain.per_contact import MaterialPairs
from ..collision import Array
from ..errors import InputError, SimulationError
from ..representation import SUMMARY_WIDTH, folded, listed, short
from ..traces.files import load_traces
from ..traces.traces import with_time_offset
from ..validation.keywords import checked_arguments, checked_methods
from ..validation.objects import Progress, callback, check_list
from .clocks import with_clocks
from .fit import ChainLike, TimeOffset, TracesLike, fit_with
from .law_parameters import loss_parameters
from .loss_laws import typical_law
from .names import Name, parse_name
from .parameters import Priors, default_names
from .result import FitResult
from .settings import Settings, for_sensors, load_experiment
from .simulations import range_notes
from .summary_width import summary_width
from .symmetry import units_of

DEFAULT_LAWS: Final = (
    "elastic", "viscoelastic", "restitution", "dashpot", "velocity-power", "unloading-ratio",
    "walton-braun",
)  # fmt: skip
# Differences of BIC above this value decide (odds of more than a hundred).
DECIDES: Final = 10.0
MARKED: Final = "* this law does not describe the data: its values and their errors have no meaning"
# Largest number of starts of each law.
STARTS: Final = 4
# Velocities, relative to that of the first shot, at which a further shot is considered.
FURTHER: Final = (0.25, 0.5, 2.0, 4.0)


@dataclass(frozen=True, eq=False)
class LossFit:
    """The fit of one law.

    Attributes
    ----------
    law : str
        Name of the law.
    result : FitResult or None
        Its fit; `None` if it failed.
    reason : str
        Why it failed or did not converge; empty otherwise.
    bic : float
        Bayesian information criterion with the effective number of samples of the best fit.
    """

    law: str
    result: FitResult | None
    reason: str = ""
    bic: float = np.inf

    @property
    def mark(self) -> str:
        """An asterisk if the law does not describe the data."""
        found = self.result
        return "" if found is None or (found.goodness.accepted and not found.meaningless) else "*"


@checked_methods
@dataclass(frozen=True, eq=False)
class LossComparison:
    """Fits of several loss laws to the same data, the best first.

    Attributes
    ----------
    fits : tuple of LossFit
        In the order of their BIC.
    further_shots : dict
        Expected difference in BIC of the two best laws in one more shot, for several velocities of
        this shot within the limits of Hertz's law [m/s]; empty if the data decide.
    """

    fits: tuple[LossFit, ...]
    further_shots: Mapping[float, float] = field(default_factory=dict)

    @property
    def best(self) -> FitResult:
        """Fit of the best law."""
        result = self.fits[0].result
        assert result is not None
        return result

    @property
    def undecided(self) -> tuple[str, ...]:
        """Laws between which the data cannot decide, the best first; one law if they can."""
        return tuple(each.law for each in self.fits if each.bic - self.fits[0].bic <= DECIDES)

    def summary(self, *, width: int | None = SUMMARY_WIDTH) -> str:
        """Table of all laws, and `statement`.

        Parameters
        ----------
        width
            Number of columns at which lines are broken; None keeps each sentence on one line.

        Returns
        -------
        str

        Examples
        --------
        >>> import hertzchain as hc
        >>> laws = ["viscoelastic", "restitution"]
        >>> compared = hc.compare_losses(*hc.example_experiment(), laws=laws)
        >>> print(compared.summary().splitlines()[0])
        law            delta BIC       chi2  parameters
        """
        lines = [f"{'law':<14} {'delta BIC':>9} {'chi2':>10}  parameters"]
        for each in self.fits:
            if each.result is None:
                lines.append(f"{each.law:<14} {'failed':>9} {'':>10}  {each.reason}")
                continue
            rows = [f"{name} = {row}" for name, row in each.result.rows() if "loss" in name]
            lines.append(
                f"{each.law:<14} {each.bic - self.fits[0].bic:>9.1f} {each.result.chi2:>10.1f}"
                f"{each.mark:<2}{', '.join(rows)}".rstrip()
            )
        columns = summary_width(width)
        table = folded("\n".join(lines), columns, lines[0].index("parameters"))
        return "\n".join((table, *(folded(note, columns) for note in self._notes)))

    @property
    def _notes(self) -> tuple[str, ...]:
        """The meaning of the mark, if there is one, and the statement."""
        return (*[MARKED] * any(each.mark for each in self.fits), self.statement)

    @property
    def statement(self) -> str:
        """Sentence on the laws between which the data can and cannot decide."""
        conflict = self.best.prior_conflict
        return f"{self._decision}. However, {conflict}" if conflict else self._decision

    @property
    def _decision(self) -> str:
        first = self.fits[0]
        if self.best.goodness.undecided:
            return (
                f"{first.law} comes closest, but the noise is too uncertain to decide whether it "
                "describes the data; give the noise, or record more samples before the pulse"
            )
        if not self.best.describes:
            return (
                f"none of the laws compared describes the data; {first.law} comes closest; check "
                "the residuals and the warnings of its fit before the laws are compared"
            )
        if len(self.undecided) == 1:
            if len(self.fits) == 1 or self.fits[1].result is None:
                return f"only {first.law} was fitted"
            gap = self.fits[1].bic - first.bic
            return (
                f"of the laws compared, {first.law} describes the data best: the next, "
                f"{self.fits[1].law}, has a BIC larger by {gap:.0f}; another law may describe them "
                "as well, with other values"
            )
        text = f"the data cannot decide between {listed(self.undecided)}"
        if not self.further_shots:
            return text
        speed, difference = max(self.further_shots.items(), key=lambda item: item[1])
        if difference < DECIDES:
            return (
                f"{text}, and neither could one more shot at {min(self.further_shots):.2g} to "
                f"{max(self.further_shots):.2g} m/s; reduce the noise"
            )
        return (
            f"{text}; one more shot at {speed:.2g} m/s would change the difference in BIC of the "
            f"first two by about {difference:.0f}"
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON.

        Returns
        -------
        dict

        Examples
        --------
        >>> import hertzchain as hc
        >>> compared = hc.compare_losses(*hc.example_experiment(), laws=["elastic"])
        >>> compared.as_dict()["laws"][0]["law"]
        'elastic'
        """
        return {
            "laws": [
                {"law": each.law, "reason": each.reason}
                | ({} if each.result is None else each.result.as_dict())
                for each in self.fits
            ],
            "undecided": list(self.undecided),
            "statement": self.statement,
            "further_shots": {f"{speed:g}": value for speed, value in self.further_shots.items()},
        }

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        from ..notebook.fits import loss_comparison_html

        return loss_comparison_html(self)

    def __repr__(self) -> str:
        return short("LossComparison", f"{len(self.fits)} laws", self.statement)


@checked_arguments("compare_losses")
def compare_losses(
    traces: TracesLike,
    chain: ChainLike,
    *,
    laws: Sequence[str | Loss] | None = None,
    free: Sequence[str] | None = None,
    also_free: Sequence[str] | None = None,
    priors: Priors | None = None,
    start: Mapping[str, float] | None = None,
    time_offset: TimeOffset = None,
    progress: Progress | None = None,
) -> LossComparison:
    r"""Fit all loss laws to the same data and compare them by their BIC.

    .. math:: \mathrm{BIC} = \chi^2/s + k \ln(n/s)

    with the number k of parameters, the number n of samples and the number s of samples per
    independent one in the best fit (`FitResult.bic`).  If the best law describes the data,
    differences above 10 decide.

    Parameters
    ----------
    traces, chain, free, also_free, priors, start, time_offset
        As for `hertzchain.fit`.  Each law is assigned to all contacts of beads, and to those walls
        that have no law of their own; a law given for a wall, such as ``Elastic()`` for a load
        cell, is kept in all fits, and springs stay elastic under `ElasticPlastic`.  Names of losses
        in ``free`` and ``also_free`` are replaced by the parameters of the law, except those of a
        wall with its own law, such as ``right_wall.loss.time``.
    laws : sequence of str or Loss, optional
        Names of laws, or laws with the values from which to start.  By default, all laws except
        `ElasticPlastic`.
    progress : callable, optional
        Called as ``progress(done, total)`` after each law.

    Returns
    -------
    LossComparison

    Raises
    ------
    InputError
        For an unknown law, and as `hertzchain.fit`.
    SimulationError
        If no law can be fitted.

    Examples
    --------
    >>> import hertzchain as hc
    >>> compared = hc.compare_losses(*hc.example_experiment(), laws=["elastic", "viscoelastic"])
    >>> [each.law for each in compared.fits]
    ['viscoelastic', 'elastic']
    """
    data, chains, settings = load_experiment(traces, chain, load_traces)
    settings = for_sensors(settings, data).updated(free, priors, start, time_offset)
    data = with_time_offset(data, time_offset)
    data, settings = with_clocks(data, settings.with_more(also_free, data, chains[0]))
    callback("progress", progress)
    wanted = DEFAULT_LAWS if laws is None else check_list("laws", laws, "names of laws")
    if not wanted:
        raise InputError("no laws to compare; name some, such as 'viscoelastic'")
    names = (
        default_names(data, chains[0])
        if settings.free is None
        else check_list("free", settings.free, "names")
    )
    of_law = partial(_is_of_law, chain=chains[0])
    kept = [name for name in names if not of_law(name)]
    fits = []
    # Names are checked before the first fit, which may take long.
    for done, law in enumerate([typical_law(each, chains[0]) for each in wanted], start=1):
        lossy = [one.replace(loss=law) for one in chains]
        own = [f"loss.{name}" for name in loss_parameters(lossy[0])]
        known = {n: v for n, v in settings.priors.items() if n in own or not of_law(n)}
        given = {n: v for n, v in settings.start.items() if n in own or not of_law(n)}
        try:
            chosen = Settings(kept + own, known, given, settings.optional)
            found = fit_with(data, lossy, chosen, STARTS)
            fits.append(LossFit(law.name, found, "" if found.converged else found.reason))
        except SimulationError as error:
            fits.append(LossFit(law.name, None, str(error)))
        if progress is not None:
            progress(done, len(wanted))
    comparison = LossComparison(_ranked(fits))
    if len(comparison.undecided) < 2:
        return comparison
    return replace(comparison, further_shots=_further_shots(comparison))


def _is_of_law(name: str, chain: Chain) -> bool:
    """Whether a name is of the laws that are compared, and not of a wall with its own law."""
    end, *rest = parse_name(name).key.split("loss.")
    wall = getattr(chain, end.rstrip("."), None) if end else None
    return bool(rest) and (wall is None or wall.loss is None)


def _ranked(fits: Sequence[LossFit]) -> tuple[LossFit, ...]:
    """Fits in the order of their BIC, with the correlation of the residuals of the best fit."""
    good = [each.result for each in fits if each.result is not None]
    if not good:
        raise SimulationError(f"no law could be fitted; {fits[0].law}: {fits[0].reason}")
    inflation = min(good, key=lambda each: each.chi2 + each._penalty).goodness.inflation
    known = [
        each if each.result is None else replace(each, bic=each.result.bic(inflation))
        for each in fits
    ]
    return tuple(sorted(known, key=lambda each: each.bic))


def law_of(chain: Chain) -> Loss | None:
    """The loss law of all contacts of a chain; `None` if contacts have several."""
    if isinstance(chain.loss, tuple | MaterialPairs):
        return None
    return chain.loss or Elastic()


def rejected_law(comparison: LossComparison, chain: Chain) -> str:
    """Name of the law of a chain if it has one, and only another one describes the data."""
    own = law_of(chain)
    if own is None or not comparison.best.describes or own.name in comparison.undecided:
        return ""
    return own.name


def _further_shots(comparison: LossComparison) -> dict[float, float]:
    """Expected difference in BIC of the two best laws, for shots of some velocities."""
    pair = [each.result for each in comparison.fits[:2]]
    found = {}
    first = pair[0]
    assert first is not None
    speed = float(np.abs(first.chain.velocities).max())
    shot = first.model.traces.shots[0]
    duration = float(shot.times[-1] - shot.times[0])
    for factor in FURTHER:
        # Beyond the limits of Hertz's law, a shot would not decide between losses of elastic balls.
        if range_notes(_struck(first.chains[0], factor), duration):
            continue
        try:
            signals = [_signals(each, factor) for each in pair if each is not None]
        except (SimulationError, InputError):
            continue
        found[factor * speed] = _difference(*signals) / first.goodness.inflation
    return found


def _struck(chain: Chain, factor: float) -> Chain:
    return chain.replace(velocities=factor * chain.velocities)


def _signals(result: FitResult, factor: float) -> tuple[Array, ...]:
    """Signals over noise of the first shot at another velocity, and their time derivatives.

    These are those of the samples that a fit uses; equal samples count once.
    """
    model = result.model
    chain = result.chains[0]
    struck = _struck(chain, factor)
    stretch = units_of(struck).time / units_of(chain).time
    shot = model.traces.shots[0]
    values = model.values(result.variables)
    names = (Name("time_offset"), Name("time_offset", shot="1"))
    offset = next((values[name] for name in names if name in values), shot.time_offset)
    times = stretch * (shot.times - offset)
    run = model.simulator.signals(struck, float(times[-1]))
    parts = []
    for signal in shot.signals:
        column = model.gain(0, signal, values) * model.simulator.column(run, signal)
        seen = np.interp(times, run.spacing * np.arange(len(column)), column)
        slope = np.gradient(seen, times)
        scale = signal.sigma * signal.counted**0.5
        parts.append(np.array([seen, slope, times * slope])[:, signal.valid] / scale)
    return tuple(np.concatenate(parts, axis=1))


def _difference(first: tuple[Array, ...], second: tuple[Array, ...]) -> float:
    """Squared difference that velocity, stiffness and time offset cannot compensate."""
    columns = np.column_stack(first)
    difference = second[0] - first[0]
    scale = np.linalg.norm(columns, axis=0)
    solution = np.linalg.lstsq(columns / scale, difference, rcond=None)[0]
    rest = difference - (columns / scale) @ solution
    return float(rest @ rest)
