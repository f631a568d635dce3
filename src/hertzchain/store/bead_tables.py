"""Read beads, one row per bead, from CSV files."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.mass_and_stiffness import sphere_masses
from ..chain.materials import Material, material
from ..collision import Array
from ..errors import InputError, errors_at
from ..validation.objects import file_path, shown_path
from .csv_tables import Column, CsvTable, read_csv

BEAD_COLUMNS: Final = {
    "bead": Column("number"),
    "radius": Column("length", above=0.0),
    "diameter": Column("length", above=0.0),
    "mass": Column("mass", above=0.0, may_be_empty=True),
    "material": Column("text"),
    "velocity": Column("velocity", if_empty="write 0 for a bead at rest"),
    "gap": Column("length", between_rows=True, least=0.0, if_empty="write 0 for beads that touch"),
    "stiffness": Column(
        "stiffness",
        between_rows=True,
        above=0.0,
        if_empty="give that of every "
        "contact, or omit the column, and it follows from the materials",
    ),
}


def load_beads(path: str | os.PathLike[str], own: Mapping[str, Material] | None = None) -> Chain:
    r"""Read a chain from a CSV file with one row per bead.

    Parameters
    ----------
    path : path-like
        The file, with the columns of `BEAD_COLUMNS`.
    own : mapping of str to Material, optional
        Custom materials, by name.

    Raises
    ------
    InputError
        If the file is missing or unreadable, a column is unknown, missing or duplicated, or a
        value is out of range.  The message names the file, row and column.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.store.bead_tables import load_beads
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "beads.csv"
    ...     _ = file.write_text("diameter [mm],material\n10,brass\n8,glass\n")
    ...     load_beads(file)
    Chain(2 beads of brass and glass, diameters 10 mm to 8 mm, impact at 1 m/s)
    """
    file = file_path("table of beads", path)
    with errors_at(shown_path(path)):
        if file.suffix.lower() == ".toml":
            raise InputError(
                "is a TOML file, but file of [chain] is a table of beads (CSV, one row per bead); "
                "copy the keys of [chain] from the TOML file into this chain file instead"
            )
        return _chain_of(read_csv(file, BEAD_COLUMNS), own or {})


def _chain_of(table: CsvTable, own: Mapping[str, Material]) -> Chain:
    columns = dict(table.columns)
    sizes = [name for name in ("radius", "diameter") if name in columns]
    if len(sizes) != 1:
        raise InputError(
            f"a table of beads requires either a column radius or a column diameter, got "
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
            raise InputError(f"materials require sizes with a unit; write {sizes[0]} [mm]")
        kinds = _materials(columns["material"], own)
        if "masses" in fields:
            spheres = sphere_masses(radii, tuple(kinds), scaled=False)
            fields["masses"] = _with_spheres(fields["masses"], spheres)
        return Chain.from_materials(radii, kinds, **fields)
    if table.has_units:
        missing = np.flatnonzero(np.isnan(fields.get("masses", [])))
        if missing.size:
            raise InputError(
                f"row {missing[0] + 1} of column 'mass' is empty: the mass of a sphere follows "
                "from its material, so add a column material, or give all masses"
            )
        return Chain(radii, units="SI", **fields)
    chain = Chain.from_radii(radii)
    if "masses" in fields:
        fields["masses"] = _with_spheres(fields["masses"], chain.masses)
    return chain.replace(**fields) if fields else chain


def _with_spheres(masses: Array, spheres: Array) -> Array | None:
    """Masses of which the missing ones are those of spheres; none if all are missing."""
    missing = np.isnan(masses)
    return None if missing.all() else np.where(missing, spheres, masses)


def _materials(names: Sequence[object], own: Mapping[str, Material]) -> list[Material]:
    found = []
    for row, name in enumerate(map(str, names), start=1):
        with errors_at(f"row {row}"):
            found.append(own.get(name) or material(name))
    return found
