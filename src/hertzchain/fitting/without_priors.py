"""Values of parameters without the priors that the data contradict, from further fits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..collision import Array
from ..representation import counted, listed, short
from .causes import Refit
from .prior_conflicts import conflict_notes, contradicted
from .problem import Problem
from .result_document import parameters_document
from .shown_values import shown_value
from .weak_directions import grouped

if TYPE_CHECKING:
    from .result import FitResult

# Largest number of contradicted priors that are omitted one by one.
MAX_TRIED: Final = 6
# Values that change by more than this number of standard errors of the first fit are listed, and
# their largest number.
CHANGED, SHOWN = 0.5, 6


@dataclass(frozen=True, eq=False)
class WithoutPriors:
    """A fit without priors that the data contradict.

    Attributes
    ----------
    priors : tuple of str
        Names of the parameters whose priors are omitted.
    result : FitResult
        The fit without them.
    note : str
        Values that change, in words.
    """

    priors: tuple[str, ...]
    result: FitResult = field(repr=False)
    note: str

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        found = self.result
        return {
            "priors": list(self.priors), "chi2": found.chi2,
            "parameters": parameters_document(found.model, found.estimates, found.sigmas),
        }  # fmt: skip

    def __repr__(self) -> str:
        return short("WithoutPriors", self.note)


def with_fits_without_priors(result: FitResult, refit: Refit) -> FitResult:
    """A result with the values of fits without contradicted priors, if other priors suffice.

    Priors are omitted one by one, because a wrong one biases the other parameters, so that these
    may contradict their priors, too.  All are omitted if no single one explains the conflict.
    """
    if not result.prior_conflict or result.meaningless or not result.converged:
        return result
    if result.explained:
        # Values without a prior would describe the data less well than the cause does.
        return result
    deviations = result.prior_deviations
    names = sorted(contradicted(deviations), key=lambda name: -abs(deviations[name]))
    found = [_fit_without(result, (name,), refit) for name in names[:MAX_TRIED]]
    good = [each for each in found if each is not None]
    if not good and 1 < len(names) < len(deviations):
        last = _fit_without(result, tuple(names), refit)
        good = [last] if last is not None else []
    if not good:
        return result
    good.sort(key=lambda each: each.result.chi2 + each.result._penalty)
    own = len(conflict_notes_of(result))
    notes = *result.notes[:own], *(each.note for each in good), *result.notes[own:]
    return replace(result, notes=notes, without_priors=tuple(good))


def conflict_notes_of(result: FitResult) -> tuple[str, ...]:
    """Notes on the contradicted priors of a fit, the first ones of its notes."""
    values = dict(zip(result.model.names, result.estimates.tolist(), strict=True))
    return conflict_notes(result.model.parameters, result.traces, values, result.sigmas)


def _fit_without(result: FitResult, names: Sequence[str], refit: Refit) -> WithoutPriors | None:
    """The fit without these priors; `None` if it is not determined or contradicts others."""
    model, starts = result.model, result.estimates.tolist()
    parameters = tuple(
        replace(each, start=start, prior=None if str(each) in names else each.prior)
        for each, start in zip(model.parameters, starts, strict=True)
    )
    problem = Problem(replace(model, parameters=parameters))
    found = refit(problem, dict(zip(result.names, starts, strict=True)), 1)
    known = {*result.names} - {*result.at_bounds, *result.undetermined}
    errors = np.array([found.errors[name] for name in known])
    if not (found.converged and np.all(np.isfinite(errors))) or found.prior_conflict:
        return None
    return WithoutPriors(tuple(names), found, _note(result, found, names))


def _note(result: FitResult, found: FitResult, names: Sequence[str]) -> str:
    """The value of each parameter that changes, and the number of the others."""
    changes = _changes(result, found)
    order = np.argsort(-changes, kind="stable").tolist()
    # First the parameters of the priors, whose new values differ most from these.
    order.sort(key=lambda i: result.names[i] not in names)
    chosen = [i for i in order if changes[i] > CHANGED or result.names[i] in names]
    shown = chosen[: max(SHOWN, len(names))]
    values = [
        f"{result.names[i]} = " + shown_value(
            found.model.parameters[i], found.traces, found.estimates[i], found.sigmas[i],
            at_bound=result.names[i] in found.at_bounds,
        )
        for i in shown
    ]  # fmt: skip
    more, rest = len(chosen) - len(shown), len(changes) - len(chosen)
    ends = [f"{counted(more, 'other value')} that {'change' if more > 1 else 'changes'}"] * bool(
        more
    )
    agree = ", the other priors agree with the data" * (len(result.prior_deviations) > len(names))
    text = (
        f"without the prior{'s' if len(names) > 1 else ''} of {grouped(list(names))}{agree}: "
        f"{listed([*values, *ends])}"
    )
    if not rest:
        return text
    others = "the others change" if rest > 1 else "the other changes"
    return f"{text}; {others} by less than half of {'their errors' if rest > 1 else 'its error'}"


def _changes(result: FitResult, found: FitResult) -> Array:
    """Changes of all values, in standard errors of the fit with all priors."""
    sigmas = np.where((result.sigmas > 0.0) & np.isfinite(result.sigmas), result.sigmas, np.inf)
    return np.asarray(np.abs(found.estimates - result.estimates) / sigmas)
