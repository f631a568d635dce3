"""The command `scoreboard`: compare every theory with the simulation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..pulse.quantities import QUANTITIES
from .options import StrictCommand, figure_option, json_option
from .output import save_figure, show_json, show_table
from .progress import progress_bar

if TYPE_CHECKING:
    from rich.table import Table

    from ..evaluation.scoreboard import Scoreboard


@click.command(cls=StrictCommand)
@click.option(
    "--quantity",
    default="velocity",
    show_default=True,
    metavar="NAME",
    help="Quantity by which theories are evaluated: "
    f"{', '.join(name for name, quantity in QUANTITIES.items() if quantity.scored)}.",
)
@click.option(
    "--first-bead", type=int, default=10, show_default=True, help="First bead to evaluate."
)
@click.option("--rms", is_flag=True, help="Show the root mean square instead of the worst error.")
@click.option("--all", "every_chain", is_flag=True, help="Show one row per chain, not per family.")
@figure_option("Also plot the table to FILE.")
@json_option("Print all quantities, from beads 2 and 10 on, as JSON.")
def scoreboard(
    quantity: str, first_bead: int, rms: bool, every_chain: bool, plot: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Compare every theory with the simulation on many tapers.

    The chains have 100 beads each: the paper's four tapers at its rates and beyond, and tapers
    to which no theory was fitted. Errors are evaluated up to bead 97, before the free end.

    \b
    Examples:
      hertzchain scoreboard
      hertzchain scoreboard --quantity arrival --first-bead 2 --plot arrival.png
    """
    from ..evaluation import evaluate
    from ..evaluation.scoreboard import QUANTITIES as SCORED
    from ..validation.objects import check_choice

    check_choice("quantity", quantity, SCORED)
    with progress_bar("chains integrated") as progress:
        board = evaluate.scoreboard(progress=progress)
    what: dict[str, Any] = {"quantity": quantity, "first_bead": first_bead}
    what["statistic"] = "rms" if rms else "worst"
    board.table(**what)  # checks the first bead before anything is written
    if plot is not None:
        from ..plotting.scoreboard import plot_scoreboard

        save_figure(plot_scoreboard(board, **what), plot)
    if as_json:
        show_json(board.as_dict())
    else:
        show_table(_scoreboard_table(board, by="case" if every_chain else "family", **what))


def _scoreboard_table(
    board: Scoreboard, *, quantity: str, first_bead: int, statistic: str, by: str
) -> Table:
    from rich import box
    from rich.table import Table

    from ..evaluation.scoreboard_rows import CAPTION, scoreboard_rows, scoreboard_title

    table = Table(
        title=scoreboard_title(board, quantity, first_bead, statistic), caption=CAPTION,
        box=box.SIMPLE_HEAD, title_justify="left", caption_justify="left", pad_edge=False,
        padding=0, show_edge=False,
    )  # fmt: skip
    table.add_column("", no_wrap=True)
    for theory in board.theories:
        table.add_column(theory.replace("-", "-\n"), justify="right", vertical="bottom")
    for label, cells in scoreboard_rows(board, quantity, first_bead, statistic, by):  # type: ignore[arg-type]
        if cells:
            table.add_row(f" {label}", *cells)
        else:
            table.add_section()
            table.add_row(f"[bold]{label}[/]")
    return table
