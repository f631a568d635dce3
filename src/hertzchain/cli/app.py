"""The command `app`: an interactive chain in the browser."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import click

from .chain_options import ChainOptions, chain_from, chain_options
from .options import StrictCommand, bead_from, check_writable, sensors_from, time_from


@dataclasses.dataclass(frozen=True)
class _Additions:
    """Options that add to the page: chain B, sensors, the end of the runs, and data."""

    other: Path | None
    sensors: tuple[str, ...]
    until: str | None
    data: Path | None

    def read(self, document: dict[str, Any]) -> dict[str, Any]:
        """Arguments of `first_view`: chain B, sensors, the end of the runs, and measured data."""
        from ..app.documents import chain_of, document_of_file
        from ..app.records import keep, record_of_file

        places = tuple(each for each in self.sensors if "=" in each)
        if places and self.data is None:
            raise click.UsageError(
                f"--sensor {places[0]!r} is the place of a column: add --data FILE, or give a bead"
            )
        record = None
        if self.data is not None:
            record = keep(record_of_file(self.data, sensors_from(places)))
        return {
            "other": None if self.other is None else document_of_file(self.other),
            "sensors": [bead_from(each) for each in self.sensors if each not in places],
            "until": time_from("--until", self.until, chain_of(document)),
            "record": record,
        }


@click.command(cls=StrictCommand)
@chain_options
@click.option(
    "--port", type=click.IntRange(0, 65535), default=8765, show_default=True,
    help="Port of the server; if it is taken, the next free one. 0 is any free port.",
)  # fmt: skip
@click.option("--no-open", is_flag=True, help="Print the address, but open no browser.")
@click.option(
    "--save", type=click.Path(path_type=Path), metavar="PAGE",
    help="Instead of serving the page, save it with the results of the chain to PAGE (.html), "
    "which needs neither Python nor a network.",
)  # fmt: skip
@click.option(
    "--compare", "other", type=click.Path(path_type=Path), metavar="FILE",
    help="The chain file of a second chain to compare with; other options do not change it.",
)  # fmt: skip
@click.option(
    "--sensor", "sensors", multiple=True, metavar="BEAD",
    help="A bead with a sensor, such as 12 or 'ball 11'; up to four times. "
    "The chain of --compare has sensors in the same balls, counted without the strikers.",
)  # fmt: skip
@click.option(
    "--data", type=click.Path(path_type=Path), metavar="FILE",
    help="A CSV file of measured forces to show over the simulated ones, as for hertzchain "
    "compare; --sensor 'CH1=ball 6' or 'CH1=load cell' gives the place of a "
    "column.",
)  # fmt: skip
@click.option(
    "--until",
    metavar="TIME",
    help="Time until which the runs last at least, such as 60 or, in SI units, 2ms.",
)
def app(
    options: ChainOptions, port: int, no_open: bool, save: Path | None, other: Path | None,
    sensors: tuple[str, ...], until: str | None, data: Path | None,
) -> None:  # fmt: skip
    """Build, strike and compare chains in the browser.

    The chain to begin with is that of a FILE (TOML, or CSV with one row per bead) or of options
    such as --taper, as in hertzchain simulate.  Without either, it is a row of steel balls in front
    of a wall.

    The page is served on this computer only, at the printed address, until you press Ctrl-C.
    On the first start after an installation, simulations are compiled, which takes one to two
    minutes; the page shows theories immediately and simulations when they are ready.

    \b
    Examples:
      hertzchain app
      hertzchain app experiment.toml --port 9000
      hertzchain app --taper backward-exponential --rate 0.05
      hertzchain app experiment.toml --speed "0.2 m/s" --wall same
      hertzchain app --no-open
      hertzchain app absorber.toml --compare row.toml --sensor "ball 4"
      hertzchain app lab.toml --data record.csv --sensor "CH1=ball 6" --sensor CH2=wall
      hertzchain app absorber.toml --compare row.toml --save absorber.html
    """
    given = _Additions(other, sensors, until, data)
    if save is not None:
        _save(options, given, save)
        return
    from ..app.serve import RunningServer, open_browser

    document = None if options == ChainOptions() else _document(options)
    view = _first_view(document, given) if any(dataclasses.astuple(given)) else None
    server = RunningServer(port, document, view=view)
    if port not in (0, server.port):
        click.echo(f"port {port} is taken; using {server.port}", err=True)
    click.echo(server.address)
    click.echo("Press Ctrl-C to stop.", err=True)

    def opened() -> None:
        if not open_browser(server.address):
            click.echo("no browser found; open the address above", err=True)

    try:
        server.run(None if no_open else opened)
    except KeyboardInterrupt:
        click.echo("stopped", err=True)


def _first_view(document: dict[str, Any] | None, given: _Additions) -> dict[str, Any]:
    """Chain B, sensors, data and the end of the run with which the page begins."""
    from ..app.about import gallery
    from ..app.page_file import first_view

    document = gallery()[0]["document"] if document is None else document
    view = first_view(document, **given.read(document))
    if not view["view"]["sensors"]:
        # The page begins with its usual sensor.
        del view["view"]["sensors"]
    return view


def _document(options: ChainOptions) -> dict[str, Any]:
    """The chain of the options; a file that they do not change keeps its units and names."""
    from ..app.documents import document_of_chain, document_of_file

    file = _file(options)
    if file is not None and options in (ChainOptions((file,)), ChainOptions(chain_file=file)):
        return document_of_file(file)
    if len(options.files) > 1:
        raise click.UsageError(
            f"give one chain FILE, and a second one as --compare FILE, got {len(options.files)}"
        )
    return document_of_chain(chain_from(options))


def _file(options: ChainOptions) -> Path | None:
    return next(iter((*options.files, options.chain_file)), None)


def _save(options: ChainOptions, given: _Additions, page: Path) -> None:
    """Save the page of one or two chains."""
    if options == ChainOptions():
        raise click.UsageError("--save requires a chain FILE, or options such as --taper")
    check_writable(page, "--save", (".html",))
    from ..app.page_file import write_page

    document, named = _document(options), {"A": _file(options), "B": given.other}
    names = {slot: each.name for slot, each in named.items() if each is not None}
    write_page(document, path=page, names=names, **given.read(document))
    click.echo(f"{page} written: open it in a browser")
