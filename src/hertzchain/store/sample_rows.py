"""Rows of files of traces, with any usual separator of columns and decimal points or commas."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from typing import Final

from ..errors import InputError
from .csv_tables import csv_lines, parsed_lines

Rows = list[list[str]]

# A number with any marks, and one with a single mark.
_ANY: Final = re.compile(r"[+-]?(\d[\d.,]*|[.,]\d+)(e[+-]?\d+)?", re.IGNORECASE)
_COMMA: Final = re.compile(r"[+-]?(\d+,\d*|,\d+)(e[+-]?\d+)?", re.IGNORECASE)
# A mark that may separate thousands, as in 1,234.
_GROUPS: Final = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")
# Spaces between names: several, or those after a unit, as in time [us] ball 6 [N].
_BETWEEN_NAMES: Final = re.compile(r"\s{2,}|(?<=[\])])\s+")
_ADVICE: Final = "save the file with decimal points in all numbers"


def sample_rows(path: str | os.PathLike[str]) -> tuple[Rows, list[int]]:
    """Rows of a file as text, with decimal points, and the numbers of their lines.

    The last line shows what separates columns.
    """
    numbered = csv_lines(path)
    numbers, lines = list(numbered), list(numbered.values())
    if lines and _is_spaced(lines[-1]):
        return with_decimal_points([_spaced_cells(line) for line in lines], certain=True), numbers
    separator = next((each for each in ";\t" if lines and each in lines[-1]), ",")
    rows = parsed_lines(lines, separator)
    return (
        with_decimal_points(list(rows.values()), certain=separator == ","),
        [numbers[index] for index in rows],
    )


def _is_spaced(line: str) -> bool:
    """Whether a line has several numbers with nothing but spaces between them."""
    numbers = line.split()
    spaced = len(numbers) > 1 and "\t" not in line.strip()
    return spaced and all(_ANY.fullmatch(each) and each[-1] != "," for each in numbers)


def _spaced_cells(line: str) -> list[str]:
    """Numbers, or names that have single spaces and end with their units or several spaces."""
    numbers = line.split()
    named = _BETWEEN_NAMES.split(line.strip())
    return numbers if _is_numeric(numbers) or len(named) == 1 else named


def with_decimal_points(rows: Rows, *, certain: bool) -> Rows:
    """The rows with decimal points instead of commas.

    Points are ``certain`` to be decimal points if commas separate the columns.
    """
    if certain and not any("," in cell for row in rows for cell in row):
        return rows
    numbers = [cell for row in rows if _is_numeric(row) for cell in row]
    point = next((each for each in numbers if "." in each), "")
    comma = next((each for each in numbers if "," in each), "")
    if point and comma:
        both = " and ".join(dict.fromkeys((comma, point)))
        raise InputError(f"its numbers have commas and points, such as {both}; {_ADVICE}")
    if (found := comma or point) and _only_groups(numbers):
        thousands = found.replace(",", "").replace(".", "")
        decimal = found.replace(",", ".")
        raise InputError(f"{found} may be {decimal} or {thousands}, like all numbers of this "
                         f"file; {_ADVICE}")  # fmt: skip
    if not comma:
        return rows
    return [[cell.replace(",", ".") if _COMMA.fullmatch(cell) else cell for cell in row]
            for row in rows]  # fmt: skip


def _is_numeric(row: list[str]) -> bool:
    cells = [cell for cell in row if cell]
    return bool(cells) and all(map(_ANY.fullmatch, cells))


def _only_groups(numbers: Iterable[str]) -> bool:
    """Whether the marks of all numbers may separate thousands."""
    return all(_GROUPS.fullmatch(each) for each in numbers if "," in each or "." in each)
