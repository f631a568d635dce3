"""Progress of long work, on stderr."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

import click

# Where no bar can be drawn, a line of progress appears so often.
SECONDS_PER_LINE: Final = 5.0


@contextmanager
def progress_of(what: str) -> Iterator[Callable[[int, int], None]]:
    """A bar on stderr that vanishes when done; in a pipe or file, a line now and then."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn()
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _lines_of_progress(what)
        return
    with Progress(
        *columns, TimeElapsedColumn(), console=console, transient=True
    ) as bar:  # fmt: skip
        task = bar.add_task("starting; the first use on a machine compiles", total=None)
        yield lambda done, total: bar.update(task, description=what, completed=done, total=total)


def _lines_of_progress(what: str) -> Callable[[int, int], None]:
    told: list[float] = []

    def update(done: int, total: int) -> None:
        now = time.monotonic()
        if told and now - told[-1] < SECONDS_PER_LINE:
            return
        if told:
            click.echo(f"{what}: {done} of {total}", err=True)
        told.append(now)

    return update
