"""Read CSV files whose headers contain units; error messages name the row and column."""

from __future__ import annotations

import codecs
import csv
import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from ..errors import InputError, unknown_name_error
from ..representation import counted
from ..units import UNITS, converted, is_unit, quantity

# A name, and a unit in brackets or parentheses.
_HEADER: Final = re.compile(
    r"\s*([^\[\]()]*?)\s*(?:\[(?P<square>[^\[\]]*)\]\s*|\((?P<round>[^()]*)\)\s*)?"
)
# Other common notations of units: radius / mm, radius_mm.
_OTHERWISE: Final = re.compile(r"\s*(?P<name>[A-Za-z]+)\s*[/_]\s*(?P<unit>[^()]+?)\s*")
# The beginning of a row of samples.
_NUMBER: Final = re.compile(r"\s*[-+]?[.,]?\d")
# Characters of a line with several names or with a unit.
_NAMES: Final = re.compile(r"[,;\t\[(]")
# Other names of columns.
_SYNONYMS: Final = {"t": "time", "times": "time"}
# Separators other than the comma.
_SEPARATORS: Final = {";": "semicolons", "\t": "tabs"}


@dataclass(frozen=True)
class Column:
    """A column that a table may have.

    Attributes
    ----------
    dimension : str
        A key of `UNITS`; ``"text"`` or ``"number"`` for columns without a unit.
    between_rows : bool
        Whether values belong to a row and the next one; the last row then has none.
    above, least : float or None
        Bounds of the values.
    may_be_empty : bool
        Whether cells of numbers may be empty; their values are NaN.
    if_empty : str
        Advice if a cell is empty and may not be.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.store.csv_tables import Column
    >>> Column("length", least=0.0).dimension
    'length'
    """

    dimension: str
    between_rows: bool = False
    above: float | None = None
    least: float | None = None
    may_be_empty: bool = False
    if_empty: str = ""


@dataclass(frozen=True, eq=False)
class CsvTable:
    """The columns of a file, in SI units or without units.

    Attributes
    ----------
    columns : dict
        Lists of numbers or text, by name.
    has_units : bool
        Whether headers have units; then all columns with a dimension have one.
    rows : int
        Number of rows below the header.
    """

    columns: Mapping[str, Sequence[float | str]]
    has_units: bool
    rows: int


def split_header(text: str) -> tuple[str, str | None] | None:
    """Name, in small letters, and unit of a header such as ``Time (s)``, if it has this form."""
    found = _HEADER.fullmatch(text)
    if found is None:
        return None
    name = " ".join(found[1].lower().split())
    unit = found["square"] if found["square"] is not None else found["round"]
    return _SYNONYMS.get(name, name), None if unit is None else unit.strip()


def read_csv(path: str | os.PathLike[str], known: Mapping[str, Column]) -> CsvTable:
    r"""Read a table whose header has names and units, such as ``radius [mm]``."""
    rows = csv_rows(path)
    if not rows:
        raise InputError("the file has no header; give names and units such as radius [mm]")
    headers = [_header(text, known) for text in rows[0]]
    names = [name for name, _ in headers]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"column {name!r} occurs {names.count(name)} times; keep one")
    measured = [(name, unit) for name, unit in headers if known[name].dimension in UNITS]
    with_unit = [name for name, unit in measured if unit is not None]
    without = [name for name, unit in measured if unit is None]
    if with_unit and without:
        example = next(iter(UNITS[known[without[0]].dimension]))
        raise InputError(
            f"column {without[0]!r} has no unit, but {with_unit[0]!r} has one; write "
            f"{without[0]} [{example}]"
        )
    for number, row in enumerate(rows[1:], start=1):
        if len(row) != len(headers):
            raise InputError(
                f"row {number} has {counted(len(row), 'cell')}, but the header has {len(headers)}"
            )
    body = rows[1:]
    columns = {
        name: _values(name, unit, [row[i] for row in body], known[name])
        for i, (name, unit) in enumerate(headers)
    }
    return CsvTable(columns, bool(with_unit), len(body))


def csv_rows(path: str | os.PathLike[str]) -> list[list[str]]:
    r"""Rows of a CSV file as text, without empty lines and lines that begin with ``#``."""
    lines = list(csv_lines(path).values())
    rows = list(parsed_lines(lines, ",").values())
    if rows:
        _check_separator(lines[0])
    return rows


def csv_lines(path: str | os.PathLike[str]) -> dict[int, str]:
    r"""Lines of a CSV file by number, without empty lines and lines that begin with ``#``.

    If the first of the others begins with a number, the comment before it is the header, as
    `numpy.savetxt` writes it.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror}); give the path of a CSV file"
        ) from None
    lines = {
        number: line
        for number, line in enumerate(_decoded(content).splitlines(), start=1)
        if line.strip()
    }
    kept = {number: line for number, line in lines.items() if not line.startswith("#")}
    first = min(kept, default=0)
    if kept and _NUMBER.match(kept[first]):
        comments = [number for number in lines if number < first]
        names = {number: lines[number].lstrip("# ") for number in comments[-1:]}
        kept = {number: line for number, line in names.items() if _NAMES.search(line)} | kept
    return kept


def _decoded(content: bytes) -> str:
    """Text in UTF-8, in UTF-16 with a byte order mark, or in the Windows code page 1252.

    Oscilloscopes write µ and other signs in the latter, in which most text is not valid UTF-8.
    """
    marked = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    for encoding in ("utf-16",) if marked else ("utf-8-sig", "cp1252"):
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise InputError("is not a text file; save the table as CSV in UTF-8")


def parsed_lines(lines: Sequence[str], separator: str) -> dict[int, list[str]]:
    """Cells without spaces around them, by the index of the last line of each row."""
    reader, rows = csv.reader(lines, delimiter=separator, strict=True), {}
    try:
        for row in reader:
            rows[reader.line_num - 1] = [cell.strip() for cell in row]
    except csv.Error as error:
        raise InputError(f"is not a CSV table ({error}); check its quotation marks") from None
    return rows


def _check_separator(header: str) -> None:
    for separator, name in _SEPARATORS.items():
        if separator in header and "," not in header:
            raise InputError(
                f"its columns are separated by {name}; save the table with commas between columns "
                "and decimal points in numbers"
            )


def _header(text: str, known: Mapping[str, Column]) -> tuple[str, str | None]:
    name, unit = split_header(text) or (text, None)
    if name not in known:
        other = _OTHERWISE.fullmatch(text)
        if other is not None and (name := other["name"].lower()) in known:
            raise InputError(f"column {text!r} must be written as {name} [{other['unit']}]")
        raise unknown_name_error("column", text, known)
    dimension = known[name].dimension
    if unit is not None and dimension not in UNITS:
        raise InputError(f"column {name!r} must have no unit, got [{unit}]")
    if unit is not None:
        converted(f"column {name!r}", 1.0, unit, UNITS[dimension][0])
    return name, unit


def _values(
    name: str, unit: str | None, cells: Sequence[str], column: Column
) -> list[float] | list[str]:
    if column.between_rows:
        if cells and cells[-1]:
            raise InputError(
                f"column {name!r} refers to a bead and the next one, so its last row must be "
                f"empty, got {cells[-1]!r} in row {len(cells)}"
            )
        cells = cells[:-1]
    for row, cell in enumerate(cells, start=1):
        if not cell and not column.may_be_empty:
            advice = f"; {column.if_empty}" if column.if_empty else ""
            raise InputError(f"row {row} of column {name!r} is empty{advice}")
    if column.dimension == "text":
        return list(cells)
    numbers = [
        _number(cell, row, name, unit) if cell else math.nan
        for row, cell in enumerate(cells, start=1)
    ]
    for row, value in enumerate(numbers, start=1):
        _check_bounds(value, f"row {row} of column {name!r} is {cells[row - 1]!r}", unit, column)
    if unit is None:
        return numbers
    si = UNITS[column.dimension][0]
    return [converted(name, cell, unit, si) if cell else math.nan for cell in cells]


def _check_bounds(value: float, where: str, unit: str | None, column: Column) -> None:
    """Compare a number with bounds, which are the same in all units if they are 0."""
    low = column.above is not None and value <= column.above
    if low or (column.least is not None and value < column.least):
        allowed = f"above {column.above:g}" if low else f"at least {column.least:g}"
        raise InputError(f"{where}{'' if unit is None else f' [{unit}]'}: it must be {allowed}")


def _number(cell: str, row: int, name: str, unit: str | None) -> float:
    try:
        value = float(cell)
    except ValueError:
        decimal = re.fullmatch(r"[+-]?\d+,\d+", cell)
        advice = f"; use a decimal point: {cell.replace(',', '.')}" if decimal else ""
        if (parts := quantity(cell)) is not None and is_unit(parts[1]):
            advice = f"; write {parts[0]}, and the unit in the header: {name} [{unit or parts[1]}]"
            if unit is not None and unit != parts[1]:
                advice = f"; convert it to {unit}, the unit in the header"
        raise InputError(
            f"row {row} of column {name!r} is {cell!r}: it must be a number{advice}"
        ) from None
    if not math.isfinite(value):
        raise InputError(f"row {row} of column {name!r} is {cell!r}: it must be finite")
    return value
