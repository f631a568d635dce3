"""Draw the figures of a report, side by side in processes if there are any."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any, Final

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from ..plotting.style import svg_and_png
from ..sweeps.executors import local_pool, workers_of
from ..validation.numbers import worker_count

# Figures drawn in the time in which a process starts.
FEW: Final = 3
MAX_PROCESSES: Final = 4


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure that is not drawn yet: a function and its argument."""

    function: Callable[[Any], Figure]
    argument: Any

    def files(self) -> tuple[bytes, bytes]:
        """The figure as SVG and PNG."""
        figure = self.function(self.argument)
        try:
            return svg_and_png(figure)
        finally:
            plt.close(figure)


@contextmanager
def drawing_pool(figures: int) -> Iterator[Executor | None]:
    """Processes that draw beside this one; None if they are not worth it or cannot start.

    They start in the background, and import what they need while other things are computed.
    """
    others = min(worker_count("workers", None), MAX_PROCESSES) - 1 if figures > FEW else 0
    with ExitStack() as stack:
        pool = None
        if others > 0:
            try:
                pool = stack.enter_context(local_pool("processes", others))
                for _ in range(others):
                    pool.submit(_ready)
            except (OSError, ImportError, BrokenProcessPool):
                # A system without semaphores, or with a limit on processes.
                pool = None
        yield pool


def _ready() -> None:
    """Import this module."""


def drawn(
    drawings: Mapping[str, Drawing], pool: Executor | None
) -> Iterator[tuple[str, tuple[bytes, bytes]]]:
    """SVG and PNG of all figures, as they are completed.

    The pool begins with the last figures, and this process with the first ones.
    """
    # Futures are not cancelled: in Python 3.11, others would never end if a process then died.
    waiting, beside = list(drawings), _Beside(drawings, pool)
    while waiting:
        beside.fill(waiting)
        yield from beside.completed()
        if waiting:
            name = waiting.pop(0)
            yield name, drawings[name].files()
    yield from beside.completed(wait=True)


class _Beside:
    """Figures that other processes are drawing."""

    def __init__(self, drawings: Mapping[str, Drawing], pool: Executor | None) -> None:
        self._drawings, self._pool = drawings, pool
        # Each process draws one figure and has another one waiting.
        self._most = 2 * workers_of(pool) if pool is not None else 0
        self._running: dict[str, Future[tuple[bytes, bytes]]] = {}

    def fill(self, waiting: list[str]) -> None:
        """Move figures from the end of a list to the processes, but not the last."""
        while len(self._running) < self._most and len(waiting) > 1:
            name = waiting[-1]
            try:
                assert self._pool is not None
                self._running[name] = self._pool.submit(self._drawings[name].files)
            except (RuntimeError, OSError):
                # The processes have ended.
                self._most = 0
            else:
                waiting.pop()

    def completed(self, *, wait: bool = False) -> Iterator[tuple[str, tuple[bytes, bytes]]]:
        """Figures that are complete; with ``wait``, all."""
        for name, future in list(self._running.items()):
            if wait or future.done():
                del self._running[name]
                try:
                    files = future.result()
                except (BrokenProcessPool, pickle.PicklingError):
                    # A process was killed, for example for lack of memory.
                    files = self._drawings[name].files()
                yield name, files
