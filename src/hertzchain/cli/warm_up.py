"""The command `warm-up`: compile all kernels in advance."""

from __future__ import annotations

import click

from .options import StrictCommand, json_option
from .output import show_json
from .progress import progress_bar


@click.command("warm-up", cls=StrictCommand)
@click.option(
    "--first", is_flag=True, help="Only the kernels needed first: pulses, walls, most losses."
)
@json_option("Print the time as JSON.")
def warm_up(first: bool, as_json: bool) -> None:
    """Compile all kernels now instead of at their first use.

    Kernels are compiled only once per installation; the command uses two processes.  If everything
    is already compiled, it takes a few seconds.

    \b
    Examples:
      hertzchain warm-up
      hertzchain warm-up --first
    """
    import hertzchain

    with progress_bar("groups of kernels compiled") as progress:
        seconds = hertzchain.warm_up(first=first, progress=progress)
    if as_json:
        show_json({"seconds": seconds})
    else:
        kernels = "The first kernels" if first else "All kernels"
        click.echo(f"{kernels} are compiled ({seconds:.1f} s).")
