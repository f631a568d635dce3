"""HTML representation of the result of a design: its value, constraints and balls."""

from __future__ import annotations

from ..designs.report import front_in_words, references_in_words, search_in_words
from ..designs.result import DesignResult
from ..representation import counted
from .drawing import note, numbers, page, table


def design_html(result: DesignResult) -> str:
    """Value, comparison, constraints, parts and notes."""
    problem, shown = result.problem, result._shown
    found = {
        "value": shown(result.value).strip(),
        "search": f"{search_in_words(result)}, {result.runs} simulations",
    }
    found |= {
        name: shown(result.objective_of(each)).strip()
        for name, each in references_in_words(result).items()
    }
    for each in problem.requirements:
        value = result.values[str(each.measure)]
        met = "" if each.excess(value) <= 1e-6 else ", NOT met"
        found[str(each)] = f"{each.shown(value)}{met}"
    if result.front:
        found[front_in_words(result)] = counted(len(result.front), "point")
    parts = [numbers(found)]
    if result.parts:
        parts.append(table(["count", "ball"], [[str(n), name] for n, name in result.parts]))
    parts += [note(f"{each[:1].upper()}{each[1:]}.") for each in result.notes]
    return page("DesignResult", str(problem.objective), *parts)
