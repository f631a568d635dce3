"""Beads and drives from CSV: a row a bead, or a row a moment."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from hertzchain.arguments import file_path, shown_path
from hertzchain.chain.chain import Chain
from hertzchain.chain.drives import Table
from hertzchain.chain.materials import Material, material
from hertzchain.errors import InputError
from hertzchain.store.csv_tables import Column, CsvTable, read_csv

BEAD_COLUMNS: Final = {
    "bead": Column("number"),
    "radius": Column("length"),
    "diameter": Column("length"),
    "mass": Column("mass"),
    "material": Column("text"),
    "velocity": Column("velocity"),
    "gap": Column("length", between_rows=True),
    "stiffness": Column("stiffness", between_rows=True),
}
DRIVE_COLUMNS: Final = {
    "time": Column("time"),
    "force": Column("force"),
    "displacement": Column("length"),
}


def load_beads(path: str | os.PathLike[str], own: Mapping[str, Material] | None = None) -> Chain:
    r"""Read a chain from a CSV file with a row a bead.

    Parameters
    ----------
    path : path-like
        The file, with the columns of `BEAD_COLUMNS`.
    own : mapping of str to Material, optional
        Materials of your own, by name.

    Returns
    -------
    Chain

    Raises
    ------
    InputError
        If the file is missing or unreadable, a column is unknown, missing or there twice, or a
        value is out of range; the file, row and column are named.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "beads.csv"
    ...     _ = file.write_text("diameter [mm],material\n10,brass\n8,glass\n")
    ...     load_beads(file)
    Chain(SI, brass and glass, R = 4 .. 5 mm, 2 beads)
    """
    file = file_path("table of beads", path)
    try:
        return _chain_of(read_csv(file, BEAD_COLUMNS), own or {})
    except InputError as error:
        raise InputError(f"{shown_path(path)}: {error}") from None


def _chain_of(table: CsvTable, own: Mapping[str, Material]) -> Chain:
    columns = dict(table.columns)
    sizes = [name for name in ("radius", "diameter") if name in columns]
    if len(sizes) != 1:
        raise InputError(
            f"a table of beads needs a column radius or diameter, and not both, got "
            f"{', '.join(columns)}"
        )
    expected = list(map(float, range(1, table.rows + 1)))
    if "bead" in columns and list(columns["bead"]) != expected:
        raise InputError("column 'bead' must count 1, 2, 3, ... in the order of the rows")
    radii = np.array(columns[sizes[0]], float) / (2.0 if sizes[0] == "diameter" else 1.0)
    fields: dict[str, Any] = {
        field: np.array(columns[name], float)
        for name, field in (("mass", "masses"), ("velocity", "velocities"), ("gap", "gaps"),
                            ("stiffness", "stiffness"))
        if name in columns
    }  # fmt: skip
    if "material" in columns:
        if not table.has_units:
            raise InputError(f"materials need sizes with a unit: write {sizes[0]} [mm]")
        kinds = [own.get(str(name)) or material(str(name)) for name in columns["material"]]
        return Chain.from_materials(radii, kinds, **fields)
    if table.has_units:
        return Chain(radii, units="SI", **fields)
    chain = Chain.from_radii(radii)
    return chain.replace(**fields) if fields else chain


def load_drive(path: str | os.PathLike[str]) -> Table:
    r"""Read a drive from a CSV file with columns ``time [us]`` and ``force [N]``, or such.

    Parameters
    ----------
    path : path-like
        The file; the second column may be ``displacement [um]``, of the left wall.

    Returns
    -------
    Table

    Raises
    ------
    InputError
        If the file is missing or unreadable, a column is unknown, missing or there twice, or
        times do not increase; the file is named.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "hammer.csv"
    ...     _ = file.write_text("time [us],force [N]\n0,0\n10,80\n30,0\n")
    ...     load_drive(file)
    Table(3 times, 0 to 3e-05, of='force')
    """
    file = file_path("table of a drive", path)
    try:
        table = read_csv(file, DRIVE_COLUMNS)
        of = [name for name in ("force", "displacement") if name in table.columns]
        if "time" not in table.columns or len(of) != 1:
            raise InputError(
                "a drive needs columns time and either force or displacement, got "
                f"{', '.join(table.columns)}"
            )
        return Table(
            np.array(table.columns["time"], float),
            np.array(table.columns[of[0]], float),
            of[0],  # type: ignore[arg-type]
        )
    except InputError as error:
        raise InputError(f"{shown_path(path)}: {error}") from None
