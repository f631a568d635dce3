"""Values of elastic chains with contacts that yield instead."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from ..chain.chain import Chain
from ..chain.hertz_range import hertz_range
from ..chain.materials import FULLY_PLASTIC
from ..collision import Array
from ..recorded_warnings import ignore_warnings
from ..simulation.simulate_many import tabulate_runs
from ..simulation.yielding import (
    MAX_BEADS,
    UNKNOWN,
    WithYield,
    dented_chain,
    largest_overlap_ratio,
    may_dent,
)
from .measured import measured
from .measures import RANGE, Measure, in_words

if TYPE_CHECKING:
    from .problem import Design

# Measures that are computed from overlaps by the elastic law.
NOT_YIELDING: Final = ("largest_force", *RANGE)
YIELD: Final = "yield_ratio"


def value_if_yielding(
    chain: Chain, measure: Measure, overlaps: Array | None = None, until: float | None = None
) -> WithYield:
    """Value of a measure with `ElasticPlastic` contacts instead of elastic ones.

    It is NaN if elastic contacts, with these largest overlaps or those of a simulation, do not
    yield, or if the value is not known.
    """
    if chain.units != "SI" or chain.materials is None or chain.beads > MAX_BEADS:
        return UNKNOWN
    dented = dented_chain(chain)
    if dented is None or not measure.columns or measure.key in NOT_YIELDING:
        return UNKNOWN
    with ignore_warnings():
        # Those of the elastic chain are shown.
        if overlaps is None:
            overlaps = tabulate_runs([chain], until=until)._overlaps[0, : chain.beads + 1]
        if not may_dent(hertz_range(chain, overlaps)):
            return UNKNOWN
        found = measured([dented], [measure], until=until)
        table = found.table or tabulate_runs([dented], until=until)
        ratio = largest_overlap_ratio(dented, table._overlaps[0, : chain.beads + 1])
        return WithYield(float(found.values[0, 0]), ratio)


def yielding_note(what: str, measure: Measure, elastic: float, yielding: WithYield) -> str:
    """A sentence with the value of contacts that yield, beside the elastic one."""
    value = in_words(yielding.value, measure.unit, "SI")
    if yielding.outside:
        return f"with contacts that yield, {what} is {value}, {yielding.caution}"
    part = f", {yielding.value / elastic:.1%} of the elastic value" if elastic else ""
    return f"with contacts that yield, {what} is {value}{part}"


def change_with_yield(problem: Design) -> str:
    """The change that a law of yield requires, because its chains have no `yield_ratio`."""
    if any(each.key == YIELD for each in problem.objective.measures):
        return f"replace the objective {YIELD}"
    limited = any(each.measure.key == YIELD for each in problem.requirements)
    return f"remove {YIELD} from subject_to" if limited else ""


def advice_with_yield(problem: Design, *, fully_plastic: bool = False) -> str:
    """Advice to search with a law of yield, also at the largest possible yield pressure."""
    change = change_with_yield(problem)
    law = f"ElasticPlastic({f'factor={FULLY_PLASTIC:g}' if fully_plastic else ''})"
    return f"{f'{change} and use' if change else 'search with'} loss={law}"
