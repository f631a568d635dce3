"""The command `app`: an interactive chain in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .chain_options import ChainOptions, chain_from, chain_options
from .options import StrictCommand, bead_from, check_writable, time_from


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
    help="With --save, the chain file of a second chain to compare with; other options do not "
    "change it.",
)  # fmt: skip
@click.option(
    "--sensor", "sensors", multiple=True, metavar="BEAD",
    help="With --save, a bead with a sensor, such as 12 or 'ball 11'; up to four times. "
    "The chain of --compare has sensors in the same balls, counted without the strikers.",
)  # fmt: skip
@click.option(
    "--until",
    metavar="TIME",
    help="With --save, time until which the runs last at least, such as 60 or, in SI units, 2ms.",
)
def app(
    options: ChainOptions, port: int, no_open: bool, save: Path | None, other: Path | None,
    sensors: tuple[str, ...], until: str | None,
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
      hertzchain app absorber.toml --compare row.toml --save absorber.html
    """
    if save is not None:
        _save(options, other, sensors, until, save)
        return
    if other is not None or sensors or until is not None:
        raise click.UsageError("--compare, --sensor and --until require --save")
    from ..app.serve import RunningServer, open_browser

    document = None if options == ChainOptions() else _document(options)
    server = RunningServer(port, document)
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


def _document(options: ChainOptions) -> dict[str, Any]:
    """The chain of the options; a file that they do not change keeps its units and names."""
    from ..app.documents import document_of_chain, document_of_file

    file = _file(options)
    if file is not None and options in (ChainOptions((file,)), ChainOptions(chain_file=file)):
        return document_of_file(file)
    return document_of_chain(chain_from(options))


def _file(options: ChainOptions) -> Path | None:
    return next(iter((*options.files, options.chain_file)), None)


def _save(
    options: ChainOptions, other: Path | None, sensors: tuple[str, ...], until: str | None,
    page: Path,
) -> None:  # fmt: skip
    """Save the page of one or two chains."""
    if options == ChainOptions():
        raise click.UsageError("--save requires a chain FILE, or options such as --taper")
    check_writable(page, "--save", (".html",))
    from ..app.documents import chain_of, document_of_file
    from ..app.page_file import write_page

    document, file = _document(options), _file(options)
    end = time_from("--until", until, chain_of(document))
    compared = None if other is None else document_of_file(other)
    beads = [bead_from(each) for each in sensors]
    named = {"A": file, "B": other}
    names = {slot: each.name for slot, each in named.items() if each is not None}
    write_page(document, compared, beads, page, names, until=end)
    click.echo(f"{page} written: open it in a browser")
