"""Print tables and JSON; save figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.table import Table


def show_table(table: Table) -> None:
    """Print a table on stdout."""
    from rich.console import Console
    from rich.text import Text

    # Numbers and the title must not be shortened; a narrow terminal wraps the lines.
    needed = Console(width=1000).measure(table).maximum
    if isinstance(table.title, str):
        # One line, also above a narrow table.
        table.title = Text(table.title, no_wrap=True, overflow="ignore")
        needed = max(needed, table.title.cell_len)
    console, below = Console(width=max(needed, Console().width)), ""
    if isinstance(table.caption, str) and max(map(len, table.caption.splitlines())) > needed:
        # Rich would break it at the width of the table.
        below, table.caption = table.caption, None
    console.print(table)
    if below:
        console.print(Text(below, style="table.caption"))


def show_json(document: dict[str, Any]) -> None:
    """Print a document with the version of its schema, and the warnings of the command.

    Numbers that are not finite become null.
    """
    import json

    from ..store.results import SCHEMA_VERSION
    from ..validation.json_types import finite
    from .shown_warnings import with_warnings

    versioned = finite({"schema_version": SCHEMA_VERSION} | with_warnings(document))
    click.echo(json.dumps(versioned, indent=2, allow_nan=False))


def save_figure(axes: Any, plot: Path) -> None:
    """Write the figure of these axes to a file, in the format given by its extension."""
    from ..plotting.style import figure_bytes
    from ..store.writing import write_bytes

    write_bytes(plot, figure_bytes(axes.figure, plot.suffix[1:]))
