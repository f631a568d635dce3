"""A gap that no difference between delays of sensors shows, as a cause of residuals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from ..errors import InputError, SimulationError
from ..representation import measure
from .causes import Cause, Refit
from .end_gaps import end_gaps
from .flat_valleys import GAPS
from .free_causes import PROMISING
from .least_squares import GOOD
from .names import Name, to_free
from .problem import Problem
from .result import FitResult
from .rough_gaps import (
    SMALL,
    RoughGap,
    better_of,
    contact_words,
    gap_names,
    is_between,
    least_size,
    own_cost,
    rough_gap,
    sizes_of,
)
from .systematics import PRESENT

# Further contacts are fitted if their rough sum of squares exceeds the least one by less than this.
LESS_LIKELY: Final = 64.0
# Largest number of contacts that are fitted.
MAX_FITS: Final = 4
# A gap with a larger error, as a part of its size, is given by its smallest possible size.
KNOWN: Final = 0.2


def gap_causes(result: FitResult, _: Mapping[str, float], refit: Refit) -> Iterator[Cause]:
    """The fits with a gap at one contact, of those that rough fits prefer."""
    if any(name.key in GAPS for name in result.model.names):
        return
    rough = _all_rough(result)
    tried: set[Name] = set()
    best: FitResult | None = None
    fitting = _likely(result, rough)
    while fitting:
        for gap in fitting:
            tried.add(gap.name)
            found = fit_of(gap, refit)
            if found is None:
                continue
            best = found if best is None or found.chi2 < best.chi2 else best
            yield cause_of(gap, found)
        # A rough fit may end before it reaches the size of the gap, so that it prefers a neighbour.
        fitting = [each for each in _neighbours(result, best, rough) if each.name not in tried]


def small_gap_causes(result: FitResult, delayed: Name, refit: Refit) -> Iterator[Cause]:
    """The fits with a small gap next to a sensor, which may look like a delay of it."""
    if any(name.key in GAPS for name in result.model.names):
        return
    names = [each for each in gap_names(result.chain) if is_between(each, delayed.item, result)]
    for gap in _likely(result, [rough_gap(result, name, (SMALL,)) for name in names]):
        found = fit_of(gap, refit)
        if found is not None:
            yield cause_of(gap, found)


def _all_rough(result: FitResult) -> list[RoughGap | None]:
    """The rough fits of a gap at each contact but that with the striker, in their order."""
    names = [each for each in gap_names(result.chain) if not _only_delays(each)]
    far = end_gaps(result)
    if any(each.cost < GOOD * result.problem.expected for each in far.values()):
        return [*far.values()]
    near = {name: rough_gap(result, name, sizes_of(name, result)) for name in names}
    return [better_of(near[name], far.get(name)) for name in names]


def _neighbours(
    result: FitResult, best: FitResult | None, rough: Sequence[RoughGap | None]
) -> list[RoughGap]:
    """The rough fits at the contacts next to that of the best fit, if this explains much."""
    excess = result.chi2 - result.goodness.freedom
    if best is None or result.chi2 - best.chi2 < PROMISING * excess:
        return []
    names = [None if each is None else each.name for each in rough]
    k = names.index(best.model.names[-1])
    near = rough[max(k - 1, 0) : k + 2]
    return [each for each in near if each is not None]


def _likely(result: FitResult, rough: Sequence[RoughGap | None]) -> list[RoughGap]:
    """The best rough fits, those that are fitted to full accuracy."""
    found = sorted((each for each in rough if each is not None), key=lambda each: each.cost)
    limit = min(own_cost(result), found[0].cost + LESS_LIKELY) if found else 0.0
    return [each for each in found if each.cost < limit][:MAX_FITS]


def _only_delays(name: Name) -> bool:
    """Whether a gap only delays the impact."""
    return name.item == "0-1"


def fit_of(gap: RoughGap, refit: Refit) -> FitResult | None:
    """The fit from a rough one; none if it fails."""
    try:
        # The fit itself determines the weights of its samples.
        return refit(Problem(gap.problem.model), gap.starts, 1)
    except (InputError, SimulationError):
        return None


def cause_of(gap: RoughGap, found: FitResult) -> Cause:
    """The cause with the size of the gap, or with the smallest one that describes the data."""
    name = str(gap.name)
    advice = f"check for a gap between {contact_words(gap.name, found.chain)}"
    what = f"{name} = {dict(found.rows())[name]}"
    if found.describes and not is_known(found, name):
        what = f"{name} of at least {shown_least(gap)}"
        advice += (
            ". Larger ones only delay the signals, as the time offset does, so that the data do "
            "not determine its size"
        )
    else:
        advice += f", or {to_free([name])}"
    return Cause(what, advice, found, 1, row=True, names=(gap.name,))


def note_on_size(gap: RoughGap, found: FitResult) -> list[str]:
    """A sentence on the size of a gap that the data do not determine."""
    name = str(gap.name)
    if not found.describes or is_known(found, name):
        return []
    return [
        f"any {name} from about {shown_least(gap)} describes the data as well: larger ones only "
        "delay the signals, as the time offset does"
    ]


def is_known(found: FitResult, name: str) -> bool:
    """Whether a fit determines the size of a gap."""
    return found.errors[name] < KNOWN * abs(found.values[name])


def shown_least(gap: RoughGap) -> str:
    """The smallest gap that describes the data, as text."""
    return measure(least_size(gap, gap.cost + PRESENT), "m", digits=2)
