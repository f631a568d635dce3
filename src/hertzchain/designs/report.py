"""Summary of the result of a design."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Final

from ..chain.hertz_ratios import OUTSIDE_LAW, caution_outside_law
from ..chain.yield_pressure import (
    ASSUMED_PRESSURE,
    assumed_for_all,
    assumes_pressure,
    note_on_soft_balls,
)
from ..representation import counted, listed, usual_unit, with_decimals
from ..simulation.yielding import unchecked_contacts
from .ball_space import BallSpace
from .compared_in_words import (
    comparison_lines,
    peak_at_end,
    second_hit_in_words,
    shown_if_yielding,
    shown_yield_range,
)
from .comparison import (
    better_if_yielding,
    has_yielding_value,
)
from .ends_of_search import no_better, not_met_with_given, search_choices
from .limits_if_yielding import (
    limits_at_fully_plastic,
    met_if_yielding,
    not_met_in_words,
    requirement_with_yield,
    search_with_yield,
)
from .measures import Measure, in_words, without_in_words
from .methods import SEEDED
from .new_samples import FRESH
from .sizes_in_words import order_in_words, parts_in_lines, sizes_in_lines
from .verified import AT_FULLY_PLASTIC, WITH_YIELD, Verified, excess_with_scatter, met, violated

if TYPE_CHECKING:
    from .result import DesignResult

# Numbers of choices from which they are rounded.
MAX_EXACT: Final = 1e9
OUTSIDE_HERTZ: Final = "outside the range of Hertz's law"
NOT_SEARCHED: Final = "No chain can meet the constraints, so nothing was searched"


def summary(result: DesignResult) -> str:
    """Text of several lines."""
    if result.method == "none":
        return f"{NOT_SEARCHED}: {result.notes[0]}"
    problem = result.problem
    lines = _heading(result)
    lines += [f"  {text}" for text in _starts(result)]
    lines += comparison_lines(result)
    lines += no_better(result)
    if problem.tie_breaker is not None:
        lines.append(
            f"  among rows of as many beads, {problem.tie_breaker.preference} is preferred"
        )
    if result.promise is not None:
        value, error = result.promise
        lines.append(f"  the local-rate law promised {value:.6g} with an estimated error of "
                     f"{error:.1g}")  # fmt: skip
    lines += [_requirement(result, i) for i in range(len(problem.requirements))]
    lines += [f"  bound: {bound}" for bound in result.bounds]
    sampled = [each for each in problem.measures if f"mean of {each}" in result.verified.scattered]
    lines += [
        f"  with scatter, {FRESH} new samples: {_scattered(result, each)}" for each in sampled
    ]
    if result.parts:
        of_row = "parts" if result.met else "parts of the row that comes closest (limits NOT met)"
        lines.append(f"{of_row}{', without the arriving ball' * _arrives(result)}:")
        lines += parts_in_lines(result)
    if result.problem.discrete and result.chain.materials is not None:
        lines.append(f"order: {order_in_words(result)}")
    lines += sizes_in_lines(result)
    lines += _totals(result)
    if result.optima:
        lines.append("local optima:")
        lines += [f"  {_point(result, i)}" for i in range(len(result.optima))]
    if result.front:
        lines.append(f"{front_in_words(result)}:")
        lines += [
            f"  {i}: {point_in_words(point)}" for i, point in enumerate(result.front, start=1)
        ]
    notes = *result.notes, _assumed(result), _soft_balls(result)
    lines += [f"note: {note}" for note in notes if note]
    return "\n".join(lines)


def _assumed(result: DesignResult) -> str:
    """A note on the yield pressure that the search assumes; empty if it is given."""
    if result.verified.fully_plastic is None or not assumes_pressure(result.chain):
        return assumed_for_all(result.chain)
    return f"{ASSUMED_PRESSURE}; the search compares chains at the smaller one"


def _soft_balls(result: DesignResult) -> str:
    """A note on balls that are harder than annealed bars; empty if no value depends on it."""
    for each in result.front or (result,):
        yielding = has_yielding_value(result, each.verified)
        if note := note_on_soft_balls(each.chain, yielding=yielding):
            return note
    return ""


def front_in_words(result: DesignResult) -> str:
    """The Pareto front, and the part of the choices among which it was found."""
    space = result.problem.space
    if not isinstance(space, BallSpace) or result.front_is_complete:
        return "Pareto front"
    if result.problem.scatter is not None:
        return "Pareto front of the simulated choices, which may miss points"
    return (f"Pareto front of {result.runs} simulated choices, of {_shown_count(space.count)} in "
            "all; it may miss points, fewer with a larger budget")  # fmt: skip


def _shown_count(count: float) -> str:
    """A number of choices, which may be astronomical."""
    return f"{count:.0f}" if count < MAX_EXACT else f"{count:.2g}"


def _scattered(result: DesignResult, each: Measure) -> str:
    """Values of a measure in samples of the scatter, and whether they exceed a limit."""
    scatter = result.problem.scatter
    tail = scatter.statistic if scatter.tail else "CVaR90"
    values = {kind: result.verified.scattered[f"{kind} of {each}"]
              for kind in ("mean", tail, "worst")}  # fmt: skip
    scaled, worst = result.chain.scaled, values["worst"]
    factor, unit = (1.0, "") if scaled or each.unit == "1" else usual_unit(worst, each.unit)
    # With so many digits that the values differ, and with at least about four.
    spread = factor * min(abs(worst - values["mean"]), 0.1 * abs(worst))
    texts = with_decimals([factor * value for value in values.values()], spread)
    parts = [f"{kind} {text} {unit}".strip() for kind, text in zip(values, texts, strict=True)]
    limits = [limit for limit in result.problem.requirements if limit.measure == each]
    over = [kind for kind, value in values.items() if any(x.excess(value) > 0.0 for x in limits)]
    verb = "exceed" if len(over) > 1 else "exceeds"
    over = ["worst value" if kind == "worst" else kind for kind in over]
    exceeding = f" ({listed(over)} {verb} the limit)" if over else ""
    return f"{each} {', '.join(parts)}{exceeding}"


def point_in_words(point: DesignResult) -> str:
    """Values of both objectives of a point, also with contacts that yield and in a second hit."""
    yielding, units, parts = point.verified.yielding, point.chain.units, []
    for each in point.problem.reported:
        name = str(each)
        text = f"{each} {in_words(point.values[name], each.unit, units)}"
        if name in yielding and not each.of_chain:
            shown = in_words(yielding[name], each.unit, units)
            parts_of = [f"{shown} {point.verified.yielding_words}"]
        else:
            parts_of = []
        harder = point.verified.fully_plastic
        if harder is not None and not each.of_chain and name in harder.values:
            beyond = f", {OUTSIDE_LAW}" if harder.outside_range else ""
            shown = in_words(harder.values[name], each.unit, units)
            parts_of.append(f"{shown} {AT_FULLY_PLASTIC}{beyond}")
        text += f" ({', '.join(parts_of)})" if parts_of else ""
        parts.append(text)
    if point.verified._dented:
        again = in_words(point.verified.second_peak, "N", units)
        parts.append(f"{peak_at_end(point.verified)} {again} in the second hit")
    return ", ".join(parts) + _outside_in_words(point.verified)


def _outside_in_words(found: Verified) -> str:
    """A statement that contacts left Hertz's law, if no value with contacts that yield is known."""
    return "" if found.yielding else _left_law(found)


def _left_law(found: Verified) -> str:
    """A statement that contacts left the range of their law, and whether forces are predicted."""
    if not found.outside_range:
        return ""
    yields = any(law.yields for law in found.chain.contact_losses)
    words = f", {OUTSIDE_LAW if yields else OUTSIDE_HERTZ}"
    return words + ", where forces are not a prediction" * found.not_a_prediction


def _counted(result: DesignResult, each: Measure) -> str:
    """Whether a sum over beads counts the arriving ball, and that it counts no striker and cap."""
    if each.key not in ("length", "mass", "beads"):
        return ""
    if without := without_in_words(result.chain):
        return without
    return " with the arriving ball" if _arrives(result) else ""


def _totals(result: DesignResult) -> list[str]:
    """Number of beads, length and mass."""
    chain = result.chain
    if not isfinite(result.value):
        return []
    beads, *others = (Measure(key) for key in ("beads", "length", "mass"))
    shown = [in_words(each.from_chain(chain, 0.0), each.unit, chain.units) for each in others]
    count = counted(int(beads.from_chain(chain, 0.0)), "bead")
    counted_ones = _counted(result, beads)
    where = f",{counted_ones}" if counted_ones else ""
    return [f"in all{where}: {count}, length {shown[0]}, mass {shown[1]}"]


def _arrives(result: DesignResult) -> bool:
    """Whether the first ball arrives, and is not among those that vary."""
    space, chain = result.problem.space, result.chain
    return (
        isinstance(space, BallSpace)
        and 0 not in space.places
        and chain.strikers == 0
        and bool(chain.velocities[0])
    )


def _heading(result: DesignResult) -> list[str]:
    """The value, and what its verification covers."""
    problem, found = result.problem, result.verified
    value = result._shown(result.value)
    single = problem.objective.single
    value += _counted(result, single) if single is not None else ""
    first = f"{_first_upper(str(problem.objective))}: {value}"
    if problem.scatter is not None and single is not None:
        aim = "smallest" if problem.objective.sign > 0.0 else "largest"
        searched = result._shown(result._sign * result.expected)
        first = (f"{_first_upper(aim)} {problem.scatter.statistic} of {single}: {searched} in the "
                 f"search; {value} without scatter")  # fmt: skip
    outside = "" if result.front else _outside_of_value(result)
    if result.met_in_search and excess_with_scatter(problem, found):
        first = f"The constraints are NOT met in new samples of the scatter. {first}{outside}"
    elif not result.met:
        first = f"{_closest(result, value.strip())}{outside}{_more_trials(result)}"
    else:
        first += outside
    harder = limits_at_fully_plastic(result)
    first += f"; NOT all limits are met if contacts yield {AT_FULLY_PLASTIC}" * bool(harder)
    remarks = *not_met_with_given(result), *search_with_yield(result), *harder
    lines = [first, *(f"  {line}" for line in remarks),
             f"  verified: the integration was repeated at rtol {found.rtol:g}"
             f"{_range_in_words(result)}"]  # fmt: skip
    if has_yielding_value(result, found):
        caution = caution_outside_law(found.yielding_overlap_ratio)
        both = "" if caution else shown_yield_range(result, found)
        lines.append(f"  the same chain with contacts that yield, loss=ElasticPlastic(): "
                     f"{both or shown_if_yielding(result, found)}"
                     f"{f', {caution}' if caution else ''}")  # fmt: skip
        lines += [f"  {found.dents}"] if found.dents and not caution else []
        lines += _better_if_yielding(result)
    elif found.dents:
        if both := shown_yield_range(result, found):
            lines.insert(1, f"  {both.replace('they', 'contacts', 1)} (Y: yield strength)")
        lines += [f"  {found.dents}", *second_hit_in_words(found)]
    return lines


def _outside_of_value(result: DesignResult) -> str:
    """A statement that the value is outside the range of the law.

    Values with contacts that yield suffice instead, unless forces are not a prediction.
    """
    found = result.verified
    return _left_law(found) if found.not_a_prediction else _outside_in_words(found)


def _closest(result: DesignResult, value: str) -> str:
    """A statement that no trial meets the constraints, with the value of the closest one."""
    problem, single = result.problem, result.problem.objective.single
    name = "score" if single is None else str(single)
    if problem.scatter is not None and single is not None:
        name = f"{problem.scatter.statistic} of {name}"
        searched = result._shown(result._sign * result.expected)
        value = f"{searched} in the search, {value} without scatter"
    outside = [each for each in problem.requirements
               if str(each.measure) in violated(problem, result.values)]  # fmt: skip
    if outside and all(each.default for each in outside):
        (limit,) = outside
        law = "the law" if _describes_yield(result) else "Hertz's law"
        ratio = limit.shown(result.values[str(limit.measure)])
        return (f"No chain was found within the range of {law} ({limit}); the closest one has "
                f"{ratio} ({name}: {value})")  # fmt: skip
    article = "an" if name[0] in "aeiou" else "a"
    return f"No trial meets the constraints; the closest one has {article} {name} of {value}"


def _more_trials(result: DesignResult) -> str:
    """Advice if no trial meets the constraints, unless all choices were tried."""
    if wall := _yielding_wall(result):
        return f"; {wall}: choose a harder wall or a smaller velocity, or relax yield_ratio"
    choices = search_choices(result)
    if choices is not None and choices[0] >= choices[1]:
        return ""
    begin = ", begin with a row that meets them (start)" if choices is not None else ""
    return f"; give a larger budget or another seed{begin}, or relax a limit"


def _yielding_wall(result: DesignResult) -> str:
    """A statement that the limit of yield fails at a wall of a softer material than its ball."""
    limits, chain = result.verified.hertz_range, result.chain
    if limits is None or violated(result.problem, result.values) != ["yield_ratio"]:
        return ""
    at = limits._most_loaded
    wall = {0: chain.left_wall, chain.beads: chain.right_wall}.get(at)
    if wall is None or wall.material is None or wall.material.name != limits.yielding[at]:
        return ""
    side = "left" if at == 0 else "right"
    return f"{wall.material.name} of the {side} wall yields, not a ball"


def _better_if_yielding(result: DesignResult) -> list[str]:
    """The runner-up that is better than the design with contacts that yield, if there is one."""
    place = better_if_yielding(result)
    if place is None:
        return []
    shown = shown_if_yielding(result, result.runners_up[place])
    return [f"  runner-up {place + 1}, which is worse with elastic contacts, has {shown} with "
            "contacts that yield (runners_up in Python, better_if_yielding in --json)"]  # fmt: skip


def _range_in_words(result: DesignResult) -> str:
    """Whether the contacts of the design, or of a Pareto front, kept to Hertz's law."""
    if result.verified.hertz_range is None:
        return ""
    outside, count = sum(each.verified.outside_range for each in result.front), len(result.front)
    if outside:
        points = f"{outside} of the {count}" if outside < count else f"all {count}"
        points = "the only point" if count == 1 else f"{points} points"
        return (f"; contacts of {points} of the Pareto front left the range of Hertz's law "
                "(see the list)")  # fmt: skip
    if result.verified.outside_range:
        return "; contacts left the range of Hertz's law (see the notes)"
    if any(unchecked_contacts(each.chain) for each in result.front or (result,)):
        where = " at any point of the Pareto front" if result.front else " (see the notes)"
        return f"; no known limit of Hertz's law was exceeded{where}"
    every = " of all points of the Pareto front" if result.front else ""
    law = "their law" if any(map(_describes_yield, result.front or (result,))) else "Hertz's law"
    if any(each.verified.stiff_walls for each in result.front or (result,)):
        return (f"; all Hertz contacts{every} stayed within the range of {law}; the spring of the "
                "wall is too stiff to replace one (see the notes)")  # fmt: skip
    return f"; all contacts{every} stayed within the range of {law}"


def _describes_yield(result: DesignResult) -> bool:
    return any(law.yields for law in result.chain.contact_losses)


def _first_upper(text: str) -> str:
    return text[:1].upper() + text[1:]


def constraints_in_words(result: DesignResult) -> str:
    """Whether the constraints are met, also with contacts that yield; empty without any."""
    if not result.problem.requirements:
        return ""
    if result.met and not met_if_yielding(result):
        words = WITH_YIELD if search_with_yield(result) else f"if contacts yield {AT_FULLY_PLASTIC}"
        return f"constraints NOT met {words}"
    return "constraints met" if result.met else "constraints NOT met"


def search_in_words(result: DesignResult) -> str:
    """The choices or starts of which the design is the best."""
    if result.method == "none":
        return "not searched"
    if (choices := search_choices(result)) is None:
        return _of_starts(result)
    done, count = choices
    if done < count:
        return f"best of the first {done} of {count} choices{_rejected(result)}"
    if result.rejected:
        return f"best of {count - result.rejected} of {count} choices{_rejected(result)}"
    return f"best of all {counted(count, 'simulated choice')}"


def _rejected(result: DesignResult) -> str:
    """The number of trials without a value, if there are any."""
    return f" ({result.rejected} were rejected, see the notes)" if result.rejected else ""


def _starts(result: DesignResult) -> list[str]:
    if (choices := search_choices(result)) is not None:
        done, count = choices
        if done >= count:
            return [search_in_words(result)]
        return [f"{search_in_words(result)}: the budget was used up before all were tried; give a "
                "larger budget, or method 'genetic'"]  # fmt: skip
    work = counted(result.runs, "simulation")
    if result.gradients:
        work += f", including those of {counted(result.gradients, 'gradient')}"
    if len(result.finals) == 0:
        return [f"no search was completed: the budget was used up in {work}, which began with the "
                "chains to compare with; give a larger budget"]  # fmt: skip
    advice = "; try other seeds" if len(result.finals) == 1 and result.method in SEEDED else ""
    by = "of" if len(result.finals) == 1 else "by"
    return [f"{_of_starts(result)}{_ends(result)} {by} method {result.method!r}, in {work} and "
            f"{result.seconds:.0f} s{advice}"]  # fmt: skip


def _ends(result: DesignResult) -> str:
    """Best and median of the starts that meet the constraints, and the number of the others."""
    if len(result.finals) < 2 or not result.met:
        return ""
    outside = int((~result.finals_met).sum())
    if outside == len(result.finals):
        return (
            " (no start ended within the constraints: the design is the best of all trials that "
            "meet them)"
        )
    best, median = map(result._shown, result.spread)
    others = f"; not counting {outside} outside the constraints" if outside else ""
    scatter, value = result.problem.scatter, result.value
    kind = ""
    if scatter is not None:
        kind, value = f"{scatter.statistic}: ", result._sign * result.expected
    improved = result._sign * (value - result.spread[0]) < 0.0
    if improved and best != result._shown(value):
        return (f" ({kind}the best one ended at {best}, the median at {median}{others}; further "
                "trials improved it)")  # fmt: skip
    return f" ({kind}best {best}, median {median}{others})"


def _of_starts(result: DesignResult) -> str:
    count = len(result.finals)
    return "one start" if count == 1 else f"best of {counted(count, 'start')}"


def _requirement(result: DesignResult, index: int) -> str:
    each = result.problem.requirements[index]
    value, name = result.values[str(each.measure)], str(each.measure)
    text = f"  {each}: {each.shown(value)}{_counted(result, each.measure)}"
    text += requirement_with_yield(each, result.verified)
    if each.default:
        why = "contacts yield" if _describes_yield(result) else "no force is predicted beyond it"
        text += f" (added because {why}; to lift it, give a limit, such as {name} <= 10)"
    return text + not_met_in_words(result.problem, each, result.verified)


def _point(result: DesignResult, index: int) -> str:
    found = result.optima[index]
    (block,) = result.problem.space.blocks  # type: ignore[union-attr]
    size = getattr(found.chain, block.field)[block.places[0]]
    outside = "" if met(result.problem, found.values) else ", which violates the constraints"
    return f"{block.field} {size:.6g}: {result._shown(result.objective_of(found))}{outside}"
