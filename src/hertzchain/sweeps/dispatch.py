"""Send the batches of a sweep to the workers of an executor, and collect their results.

Threads share memory with the sweep.  Processes of this machine return results through files.
All other executors, such as the workers of a dask scheduler, exchange messages.
"""

from __future__ import annotations

import pickle
import re
import tempfile
import threading
import traceback
from collections.abc import Generator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, Final, Protocol

from ..errors import InputError, StoreError
from ..store.writing import cannot_write
from .batches import Result, run_batch, run_planned
from .executors import check_version
from .plan import Plan
from .specification import specification_from_json

# Batches submitted per worker; with fewer, a worker might have to wait for the next one.
AHEAD: Final = 2
# Seconds between checks for an interrupt, where waiting cannot be interrupted (Windows).
POLL: Final = 0.1
# Seconds to wait until batches have stopped, before their files are removed.
STOP_SECONDS: Final = 1.0
# Names of the folder and the files through which worker processes return results.
FOLDER_SUFFIX: Final = ".results"
RESULT_SUFFIX: Final = ".result"
SPECIFICATION_FILE: Final = "specification.json"


def results_of(
    plan: Plan, batches: Sequence[int], pool: Executor, workers: int, store: Path | None = None
) -> Generator[Result]:
    """Compute batches on an executor, and yield each result as soon as it is complete.

    Worker processes of this machine return results through files next to the store, or in the
    folder for temporary files if there is no store.
    """
    waiting = iter(batches)
    running: set[Future[Any]] = set()
    left, ahead = len(batches), AHEAD * workers
    exchange = _exchange(plan, pool, store)
    try:
        while left:
            for batch in waiting:
                running.add(_submitted(exchange, batch))
                if len(running) >= ahead:
                    break
            finished, running = _wait(running)
            for future in finished:
                result = exchange.result(future)
                check_version(result.version, "a worker")
                left -= 1
                yield result
    except CancelledError:
        raise StoreError(
            f"the executor stopped with {left} of {len(batches)} batches missing (did its "
            "scheduler end?)"
        ) from None
    except BrokenExecutor:
        raise StoreError(
            f"a worker process ended abruptly with {left} of {len(batches)} batches missing "
            "(killed, or out of memory?)"
        ) from None
    finally:
        for future in running:
            future.cancel()
        exchange.close(running)


def _submitted(exchange: _Exchange, batch: int) -> Future[Any]:
    try:
        return exchange.submit(batch)
    except BrokenExecutor:
        raise
    except RuntimeError as error:
        raise InputError(
            f"the executor does not accept work ({error}); pass a running executor"
        ) from None


def _wait(running: set[Future[Any]]) -> tuple[set[Future[Any]], set[Future[Any]]]:
    while True:
        finished, others = wait(running, timeout=POLL, return_when=FIRST_COMPLETED)
        if finished:
            return finished, others


class _Exchange(Protocol):
    """How a batch reaches a worker, and how its result returns."""

    def submit(self, batch: int) -> Future[Any]: ...

    def result(self, future: Future[Any]) -> Result: ...

    def close(self, running: set[Future[Any]]) -> None: ...


def _exchange(plan: Plan, pool: Executor, store: Path | None) -> _Exchange:
    if isinstance(pool, ThreadPoolExecutor):
        return _Memory(plan, pool)
    if isinstance(pool, ProcessPoolExecutor):
        return _Files(plan, pool, store)
    return _Messages(plan, pool)


class _Memory:
    """Threads share the plan, and return results in memory."""

    def __init__(self, plan: Plan, pool: Executor) -> None:
        self._plan, self._pool, self._stop = plan, pool, threading.Event()

    def submit(self, batch: int) -> Future[Result]:
        return self._pool.submit(run_planned, self._plan, batch, self._stop.is_set)

    def result(self, future: Future[Result]) -> Result:
        return future.result()

    def close(self, running: set[Future[Any]]) -> None:
        del running
        self._stop.set()


class _Messages:
    """Workers anywhere get the specification and return results through their executor."""

    def __init__(self, plan: Plan, pool: Executor) -> None:
        self._specification, self._pool = plan.specification.as_json(), pool

    def submit(self, batch: int) -> Future[Result]:
        return self._pool.submit(run_batch, self._specification, batch)

    def result(self, future: Future[Result]) -> Result:
        return future.result()

    def close(self, running: set[Future[Any]]) -> None:
        """Batches elsewhere cannot be stopped: each runs to its end, and its result is lost."""


class _Files:
    """Processes of this machine read the specification from a file, and write results to files.

    A process that is killed while it sends a long message leaves a part of it in the pipe, and
    `ProcessPoolExecutor` then waits for the rest indefinitely.  A name is so short that the
    operating system transfers it as a whole or not at all.
    """

    def __init__(self, plan: Plan, pool: Executor, store: Path | None) -> None:
        self._pool = pool
        prefix = "hertzchain." if store is None else f".{store.name}."
        parent = None if store is None else store.parent
        if store is not None:
            # A process that was killed could not remove its folder, whose name is from mkdtemp.
            name = re.compile(rf"{re.escape(prefix)}\w{{8}}{re.escape(FOLDER_SUFFIX)}")
            for folder in store.parent.iterdir():
                if name.fullmatch(folder.name) and not folder.is_symlink():
                    _remove(folder)
        try:
            self._folder = Path(tempfile.mkdtemp(FOLDER_SUFFIX, prefix, parent))
            file = self._folder / SPECIFICATION_FILE
            file.write_text(plan.specification.as_json(), "utf-8")
        except OSError as error:
            raise cannot_write(parent or tempfile.gettempdir(), error) from None

    def submit(self, batch: int) -> Future[str]:
        return self._pool.submit(run_into_file, str(self._folder), batch)

    def result(self, future: Future[str]) -> Result:
        try:
            file = self._folder / future.result()
            outcome = pickle.loads(file.read_bytes())
            file.unlink()
        except OSError as error:
            raise cannot_write(self._folder, error) from None
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    def close(self, running: set[Future[Any]]) -> None:
        # Workers stop when there is no specification.
        with suppress(OSError):
            (self._folder / SPECIFICATION_FILE).unlink()
        wait([each for each in running if not each.cancelled()], timeout=STOP_SECONDS)
        _remove(self._folder)


def _remove(folder: Path) -> None:
    """Remove a folder of results, unless it has files of other names."""
    with suppress(OSError):
        for file in folder.glob(f"*{RESULT_SUFFIX}"):
            file.unlink()
        (folder / SPECIFICATION_FILE).unlink(missing_ok=True)
        folder.rmdir()


def run_into_file(folder: str, batch: int) -> str:
    """Compute one batch in a worker process; write the result, or the error, to a file."""
    specification = Path(folder, SPECIFICATION_FILE)
    outcome: Result | Exception
    try:
        outcome = run_planned(_plan_in(specification), batch, lambda: not specification.exists())
    except Exception as error:  # noqa: BLE001  (raised again where the file is read)
        error.add_note("".join(traceback.format_exception(error)))
        outcome = error
    file = Path(folder, f"{batch}{RESULT_SUFFIX}")
    file.write_bytes(pickle.dumps(outcome, pickle.HIGHEST_PROTOCOL))
    return file.name


@lru_cache(maxsize=4)
def _plan_in(file: Path) -> Plan:
    """Plan of a specification in a file whose name is used only once."""
    return Plan(specification_from_json(file.read_text("utf-8")))
