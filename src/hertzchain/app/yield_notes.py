"""Notes about contacts that have yielded, as in the summary of the command line."""

from __future__ import annotations

from ..chain.yield_pressure import ASSUMED_PRESSURE, OTHER_PRESSURE
from ..simulation.run import Run
from ..simulation.yield_range import depends_on_yield_pressure
from ..simulation.yielding import dents_in_words, remark_on_overlaps
from .wording import on_the_page


def yield_notes(run: Run) -> list[str]:
    """Contacts that have yielded, their largest overlap, and the pressure if it is assumed."""
    if not run.dents.any():
        return []
    yielded = (dents_in_words(run.chain, run._furthest_overlaps), remark_on_overlaps(run))
    notes = ["; ".join(filter(None, yielded))]
    if depends_on_yield_pressure(run):
        notes.append(f"{ASSUMED_PRESSURE}; to see its effect, {OTHER_PRESSURE}")
    return [on_the_page(each) for each in notes]
