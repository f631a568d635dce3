"""Notes about contacts that have yielded, as in the summary of the command line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ..chain.materials import FIRST_YIELD
from ..chain.yield_pressure import ASSUMED_PRESSURE, OTHER_PRESSURE
from ..simulation.run import Run
from ..simulation.yield_range import depends_on_yield_pressure
from ..simulation.yielding import dents_in_words, remark_on_overlaps
from .wording import on_the_page

# Label of the peak in a second simulation, of an elastic chain with contacts that yield.
IF_YIELDING: Final = f"peak if contacts yield at {FIRST_YIELD:g} Y"


def yield_notes(run: Run) -> list[str]:
    """Contacts that have yielded, their largest overlap, and the pressure if it is assumed."""
    if not run.dents.any():
        return []
    yielded = (dents_in_words(run.chain, run._furthest_overlaps), remark_on_overlaps(run))
    notes = ["; ".join(filter(None, yielded))]
    if depends_on_yield_pressure(run):
        notes.append(f"{ASSUMED_PRESSURE}; to see its effect, {OTHER_PRESSURE}")
    return [on_the_page(each) for each in notes]


def assumption_note(peaks: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """The yield pressure that a peak of an elastic chain assumes, if one is shown."""
    labels = [what for each in peaks.values() for what, *_ in each["shown"]]
    given = any(each.startswith(IF_YIELDING) for each in labels)
    return [f"{IF_YIELDING}: {ASSUMED_PRESSURE}"] if given else []
