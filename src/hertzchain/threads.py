"""Compute parts of a task in threads, with progress, until they are done or interrupted."""

from __future__ import annotations

from collections.abc import Callable, Sequence, Sized
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextvars import copy_context
from typing import Any, Final, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from .validation.objects import Progress

Signal: TypeAlias = NDArray[np.int64]
# Entries of the array with which a part is stopped and counts the items it has done.
STOP, COUNT = 0, 1
# Time between two reports of progress [s]; an interrupt is handled in this time.
POLL: Final = 0.1

P = TypeVar("P", bound=Sized)
R = TypeVar("R")


class Threads(ThreadPoolExecutor):
    """Threads in which warnings are recorded or ignored as where the work was submitted."""

    def submit(self, work: Callable[..., Any], /, *args: Any, **options: Any) -> Future[Any]:
        """Call ``work`` with a copy of the context of the caller."""
        return super().submit(copy_context().run, work, *args, **options)


def run_in_threads(
    parts: Sequence[P],
    compute: Callable[[P, Signal], R],
    store: Callable[[P, R], None],
    *,
    threads: int,
    of: str,
    total: int,
    done: int = 0,
    counted: bool = True,
    progress: Progress | None = None,
) -> None:
    """Compute all parts, and store each result in this thread.

    Progress is the number of items, such as "chains" (``of``), of the parts that are stored, and
    if ``counted`` what the others have counted in their signals.  If the work is interrupted, or
    a part fails, the signals stop all other parts.
    """
    signals = [np.zeros(2, np.int64) for _ in parts]
    running: dict[Future[R], tuple[P, Signal]] = {}
    executor = Threads(threads)

    def so_far() -> int:
        ahead = sum(min(int(signal[COUNT]), len(part)) for part, signal in running.values())
        return done + ahead if counted else done

    try:
        for part, signal in zip(parts, signals, strict=True):
            running[executor.submit(compute, part, signal)] = part, signal
        while running:
            finished, _ = wait(running, timeout=POLL, return_when=FIRST_COMPLETED)
            for future in finished:
                part, _ = running.pop(future)
                store(part, future.result())
                done += len(part)
            if progress is not None:
                progress(so_far(), total)
    except BaseException as error:
        for signal in signals:
            signal[STOP] = 1
        error.add_note(f"stopped after {so_far()} of {total} {of}")
        raise
    finally:
        executor.shutdown(wait=True, cancel_futures=True)
