"""Limits of a design that hold for elastic contacts, but not with contacts that yield."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..representation import listed
from .default_limits import OVERLAP
from .problem import Design
from .requirements import TOLERANCE, Requirement
from .verified import AT_FULLY_PLASTIC, WITH_YIELD, Verified
from .yielding import advice_with_yield

if TYPE_CHECKING:
    from .result import DesignResult


def value_with_yield(limit: Requirement, found: Verified) -> float | None:
    """The limited value with contacts that yield, if it is known and may be another one."""
    if not found.yields or limit.measure.of_chain:
        return None
    if limit.measure.key == OVERLAP:
        return found.yielding_overlap_ratio
    return found.yielding.get(str(limit.measure))


def violated_only_if_yielding(problem: Design, found: Verified) -> list[Requirement]:
    """Limits that elastic contacts meet and contacts that yield violate."""
    exceeded = []
    for each in problem.requirements:
        value = value_with_yield(each, found)
        elastic = float(each.excess(found.values[str(each.measure)]))
        if value is not None and each.excess(value) > TOLERANCE >= elastic:
            exceeded.append(each)
    return exceeded


def violated_if_fully_plastic(problem: Design, found: Verified) -> list[Requirement]:
    """Limits that are violated at the largest possible yield pressure, but not at the assumed one.

    Values outside the range of the law are not compared.
    """
    harder = found.fully_plastic
    if harder is None or harder.outside_range:
        return []
    exceeded = []
    for each in problem.requirements:
        value = harder.values.get(str(each.measure))
        if value is None or each.measure.of_chain or not each.excess(value) > TOLERANCE:
            continue
        own = value_with_yield(each, found)
        if each.excess(found.values[str(each.measure)] if own is None else own) <= TOLERANCE:
            exceeded.append(each)
    return exceeded


def met_if_yielding(result: DesignResult) -> bool:
    """Whether the design, or all points of a front, meet all limits also if contacts yield.

    The limits are to be met at the assumed and at the largest possible yield pressure.
    """
    return result.met and not any(
        violated(result.problem, each.verified)
        for each in result.front or (result,)
        for violated in (violated_only_if_yielding, violated_if_fully_plastic)
    )


def limits_at_fully_plastic(result: DesignResult) -> list[str]:
    """A line on limits that only the largest possible yield pressure violates, and the remedy."""
    points = result.front or (result,)
    broken = [violated_if_fully_plastic(result.problem, each.verified) for each in points]
    outside = sum(map(bool, broken))
    if not (result.met and outside):
        return []
    names = listed([*dict.fromkeys(str(limit) for limits in broken for limit in limits)])
    of_front = f"{outside} of the {len(points)} points of the Pareto front do"
    subject = of_front if result.front else "the design does"
    advice = advice_with_yield(result.problem, fully_plastic=True)
    return [f"{subject} NOT meet {names} if contacts yield {AT_FULLY_PLASTIC}: {advice}, because "
            "most forces grow with the yield pressure"]  # fmt: skip


def search_with_yield(result: DesignResult) -> list[str]:
    """A line on an elastic design whose contacts yield: limits that it violates, and the remedy."""
    points = result.front or (result,)
    count = sum(each.verified.yields for each in points)
    if not count:
        return []
    broken = [violated_only_if_yielding(result.problem, each.verified) for each in points]
    names = dict.fromkeys(str(limit) for limits in broken for limit in limits)
    exceeded = listed([*names]) if names else ""
    if result.front:
        points_of = f"{count} of the {len(points)} points of the Pareto front"
        text = f"contacts of {points_of} yield"
        outside = sum(map(bool, broken))
        text += f", so that {outside} of them do NOT meet {exceeded}" * bool(outside)
    else:
        text = "contacts yield" + f", and then the design does NOT meet {exceeded}" * bool(exceeded)
    advice = advice_with_yield(result.problem)
    return [f"{text}; the search assumed elastic contacts: {advice}"]


def requirement_with_yield(limit: Requirement, found: Verified) -> str:
    """The limited value with contacts that yield, in parentheses; empty if it is not known."""
    value, harder = value_with_yield(limit, found), found.fully_plastic
    parts = [] if value is None else [f"{limit.shown(value)} {found.yielding_words}"]
    if harder is not None and not harder.outside_range and not limit.measure.of_chain:
        other = harder.values.get(str(limit.measure))
        parts += [] if other is None else [f"{limit.shown(other)} {AT_FULLY_PLASTIC}"]
    return f" ({', '.join(parts)})" if parts else ""


def not_met_in_words(problem: Design, limit: Requirement, found: Verified) -> str:
    """The end of the line of a limit that the design violates, also if only with yield."""
    # A value that is not known meets no limit.
    if not limit.excess(found.values[str(limit.measure)]) <= TOLERANCE:
        return ", NOT met"
    broken = limit in violated_only_if_yielding(problem, found)
    if broken:
        return f", NOT met {WITH_YIELD}"
    harder = limit in violated_if_fully_plastic(problem, found)
    return f", NOT met if contacts yield {AT_FULLY_PLASTIC}" if harder else ""
