"""Chains to compare with, and second hits, in the summary of a design."""

from __future__ import annotations

from math import isnan
from typing import TYPE_CHECKING

from ..representation import listed
from .comparison import compared, objective_if_yielding, value_in_samples
from .measures import in_words
from .new_samples import FRESH
from .requirements import TOLERANCE
from .verified import Verified, excess_with_scatter, violated

if TYPE_CHECKING:
    from .result import DesignResult


def compared_in_words(result: DesignResult, found: Verified) -> str:
    """Values of a chain to compare with, and which part of each the design has."""
    return "; ".join([
        *_compared_in_samples(result, found), _compared_values(result, found),
        *_compared_second_hit(result, found),
    ])  # fmt: skip


def _compared_in_samples(result: DesignResult, found: Verified) -> list[str]:
    """The statistic of a scatter in new samples of a chain to compare with, if it has a value."""
    value, own = (value_in_samples(result, each) for each in (found, result.verified))
    if isnan(value):
        return []
    text = (
        f"{result.problem.scatter.statistic} {result._shown(value).strip()} in {FRESH} new samples"
    )
    if exceeded := excess_with_scatter(result.problem, found):
        return [f"{text}, which do NOT meet {listed(list(exceeded))}"]
    return [f"{text}; this design: {own / value:.1%} of this value" if value else text]


def _compared_values(result: DesignResult, found: Verified) -> str:
    """The verified value of a chain to compare with, which has no scatter."""
    both = compared(result, found)
    text = result._shown(both.value)
    # At a small excess of the pressure, the values agree in all digits that are shown.
    if (yielding := shown_if_yielding(result, found)) != text.strip():
        text += f" ({yielding} {found.yielding_words})"
    if result.problem.scatter is not None:
        text += " without scatter"
    if not both.met:
        return f"{text}, which does NOT meet {_violated_limits(result, found)}"
    if not both.value:
        return text
    part = f"{both.own / both.value:.1%}"
    yielding_part = f"{both.own_if_yielding / both.value_if_yielding:.1%}"
    text += f"; this design: {part} of this value"
    if part != yielding_part and both.within_range:
        text += f", {yielding_part} with contacts that yield"
    return f"{text}, which reverses the comparison" if both.reversed else text


def _violated_limits(result: DesignResult, found: Verified) -> str:
    """Limits that a chain violates, each with its value."""
    names = violated(result.problem, found.values)
    if not names:
        return "the limits"
    limits = [each for each in result.problem.requirements if str(each.measure) in names]
    shown = [
        f"{each} ({each.shown(found.values[str(each.measure)])})"
        for each in limits
        if each.excess(found.values[str(each.measure)]) > TOLERANCE
    ]
    return listed(shown)


def _compared_second_hit(result: DesignResult, found: Verified) -> list[str]:
    """The peak of a chain to compare with that is struck again, if the design has one, too."""
    peak, own = found.second_peak, result.verified.second_peak
    if isnan(peak) or isnan(own):
        return []
    return [f"{_second_hit(found)}; this design: {own / peak:.1%} of this value"]


def _second_hit(found: Verified) -> str:
    return (
        f"wall_force.peak = {in_words(found.second_peak, 'N', found.chain.units)} in the second hit"
    )


def second_hit_in_words(found: Verified) -> list[str]:
    """The peak on the right wall if the chain is struck again with its dents."""
    if isnan(found.second_peak):
        return []
    return [f"  struck again with these dents: {_second_hit(found)}; the search compares the first "
            "hit only"]  # fmt: skip


def shown_if_yielding(result: DesignResult, found: Verified) -> str:
    """The objective with contacts that yield."""
    return result._shown(objective_if_yielding(result, found)).strip()
