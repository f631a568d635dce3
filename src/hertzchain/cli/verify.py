"""The command `verify`: compare with exact and published values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import click

from .exit_codes import DONE, OUTSIDE_TOLERANCE
from .options import StrictCommand, json_option, names_from
from .output import show_json, show_table
from .progress import progress_bar

if TYPE_CHECKING:
    from ..verification.verify import Verdict


@click.command(cls=StrictCommand)
@click.option(
    "--only", metavar="NAMES", help="Groups of cases, separated by commas: walls, dimers, ..."
)
@json_option()
def verify(only: str | None, as_json: bool) -> int:
    """Compare computed with exact and published values.

    The sources are listed below the table, with the origin of each value: derived,
    computed by other code, or recalled from a paper whose text was not available.  Exits with
    code 3 if any value is outside its tolerance.

    \b
    Examples:
      hertzchain verify
      hertzchain verify --only restitution,walls
    """
    import hertzchain

    from ..verification.verify import as_dict

    with progress_bar("cases computed") as progress:
        verdicts = hertzchain.verify(names_from(only), progress=progress)
    if as_json:
        show_json(as_dict(verdicts))
    else:
        _show_verdicts(verdicts)
    return DONE if all(verdict.agrees for verdict in verdicts) else OUTSIDE_TOLERANCE


def _show_verdicts(verdicts: list[Verdict]) -> None:
    """Print the table and the numbered list of sources."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    from ..verification.case import ORIGINS

    agreeing = sum(verdict.agrees for verdict in verdicts)
    title = f"{agreeing} of {len(verdicts)} cases agree"
    if agreeing < len(verdicts):
        title += "; cases marked ! are outside their tolerance"
    table = Table(
        title=title, box=box.SIMPLE_HEAD, title_justify="left", padding=0, show_edge=False
    )
    for name in ("quantity", "expected", "computed", "difference", "allowed", "source"):
        side: Literal["left", "right"] = "left" if name == "quantity" else "right"
        table.add_column(name, justify=side, no_wrap=True)
    sources: dict[tuple[str, str], int] = {}
    group = ""
    for verdict in verdicts:
        case = verdict.case
        if case.group != group:
            group = case.group
            table.add_row(f"[bold]{group}[/bold]")
        number = sources.setdefault((case.source, case.origin), len(sources) + 1)
        table.add_row(
            f"{' ' if verdict.agrees else '!'} {escape(case.name)}",
            f"{case.expected:.8g}", f"{verdict.ours:.8g}",
            f"{verdict.difference:+.1e}", f"{case.tolerance:.0e}", f"[{number}]",
        )  # fmt: skip
    show_table(table)
    for (source, origin), number in sources.items():
        click.echo(f"{f'[{number}]':>5} {source} ({origin})")
    click.echo()
    for origin in dict.fromkeys(verdict.case.origin for verdict in verdicts):
        click.echo(f"{origin}: {ORIGINS[origin]}")
