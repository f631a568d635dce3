"""The command `reproduce`: recompute the paper and compare."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from .exit_codes import DONE, OUTSIDE_TOLERANCE
from .options import StrictCommand, json_option, names_from, window_from
from .output import show_json
from .progress import progress_bar

if TYPE_CHECKING:
    from ..paper.reproduction import Reproduction


@click.command(cls=StrictCommand)
@click.option(
    "--only", metavar="NAMES", help="Parts, separated by commas: table1, figure5, errata, ..."
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("reproduction"),
    show_default=True,
    metavar="FOLDER",
    help="Folder for the report, figures and data.",
)
@click.option(
    "--window-exponential",
    metavar="FIRST:LAST",
    default="5:80",
    show_default=True,
    help="Beads of the fits in tables 1 and 2.",
)
@click.option(
    "--window-linear",
    metavar="FIRST:LAST",
    default="5:60",
    show_default=True,
    help="Beads of the fit in table 3.",
)
@json_option("Print verdict.json.")
def reproduce(
    only: str | None, out: Path, window_exponential: str, window_linear: str, as_json: bool
) -> int:
    """Recompute every table and figure of the paper.

    The results are compared with the numbers printed in the paper.

    The command writes report.html, verdict.json, summary.md and figures/ to a folder, and exits
    with code 3 if anything is outside its tolerance.  In a folder that it wrote before, it
    replaces the report and the figures of the computed parts, and keeps all other figures.  It
    never replaces files that it did not write, or that were changed afterwards.

    \b
    Examples:
      hertzchain reproduce
      hertzchain reproduce --only table1,figure5 --out check
    """
    from ..calibration import BEADS, beads_in_window
    from ..paper import report, report_folder, reproduction
    from ..paper.drawings import drawing_pool
    from ..paper.published import published_figures

    windows = {
        "exponential": window_from("--window-exponential", window_exponential),
        "linear": window_from("--window-linear", window_linear),
    }
    parts = reproduction.checked_parts(names_from(only))
    for window in windows.values():
        beads_in_window(window, BEADS)
    figures = len(parts.intersection(published_figures()))
    with report_folder.reserved(out, parts), drawing_pool(figures) as pool:
        replaced = report_folder.replaced_report(out, parts)
        with progress_bar("chains integrated") as progress:
            result = reproduction.reproduce(parts, windows=windows, progress=progress)  # type: ignore[arg-type]
        with progress_bar("figures drawn") as progress:
            page = report.write_reserved(result, out, progress=progress, pool=pool)
    if as_json:
        show_json(report.verdict(result))
    else:
        _show_reproduction(result)
        click.echo(f"Report: {page}")
    if replaced:
        click.echo(replaced, err=True)
    return DONE if result.within_tolerance else OUTSIDE_TOLERANCE


def _show_reproduction(result: Reproduction) -> None:
    from ..paper.mathml import plain

    click.echo(result.verdict)
    for table in result.tables:
        for entry in table.entries:
            if not entry.agrees:
                click.echo(
                    f"  outside tolerance: {entry.table}, {entry.taper}, {entry.column}, rate "
                    f"{entry.rate:g}: printed {entry.printed.text}, computed {entry.ours:.7f}"
                )
    for figure in result.figures:
        if not figure.statement.holds:
            click.echo(f"  not confirmed: {figure.published.name}: {figure.statement.claim}")
    if result.all_errata:
        return
    for erratum in result.errata:
        click.echo(
            f"  erratum: {plain(erratum.place)}: printed {plain(erratum.printed)}; correct: "
            f"{plain(erratum.follows)}"
        )
