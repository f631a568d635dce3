"""The command `sheet`: a laboratory sheet with predictions, tasks and answers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .chain_options import ChainOptions, chain_from, chain_options
from .options import (
    StrictCommand,
    as_typed,
    bead_from,
    check_writable,
    json_option,
    require_unit,
    time_from,
    until_option,
)
from .output import show_json
from .wording import on_command_line

if TYPE_CHECKING:
    from ..sheets.sheet import LabSheet


@click.command(cls=StrictCommand)
@chain_options
@click.option(
    "--sensor",
    "sensors",
    multiple=True,
    metavar="PLACE",
    help="A bead with a force sensor, such as 'ball 6', or wall, or load cell; up to four "
    "times.  "
    "[default: wall]",
)
@click.option(
    "--to",
    "target",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write the sheet to FILE (.html or .md).",
)
@click.option("--title", metavar="TEXT", help="Title of the sheet.")
@click.option(
    "--blank", is_flag=True, help="Print the predictions only on the page for the teacher."
)
@until_option
@json_option("Print the predictions as JSON.")
def sheet(
    options: ChainOptions, sensors: tuple[str, ...], target: Path | None, title: str | None,
    blank: bool, until: str | None, as_json: bool,
) -> None:  # fmt: skip
    """Write a laboratory sheet of a row, with predictions.

    The sheet has tasks, a sketch of the row, and a table of the forces in the sensors and of the
    times between them, with columns for the readings.  On a separate page, the answers for the
    teacher have the exponents of the forces, the speed of the pulse between balls, and the effect
    of losses and gaps.  Print the page from a browser, or convert the Markdown file with pandoc.

    \b
    Examples:
      hertzchain sheet lab.toml --sensor "ball 6" --sensor wall \\
          --height 1mm --height 2mm --height 4mm --to sheet.html
      hertzchain sheet lab.toml --speed 0.1m/s --speed 0.2m/s --blank --to sheet.md
    """
    import hertzchain

    from ..sheets.sheet import ENDINGS, LEAST, places_of

    chain = chain_from(replace(options, others=()))
    named = [bead_from(each) for each in sensors] or ["wall"]
    if chain.units == "SI":
        places_of(chain, named, "--sensor")  # before the options that are usually written last
    if target is None and not as_json:
        raise click.UsageError("give the file to write, such as --to sheet.html")
    check_writable(target, "--to", ENDINGS)
    falls = options.height is not None
    given = tuple(filter(None, (options.height or options.speed, *options.others)))
    if len(given) < LEAST:
        raise click.UsageError("give --height or --speed at least twice, such as --height 1mm "
                               "--height 4mm")  # fmt: skip
    for each in given:
        require_unit(options.option_of_speed, each, "mm" if falls else "m/s")
    values = [as_typed(each) for each in given]
    found = hertzchain.lab_sheet(
        chain, sensors=named,
        heights=values if falls else None, speeds=None if falls else values, blank=blank,
        until=time_from("--until", until, chain), **({} if title is None else {"title": title}),
    )  # fmt: skip
    found = replace(found, warnings=tuple(map(on_command_line, found.warnings)))
    if target is not None:
        found.save(target)
    if as_json:
        show_json(_document(found))
    for each in found.warnings:
        click.echo(f"Warning: {each}", err=True)


def _document(found: LabSheet) -> dict[str, Any]:
    """The predictions in plain types."""
    from ..validation.json_types import finite

    return {
        "title": found.title, "sensors": list(found.places),
        "heights": None if found.heights is None else found.heights.tolist(),
        "speeds": found.speeds.tolist(),
        "forces": [[finite(each) for each in row] for row in found.forces.tolist()],
        "times": [[finite(each) for each in row] for row in found.times.tolist()],
        "exponents": [[finite(each) for each in row] for row in found.exponents.tolist()],
        "warnings": list(found.warnings),
    }  # fmt: skip
