"""Contacts and materials of a run, as a table and as plain data."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.table import Table

    from ..chain.chain import Chain
    from ..chain.materials import Material
    from ..simulation.run import Run


def contacts_as_dict(run: Run) -> dict[str, Any]:
    """Materials and contacts as plain data; unknown values are None."""
    import numpy as np

    from ..chain.contact_groups import law_yield_ratios
    from ..chain.hertz_range import hertz_range
    from ..validation.json_types import finite

    chain, overlaps = run.chain, run._furthest_overlaps
    names = _bodies(chain)
    known = chain.units == "SI" and chain.materials is not None
    if known:
        found = hertz_range(chain, overlaps)
        ratios = np.fmax(found.yield_ratio, found.law_yield_ratio)
    else:
        ratios = law_yield_ratios(chain.contact_groups, overlaps)
    rows = [
        {
            "contact": k,
            "between": names[k : k + 2],
            "stiffness": stiffness,
            "exponent": exponent,
            "largest_overlap": overlap,
            "pressure_over_yield": ratio,
            "dent": dent,
        }
        for k, (stiffness, exponent, overlap, ratio, dent) in enumerate(
            zip(
                chain.contact_stiffness,
                chain.contact_exponents,
                overlaps,
                ratios,
                run.dents,
                strict=True,
            )
        )
        if stiffness > 0.0
    ]
    materials = [dataclasses.asdict(each) for each in _materials(chain)] if known else []
    document: dict[str, Any] = finite({"materials": materials, "contacts": rows})
    return document


def largest_pressure(run: Run) -> dict[str, Any] | None:
    """The largest known pressure over that at first yield, and its contact; `None` without one."""
    known = [
        row for row in contacts_as_dict(run)["contacts"] if row["pressure_over_yield"] is not None
    ]
    if not known:
        return None
    worst = max(known, key=lambda row: float(row["pressure_over_yield"]))
    return {name: worst[name] for name in ("contact", "between", "pressure_over_yield")}


def contact_table(run: Run) -> Table:
    """Table with one row per contact, below the properties of the materials."""
    from rich import box
    from rich.table import Table

    from ..chain.hertz_ratios import linear_springs
    from ..representation import in_column
    from ..simulation.hits import leaves_dents

    chain = run.chain
    rows, springs = contacts_as_dict(run)["contacts"], linear_springs(chain)
    si = chain.units == "SI"
    title = "\n".join([f"{len(rows)} contacts", *map(_described, _materials(chain) if si else ())])
    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left")
    units = (" N/m^p", " um") if si else ("", "")
    dented = [f"dent{units[1]}"] if leaves_dents(chain) else []
    for name in (
        "contact", "between", f"stiffness{units[0]}", "exponent p", f"largest overlap{units[1]}",
        "pressure / yield", *dented,
    ):  # fmt: skip
        table.add_column(name, justify="left" if name == "between" else "right", no_wrap=True)
    length = 1e6 if si else 1.0
    stiffness = in_column([row["stiffness"] for row in rows], 5)
    overlaps = in_column([length * row["largest_overlap"] for row in rows], 4)
    pressures = [row["pressure_over_yield"] for row in rows]
    ratios = in_column([math.nan if each is None else each for each in pressures], 3)
    dents = in_column([length * row["dent"] for row in rows], 4)
    for i, row in enumerate(rows):
        table.add_row(
            str(row["contact"]),
            " and ".join(row["between"]),
            stiffness[i],
            f"{row['exponent']:g}",
            overlaps[i],
            "spring, not checked" if springs[row["contact"]] else ratios[i],
            *[dents[i] for _ in dented],
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
