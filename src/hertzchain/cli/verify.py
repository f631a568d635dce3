"""The command `verify`: exact and published values."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

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
    """Compute quantities with exact or published values and hold them against these.

    Leaves with exit code 3 if any is outside its tolerance.

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
    from rich import box
    from rich.table import Table

    agreeing = sum(verdict.agrees for verdict in verdicts)
    title = f"{agreeing} of {len(verdicts)} cases agree"
    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left")
    for name, side in (("quantity", "left"), ("expected", "right"), ("ours", "right"),
                       ("difference", "right"), ("allowed", "right"), ("", "left"),
                       ("source", "left")):  # fmt: skip
        table.add_column(name, justify=side, no_wrap=True)  # type: ignore[arg-type]
    for i, verdict in enumerate(verdicts):
        case = verdict.case
        if i == 0 or case.group != verdicts[i - 1].case.group:
            table.add_row(f"[bold]{case.group}[/bold]")
        table.add_row(
            f"  {case.name}", f"{case.expected:.10g}", f"{verdict.ours:.10g}",
            f"{verdict.difference:+.1e}", f"{case.tolerance:.0e}",
            "" if verdict.agrees else "OUTSIDE", case.source,
        )  # fmt: skip
    show_table(table)
