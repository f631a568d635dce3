"""HTML representations of designs and of distributions over random chains."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..designs.compared_in_words import compared_in_words
from ..designs.comparison import compared_chains
from ..designs.distribution import Distribution
from ..designs.limits_if_yielding import not_met_in_words
from ..designs.measures import notes_on
from ..designs.report import front_in_words, search_in_words
from ..designs.result import DesignResult
from ..designs.scatter import Scatter
from ..designs.scatter_causes import NOTE, ScatterCauses
from ..designs.sizes_in_words import order_in_words
from ..representation import counted
from .drawing import Curve, axis_unit, chart, engineering, note, numbers, page, sentence, table

PERCENTILES: Final = (5, 50, 95)


def design_html(result: DesignResult) -> str:
    """Value, comparison, constraints, parts and notes."""
    problem, shown = result.problem, result._shown
    found = {"value": shown(result.value).strip()}
    if problem.scatter is not None:
        expected = shown(result._sign * result.expected).strip()
        found = {
            f"{problem.scatter.statistic} in the search": expected,
            "value without scatter": found["value"],
        }
    found["search"] = f"{search_in_words(result)}, {result.runs} simulations"
    found |= {
        name: compared_in_words(result, each).strip()
        for name, each in compared_chains(result).items()
    }
    for each in problem.requirements:
        value = result.values[str(each.measure)]
        words = not_met_in_words(problem, each, result.verified)
        found[str(each)] = f"{each.shown(value)}{words}"
    if result.front:
        found[front_in_words(result)] = counted(len(result.front), "point")
    parts = [numbers(found)]
    if result.parts:
        rows = [
            [str(count), name, f"{price:g}" if price == price else ""]
            for (count, name), price in zip(result.parts, result.part_prices, strict=True)
        ]
        priced = 2 + any(price for *_, price in rows)
        head = ["count", "ball", "price of one"]
        parts.append(table(head[:priced], [row[:priced] for row in rows]))
    if problem.discrete and result.chain.materials is not None:
        parts.append(note(f"order: {order_in_words(result)}"))
    parts += [note(sentence(each)) for each in result.notes]
    return page("DesignResult", str(problem.objective), *parts)


def distribution_html(found: Distribution) -> str:
    """Histogram of the values, and their mean, spread and percentiles."""
    units = "scaled" if found.unit == "1" else "SI"
    factor, unit = axis_unit(found.values, found.unit, units)
    counts, edges = np.histogram(factor * found.values, bins="auto")
    height = np.repeat(counts, 2).astype(float)
    steps = Curve(np.repeat(edges, 2)[1:-1], height, base=np.zeros(len(height)))
    figure = chart([steps], f"{found.label}{unit}", "number of chains")
    shown = {"nominal": found.nominal, "mean": found.mean,
             "standard deviation": found.standard_deviation}  # fmt: skip
    shown |= {f"{percent}% are below": found.percentile(percent) for percent in PERCENTILES}
    own = "" if found.unit == "1" else found.unit
    words = {name: engineering(value, own, units) for name, value in shown.items()}
    if found.failed:
        words["failed"] = f"{found.failed}"
    few = found._few_values_note(PERCENTILES)
    notes = [note(f"{few}.")] if few else []
    notes += [note(sentence(each)) for each in notes_on(found.chain, [found._measure])]
    notes += [note(sentence(each)) for each in found._stiff_walls]
    if found.outside_range:
        exceed = "exceeds" if found.outside_range == 1 else "exceed"
        chains = counted(found.outside_range, "chain")
        notes += [note(f"{chains} {exceed} the limits of Hertz's law.")]
    if yielding := found._yielding_note:
        notes.append(note(sentence(yielding)))
    about = f"{found.quantity} of {len(found.values)} random chains: {found.chain.description}"
    return page("Distribution", about, figure, numbers(words), *notes)


def scatter_causes_html(found: ScatterCauses) -> str:
    """Mean and standard deviation with each cause alone."""
    head, *rows = found._rows()
    first = next(iter(found.alone.values()))
    about = f"{first.quantity}: {first.chain.description}"
    return page("ScatterCauses", about, table(head, rows, numeric=True), note(sentence(NOTE)))


def scatter_html(scatter: Scatter) -> str:
    """Deviations, the beads that have them, the number of samples and the measure."""
    beads = "all but strikers and a cap" if scatter.beads is None else str(scatter.beads)
    found = {"beads": beads, "samples": f"{scatter.samples}", "measure": scatter.statistic}
    # A number without a unit is scaled, or in SI units: the chain decides.
    return page("Scatter", scatter._in_words("scaled"), numbers(found))
