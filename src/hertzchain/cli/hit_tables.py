"""Repeated hits of a chain with dents, as a table and as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Final

import click

if TYPE_CHECKING:
    from rich.table import Table

    from ..chain.chain import Chain
    from ..simulation.run import Run


# Peak of a second hit over that of the first, above which the summary of a run states it.
LARGER: Final = 1.01


def check_hits(hits: int | None, chains: Iterable[Chain]) -> None:
    """Raise `click.UsageError` if several hits are asked for that are all the same."""
    from ..simulation.hits import leaves_dents

    if hits is not None and not all(map(leaves_dents, chains)):
        raise click.UsageError(
            "--hits requires a loss that leaves dents, such as --loss elastic-plastic; without "
            "dents, all hits are the same"
        )


def second_hit_lines(run: Run) -> list[str]:
    """A line with the peak of a second equal impact on the dents, if it is larger."""
    from ..representation import measure
    from ..simulation.hits import peak_at_right_end, second_hit

    first, second = peak_at_right_end(run), second_hit(run)
    if not second > LARGER * first:
        return []
    peak = measure(second, "N", run.chain.units, 5)
    return [
        f"  a second, equal impact on these dents: peak {peak}, {second / first - 1.0:.0%} larger "
        "(--hits 2)"
    ]


def hits_as_list(runs: Sequence[Run], beads: Sequence[int]) -> list[dict[str, Any]]:
    """Peaks on walls, forces in sensors and on a cap, and dents after each hit, as plain data.

    A peak that is not complete is None.
    """
    from ..chain.bead_names import walls_of
    from ..simulation.body_force import body_force
    from ..validation.json_types import finite

    rows = []
    for number, run in enumerate(runs, start=1):
        walls = {side: run.wall_force(side) for side in walls_of(run.chain)}
        document = {
            "hit": number,
            "wall_peaks": {
                side: wall.peak if wall.complete else None for side, wall in walls.items()
            },
            "sensors": {str(bead): run.sensor_force(bead).largest_so_far for bead in beads},
            "dents": run.dents.tolist(),
        }
        if run.chain._free_cap:
            body = body_force(run)
            document["cap"] = body.force if body is not None and body.complete else None
        rows.append(finite(document))
    return rows


def hit_table(runs: Sequence[Run], beads: Sequence[int]) -> Table:
    """Table with one row per hit: forces, and the deepest dent after the hit."""
    from rich import box
    from rich.table import Table

    from ..chain.bead_names import bead_label, walls_of
    from ..chain.per_contact import contact_name

    chain = runs[0].chain
    si = chain.units == "SI"
    force, length = (" N", " um") if si else ("", "")
    title = f"{len(runs)} hits, each with the dents of the previous ones"
    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left")
    walls = [f"peak on the {side} wall{force}" for side in walls_of(chain)]
    sensors = [f"largest in {bead_label(chain, bead)}{force}" for bead in beads]
    caps = [f"largest on the cap{force}"] if chain._free_cap else []
    for name in ("hit", *walls, *caps, *sensors, f"deepest dent{length}", "at"):
        table.add_column(name, justify="left" if name == "at" else "right")
    for row in hits_as_list(runs, beads):
        deepest = max(range(len(row["dents"])), key=row["dents"].__getitem__)
        dent = row["dents"][deepest]
        cap = [row["cap"]] if caps else []
        forces = [*row["wall_peaks"].values(), *cap, *row["sensors"].values()]
        table.add_row(
            str(row["hit"]),
            *("not complete" if each is None else f"{each:.5g}" for each in forces),
            f"{(1e6 if si else 1.0) * dent:.3g}",
            contact_name(deepest, chain.beads) if dent else "-",
        )
    return table
