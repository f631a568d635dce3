"""Effects of sensors, and parameters of shots and losses that are not free, as causes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

from ..errors import InputError, SimulationError
from ..representation import listed
from ..traces.places import Place
from .advice import unequal_levels
from .ball_count_causes import count_between
from .causes import Cause, Refit, is_free, try_further
from .law_parameters import names_of_losses
from .loss_laws import typical_law
from .misread_places import OtherPlace, likely_places
from .names import TIME_OFFSET, Name, to_free
from .problem import Problem
from .result import FitResult
from .sensor_effects import gained_by, groups_of_effects
from .systematics import PRESENT

# Part of the excess of chi-squared that a cause must remove, and the part that it must remove in
# the linearised fit to be tried.
MOST, PROMISING = 0.75, 0.4
# Largest number of effects that are tried.
MAX_TRIED: Final = 4
# Largest number of pairs of effects that are tried.
MAX_PAIRS: Final = 2
# Common parameters that may differ between shots.
OF_SHOTS: Final = ("struck_by.velocity", "time_offset")
# Law that is tried if the chain has no loss.
LOSS: Final = "viscoelastic"


def other_places(result: FitResult, start: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The best fit with one sensor in another ball, if this agrees better with the chain."""
    best: tuple[OtherPlace, FitResult] | None = None
    for each in likely_places(result.model):
        try:
            other = refit(Problem(each.model), start, 1)
        except SimulationError:
            continue
        if best is None or other.chi2 < best[1].chi2:
            best = each, other
        if other.describes:
            break
    if best is None:
        return
    found, other = best
    yield Cause(
        f"the sensor {found.name!r} in {found.place.name.removesuffix(' velocity')} instead",
        "check the number in the name of this column, and how balls and strikers are counted"
        f"{_other_count(found, result, other, start, refit)}",
        other, 0, place=True,
    )  # fmt: skip


def _other_count(
    found: OtherPlace, result: FitResult, other: FitResult, start: Mapping[str, float], refit: Refit
) -> str:
    """Another cause that looks like another ball of the first or the last sensor.

    Waves that return from the end of the row distinguish both, if the record contains them.
    """
    places = {each.name: each.place for _, each in result.traces}
    order = sorted(places, key=lambda each: places[each].bead(result.chain))
    # The time offset makes the distance of the first sensor from the impact unimportant.
    if len(order) < 2 or not any(each.key == TIME_OFFSET for each in result.model.names):
        return ""
    moved = found.place.number - places[found.name].number
    if abs(moved) != 1:
        return ""
    further = moved > 0
    if found.name == order[0]:
        missing, first, second = further, *order[:2]
    elif found.name == order[-1]:
        missing, first, second = not further, *order[-2:]
    else:
        return ""
    if _worse_with_count(result, other, places[second], -1 if missing else 1, start, refit):
        return ""
    what = "a ball is missing" if missing else "there is one ball more"
    first, second = (places[each].name.removesuffix(" velocity") for each in (first, second))
    return f", or whether {what} between {first} and {'the ' * ('wall' in second)}{second}"


def _worse_with_count(
    result: FitResult, other: FitResult, behind: Place, step: int, start: Mapping[str, float],
    refit: Refit,
) -> bool:  # fmt: skip
    """Whether the data exclude one ball more or fewer in front of a sensor."""
    model = count_between(result.model, behind, step)
    if model is None:
        return True
    try:
        counted = refit(Problem(model), start, 1)
    except (InputError, SimulationError):
        return True
    return counted.chi2 > other.chi2 + PRESENT


def with_effects(result: FitResult, _: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """Fits with the effects of sensors that reduce chi-squared most in the linearised fit."""
    groups = list(groups_of_effects(result))
    excess = max(result.chi2 - result.goodness.freedom, 1.0)
    gained = [each / excess for each in gained_by(result, groups)]
    order = sorted(range(len(groups)), key=lambda i: (gained[i] < MOST, len(groups[i]), -gained[i]))
    for i in [i for i in order if gained[i] > PROMISING][:MAX_TRIED]:
        yield from filter(None, [try_further(result, groups[i], refit)])


def free_zeros(result: FitResult, refit: Refit) -> Cause | None:
    """The fit with offsets of the sensors whose zeros are wrong, if these are not free."""
    if any(each.key == "offset" and not each.item for each in result.model.names):
        return None
    names = [name for notes in unequal_levels(result).values() for name, _ in notes]
    cause = try_further(result, names, refit) if names else None
    return cause if cause is not None and cause.result.chi2 < result.chi2 else None


def after_zeros(zeros: Cause, cause: Cause) -> Cause:
    """A cause that is found in the fit with other zeros, together with these."""
    rows = dict(cause.result.rows())
    what = [*(f"{each} = {rows[str(each)]}" for each in zeros.names), cause.what]
    return replace(
        cause, what=listed(what), added=zeros.added + cause.added,
        advice=f"{zeros.advice}, or correct the zeros, and {cause.advice}", base=zeros.result,
        names=(*zeros.names, *cause.names),
    )  # fmt: skip


def with_pairs(result: FitResult, _: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """Fits with two offsets, gains or delays that reduce chi-squared most together."""
    singles = [names for names in groups_of_effects(result) if len(names) == 1 and names[0].item]
    pairs = [(*one, *two) for one, two in itertools.combinations(singles, 2)]
    gained = gained_by(result, pairs)
    excess = max(result.chi2 - result.goodness.freedom, 1.0)
    order = sorted(range(len(pairs)), key=lambda i: -gained[i])
    for i in [i for i in order if gained[i] > PROMISING * excess][:MAX_PAIRS]:
        yield from filter(None, [try_further(result, pairs[i], refit)])


def with_shots(result: FitResult, _: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """Fits in which a common velocity or time offset has another value in each shot."""
    model = result.model
    for key in OF_SHOTS:
        own = [Name(key, shot=str(k)) for k in range(2, len(model.chains) + 1)]
        if not own or {each for each in model.names if each.key == key} != {Name(key)}:
            continue
        # The common parameter becomes that of the first shot.
        cause = try_further(result, own, refit)
        if cause is not None:
            yield replace(cause, advice=f"free '{key}@*' instead of '{key}'")


def with_losses(result: FitResult, _: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """Fits with a loss, if the chains have none, or with the parameters of their losses."""
    model = result.model
    if not all(chain.lossless for chain in model.chains):
        for key in names_of_losses(result.chain):
            name = Name(key)
            cause = None if is_free(name.key, model) else try_further(result, (name,), refit)
            if cause is not None:
                yield cause
        return
    law = typical_law(LOSS, model.chains[0])
    chains = tuple(chain.replace(loss=law) for chain in model.chains)
    name = Name("loss.time")
    lossy = replace(model, chains=chains)
    cause = try_further(result, (name,), refit, lossy, neutral=0.0)
    if cause is not None:
        yield replace(cause, what=f"a {LOSS} loss, {cause.what}", advice=(
            f"add a loss to the chain, such as loss = {{law = '{LOSS}', time = "
            f"'{1e6 * cause.result.values[str(name)]:.3g} us'}}, and "
            f"{to_free([name])}; compare_losses compares other laws"
        ))  # fmt: skip
