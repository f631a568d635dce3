"""The command `calibrate`: fit the constants of the modified BCA."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from .options import StrictCommand, check_writable, json_option, numbers_from, window_from
from .output import show_json, show_table
from .progress import progress_bar

if TYPE_CHECKING:
    from ..calibration import Calibration


@click.command(cls=StrictCommand)
@click.option(
    "--taper",
    "tapers",
    multiple=True,
    metavar="NAME",
    help="Taper to calibrate; repeatable.  [default: all four]",
)
@click.option(
    "--rates",
    metavar="NUMBERS",
    help="Values of S or q, separated by commas; requires one --taper.  "
    "[default: those of the paper]",
)
@click.option(
    "--window", metavar="FIRST:LAST", default="5:80", show_default=True, help="Beads to fit."
)
@click.option(
    "--beads", type=int, default=100, show_default=True, help="Number of beads in each chain."
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Also write the constants to FILE (.toml).",
)
@json_option()
def calibrate(
    tapers: tuple[str, ...], rates: str | None, window: str, beads: int, out: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Fit the constants of the modified BCA, as in the paper.

    Prints each constant with its standard error and the value in the paper, and the error of
    the fitted velocity.

    \b
    Examples:
      hertzchain calibrate
      hertzchain calibrate --taper forward-linear --rates 0.01,0.015 --beads 60 --window 5:50
    """
    from .. import calibration
    from ..chain.tapers import PAPER_TAPERS
    from ..store.writing import write_bytes
    from ..validation.objects import check_choice

    for taper in tapers:
        check_choice("taper", taper, PAPER_TAPERS)
    check_writable(out, "--out", (".toml",))
    chosen = tuple(dict.fromkeys(tapers)) or PAPER_TAPERS
    if rates is not None and len(chosen) != 1:
        raise click.UsageError("--rates requires exactly one --taper")
    numbers = None if rates is None else numbers_from("--rates", rates)
    beads_of_fit = window_from("--window", window)
    with progress_bar("chains integrated") as progress:
        found = [
            calibration.calibrate(
                taper,
                rates=numbers,
                window=beads_of_fit,
                beads=beads,
                progress=progress,
            )
            for taper in chosen
        ]
    if out is not None:
        write_bytes(out, calibration.calibrated_toml(found).encode())
    if as_json:
        show_json({"calibrations": [result.as_dict() for result in found]})
        return
    for result in found:
        _show_calibration(result)


def _show_calibration(result: Calibration) -> None:
    from rich import box
    from rich.table import Table

    from ..calibration import error_text
    from ..chain.tapers import rate_symbol

    first, last = result.window
    click.echo(f"{result.taper}, beads {first}..{last} of {result.beads}")
    table = Table(title=result.correction.formula, box=box.SIMPLE_HEAD, title_justify="left")
    for heading in ("constant", "value", "standard error", "printed in the paper"):
        table.add_column(heading, justify="right")
    for name, value in result.constants.items():
        error, printed = result.standard_errors[name], result.printed[name]
        table.add_row(name, f"{value:.6g}", error_text(error), f"{printed:.3g}")
    show_table(table)
    click.echo(
        f"relative error of velocity: worst {result.worst_error:.2%}, rms {result.rms_error:.2%}"
    )
    for rate, worst in zip(result.rates, result.worst_by_rate, strict=True):
        click.echo(f"  {rate_symbol(result.taper)} = {rate:<6g} worst {worst:7.2%}")
    click.echo()
