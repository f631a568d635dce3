"""Causes of residuals that a fit does not describe, each tried in another fit.

A cause is named only if the model describes the data with it, or if it removes most of the excess
of chi-squared.  Wrong columns are recognised by amplitudes and arrivals.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from ..errors import SimulationError
from ..representation import measure
from .advice import advice_to_free, considered, level_advice, nothing_explains
from .ball_count_causes import likely_count
from .cap_notes import is_cap_note
from .causes import CERTAIN, CLEAR, Cause, Refit, fixed_ends, try_further
from .clocks import fixed_offsets
from .dead_channels import without_dead_channels
from .effect_limits import limited
from .free_causes import MAX_TRIED, MOST, PROMISING, after_zeros, free_zeros, other_places
from .gap_causes import small_gap_causes
from .goodness import rounded_chi2
from .misread_columns import misread_columns
from .misread_places import agrees_much_better
from .misread_times import check_times, misread_times
from .names import Name
from .parameters import Parameter, kind_and_value
from .prior_conflicts import bound_notes
from .problem import Problem
from .result import FitResult
from .sensor_effects import gained_by, groups_of_effects
from .signal_noise import signal_noise_of
from .steps import STEPS, Step
from .systematics import PRESENT
from .without_priors import conflict_notes_of

# Largest number of causes that are named besides the best one.
MAX_OTHERS: Final = 2
# Below this multiple of chi-squared, a number of balls is named beside a place, and vice versa.
SIMILAR: Final = 1.5
# Columns may be wrong if a parameter is further from its prior, in standard deviations.
FAR_FROM_PRIOR: Final = 10.0
UNITS: Final = (
    "check the units of the times and of the sensors, the materials and the velocity of the chain, "
    "and whether the record contains the first pulse; hertzchain compare shows data and simulation"
)


def diagnosed(result: FitResult, start: Mapping[str, float], refit: Refit) -> FitResult:
    """A result with advice if the model does not describe the data, or if they show an effect."""
    if result.goodness.accepted and not result._implausible:
        return _with_other_columns(result, start, refit) or _with_effect(result, refit)
    if result.goodness.only_noise:
        return result
    columns, found = _of_columns(result, start, refit)
    if found is not None:
        return found
    noise = None if columns else signal_noise_of(result)
    causes, tried = list(columns), dict[str, None]()
    causes += _further(result, start, refit, columns, tried)
    good = [each for each in causes if _removed(each.base or result, each.result) > MOST]
    levels = level_advice(result)
    if noise is not None and all(noise.cost < cause.result.chi2 for cause in good):
        return replace(result, advice=(*levels, noise.advice))
    # Delays, gaps and odd balls all make signals late, so that those that fail are not advised.
    rejected = [cause for cause in good if _is_late(cause) and not cause.result.describes]
    good = [cause for cause in good if cause not in rejected]
    if not good:
        advice = f"{_only_late(result, rejected)}{nothing_explains(result, tried, levels)}"
        return replace(result, advice=(*levels, advice))
    best = min(good, key=lambda each: (
        not each.result.describes,
        each.result.chi2 + (PRESENT * each.added if each.result.describes else 0.0),
    ))  # fmt: skip
    if best.shifts_level:
        levels = ()
    if best in columns and (best.order or best.result.describes):
        return as_misread(result, best)
    best, others = _count_first(best, good)
    others = others or _not_distinguished(best, good) or _place_or_count(best, causes)
    found = replace(result, advice=(_sentence(result, best, others), *levels))
    return _without_consequences(found) if _is_certain(best) else found


def _further(
    result: FitResult, start: Mapping[str, float], refit: Refit, columns: Sequence[Cause],
    tried: dict[str, None],
) -> list[Cause]:  # fmt: skip
    """Causes that are not readings of columns; ``tried`` gets their kinds in words."""
    found: list[Cause] = []
    zeros, base = None, None
    for step in STEPS:
        if any(_settles(result, cause, step) for cause in (*columns, *found)):
            continue
        result.model.simulator.trying = step.shown or step.words
        if step.with_zeros and base is None:
            zeros = free_zeros(result, refit)
            base = result if zeros is None else zeros.result
        noting = _noting(refit, step.words, tried)
        if step.with_zeros and zeros is not None and base is not None:
            found += [after_zeros(zeros, each) for each in step.tried(base, start, noting)]
        else:
            found += step.tried(result, start, noting)
    return found


def quickly_diagnosed(
    result: FitResult, start: Mapping[str, float], refit: Refit
) -> tuple[FitResult, bool]:
    """A result with advice on misread data or a different row, and whether more is to be tried.

    These causes are tested before a search for defects, which takes as long as all others, and
    before the fit is printed.
    """
    if (result.goodness.accepted and not result._implausible) or result.goodness.only_noise:
        return diagnosed(result, start, refit), False
    columns, found = _of_columns(result, start, refit)
    if found is not None:
        return found, False
    if columns:
        return result, True
    for cause in itertools.chain(
        other_places(result, start, refit), likely_count(result, start, refit)
    ):
        if cause.result.describes:
            found = replace(result, advice=(_sentence(result, cause),))
            return (_without_consequences(found) if _is_certain(cause) else found), False
    return replace(result, advice=level_advice(result)), True


def _of_columns(
    result: FitResult, start: Mapping[str, float], refit: Refit
) -> tuple[list[Cause], FitResult | None]:
    """Fits to columns and times that are read differently, and the result if these decide it."""
    check_times(result.model)
    dead = without_dead_channels(result, start, refit)
    if dead is not None and _much_better(result, dead):
        return [dead], _without_consequences(replace(result, advice=(_sentence(result, dead),)))
    columns = list(_columns(result, start, refit))
    causes = [*columns, *_clock(result, start, refit)]
    misread = next((each for each in causes if each.whole and _much_better(result, each)), None)
    if misread is not None:
        return causes, as_misread(result, misread)
    gross = next((each for each in causes if each.gross and _much_better(result, each)), None)
    if gross is not None and _is_good(gross.result):
        return causes, as_misread(result, gross)
    if gross is not None:
        return causes, replace(result, advice=_with_next(result, gross, start, refit))
    if result.meaningless and not any(_much_better(result, each) for each in causes):
        # Effects of sensors do not make a fit meaningless, and fits far from the data take long.
        return causes, replace(result, advice=(UNITS,))
    return causes, None


def _settles(result: FitResult, cause: Cause, step: Step) -> bool:
    """Whether a step is not tried after a cause."""
    return _explains(result, cause.result) and not (step.after_delays and _has_delay(cause))


def _has_delay(cause: Cause) -> bool:
    return any(each.key == "delay" for each in cause.names)


def _is_late(cause: Cause) -> bool:
    """Whether a cause makes the signals of all sensors beyond a place late."""
    return cause.row or _has_delay(cause)


def _only_late(result: FitResult, rejected: Sequence[Cause]) -> str:
    """A sentence on signals that are late for another reason than one delay, gap or ball."""
    if not rejected:
        return ""
    best = min(rejected, key=lambda each: each.result.chi2)
    return (
        f"{_improved(result, best)}. A delay of a channel, a gap and an odd ball all make signals "
        "late, but none of them alone describes the data; "
    )


def _not_distinguished(best: Cause, good: Sequence[Cause]) -> str:
    """Delays, gaps and odd balls that describe the data as well as the best one of them."""
    if not _is_late(best):
        return ""
    limit = best.result.chi2 + PRESENT
    others = [
        each for each in good
        if each is not best and _is_late(each) and each.result.describes
        and each.result.chi2 < limit
    ]  # fmt: skip
    others.sort(key=lambda each: each.result.chi2)
    return "".join(
        f". With {each.what} instead, chi2 is {each.result.chi2:.0f}, and the data hardly "
        f"distinguish these causes: {each.advice}"
        for each in others[:MAX_OTHERS]
    )


def _place_or_count(best: Cause, causes: Sequence[Cause]) -> str:
    """Another number of balls that explains about as much as a wrong place, or vice versa."""
    limit = 0.0 if best.result.describes else SIMILAR * best.result.chi2
    others = [each for each in causes if each.count * best.place or each.place * best.count]
    other = min(others, key=lambda each: each.result.chi2, default=best)
    if other is best or other.result.chi2 >= limit:
        return ""
    return f". With {other.what} instead, chi2 is {rounded_chi2(other.result.chi2)}: {other.advice}"


def first_misread(problem: Problem, start: Mapping[str, float], refit: Refit) -> Cause | None:
    """The fit to data in another unit or order, if those of the columns are clearly wrong.

    It is tried before a fit to the data as they are, which takes long and has no meaning: if known
    gains exclude the unit, or if columns in another order agree much better with the nominal chain.
    """
    model = problem.model
    for each in misread_columns(model):
        other = replace(model, traces=each.traces)
        if not (each.unit or (each.order and agrees_much_better(other, model))):
            continue
        try:
            found = refit(Problem(other), start, 1)
        except SimulationError:
            continue
        if _is_good(found) and not found.prior_conflict:
            return Cause(each.what, each.advice, found, 0, misread=True, gross=each.gross)
    return None


def as_misread(result: FitResult, cause: Cause) -> FitResult:
    """A result without any meaning, because columns or times are read wrongly."""
    found = replace(result, advice=(_sentence(result, cause),), misread=True)
    # Nothing follows from gains that are fitted to the signals of other sensors.
    return _without_consequences(found) if cause.order or _is_good(cause.result) else found


def _without_consequences(result: FitResult) -> FitResult:
    """A result without notes on priors and bounds, which its cause contradicts."""
    priors = len(conflict_notes_of(result))
    ends = bound_notes(result.at_bounds)
    notes = tuple(
        each for each in result.notes[priors:] if each not in ends and not is_cap_note(each)
    )
    return replace(result, notes=notes, explained=True)


def _is_certain(cause: Cause) -> bool:
    """Whether a cause is one of the data or the row, and not a parameter that may hide another."""
    found = cause.result
    return found.describes and (
        cause.misread or cause.count or (cause.row and not found.prior_conflict)
    )


def _count_first(best: Cause, good: Sequence[Cause]) -> tuple[Cause, str]:
    """The number of balls rather than a delay that describes the data as well, and that delay."""
    delays = [each for each in good if each.delays and each.result.describes]
    counts = [each for each in good if each.count and each.result.describes]
    if not (counts and delays):
        return best, ""
    count, delay = (min(each, key=lambda one: one.result.chi2) for each in (counts, delays))
    if best not in (count, delay) or count.result.chi2 > delay.result.chi2 + PRESENT:
        return best, ""
    return count, (
        f". If the number is right, {delay.advice}: with {delay.what}, about the time in which the "
        f"pulse passes one ball, chi2 is {delay.result.chi2:.0f}, and the data hardly distinguish "
        "these causes"
        if delay.result.chi2 < count.result.chi2 + PRESENT
        else ""
    )


def _with_next(
    result: FitResult, cause: Cause, start: Mapping[str, float], refit: Refit
) -> tuple[str, ...]:
    """A cause that hides all others, and the advice that remains after its correction."""
    if _is_good(cause.result):
        return (_sentence(result, cause),)
    left = diagnosed(cause.result, start, refit).advice
    first = f"{_improved(result, cause)}: {cause.advice}"
    return (first, *(f"after that, {each}" for each in left))


def without_tested(result: FitResult, *tested: str) -> FitResult:
    """A result whose advice omits causes that were tested, such as `advice.DEFECTS`."""
    usual, left = considered(result), considered(result, tested)
    return replace(result, advice=tuple(each.replace(usual, left) for each in result.advice))


def _noting(refit: Refit, words: str, tried: dict[str, None]) -> Refit:
    """A function that fits, and notes in words what was tried."""

    def noting(problem: Problem, start: Mapping[str, float], starts: int) -> FitResult:
        tried[words] = None
        return refit(problem, start, starts)

    return noting


def _with_other_columns(
    result: FitResult, start: Mapping[str, float], refit: Refit
) -> FitResult | None:
    """A result with advice if it agrees with its priors only if columns are read differently."""
    if all(abs(each) < FAR_FROM_PRIOR for each in result.prior_deviations.values()):
        return None
    for cause in _columns(result, start, refit):
        if _is_good(cause.result) and not cause.result.prior_conflict:
            agrees = f"with {cause.what}, the fit also agrees with the priors: {cause.advice}"
            text = f"{agrees}. The values are then{cause.values}"
            return replace(result, advice=(text,), explained=True)
    return None


def _with_effect(result: FitResult, refit: Refit) -> FitResult:
    """A result with the value of the clearest effect of the sensors, from another fit."""
    causes = (_clear_cause(result, name, refit) for name in _clear_effects(result)[:MAX_TRIED])
    cause = next(filter(None, causes), None)
    if cause is None:
        return limited(result)
    alike = [cause]
    if cause.delays:
        # A small gap looks like a delay.
        gaps = small_gap_causes(result, cause.names[0], refit)
        alike += [each for each in gaps if each.result.goodness.accepted]
        cause = min(alike, key=lambda each: each.result.chi2 + PRESENT * each.row)
    text = f"with {cause.what}, chi2 falls from {result.chi2:.0f} to {cause.result.chi2:.0f}"
    shifts = {
        str(each): abs(cause.result.values[str(each)] - result.values[str(each)])
        / result.errors[str(each)]
        for each in result.model.parameters
        if each.of_chain and 0.0 < result.errors[str(each)] < np.inf
    }
    if shifts:
        moved = max(shifts, key=lambda each: shifts[each])
        text += f", and {moved} moves by {shifts[moved]:.1f} sigma"
    also = _not_distinguished(cause, alike)
    return replace(result, advice=(f"{text}: {cause.advice}{also}",))


def _clear_effects(result: FitResult) -> list[Name]:
    """Effects of sensors, and ends, that reduce chi-squared clearly, the clearest first."""
    gained = {Name(each.name): each.improvement for each in result.effects}
    singles = [names for names in groups_of_effects(result) if len(names) == 1 and names[0].item]
    singles += [(name,) for name in fixed_ends(result.model)]
    if singles and not result.goodness.noiseless:
        falls = gained_by(result, singles)
        gained |= {names[0]: each for names, each in zip(singles, falls, strict=True)}
    return sorted(
        (name for name in gained if gained[name] > PRESENT), key=lambda name: -gained[name]
    )


def _clear_cause(result: FitResult, name: Name, refit: Refit) -> Cause | None:
    """The fit with an effect, if it confirms it."""
    if name in fixed_ends(result.model):
        # The error of this stiffness includes those of the others, which only priors determine.
        cause = try_further(result, (name,), refit, least=0.0)
        fallen = 0.0 if cause is None else result.chi2 - cause.result.chi2
        confirmed = fallen > PRESENT
    else:
        cause = try_further(result, (name,), refit, least=CERTAIN if name.item else CLEAR)
        confirmed = True
    return cause if cause is not None and cause.result.converged and confirmed else None


def _is_good(result: FitResult) -> bool:
    """Whether a model describes the data, or may do so, with possible values."""
    return result.goodness.accepted and not result.meaningless


def _much_better(result: FitResult, cause: Cause) -> bool:
    """Whether a cause leaves possible values, and explains most of the residuals if they matter."""
    found = cause.result
    return _is_good(found) or (not found.meaningless and _removed(result, found) > MOST)


def _explains(result: FitResult, other: FitResult) -> bool:
    """Whether a fit describes the data, and not only just."""
    excess = result.chi2 - result.goodness.freedom
    return other.describes and result.chi2 - other.chi2 > PROMISING * excess


def _removed(result: FitResult, other: FitResult) -> float:
    """Part of the excess of chi-squared that another fit removes."""
    if other.describes:
        return 1.0
    excess = result.chi2 - result.goodness.freedom
    return (result.chi2 - other.chi2) / excess if excess > 0.0 else 0.0


def _sentence(result: FitResult, cause: Cause, others: str = "") -> str:
    then = f". The values are then{cause.values}" if cause.values else ""
    if result.goodness.accepted:
        possible = "" if then else " with possible values"
        return f"with {cause.what}, the model describes the data{possible}: {cause.advice}{then}"
    text = f"{_improved(result, cause)}: {cause.advice}"
    if cause.result.describes:
        return f"{text}{then}{others}"
    return f"{text}{others}. The model still does not describe the data. {considered(result)}"


def _improved(result: FitResult, cause: Cause) -> str:
    """By how much a cause lowers chi-squared."""
    text = f"with {cause.what}, chi2 falls from {rounded_chi2(result.chi2)} to "
    text += rounded_chi2(cause.result.chi2)
    if cause.result.describes:
        return f"{text}, and the model describes the data"
    return f"{text}, by {_removed(result, cause.result):.0%} of its excess"


def _columns(result: FitResult, start: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """Fits to columns with another sign, unit or order."""
    model = result.model
    for each in itertools.chain(misread_columns(model), misread_times(model)):
        problem = Problem(replace(model, traces=each.traces))
        try:
            found = refit(problem, start, 1)
            # Such an order is certain although another error remains, such as a gap.
            whole = each.whole or (each.order and agrees_much_better(problem.model, model))
            yield Cause(
                each.what, each.advice, found, 0, whole, misread=True, gross=each.gross,
                order=each.order,
            )  # fmt: skip
        except SimulationError:
            continue


def _clock(result: FitResult, start: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The fit in which time offsets that are fixed are free, and aligned first."""
    model = result.model
    fixed = fixed_offsets(model)
    if not fixed:
        return
    known = [kind_and_value(name, model.traces, model.chains) for name in fixed]
    more = [Parameter(name, *each) for name, each in zip(fixed, known, strict=True)]
    others = {name: value for name, value in start.items() if not name.startswith("stiffness")}
    try:
        problem = Problem(replace(model, parameters=(*model.parameters, *more)))
        found = refit(problem, others, 1)
    except SimulationError:
        return
    rows = dict(found.rows())
    shown = ", ".join(
        f"{each} = {rows[str(each)]} instead of {measure(each.start, 's')}" for each in more
    )
    advice = f"{advice_to_free(fixed, model.traces)}, or correct it"
    yield Cause(shown, advice, found, len(more), names=tuple(fixed))
