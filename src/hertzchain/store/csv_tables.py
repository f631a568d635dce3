"""CSV files of measured columns: headers carry the units, rows and columns are named in errors."""

from __future__ import annotations

import csv
import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from hertzchain.errors import InputError, unknown_name
from hertzchain.units import UNITS, converted

HEADER: Final = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\]\s*)?")
# Units as they are found elsewhere: radius (mm), radius / mm, radius_mm.
_OTHERWISE: Final = re.compile(r"\s*(?P<name>[A-Za-z]+)\s*[(/_]\s*(?P<unit>[^()]+?)\s*\)?\s*")
# What separates columns elsewhere.
_SEPARATORS: Final = {";": "semicolons", "\t": "tabs"}


@dataclass(frozen=True)
class Column:
    """A column that a table may have.

    Attributes
    ----------
    dimension : str
        A key of `UNITS`; ``"text"`` or ``"number"`` for what has no unit.
    between_rows : bool
        Whether the value is of a row and the next, so that the last row has none.

    Examples
    --------
    >>> Column("length")
    Column(dimension='length', between_rows=False)
    """

    dimension: str
    between_rows: bool = False


@dataclass(frozen=True, eq=False)
class CsvTable:
    """The columns found in a file, in SI units, or without any.

    Attributes
    ----------
    columns : dict
        Lists of numbers or text, by name.
    has_units : bool
        Whether headers give units; then all do that can.
    rows : int
        Number of rows below the header.
    """

    columns: Mapping[str, Sequence[float | str]]
    has_units: bool
    rows: int


def read_csv(path: str | os.PathLike[str], known: Mapping[str, Column]) -> CsvTable:
    r"""Read a table whose header says what the columns are, such as ``radius [mm]``.

    Parameters
    ----------
    path : path-like
        The file; lines that begin with ``#`` are left out.
    known : mapping of str to Column
        The columns it may have.

    Returns
    -------
    CsvTable

    Raises
    ------
    InputError
        If the file cannot be read, a column is unknown or there twice, units are unknown or
        given for some columns only, or a cell is empty or no number: row and column are named.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "beads.csv"
    ...     _ = file.write_text("radius [mm],material\n5,brass\n4,glass\n")
    ...     read_csv(file, {"radius": Column("length"), "material": Column("text")}).columns
    {'radius': [0.005, 0.004], 'material': ['brass', 'glass']}
    """
    rows = csv_rows(path)
    if not rows:
        raise InputError("the file has no header; give names and units such as radius [mm]")
    headers = [_header(text, known) for text in rows[0]]
    names = [name for name, _ in headers]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"column {name!r} is there {names.count(name)} times: leave one")
    measured = [(name, unit) for name, unit in headers if known[name].dimension in UNITS]
    with_unit = [name for name, unit in measured if unit is not None]
    without = [name for name, unit in measured if unit is None]
    if with_unit and without:
        example = next(iter(UNITS[known[without[0]].dimension]))
        raise InputError(
            f"column {without[0]!r} has no unit, but {with_unit[0]!r} has one: write "
            f"{without[0]} [{example}]"
        )
    for number, row in enumerate(rows[1:], start=1):
        if len(row) != len(headers):
            raise InputError(f"row {number} has {len(row)} cells, the header has {len(headers)}")
    body = rows[1:]
    columns = {
        name: _values(name, unit, [row[i] for row in body], known[name])
        for i, (name, unit) in enumerate(headers)
    }
    return CsvTable(columns, bool(with_unit), len(body))


def csv_rows(path: str | os.PathLike[str]) -> list[list[str]]:
    r"""Rows of a CSV file as text; empty lines and those that begin with ``#`` are left out.

    Parameters
    ----------
    path : path-like
        The file.

    Returns
    -------
    list of list of str

    Raises
    ------
    InputError
        If it cannot be read, or is not CSV.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "points.csv"
    ...     _ = file.write_text("# measured\nrate, beads\n0.02, 10\n")
    ...     csv_rows(file)
    [['rate', 'beads'], ['0.02', '10']]
    """
    try:
        text = Path(path).read_text("utf-8-sig")
    except OSError as error:
        raise InputError(
            f"cannot read it ({error.strerror}); give the path of a CSV file"
        ) from None
    except UnicodeDecodeError:
        raise InputError("is not UTF-8 text; save the table as CSV in UTF-8") from None
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    try:
        rows = [[cell.strip() for cell in row] for row in csv.reader(lines, strict=True)]
    except csv.Error as error:
        raise InputError(f"is not a CSV table ({error}): look for a stray quotation mark") from None
    if rows:
        _check_separator(lines[0])
    return rows


def _check_separator(header: str) -> None:
    for separator, name in _SEPARATORS.items():
        if separator in header and "," not in header:
            raise InputError(
                f"its columns are separated by {name}: save the table with commas between columns, "
                "and with points in numbers"
            )


def _header(text: str, known: Mapping[str, Column]) -> tuple[str, str | None]:
    found = HEADER.fullmatch(text)
    name = text if found is None else found["name"].lower()
    unit = None if found is None else found["unit"]
    if found is None or name not in known:
        other = _OTHERWISE.fullmatch(text)
        if other is not None and (name := other["name"].lower()) in known:
            raise InputError(f"column {text!r}: write its unit as {name} [{other['unit']}]")
        raise unknown_name("column", text, known)
    dimension = known[name].dimension
    if unit is not None and dimension not in UNITS:
        raise InputError(f"column {name!r} has no unit, got [{unit}]")
    if unit is not None:
        converted(f"column {name!r}", 1.0, unit, UNITS[dimension][0])
    return name, None if unit is None else unit.strip()


def _values(
    name: str, unit: str | None, cells: Sequence[str], column: Column
) -> list[float] | list[str]:
    if column.between_rows:
        if cells and cells[-1]:
            raise InputError(
                f"column {name!r} is of a bead and the next one, so its last row must be empty, "
                f"got {cells[-1]!r} in row {len(cells)}"
            )
        cells = cells[:-1]
    for row, cell in enumerate(cells, start=1):
        if not cell:
            raise InputError(f"row {row} of column {name!r} is empty")
    if column.dimension == "text":
        return list(cells)
    numbers = [_number(cell, row, name) for row, cell in enumerate(cells, start=1)]
    if unit is None:
        return numbers
    return [converted(name, cell, unit, UNITS[column.dimension][0]) for cell in cells]


def _number(cell: str, row: int, name: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        decimal = re.fullmatch(r"[+-]?\d+,\d+", cell)
        advice = f"; decimals have a point: {cell.replace(',', '.')}" if decimal else ""
        raise InputError(
            f"row {row} of column {name!r} is {cell!r}: it must be a number{advice}"
        ) from None
    if not math.isfinite(value):
        raise InputError(f"row {row} of column {name!r} is {cell!r}: it must be finite")
    return value
