"""The pages of a laboratory sheet as HTML and Markdown."""

from __future__ import annotations

import functools
import re
from itertools import pairwise
from typing import Any, Final

import numpy as np
from jinja2 import Environment, PackageLoader, select_autoescape
from markupsafe import Markup, escape

from ..chain.chain import Chain
from ..chain.chain_words import described_loss
from ..representation import listed
from . import answers
from .answers import Table
from .kinds import is_column
from .losses import inherits_loss, losses_in_words
from .row import names, place_in_words, row_in_words
from .sheet import LabSheet
from .sketch import sketch

READINGS: Final = ("reading 1", "reading 2", "mean")
ON_RATIOS: Final = (
    "A wrong sensitivity changes the ratio of one sensor by the same factor at all speeds. A loss "
    "lowers forces more, the farther the sensor is from the impact."
)
ON_GAPS: Final = " Gaps delay the pulse, most at small speeds, and can lower or raise the forces."
INHERITED: Final = (
    "No loss is given for the load cell, so that its contact has the law of the row: if it is "
    "elastic, describe the wall with the loss elastic"
)
BEYOND: Final = "Beyond this limit, Hertz's law does not hold: use smaller speeds."


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
        "title": sheet.title, "row": row_in_words(sheet), "how": _how(sheet),
        "sketch": Markup(sketch(sheet)), "column": is_column(sheet.chain),
        "table": _table(sheet, predicted=not sheet.blank, readings=READINGS),
        "tasks": _tasks(sheet), "description": _description(sheet.chain),
        "predictions": [predictions(sheet)] if sheet.blank else [],
        "answers": [answers.on_exponents(sheet), answers.on_travel(sheet),
                    ON_RATIOS + ON_GAPS * (not answers.rests(sheet.chain)),
                    answers.on_errors(sheet)],
        "answer_tables": [each for each in tables if each is not None],
        "warnings": [_warning(each) for each in sheet.warnings],
    }  # fmt: skip


def _warning(text: str) -> str:
    """A limit that is exceeded, as a sentence without advice on arguments and options."""
    limit = text.partition("; ")[0]
    return f"{limit[0].upper()}{limit[1:]}. {BEYOND}"


def _description(chain: Chain) -> str:
    """The description of the chain, with its laws of loss in a sentence instead of a word."""
    losses = losses_in_words(chain)
    if not losses:
        return chain.description
    described = f"{chain.description.replace(f', {described_loss(chain)}', '')}. Loss: {losses}"
    return f"{described}. {INHERITED}" if inherits_loss(chain) else described


def _how(sheet: LabSheet) -> str:
    striker = "striker" if sheet.chain.strikers else "first ball"
    they = "it arrives"
    if sheet.chain.strikers > 1:
        striker, they = "strikers", "they touch each other and arrive"
    if is_column(sheet.chain) and sheet.heights is not None:
        return (f"Let the {striker} fall onto the column from the heights h of the table, so that "
                f"{they} at the speed v with v² = 2gh. A rebound may strike the column again: "
                "only the first pulse counts.")  # fmt: skip
    if sheet.heights is None:
        return f"Let the {striker} hit the row at the speeds v of the table."
    return (f"Let the {striker} fall or swing from the heights h of the "
            f"table, so that {they} at the speed v with v² = 2gh. A ball that rolls is "
            "slower: measure its speed, for example with a light barrier.")  # fmt: skip


def predictions(sheet: LabSheet) -> Table:
    """The table of the predictions without columns for readings."""
    return _table(sheet, predicted=True, readings=())


def _table(sheet: LabSheet, *, predicted: bool, readings: tuple[str, ...]) -> Table:
    """The force in each sensor and the times between them at all speeds, one below the other."""
    first = () if sheet.heights is None else ("h [mm]",)
    heads = ("quantity", *first, "v [mm/s]", *(["predicted"] * predicted), *readings)
    rows = []
    for quantity, values in _quantities(sheet):
        for i, value in enumerate(values):
            height = () if sheet.heights is None else (f"{1e3 * sheet.heights[i]:g}",)
            shown = ("not complete" if value == "nan" else value,) if predicted else ()
            speed = f"{1e3 * sheet.speeds[i]:.1f}"
            rows.append((quantity, *height, speed, *shown, *("",) * len(readings)))
    caption = "Largest forces of the first pulse, and times "
    caption += "between them" if len(sheet.places) > 1 else "after the impact"
    return Table(caption, heads, tuple(rows))


def _quantities(sheet: LabSheet) -> list[tuple[str, list[str]]]:
    """Names and predictions of the forces and times of the table."""
    places = names(sheet)
    found = [
        (f"force, {name} [N]", [f"{value:#.4g}".rstrip(".") for value in values])
        for name, values in zip(places, sheet.forces.T, strict=True)
    ]
    if len(places) == 1:
        times = [(f"time, impact to {places[0]} [µs]", sheet.times[:, 0])]
    else:
        times = [
            (f"time, {one} to {other} [µs]", difference)
            for (one, other), difference in zip(
                pairwise(places), np.diff(sheet.times, axis=1).T, strict=True
            )
        ]
    return found + [(name, [f"{1e6 * value:.1f}" for value in values]) for name, values in times]


def _tasks(sheet: LabSheet) -> list[str]:
    several = len(sheet.places) > 1
    time = "the time between the sensors" if several else "the time after the impact"
    expected = "Which slope do contacts that follow Hertz's law have? Where does yours differ, and "
    error = "speed" if sheet.heights is None else "height"
    divide = "Divide your means by the predictions."
    if sheet.blank:
        divide = "Ask your teacher for the predictions, and divide your means by them."
    causes = "the wrong sensitivity of a sensor, a loss in the contacts, or gaps between the balls"
    if answers.rests(sheet.chain):
        causes = "the wrong sensitivity of a sensor, or a loss in the contacts,"
    return [
        "Read the largest force of the first pulse in each sensor, twice at each speed, and enter "
        "the means.",
        "Plot the means against the speed on logarithmic axes. What is the slope for each sensor? "
        f"{expected}why?",
        f"Plot {time} in the same way. How does it depend on the speed?{_on_speed(sheet)}",
        f"{divide} Are the ratios the same at all speeds and sensors? What would {causes} change?",
        f"How large is the error of your {error}, and what error of the force results?",
    ]


def _on_speed(sheet: LabSheet) -> str:
    """The question about the speed of the pulse, which needs two balls with sensors."""
    balls = [place_in_words(sheet.chain, sheet.places[j])
             for j in answers.balls_with_sensors(sheet)]  # fmt: skip
    if len(balls) < 2:
        return ""
    between = "them" if len(balls) == len(sheet.places) else listed(balls)
    return f" What is the speed of the pulse between {between}, and is it constant?"
