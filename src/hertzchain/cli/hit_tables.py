"""Repeated hits of a chain with dents, as a table and as plain data."""

from __future__ import annotations

import math
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
    from ..representation import in_column

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
    hits = hits_as_list(runs, beads)
    deepest = [max(range(len(row["dents"])), key=row["dents"].__getitem__) for row in hits]
    depths = [row["dents"][contact] for row, contact in zip(hits, deepest, strict=True)]
    dents = in_column([(1e6 if si else 1.0) * depth for depth in depths], 3)
    forces = [
        [*row["wall_peaks"].values(), *([row["cap"]] if caps else []), *row["sensors"].values()]
        for row in hits
    ]
    columns = [_forces(column) for column in zip(*forces, strict=True)]
    for i, row in enumerate(hits):
        at = contact_name(deepest[i], chain.beads) if depths[i] else "-"
        table.add_row(str(row["hit"]), *(column[i] for column in columns), dents[i], at)
    return table


def _forces(column: Sequence[float | None]) -> list[str]:
    """Forces of all hits; some are not complete."""
    from ..representation import in_column

    shown = in_column([math.nan if each is None else each for each in column], 5)
    return ["not complete" if each == "-" else each for each in shown]
