"""The command `cite`: what to cite."""

from __future__ import annotations

import click


@click.command()
def cite() -> None:
    """Print what to cite: the paper, the methods, this software.

    \b
    Example:
      hertzchain cite
    """
    from hertzchain.citations import CITATIONS

    click.echo("\n\n".join(CITATIONS))
