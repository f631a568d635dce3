"""The command `calibrate`: the constants of the modified BCA."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hertzchain.cli.options import check_writable, numbers_from, window_from
from hertzchain.cli.progress import progress_of
from hertzchain.cli.show import show_json, show_table

if TYPE_CHECKING:
    from hertzchain.calibration import Calibration


@click.command()
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
    help="Its S or q, separated by commas; with one --taper.  [default: those of the paper]",
)
@click.option(
    "--window", metavar="FIRST:LAST", default="5:80", show_default=True, help="Beads of the fit."
)
@click.option("--beads", type=int, default=100, show_default=True, help="Beads of each chain.")
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Also write the constants into FILE (.toml).",
)
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
def calibrate(
    tapers: tuple[str, ...], rates: str | None, window: str, beads: int, output: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Fit the constants of the modified BCA to the integration, as the paper did.

    Shows each constant with its standard error and what the paper prints for it, and how
    far the fitted velocity is off.

    \b
    Examples:
      hertzchain calibrate
      hertzchain calibrate --taper forward-linear --rates 0.01,0.015 --beads 60 --window 5:50
    """
    from hertzchain import calibration
    from hertzchain.arguments import one_of
    from hertzchain.chain.chain import TAPERS
    from hertzchain.store import results
    from hertzchain.store.writing import write_bytes

    for taper in tapers:
        one_of("taper", taper, TAPERS)
    check_writable(output, "--output", (".toml",))
    chosen = tuple(dict.fromkeys(tapers)) or TAPERS
    if rates is not None and len(chosen) != 1:
        raise click.UsageError("--rates are those of one taper: give one --taper")
    numbers = None if rates is None else numbers_from("--rates", rates)
    beads_of_fit = window_from("--window", window)
    with progress_of("chains integrated") as progress:
        found = [
            calibration.calibrate(
                taper,  # type: ignore[arg-type]
                rates=numbers,
                window=beads_of_fit,
                beads=beads,
                progress=progress,
            )
            for taper in chosen
        ]
    if output is not None:
        write_bytes(output, calibration.calibrated_toml(found).encode())
    if as_json:
        document: dict[str, Any] = {"schema_version": results.SCHEMA_VERSION}
        document["calibrations"] = [result.as_dict() for result in found]
        show_json(document)
        return
    for result in found:
        _show_calibration(result)


def _show_calibration(result: Calibration) -> None:
    from rich import box
    from rich.table import Table

    from hertzchain.chain.chain import rate_symbol

    first, last = result.window
    click.echo(f"{result.taper}, beads {first}..{last} of {result.beads}")
    table = Table(title=result.correction.formula, box=box.SIMPLE_HEAD, title_justify="left")
    for heading in ("constant", "value", "standard error", "printed in the paper"):
        table.add_column(heading, justify="right")
    for name, value in result.constants.items():
        error, printed = result.standard_errors[name], result.printed[name]
        table.add_row(name, f"{value:.6g}", f"{error:.2g}", f"{printed:.3g}")
    show_table(table)
    click.echo(
        f"relative error of velocity: worst {result.worst_error:.2%}, rms {result.rms_error:.2%}"
    )
    for rate, worst in zip(result.rates, result.worst_by_rate, strict=True):
        click.echo(f"  {rate_symbol(result.taper)} = {rate:<6g} worst {worst:7.2%}")
    click.echo()
