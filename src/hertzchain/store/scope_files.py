"""Files of oscilloscopes: the header and the samples among settings, and rows of units."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import dropwhile
from typing import Final

import numpy as np

from ..errors import InputError
from ..representation import counted
from ..units import UNITS
from .csv_tables import split_header
from .sample_rows import Rows

# Missing samples, and those beyond the range of the digitiser.
MISSING: Final = ("", "nan", "NaN", "NA")
INFINITE: Final = {"∞": np.inf, "+∞": np.inf, "-∞": -np.inf}
# The numbers of SCPI (1999, volume 1, section 7.2.1.4) for infinity and for "not a number", with a
# relative tolerance for rounding.
SCPI_INFINITY, SCPI_MISSING, ROUNDING = 9.9e37, 9.91e37, 4e-4
# Units that oscilloscopes write as words.
WORDS: Final = {
    "s": "s", "second": "s", "seconds": "s", "sec": "s", "volt": "V", "volts": "V", "newton": "N",
}  # fmt: skip
# Units of columns of times; "min" among settings is a minimum.
TIME_UNITS: Final = tuple(unit for unit in UNITS["time"] if unit not in ("min", "h"))
# Settings of Tektronix files that have units of columns.
TIME_UNIT, SIGNAL_UNITS, SOURCE = "horizontal units", "vertical units", "source"
# Columns of the times and samples in Tektronix files that have the settings beside them.
BESIDE: Final = (3, 4)


def header_and_samples(rows: Rows, lines: Sequence[int]) -> tuple[list[str], Rows]:
    """Names with units, and the rows of samples, which are the last ones.

    Settings above them are not read; ``lines`` has the number of the line of each row.
    """
    if _settings_beside(rows):
        return _without_settings_beside(rows)
    if _numbered(rows):
        return _with_times_of_numbers(rows, lines)
    at = _header_row(rows)
    header, body = rows[at], list(dropwhile(_is_empty, rows[at + 1 :]))
    units = [""] * len(header)
    if body and _is_unit_row(body[0], _time_column(header)):
        units, body = [_unit(cell) for cell in body[0]], body[1:]
        if len(units) != len(header):
            raise InputError(
                f"the row of units has {counted(len(units), 'cell')}, but the header has "
                f"{len(header)}; complete one of them"
            )
    else:
        units = _units_in_settings(rows[:at], len(header))
    named = [_with_unit(name, unit) for name, unit in zip(header, units, strict=True)]
    named[_time_column(header)] = _as_time(named[_time_column(header)])
    if not named[-1] and all(len(row) != len(header) or not row[-1] for row in body):
        # Each line ends with a comma.
        named = named[:-1]
        body = [row[:-1] if len(row) == len(header) else row for row in body]
    return named, body


def _header_row(rows: Rows) -> int:
    """Last row with the name of the times before the numbers, or the one above units or numbers."""
    wide = [at for at, row in enumerate(rows) if len(row) > 1 and not _is_empty(row)]
    end = next((at for at in wide if _is_numeric(rows[at])), len(rows))
    named = [at for at in wide if at < end and "time" in _names(rows[at])]
    if named:
        return named[-1]
    units = (at for at in wide if 0 < at < end and _is_unit_row(rows[at], 0))
    below = next(units, end if end < len(rows) else 0)
    return max((at for at in range(below) if not _is_empty(rows[at])), default=0)


def sample(cell: str) -> float:
    """Value of a cell: NaN if it is missing, infinite beyond the range of the digitiser."""
    if cell in MISSING:
        return np.nan
    value = INFINITE.get(cell) or float(cell)
    if abs(abs(value) / SCPI_INFINITY - 1.0) < ROUNDING:
        return math.copysign(math.inf, value)
    return np.nan if abs(value / SCPI_MISSING - 1.0) < ROUNDING else value


def _names(row: list[str]) -> list[str]:
    return [(split_header(cell) or ("", None))[0] for cell in row]


def _time_column(header: list[str]) -> int:
    """Column of the times: the one with this name, otherwise the first."""
    names = _names(header)
    return names.index("time") if "time" in names else 0


def _is_empty(row: list[str]) -> bool:
    """Whether no cell has text, as in a row of units without any."""
    return not any(row)


def _is_numeric(row: list[str]) -> bool:
    try:
        found = [sample(cell) for cell in row]
    except ValueError:
        return False
    return bool(np.isfinite(found).any()) and row[0] not in MISSING


def _is_unit_row(row: list[str], time: int) -> bool:
    """Whether a row has units under names, the one of the times among them."""
    return time < len(row) and _unit(row[time]) in TIME_UNITS


def _unit(cell: str) -> str:
    plain = re.sub(r"[\[\]()]", "", cell).strip()
    return WORDS.get(plain.lower(), plain)


def _with_unit(name: str, unit: str) -> str:
    """The name of a column with its unit; that of the header itself comes first."""
    found = split_header(name)
    return f"{name} [{unit}]" if unit and name and (found is None or found[1] is None) else name


def _as_time(header: str) -> str:
    """Header of the first column, which is that of times if it has a unit of time."""
    name, unit = split_header(header) or (header, None)
    return f"time [{unit}]" if name != "time" and unit in TIME_UNITS else header


def _units_in_settings(settings: Rows, columns: int) -> list[str]:
    """Units of the columns in the settings above the header, if they are there."""
    units = [""] * columns
    for row in settings:
        name = row[0].lower()
        if name == TIME_UNIT and len(row) > 1:
            units[0] = _unit(row[1])
        elif name == SIGNAL_UNITS:
            given = [_unit(cell) for cell in row[1:columns]]
            units[1 : 1 + len(given)] = given
    return units


def _numbered(rows: Rows) -> bool:
    """Whether samples are numbered, with the first time and the step in the row of units."""
    names = [cell.lower() for cell in rows[0]]
    return (
        len(rows) > 2
        and rows[1][0].lower() == "sequence"
        and {"start", "increment"} <= {*names}
        and _is_numeric(["0", *(rows[1][names.index(each)] for each in ("start", "increment"))])
    )


def _with_times_of_numbers(rows: Rows, lines: Sequence[int]) -> tuple[list[str], Rows]:
    """Names with units, and samples with times in place of their numbers."""
    names = [cell.lower() for cell in rows[0]]
    start, step = (float(rows[1][names.index(each)]) for each in ("start", "increment"))
    columns = [i for i, name in enumerate(names) if i and name not in ("", "start", "increment")]
    header = [_with_unit(rows[0][i], _unit(rows[1][i])) for i in columns]
    body = []
    for number, row in zip(lines[2:], rows[2:], strict=True):
        if len(row) <= columns[-1] or not _is_numeric(row[:1]):
            raise InputError(
                f"line {number} must have a number and {len(columns)} samples; complete or remove "
                "it"
            )
        time = start + step * float(row[0])
        body.append([repr(time), *(row[i] for i in columns)])
    return ["time [s]", *header], body


def _settings_beside(rows: Rows) -> bool:
    """Whether settings are in the first columns, and one signal in the fourth and fifth."""
    return rows[0][0].lower() == "record length" and all(
        len(row) > BESIDE[-1] and _is_numeric([row[each] for each in BESIDE]) for row in rows
    )


def _without_settings_beside(rows: Rows) -> tuple[list[str], Rows]:
    settings = {row[0].lower(): row[1] for row in rows if row[0]}
    source = settings.get(SOURCE) or "CH1"
    header = [
        _with_unit("time", _unit(settings.get(TIME_UNIT, ""))),
        _with_unit(source, _unit(settings.get(SIGNAL_UNITS, ""))),
    ]
    return header, [[row[each] for each in BESIDE] for row in rows]
