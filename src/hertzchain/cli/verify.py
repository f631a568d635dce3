"""The command `verify`: exact and published values."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Literal

import click

from hertzchain.cli.exit_codes import OUTSIDE_TOLERANCE
from hertzchain.cli.options import names_from
from hertzchain.cli.progress import progress_of
from hertzchain.cli.show import show_json, show_table

if TYPE_CHECKING:
    from hertzchain.verification.verify import Verdict


@click.command()
@click.option(
    "--only", metavar="NAMES", help="Groups of cases, separated by commas: walls, dimers, ..."
)
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
def verify(only: str | None, as_json: bool) -> None:
    """Compute quantities with exact or published values and compare them.

    Sources are listed below the table, with how each value was obtained: derived again,
    computed by other code, or recalled from a paper whose text was not at hand.  Exits with
    code 3 if any is outside its tolerance.

    \b
    Examples:
      hertzchain verify
      hertzchain verify --only restitution,walls
    """
    import hertzchain
    from hertzchain.verification.verify import as_dict

    with progress_of("cases computed") as progress:
        verdicts = hertzchain.verify(names_from(only), progress=progress)
    if as_json:
        show_json(as_dict(verdicts))
    else:
        _show_verdicts(verdicts)
    if not all(verdict.agrees for verdict in verdicts):
        sys.exit(OUTSIDE_TOLERANCE)


def _show_verdicts(verdicts: list[Verdict]) -> None:
    """Print the table, and below it the sources by their numbers."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    from hertzchain.verification.case import ORIGINS

    agreeing = sum(verdict.agrees for verdict in verdicts)
    title = f"{agreeing} of {len(verdicts)} cases agree"
    if agreeing < len(verdicts):
        title += "; those marked ! are outside what is allowed"
    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left", padding=0)
    for name in ("quantity", "expected", "ours", "difference", "allowed", "source"):
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
