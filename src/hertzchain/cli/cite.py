"""The command `cite`: print references."""

from __future__ import annotations

import click


@click.command()
def cite() -> None:
    """Print the references to cite: the paper, the methods and this software.

    \b
    Example:
      hertzchain cite
    """
    from ..citations import CITATIONS

    click.echo("\n\n".join(CITATIONS))
