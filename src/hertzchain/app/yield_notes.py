"""Notes about contacts that have yielded, as in the summary of the command line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ..chain.chain import Chain
from ..chain.hertz_ratios import OUTSIDE_LAW
from ..chain.materials import FULLY_PLASTIC
from ..chain.yield_pressure import (
    ASSUMED_PRESSURE,
    OTHER_PRESSURE,
    YIELD_ASSUMED,
    assumes_pressure,
)
from ..simulation.run import Run
from ..simulation.yield_range import (
    depends_on_yield_pressure,
    peaks_at_both_pressures,
    same_at_any_pressure,
)
from ..simulation.yielding import dents_in_words, remark_on_overlaps
from ..validation.objects import Progress
from .wording import on_the_page

# Label of the peak with contacts that yield, in a second simulation if the chain is elastic.
IF_YIELDING: Final = f"peak if {YIELD_ASSUMED}"
AT_MOST: Final = f"at {FULLY_PLASTIC:g} Y"
# After labels of peaks that a later force may exceed.
SO_FAR: Final = " (so far)"


def peaks_if_yielding(run: Run, progress: Progress | None) -> list[list[Any]]:
    """Labels, peaks and no times of a run with contacts that yield, at both pressures."""
    first, last = peaks_at_both_pressures(run, progress)
    if first is None:
        return []
    label = f"{IF_YIELDING}{SO_FAR}" if first.so_far else IF_YIELDING
    if first.outside:
        return [[f"{label}, {OUTSIDE_LAW}", first.value, None]]
    shown: list[list[Any]] = [[label, first.value, None]]
    if last is not None and not last.outside:
        shown.append([f"{AT_MOST}{SO_FAR if last.so_far else ''}", last.value, None])
    return shown


def known_peak(run: Run, shown: list[list[Any]], own: float | None) -> float | None:
    """The peak at first yield, `None` if it is not known within the range of the law.

    It is that of the run itself, ``own``, if no contact yields.
    """
    if not shown:
        return own if same_at_any_pressure(run) else None
    if shown[0][0].removesuffix(SO_FAR) != IF_YIELDING:
        return None
    value: float = shown[0][1]
    return value


def yield_notes(run: Run) -> list[str]:
    """Contacts that have yielded, their largest overlap, and the pressure if it is assumed."""
    if not run.dents.any():
        return []
    yielded = (dents_in_words(run.chain, run._furthest_overlaps), remark_on_overlaps(run))
    notes = ["; ".join(filter(None, yielded))]
    if depends_on_yield_pressure(run):
        notes.append(f"{ASSUMED_PRESSURE}; to see its effect, {OTHER_PRESSURE}")
    return [on_the_page(each) for each in notes]


def assumption_note(chain: Chain, peaks: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """The yield pressure that a peak of an elastic chain assumes, if one is shown."""
    labels = [what for each in peaks.values() for what, *_ in each["shown"]]
    # `yield_notes` states that of a chain with a law of yield.
    given = any(each.startswith(IF_YIELDING) for each in labels) and not assumes_pressure(chain)
    return [f"{IF_YIELDING}: {ASSUMED_PRESSURE}"] if given else []
