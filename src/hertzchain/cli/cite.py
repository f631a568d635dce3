"""The command `cite`: print references."""

from __future__ import annotations

import click

from .options import StrictCommand


@click.command(cls=StrictCommand)
@click.option("--bibtex", is_flag=True, help="Print the references as a BibTeX file.")
def cite(*, bibtex: bool) -> None:
    """Print the references to cite: paper, methods and software.

    \b
    Examples:
      hertzchain cite
      hertzchain cite --bibtex > granular.bib
    """
    from .. import citations

    click.echo(citations.bibtex() if bibtex else citations.text())
