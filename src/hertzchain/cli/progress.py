"""Progress bars of long computations, on stderr."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.progress import ProgressColumn

# Time until the first line of progress if stderr is not a terminal; each of the next intervals is
# twice as long as the last one, up to the longest.
SECONDS_PER_LINE, LONGEST_INTERVAL = 10.0, 300.0


@contextmanager
def progress_bar(
    what: str | Callable[[int], str], *, rate: bool = False, counted: bool = True
) -> Iterator[Callable[[int, int], None]]:
    """Show a bar on stderr that disappears at the end; in a pipe or file, print lines.

    ``what`` may be a function of the number that is done, which names what is being tried.
    If less is done than was announced, a last line states the total, except after an error.
    With ``rate``, the number per second and the remaining time are shown as well.  Without
    ``counted``, the total is not known in advance, and only the number that is done is shown.
    """
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
    )

    named = what if callable(what) else lambda _: what
    console = Console(stderr=True)
    pace = _Pace() if rate else None
    announce_compilation()
    if not console.is_terminal:
        lines = _Lines(named, pace, counted=counted)
        yield lines
        lines.finish()
        return
    columns = [TextColumn("{task.description}"), BarColumn(), _count_column()]
    last = TextColumn("{task.fields[pace]}") if rate else TimeElapsedColumn()
    with Progress(*columns, last, console=console, transient=True) as bar:
        task = bar.add_task("starting", total=None, pace="")
        announce_compilation(lambda line: bar.update(task, description=line.partition(", ")[0]))

        def update(done: int, total: int) -> None:
            text = pace.text(done, total) if pace else ""
            if not counted:
                bar.update(task, description=f"{named(done)}: {done}")
            elif done < total:
                bar.update(task, description=named(done), completed=done, total=total, pace=text)
            else:
                # Further work may follow; the clock of a bar that is full would stop.
                bar.tasks[0].total = None
                bar.update(task, description=f"{named(done)}: {done}, finishing", pace=text)

        try:
            yield update
        finally:
            announce_compilation()


def announce_compilation(also: Callable[[str], None] | None = None) -> None:
    """Write a line to stderr, also in a pipe or file, whenever functions are being compiled."""
    from ..kernels.compile_notice import send_to

    def write(line: str) -> None:
        if multiprocessing.parent_process() is None:
            click.echo(line, err=True)
            if also is not None:
                also(line)

    send_to(write)


def _count_column() -> ProgressColumn:
    """The column ``3/10``, which is empty before the first result."""
    from rich.progress import MofNCompleteColumn
    from rich.text import Text

    class Count(MofNCompleteColumn):
        def render(self, task: Any) -> Text:
            return Text("") if task.total is None else super().render(task)

    return Count()


class _Pace:
    """Number per second since the end of the first batch, which may compile, and remaining time."""

    def __init__(self) -> None:
        self.begun: tuple[float, int] | None = None
        self.warm = False

    def text(self, done: int, total: int) -> str:
        now = time.monotonic()
        if self.begun is None:
            self.begun = now, done
        elapsed, more = now - self.begun[0], done - self.begun[1]
        if more > 0 and not self.warm:
            self.begun, self.warm = (now, done), True
            return ""
        if more <= 0 or elapsed <= 0.0:
            return ""
        left = timedelta(seconds=round((total - done) * elapsed / more))
        pace = more / elapsed
        shown = f"{pace:.0f}" if pace >= 10 else f"{pace:.2g}"
        return f"{shown} per second, {left} left"


class _Lines:
    """Lines of progress, the last of which states the total."""

    def __init__(
        self, what: str | Callable[[int], str], pace: _Pace | None, *, counted: bool = True
    ) -> None:
        self.what: Callable[[int], str] = what if callable(what) else lambda _: what
        self.pace, self.counted = pace, counted
        self.begun, self.latest = time.monotonic(), -1
        self.interval = SECONDS_PER_LINE
        self.done = self.total = 0

    def __call__(self, done: int, total: int) -> None:
        now = time.monotonic()
        self.done, self.total = done, total
        text = self.pace.text(done, total) if self.pace else ""
        # After a first line, the last one states the total.
        complete = self.counted and done >= total
        due = now - self.begun >= self.interval or (complete and self.latest >= 0)
        # While functions are compiled, nothing changes.
        if not due or done == self.latest:
            return
        of = f" of {total}" if self.counted else ""
        click.echo(f"{self.what(done)}: {done}{of}" + (f", {text}" if text else ""), err=True)
        self.begun, self.latest = now, done
        self.interval = min(2.0 * self.interval, LONGEST_INTERVAL)

    def finish(self) -> None:
        """State the total of work that has ended early, such as a search within its budget."""
        if self.latest >= 0 and (not self.counted or self.done < self.total):
            click.echo(f"{self.what(self.done)}: {self.done} in total", err=True)
