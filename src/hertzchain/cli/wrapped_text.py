"""Print text whose lines are wrapped on a narrow terminal."""

from __future__ import annotations

import shutil
import sys
from typing import Final

import click

# Lines are not wrapped to less than this width.
LEAST_WIDTH: Final = 40


def show_text(text: str, *, err: bool = False) -> None:
    """Print lines, wrapped on a terminal that is narrower.

    Lines in files and pipes are whole, so that they can be searched.
    """
    if (sys.stderr if err else sys.stdout).isatty():
        text = wrapped(text, max(LEAST_WIDTH, shutil.get_terminal_size().columns))
    click.echo(text, err=err)


def wrapped(text: str, width: int) -> str:
    """Lines of at most this width; continuation lines are indented by four more columns."""
    import textwrap

    lines = []
    for line in text.split("\n"):
        indent = " " * (len(line) - len(line.lstrip(" ")) + 4)
        lines += (
            textwrap.wrap(
                line,
                width,
                subsequent_indent=indent,
                break_long_words=False,
                break_on_hyphens=False,
            )
            or [""]
            if len(line) > width
            else [line]
        )
    return "\n".join(lines)
