"""Catalogues of real balls: diameters, materials, prices and numbers in stock, from CSV files."""

from __future__ import annotations

import os
from dataclasses import dataclass
from fractions import Fraction
from importlib.resources import as_file, files
from pathlib import Path
from typing import Final

from ..chain.materials import Material, material
from ..errors import InputError, errors_at
from ..representation import counted
from ..store.csv_tables import csv_rows, split_header
from ..units import converted
from ..validation.objects import file_path, shown_path

SHIPPED: Final = "bearing-balls"
# Inch [m], divisor of the smallest fraction of it that is a size of balls, and the largest
# rounding error of catalogues in mm with four digits, such as 7.1438 mm.
INCH, FINEST, ROUNDED = 25.4e-3, 64, 0.6e-7
# Diameter [m] below which one of these units of a column is probably wrong.
SMALLEST, LARGE_UNITS = 50e-6, ("m", "cm", "mm", "in")
# Relative difference of two diameters that are regarded as the same.
SAME: Final = 1e-3
COLUMNS: Final = ("diameter", "material", "grade", "price", "name", "count")


@dataclass(frozen=True)
class Ball:
    """A ball of a catalogue.

    ``diameter`` is in m, ``price`` in any currency or NaN; ``count`` is the number of balls in
    stock, or None if it does not limit the choice.
    """

    diameter: float
    material: Material
    grade: str = ""
    price: float = float("nan")
    name: str = ""
    count: int | None = None

    @property
    def radius(self) -> float:
        """Radius [m]."""
        return 0.5 * self.diameter

    def __str__(self) -> str:
        grade = f", grade {self.grade}" if self.grade else ""
        label = f" ({self.name})" if self.name else ""
        inch = inch_fraction(self.diameter)
        size = f"{1e3 * self.diameter:g} mm" + (f" ({inch} in)" if inch else "")
        return f"{size} {self.material.name}{grade}{label}"


def inch_fraction(diameter: float) -> str:
    """A size [m] in inches, such as ``9/32``; empty if it is another size than n/64 in."""
    parts = round(diameter / INCH * FINEST)
    if not parts or abs(diameter - parts * INCH / FINEST) > ROUNDED:
        return ""
    whole, rest = divmod(Fraction(parts, FINEST), 1)
    return " ".join(str(each) for each in (whole, rest) if each)


def among(diameter: float, wanted: tuple[float, ...]) -> bool:
    """Whether a diameter is one of these, apart from rounding in catalogues."""
    return any(abs(diameter - each) <= SAME * each for each in wanted)


def load_balls(catalogue: str | os.PathLike[str]) -> tuple[Ball, ...]:
    """Read a catalogue of balls; ``"bearing-balls"`` is that of hertzchain."""
    if catalogue == SHIPPED:
        with as_file(files("hertzchain.designs") / f"{SHIPPED}.csv") as path:
            return _read(path)
    path = file_path("catalogue of balls", catalogue)
    with errors_at(f"catalogue {shown_path(path)!r}"):
        return _read(path)


def _read(path: Path) -> tuple[Ball, ...]:
    rows = csv_rows(path)
    if len(rows) < 2:
        raise InputError("it has no balls; give a header, such as diameter [mm],material, and rows")
    names, units = [], {}
    for header in rows[0]:
        name, unit = split_header(header) or (header, None)
        if name not in COLUMNS or name in names:
            raise InputError(
                f"column {header!r} is unknown or repeated: choose from {', '.join(COLUMNS)}"
            )
        names.append(name)
        units[name] = unit or ""
    for needed in ("diameter", "material"):
        if needed not in names:
            raise InputError(f"it has no column {needed}")
    if not units["diameter"]:
        raise InputError("column 'diameter' has no unit; write diameter [mm]")
    return tuple(_ball(i, dict(zip(names, row, strict=False)), units["diameter"], len(rows[0]), row)
                 for i, row in enumerate(rows[1:], start=1))  # fmt: skip


def _ball(row: int, cells: dict[str, str], unit: str, width: int, given: list[str]) -> Ball:
    if len(given) != width:
        raise InputError(f"row {row} has {counted(len(given), 'cell')}, but the header has {width}")

    def read(name: str) -> float:
        try:
            return float(cells[name])
        except ValueError:
            raise InputError(f"{name} in row {row} must be a number, got {cells[name]!r}") from None

    diameter = converted(f"diameter in row {row}", read("diameter"), unit, "m")
    if not 0.0 < diameter < float("inf"):
        raise InputError(f"diameter in row {row} must be above 0, got {cells['diameter']}")
    if diameter < SMALLEST and unit in LARGE_UNITS:
        raise InputError(
            f"diameter in row {row} must be at least {1e3 * SMALLEST:g} mm in a column in {unit}, "
            f"got {cells['diameter']} {unit}; write diameter [m] if the column is in metres, or "
            "diameter [um] if the balls are this small"
        )
    if not cells["material"]:
        raise InputError(f"row {row} has no material")
    with errors_at(f"row {row}"):
        kind = material(cells["material"])
    price = read("price") if cells.get("price") else float("nan")
    if price < 0.0:
        raise InputError(
            f"price in row {row} must be at least 0, or empty if it is unknown, "
            f"got {cells['price']}"
        )
    return Ball(
        diameter, kind, cells.get("grade", ""), price, cells.get("name", ""),
        _in_stock(row, cells.get("count", "")),
    )  # fmt: skip


def _in_stock(row: int, cell: str) -> int | None:
    """Number of balls in stock; None, for any number, if the cell is empty."""
    if not cell:
        return None
    if not (cell.isascii() and cell.isdigit()):
        raise InputError(
            f"count in row {row} must be a whole number, or empty for any number of balls, "
            f"got {cell!r}"
        )
    return int(cell)
