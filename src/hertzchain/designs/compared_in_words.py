"""Chains to compare with, and second hits, in the summary of a design."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite, isnan, nan
from typing import TYPE_CHECKING, Final, NamedTuple

from ..chain.hertz_ratios import OUTSIDE_LAW
from ..chain.yield_pressure import LOW, assumes_pressure
from ..representation import listed
from .allowed_sizes import given_beyond_allowed
from .comparison import (
    advantage,
    compared_chains,
    given_chain,
    objective_if_fully_plastic,
    objective_if_yielding,
    value_in_samples,
)
from .limits_if_yielding import violated_if_fully_plastic, violated_only_if_yielding
from .measures import BODY_PEAK, in_words
from .new_samples import FRESH
from .requirements import TOLERANCE
from .verified import (
    AT_FULLY_PLASTIC,
    WITH_YIELD,
    Verified,
    excess_with_scatter,
    met,
    violated,
)
from .yield_range import LEGEND, YIELD_HIGH, YIELD_LOW

if TYPE_CHECKING:
    from .result import DesignResult

WALL_PEAK: Final = "wall_force.peak"
BODY_ACCELERATION: Final = "body_force.acceleration"
# Objectives that follow from the peak of a hit.
FROM_PEAK: Final = (WALL_PEAK, BODY_PEAK, BODY_ACCELERATION)
# Marks values outside the range of the law of yield.
MARK: Final = "*"
MARKED: Final = f"{MARK} outside the range of the law, where forces are not a prediction"
# An advantage shrinks if it is below this part of the largest one, and by this amount.
SHRUNK, LOST = 0.75, 0.02


class Column(NamedTuple):
    """Values of the objective under one condition, and the part of them the design has."""

    title: str
    value: Callable[[Verified], float]
    outside: Callable[[Verified], bool]
    # Words for the condition in a sentence; empty if it does not belong to yield.
    words: str = ""


def comparison_lines(result: DesignResult) -> list[str]:
    """The chains to compare with: a line each, or a table if there are values with yield."""
    if not result.references:
        return []
    columns = _columns(result)
    if len(columns) == 1:
        return _single_values(result, columns[0])
    single = result.problem.objective.single
    lines = [(str(single or "score"), *(each.title for each in columns))]
    lines.append(("  this design", *_shown_row(result, columns, result.verified)))
    for name, found in compared_chains(result).items():
        lines.append((f"{name}:",))
        lines.append(("  value", *_shown_row(result, columns, found)))
        if _has_parts(result, found):
            lines.append(("  this design / value", *_parts(result, columns, found)))
        lines += [(f"  {each}",) for each in _remarks(result, columns, found)]
    texts = [text for line in lines if len(line) > 1 for text in line[1:]]
    notes = [LEGEND] if any(each.title == YIELD_HIGH for each in columns) else []
    notes += [MARKED] if any(text.endswith(MARK) for text in texts) else []
    return [*_aligned(lines), *(f"  {each}" for each in notes)]


def _aligned(lines: list[tuple[str, ...]]) -> list[str]:
    """Rows of the table with columns of equal width; lines of one text keep their own."""
    rows = [line for line in lines if len(line) > 1]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    found = []
    for first, *others in lines:
        texts = [text.rjust(width) for text, width in zip(others, widths[1:], strict=False)]
        found.append("  " + "  ".join([first.ljust(widths[0]) if texts else first, *texts]))
    return [each.rstrip() for each in found]


def _columns(result: DesignResult) -> list[Column]:
    """Conditions with values that differ from those of the condition before."""
    scatter, assumed = result.problem.scatter, assumes_pressure(result.chain)
    yields = any(law.yields for law in result.chain.contact_losses)

    def never(_: Verified) -> bool:
        return False

    def harder(found: Verified) -> bool:
        return found.fully_plastic is not None and found.fully_plastic.outside_range

    base = "no scatter" if scatter is not None else "first hit" if yields else "elastic"
    if assumed:
        base = YIELD_LOW
    words = LOW if assumed else "" if yields else "with elastic contacts"
    columns = [Column(base, result.objective_of, never, words)]
    further = [
        Column(YIELD_LOW, lambda found: objective_if_yielding(result, found),
               lambda found: found.yielding_outside_range, LOW),
        Column(YIELD_HIGH, lambda found: objective_if_fully_plastic(result, found), harder,
               AT_FULLY_PLASTIC),
    ]  # fmt: skip
    chains = [result.verified, *compared_chains(result).values()]
    for each in further:
        last = columns[-1]
        pairs = [(result._shown(last.value(one)), result._shown(each.value(one)))
                 for one in chains if isfinite(each.value(one))]  # fmt: skip
        if any(one != other for one, other in pairs):
            columns.append(each)
    if scatter is not None and any(isfinite(value_in_samples(result, each)) for each in chains):
        first = Column(scatter.statistic, lambda found: value_in_samples(result, found), never)
        columns = [first, *columns]
    return columns + _second_hits(result)


def _second_hits(result: DesignResult) -> list[Column]:
    """Columns with the objective in a second hit, if it follows from the peak of this hit."""
    chains = [result.verified, *compared_chains(result).values()]
    of_peak = str(result.problem.objective.single) in FROM_PEAK
    if (
        not of_peak
        or not any(each._dented for each in chains)
        or isnan(result.verified.second_peak)
    ):
        return []
    accelerates = str(result.problem.objective.single) == BODY_ACCELERATION

    def own(found: Verified, peak: float) -> float:
        return peak / float(found.chain.masses[-1]) if accelerates else peak

    def harder(found: Verified) -> float:
        return nan if found.fully_plastic is None else own(found, found.fully_plastic.second_peak)

    def outside(found: Verified) -> bool:
        return found.fully_plastic is not None and found.fully_plastic.outside_range

    known = isfinite(harder(result.verified))
    first = f"hit 2 {LOW}" if known else "second hit"
    columns = [Column(first, lambda found: own(found, found.second_peak), lambda _: False)]
    return columns + [Column(f"hit 2 {AT_FULLY_PLASTIC}", harder, outside)] * known


def _shown_row(result: DesignResult, columns: list[Column], found: Verified) -> list[str]:
    texts = []
    for each in columns:
        value = each.value(found)
        text = result._shown(value).strip() if isfinite(value) else "-"
        texts.append(text + MARK * each.outside(found))
    return texts


def _parts(result: DesignResult, columns: list[Column], found: Verified) -> list[str]:
    """The value of the design as part of that of a chain, under each condition."""
    texts = []
    for each in columns:
        own, value = each.value(result.verified), each.value(found)
        known = isfinite(own) and isfinite(value) and value and not _outside(result, each, found)
        texts.append(f"{own / value:.1%}" if known else "-")
    return texts


def _has_parts(result: DesignResult, found: Verified) -> bool:
    """Whether the design is compared with a chain: one that meets the limits, or the given one."""
    return met(result.problem, found.values) or found is given_chain(result)


def _outside(result: DesignResult, column: Column, found: Verified) -> bool:
    return column.outside(found) or column.outside(result.verified)


def _remarks(result: DesignResult, columns: list[Column], found: Verified) -> list[str]:
    """Limits that a chain violates, and how the comparison depends on yield."""
    lines = _not_met(result, found)
    if met(result.problem, found.values):
        lines += _dependence(result, columns, found)
    worse = advantage(result, result.value, result.objective_of(found)) < 0.0
    if worse and found is given_chain(result):
        lines += given_beyond_allowed(result)
    if str(result.problem.objective.single) not in FROM_PEAK:
        lines += _compared_second_hit(result, found)
    return lines


def reference_remarks(result: DesignResult, found: Verified) -> list[str]:
    """Sentences on a chain to compare with: limits that it violates, and how yield matters."""
    return _remarks(result, _columns(result), found)


def _not_met(result: DesignResult, found: Verified) -> list[str]:
    """Limits that a chain violates, also only if its contacts yield, or in new samples."""
    lines = []
    if not met(result.problem, found.values):
        lines.append(f"does NOT meet {_violated_limits(result, found)}")
    if broken := violated_only_if_yielding(result.problem, found):
        lines.append(f"does NOT meet {listed([str(each) for each in broken])} {WITH_YIELD}")
    elif broken := violated_if_fully_plastic(result.problem, found):
        names = listed([str(each) for each in broken])
        lines.append(f"does NOT meet {names} if contacts yield {AT_FULLY_PLASTIC}")
    if exceeded := excess_with_scatter(result.problem, found):
        lines.append(f"does NOT meet {listed(list(exceeded))} in {FRESH} new samples")
    return lines


def _dependence(result: DesignResult, columns: list[Column], found: Verified) -> list[str]:
    """A sentence if the comparison is reversed by yield, or if its advantage shrinks."""
    gains = {
        each.words: advantage(result, each.value(result.verified), each.value(found))
        for each in columns
        if each.words and not _outside(result, each, found)
    }
    gains = {words: gain for words, gain in gains.items() if isfinite(gain)}
    if len(gains) < 2:
        return []
    least, most = min(gains.values()), max(gains.values())
    kinds = {words: _percent(gain) for words, gain in gains.items()}
    if len(set(kinds.values())) < 2:
        return []
    if least < 0.0 < most:
        return [f"this design is {listed(_phrases(kinds))}: yield reverses the comparison"]
    if most > 0.0 and least < SHRUNK * most and most - least > LOST:
        return [f"this design is {listed(_phrases(kinds))}: its advantage here depends on yield"]
    return []


def _percent(gain: float) -> str:
    digits = 0 if abs(gain) >= 0.01 else 1
    return f"{abs(gain):.{digits}%} {'better' if gain >= 0.0 else 'worse'}"


def _phrases(kinds: dict[str, str]) -> list[str]:
    return [f"{kind} {words}" for words, kind in kinds.items()]


def _single_values(result: DesignResult, column: Column) -> list[str]:
    """The chains to compare with, if they have one value each."""
    lines = []
    for name, found in compared_chains(result).items():
        (value,) = _shown_row(result, [column], found)
        lines.append(f"  {name}: {value}")
        if _has_parts(result, found):
            (part,) = _parts(result, [column], found)
            lines += [f"    this design: {part} of this value"] if part != "-" else []
        lines += [f"    {each}" for each in _remarks(result, [column], found)]
    return lines


def compared_in_words(result: DesignResult, found: Verified) -> str:
    """Values of a chain to compare with, and which part of each the design has, on one line."""
    columns = _columns(result)
    values, parts = _shown_row(result, columns, found), _parts(result, columns, found)
    compared = _has_parts(result, found)
    texts = []
    for column, value, part in zip(columns, values, parts, strict=True):
        title = f"{column.title} " if len(columns) > 1 else ""
        shown = f"; this design: {part} of this value" if compared and part != "-" else ""
        texts.append(f"{title}{value}{shown}")
    return "; ".join([*texts, *_remarks(result, columns, found)])


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
    if isnan(peak) or isnan(own) or not (found._dented or result.verified._dented):
        return []
    return [f"{_second_hit(found)}; this design: {own / peak:.1%} of this value"]


def peak_at_end(found: Verified) -> str:
    """Name of the peak of a second hit."""
    return WALL_PEAK if found.chain.right_wall is not None else BODY_PEAK


def _second_hit(found: Verified) -> str:
    units, text = found.chain.units, ""
    if found.fully_plastic is not None and isfinite(again := found.fully_plastic.second_peak):
        text = f" ({in_words(again, 'N', units)} {AT_FULLY_PLASTIC})"
    return (
        f"{peak_at_end(found)} = {in_words(found.second_peak, 'N', units)} in the second hit{text}"
    )


def second_hit_in_words(found: Verified) -> list[str]:
    """The peak on the right wall, or on a cap, if the chain is struck again with its dents."""
    if not found._dented:
        return []
    return [f"  struck again with these dents: {_second_hit(found)}",
            "  the search compares the first hit only"]  # fmt: skip


def shown_if_yielding(result: DesignResult, found: Verified) -> str:
    """The objective with contacts that yield."""
    return result._shown(objective_if_yielding(result, found)).strip()


def shown_yield_range(result: DesignResult, found: Verified) -> str:
    """The objective at both yield pressures; empty if it is the same or not known."""
    low, high = objective_if_yielding(result, found), objective_if_fully_plastic(result, found)
    texts = [result._shown(each).strip() for each in (low, high)]
    if found.fully_plastic is None or not isfinite(high) or texts[0] == texts[1]:
        return ""
    mark = f", {OUTSIDE_LAW}" if found.fully_plastic.outside_range else ""
    return f"{texts[0]} if they yield {LOW}, {texts[1]} {AT_FULLY_PLASTIC}{mark}"
