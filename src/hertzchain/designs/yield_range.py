"""Values of verified chains at the largest possible yield pressure, where one is assumed."""

from __future__ import annotations

from dataclasses import replace
from math import isnan, nan
from typing import Final

from ..chain.chain import Chain
from ..chain.materials import FIRST_YIELD, FULLY_PLASTIC
from ..chain.yield_pressure import assumes_pressure, with_factor
from ..recorded_warnings import ignore_warnings
from ..simulation.hits import peak_of_second_hit
from ..simulation.yielding import MAX_BEADS, dented_chain
from .problem import Design
from .verified import FullyPlastic, Verified, run_with_yield

FACTORS: Final = (FIRST_YIELD, FULLY_PLASTIC)
# Headings of values at both yield pressures.
YIELD_LOW: Final = f"yield {FIRST_YIELD:g} Y"
YIELD_HIGH: Final = f"yield {FULLY_PLASTIC:g} Y"
LEGEND: Final = (
    f"Y: yield strength; contacts yield at a pressure of {FIRST_YIELD:g} to {FULLY_PLASTIC:g} Y, "
    "of which both ends are simulated"
)


def with_yield_range(problem: Design, found: Verified) -> Verified:
    """Numbers of a chain, with those at the largest possible yield pressure, if one is assumed."""
    chain = _at_assumed_pressure(found)
    if chain is None or chain.beads > MAX_BEADS:
        return found
    harder = with_factor(chain, FULLY_PLASTIC)
    with ignore_warnings():  # Those of the chain itself are shown.
        run = run_with_yield(problem, harder, found.values)
    if run is None:
        return found
    again = nan
    if not isnan(found.second_peak):
        again = peak_of_second_hit(harder, problem.until)
    return replace(found, fully_plastic=FullyPlastic(run.values, run.overlap_ratio, again))


def _at_assumed_pressure(found: Verified) -> Chain | None:
    """The chain whose contacts yield at an assumed pressure; None if there is none."""
    if assumes_pressure(found.chain):
        return found.chain
    return dented_chain(found.chain) if found.yielding else None
