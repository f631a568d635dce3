"""Print text whose lines are broken on a narrow terminal."""

from __future__ import annotations

import shutil
import sys
from typing import Final

import click

from ..representation import folded

# Lines are not broken to less than this width.
LEAST_WIDTH: Final = 40
# Additional indent of the rest of a broken line.
INDENT: Final = 4


def show_text(text: str, *, err: bool = False) -> None:
    """Print lines, broken on a terminal that is narrower.

    Lines in files and pipes are whole, so that they can be searched.
    """
    if (sys.stderr if err else sys.stdout).isatty():
        text = wrapped(text, max(LEAST_WIDTH, shutil.get_terminal_size().columns))
    click.echo(text, err=err)


def wrapped(text: str, width: int) -> str:
    """Lines of at most this width; the rest of a broken line is indented further."""
    return "\n".join(
        folded(line, width, len(line) - len(line.lstrip(" ")) + INDENT) for line in text.split("\n")
    )
