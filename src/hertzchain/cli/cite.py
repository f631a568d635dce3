"""The command `cite`: print references."""

from __future__ import annotations

import click

from .options import StrictCommand


@click.command(cls=StrictCommand)
def cite() -> None:
    """Print the references to cite: paper, methods and software.

    \b
    Example:
      hertzchain cite
    """
    from ..citations import CITATIONS

    click.echo("\n\n".join(CITATIONS))
