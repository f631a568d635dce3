"""Points of a sweep that are listed one by one: tables ``[[points]]``, or a CSV file."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError, errors_at, short_repr
from ..representation import counted
from ..store.csv_tables import csv_rows
from ..validation.objects import file_path
from .axes import flattened, path_of


def columns_of_points(points: Any, folder: Path) -> dict[tuple[str, ...], list[Any]]:
    """Values of each parameter from explicit points: a list of tables or the name of a CSV file."""
    if isinstance(points, str):
        return _columns_of_csv(file_path("points", folder / points))
    if not isinstance(points, list | tuple) or not points:
        raise InputError(
            f"points: must be tables [[points]] or the name of a CSV file, got {short_repr(points)}"
        )
    for place, row in enumerate(points, start=1):
        if not isinstance(row, Mapping) or not row:
            raise InputError(
                f"points[{place}]: must be a table of parameters, got {short_repr(row)}"
            )
    listed = [[*flattened(row)] for row in points]
    rows = [dict(each) for each in listed]
    for place, row in enumerate(rows, start=1):
        if len(row) < len(listed[place - 1]):
            raise InputError(f"points[{place}]: gives the same parameter twice, by two names")
        if row.keys() != rows[0].keys():
            names = ", ".join(".".join(path) for path in rows[0])
            raise InputError(
                f"points[{place}]: must have the same parameters as points[1]: {names}"
            )
    return {path: [row[path] for row in rows] for path in rows[0]}


def _columns_of_csv(file: Path) -> dict[tuple[str, ...], list[Any]]:
    """Columns of a CSV file: numbers if all cells of a column are numbers, otherwise text."""
    with errors_at(f"points: {os.fspath(file)!r}"):
        rows = csv_rows(file)
        if len(rows) < 2:
            raise InputError("must have a header with parameters and one row per point")
        header, *body = rows
        paths = [path_of(column) for column in header]
        for path in paths:
            if paths.count(path) > 1:
                raise InputError(f"has two columns {'.'.join(path)!r}: remove one")
        for place, row in enumerate(body, start=1):
            if len(row) != len(header):
                raise InputError(
                    f"row {place} has {counted(len(row), 'cell')}, but the header has {len(header)}"
                )
            if "" in row:
                raise InputError(f"row {place} has no {header[row.index('')]}")
    columns = zip(*body, strict=True)
    return {path: _cells(cells) for path, cells in zip(paths, columns, strict=True)}


def _cells(cells: Sequence[str]) -> list[Any]:
    for kind in (int, float):
        try:
            return [kind(cell) for cell in cells]
        except ValueError:
            continue
    return list(cells)
