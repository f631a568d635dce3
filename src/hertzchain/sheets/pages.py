"""The pages of a laboratory sheet as HTML and Markdown."""

from __future__ import annotations

import functools
import re
from itertools import pairwise
from typing import Any, Final

from jinja2 import Environment, PackageLoader, select_autoescape
from markupsafe import Markup, escape

from . import answers
from .answers import Table
from .sheet import WALL, LabSheet

READINGS: Final = ("reading 1", "reading 2", "reading 3", "mean")
ON_RATIOS: Final = (
    "A wrong sensitivity changes the ratio of one sensor by the same factor at all speeds. A loss "
    "lowers forces more, the farther the sensor is from the impact. Gaps delay the pulse, most at "
    "small speeds, and can lower or raise the forces."
)


def html(sheet: LabSheet) -> str:
    """The sheet as a page in HTML."""
    return _templates().get_template("sheet.html.j2").render(_context(sheet))


def markdown(sheet: LabSheet) -> str:
    """The sheet in Markdown."""
    return _templates().get_template("sheet.md.j2").render(_context(sheet))


@functools.cache
def _templates() -> Environment:
    found = Environment(
        loader=PackageLoader("hertzchain.sheets", "templates"),
        autoescape=select_autoescape(["html.j2"]), trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True,
    )  # fmt: skip
    found.filters["superscripts"] = _superscripts
    return found


def _superscripts(text: str) -> Markup:
    """A text in HTML with raised exponents, which are in parentheses after ``^``."""
    return Markup(re.sub(r"\^\(([^)]+)\)", r"<sup>\1</sup>", str(escape(text))))


def _context(sheet: LabSheet) -> dict[str, Any]:
    tables = [answers.exponents(sheet), answers.travel(sheet), answers.causes(sheet)]
    return {
        "title": sheet.title, "row": _row(sheet), "how": _how(sheet),
        "tables": _tables(sheet, predicted=not sheet.blank, readings=READINGS),
        "tasks": _tasks(sheet),
        "predictions": _tables(sheet, predicted=True, readings=()) if sheet.blank else [],
        "answers": [answers.on_exponents(sheet), answers.on_travel(sheet), ON_RATIOS,
                    answers.on_errors(sheet)],
        "answer_tables": [each for each in tables if each is not None],
        "warnings": sheet.warnings,
    }  # fmt: skip


def _row(sheet: LabSheet) -> str:
    sensors = ", ".join(place if place != WALL else "the wall or load cell behind the row"
                        for place in sheet.places)  # fmt: skip
    return f"{sheet.chain.description}. Sensors: {sensors}."


def _how(sheet: LabSheet) -> str:
    striker = "striker" if sheet.chain.strikers else "first ball"
    if sheet.heights is None:
        return f"Let the {striker} hit the row at the speeds v of the tables."
    return (f"Let the {striker} fall or swing from the heights h of the "
            "tables, so that it arrives at the speed v with v² = 2 g h. A ball that rolls is "
            "slower: measure its speed, for example with a light barrier.")  # fmt: skip


def _tables(sheet: LabSheet, *, predicted: bool, readings: tuple[str, ...]) -> list[Table]:
    """Tables of the force in each sensor, and of the times between them."""
    found = [
        _table(sheet, f"Force on the {place}" if place == WALL else f"Force in {place}", "N",
               [f"{value:#.4g}".rstrip(".") for value in sheet.forces[:, j]], predicted, readings)
        for j, place in enumerate(sheet.places)
    ]  # fmt: skip
    if len(sheet.places) == 1:
        times = [(f"Time from the impact to the largest force ({sheet.places[0]})",
                  sheet.times[:, 0])]  # fmt: skip
    else:
        times = [
            (f"Time between the largest forces ({one} to {other})",
             sheet.times[:, j + 1] - sheet.times[:, j])
            for j, (one, other) in enumerate(pairwise(sheet.places))
        ]  # fmt: skip
    return found + [
        _table(
            sheet, caption, "µs", [f"{1e6 * value:.1f}" for value in values], predicted, readings
        )
        for caption, values in times
    ]


def _table(
    sheet: LabSheet, caption: str, unit: str, values: list[str], predicted: bool,
    readings: tuple[str, ...],
) -> Table:  # fmt: skip
    first = () if sheet.heights is None else ("h [mm]",)
    own = (f"predicted [{unit}]",) if predicted else ()
    rows = []
    for i, value in enumerate(values):
        height = () if sheet.heights is None else (f"{1e3 * sheet.heights[i]:g}",)
        shown = ("not complete" if value == "nan" else value,) if predicted else ()
        rows.append((*height, f"{1e3 * sheet.speeds[i]:.1f}", *shown, *("",) * len(readings)))
    heads = (*first, "v [mm/s]", *own, *(f"{each} [{unit}]" for each in readings))
    return Table(caption, heads, tuple(rows))


def _tasks(sheet: LabSheet) -> list[str]:
    several = len(sheet.places) > 1
    time = "the time between the sensors" if several else "the time after the impact"
    speed = " Which speed has the pulse between them, and is it constant?" if several else ""
    expected = "Which slope do contacts that follow Hertz's law have? Where does yours differ, and "
    error = "speed" if sheet.heights is None else "height"
    return [
        "Read the largest force of the first pulse in each sensor, three times at each speed, and "
        "enter the means.",
        "Plot the means over the speed on logarithmic axes. What is the slope for each sensor? "
        f"{expected}why?",
        f"Plot {time} in the same way. How does it depend on the speed?{speed}",
        "Divide your means by the predictions. Are the ratios the same at all speeds and sensors? "
        "What would the wrong sensitivity of a sensor, a loss in the contacts, or gaps between the "
        "balls change?",
        f"How large is the error of your {error}, and which error of the force follows?",
    ]
