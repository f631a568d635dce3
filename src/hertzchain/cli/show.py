"""Show a table, print JSON, save a drawing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.table import Table


def show_table(table: Table) -> None:
    """Print a table on stdout."""
    from rich.console import Console

    # Never shorten a number: a narrow terminal folds the line itself.
    needed = Console(width=1000).measure(table).maximum
    Console(width=max(needed, Console().width)).print(table)


def show_json(document: dict[str, Any]) -> None:
    """Print a document on stdout; all its numbers are finite."""
    import json

    click.echo(json.dumps(document, indent=2, allow_nan=False))


def save_axes(axes: Any, plot: Path) -> None:
    """Write the figure of some axes into a file, by its ending."""
    from hertzchain.plotting.style import figure_bytes
    from hertzchain.store.writing import write_bytes

    write_bytes(plot, figure_bytes(axes.figure, plot.suffix[1:]))
