"""Contacts and materials of a run, as a table and as plain data."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.table import Table

    from ..chain.chain import Chain
    from ..chain.materials import Material
    from ..simulation.run import Run


def contacts_as_dict(run: Run) -> dict[str, Any]:
    """Materials and contacts as plain data; unknown values are None."""
    from ..chain.hertz_range import hertz_range
    from ..validation.json_types import finite

    chain, overlaps = run.chain, run.largest_overlaps
    names = _bodies(chain)
    known = chain.units == "SI" and chain.materials is not None
    ratios = hertz_range(chain, overlaps).yield_ratio if known else [None] * len(overlaps)
    rows = [
        {
            "contact": k,
            "between": names[k : k + 2],
            "stiffness": stiffness,
            "exponent": exponent,
            "largest_overlap": overlap,
            "pressure_over_yield": ratio,
        }
        for k, (stiffness, exponent, overlap, ratio) in enumerate(
            zip(chain.contact_stiffness, chain.contact_exponents, overlaps, ratios, strict=True)
        )
        if stiffness > 0.0
    ]
    materials = [dataclasses.asdict(each) for each in _materials(chain)] if known else []
    found: dict[str, Any] = finite({"materials": materials, "contacts": rows})
    return found


def contact_table(run: Run) -> Table:
    """Table with one row per contact, below the properties of the materials."""
    from rich import box
    from rich.table import Table

    chain = run.chain
    rows = contacts_as_dict(run)["contacts"]
    si = chain.units == "SI"
    title = "\n".join([f"{len(rows)} contacts", *map(_described, _materials(chain) if si else ())])
    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left")
    units = (" N/m^p", " um") if si else ("", "")
    for name in (
        "contact", "between", f"stiffness{units[0]}", "exponent p", f"largest overlap{units[1]}",
        "pressure / yield",
    ):  # fmt: skip
        table.add_column(name, justify="left" if name == "between" else "right", no_wrap=True)
    for row in rows:
        ratio = row["pressure_over_yield"]
        table.add_row(
            str(row["contact"]),
            " and ".join(row["between"]),
            f"{row['stiffness']:.5g}",
            f"{row['exponent']:g}",
            f"{(1e6 if si else 1.0) * row['largest_overlap']:.4g}",
            "-" if ratio is None else f"{ratio:.3g}",
        )
    return table


def _bodies(chain: Chain) -> list[str]:
    """Names of the bodies of contacts 0 to N."""
    beads = [
        f"striker {k}" if k <= chain.strikers else f"ball {k - chain.strikers}"
        for k in range(1, chain.beads + 1)
    ]
    if chain.cap is not None:
        beads[-1] = "cap"
    return ["left wall", *beads, "right wall"]


def _materials(chain: Chain) -> list[Material]:
    """Materials of beads and walls, each once."""
    from ..chain.walls import materials_with_walls

    if chain.materials is None:
        return []
    walls = (chain.left_wall, chain.right_wall)
    return list(dict.fromkeys(materials_with_walls(chain.materials, walls)))


def _described(material: Material) -> str:
    """``brass: 8500 kg/m^3, E = 103 GPa, nu = 0.34, yields at 310 MPa``."""
    return " ".join(repr(material).split()).removeprefix("Material(").removesuffix(")")
