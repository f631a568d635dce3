"""The command `scoreboard`: every theory against the integration."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hertzchain.cli.options import PICTURES, check_writable
from hertzchain.cli.progress import progress_of
from hertzchain.cli.show import save_axes, show_json, show_table

if TYPE_CHECKING:
    from rich.table import Table

    from hertzchain.scoreboard.scoreboard import Scoreboard


@click.command()
@click.option(
    "--quantity",
    default="velocity",
    show_default=True,
    metavar="NAME",
    help="What to judge: velocity, momentum, energy, arrival, peak_force.",
)
@click.option(
    "--first-bead", type=int, default=10, show_default=True, help="First bead that counts."
)
@click.option("--rms", is_flag=True, help="Show the root mean square instead of the worst error.")
@click.option("--all", "every_chain", is_flag=True, help="A row for each chain, not each family.")
@click.option(
    "--figure",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Also draw the table into FILE (.png, .svg or .pdf).",
)
@click.option(
    "--json", "as_json", is_flag=True, help="Print all quantities, from beads 2 and 10 on, as JSON."
)
def scoreboard(
    quantity: str, first_bead: int, rms: bool, every_chain: bool, figure: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Hold every theory against the integration: which one to trust where.

    The paper's four tapers at its rates and beyond, and tapers that no theory was fitted
    to; 100 beads each. Errors count up to bead 97, short of the free end.

    \b
    Examples:
      hertzchain scoreboard
      hertzchain scoreboard --quantity arrival --first-bead 2 --figure arrival.png
    """
    from hertzchain.arguments import one_of
    from hertzchain.scoreboard import judge
    from hertzchain.scoreboard.scoreboard import JUDGED
    from hertzchain.store import results

    one_of("quantity", quantity, JUDGED)
    check_writable(figure, "--figure", PICTURES)
    with progress_of("chains integrated") as progress:
        board = judge.scoreboard(progress=progress)
    what: dict[str, Any] = {"quantity": quantity, "first_bead": first_bead}
    what["statistic"] = "rms" if rms else "worst"
    board.table(**what)  # refuses a bead that is not there, before anything is written
    if figure is not None:
        from hertzchain.plotting.scoreboard import plot_scoreboard

        save_axes(plot_scoreboard(board, **what), figure)
    if as_json:
        document = {"schema_version": results.SCHEMA_VERSION} | board.as_dict()
        show_json(document)
    else:
        show_table(_scoreboard_table(board, by="case" if every_chain else "family", **what))


def _scoreboard_table(
    board: Scoreboard, *, quantity: str, first_bead: int, statistic: str, by: str
) -> Table:
    from rich import box
    from rich.table import Table

    from hertzchain.scoreboard.cases import GROUPS
    from hertzchain.scoreboard.scoreboard import percentage

    errors = board.table(quantity, first_bead=first_bead, statistic=statistic, by=by)  # type: ignore[arg-type]
    outside = board.outside(by)  # type: ignore[arg-type]
    table = Table(
        title=f"{quantity}: {statistic} relative error in %, k = {first_bead}..{board.last_bead} "
        f"of {len(board.cases)} chains",
        caption="– not covered   * outside its range, as the theory itself warns",
        box=box.SIMPLE_HEAD, title_justify="left", caption_justify="left", pad_edge=False,
        collapse_padding=True,
    )  # fmt: skip
    table.add_column("", no_wrap=True)
    for theory in board.theories:
        table.add_column(theory.replace("-", "-\n"), justify="right", vertical="bottom")
    group = None
    for label, members in board.rows(by).items():  # type: ignore[arg-type]
        if board.cases[members[0]].group != group:
            group = board.cases[members[0]].group
            table.add_section()
            table.add_row(f"[bold]{GROUPS[group]}[/]")
        cells = [percentage(error) for error in errors.loc[label]]
        starred = (
            cell + ("*" if warned and cell != "–" else " ")
            for cell, warned in zip(cells, outside.loc[label], strict=True)
        )
        table.add_row(f" {label}", *starred)
    return table
