"""Executors for the batches of a sweep: threads, processes, and the workers of a dask scheduler."""

from __future__ import annotations

import logging
import multiprocessing
import os
import re
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any, Final
from weakref import WeakKeyDictionary

from .. import __version__
from ..errors import InputError, short_repr, unknown_name_error
from ..threads import Threads
from ..validation.numbers import worker_count

POOLS: Final = ("threads", "processes")
# Address of a scheduler: scheme, host and port.
ADDRESS: Final = re.compile(r"(tcp|tls|ws|wss|ucx)://(\[[^]/]+\]|[^:/\[\]]+):\d{1,5}/?")
# Seconds after which a scheduler counts as unreachable.
PATIENCE: Final = 5.0
# Workers per processor of this machine, assumed for executors that were not made here.
USUAL_WORKERS: Final = 2

_numbers_of_workers: WeakKeyDictionary[Executor, int] = WeakKeyDictionary()


def workers_of(pool: Executor) -> int:
    """Number of workers of an executor; a guess for executors that were not made here."""
    return _numbers_of_workers.get(pool) or USUAL_WORKERS * worker_count("workers", None)


@contextmanager
def local_pool(kind: str = "threads", workers: int | None = None) -> Iterator[Executor]:
    """Provide a pool of threads or processes on this machine for a ``with`` block.

    Threads are the default: the compiled kernels run in parallel, and threads start immediately.
    Processes are faster if most of the time is spent in Python, as in sweeps of theories only.

    Parameters
    ----------
    kind : str
        ``"threads"`` or ``"processes"``.
    workers : int, optional
        Number of threads or processes; by default, one per processor.

    Yields
    ------
    concurrent.futures.Executor

    Raises
    ------
    InputError
        If the kind is unknown, or the number of workers is below one.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.sweeps.executors import local_pool
    >>> with local_pool(workers=2) as pool:
    ...     pool.submit(abs, -1).result()
    1
    """
    if kind not in POOLS:
        raise unknown_name_error("pool", kind, POOLS)
    count = worker_count("workers", workers)
    with _threads(count) if kind == "threads" else _processes(count) as pool:
        _numbers_of_workers[pool] = count
        yield pool


@contextmanager
def _threads(count: int) -> Iterator[Executor]:
    pool = Threads(count)
    try:
        yield pool
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _processes(count: int) -> Iterator[Executor]:
    # A fork would copy locks of threads in any state.
    context = multiprocessing.get_context("spawn")
    # Workers end when the other end of this pipe is closed: here, or with this process.
    # `multiprocessing.Event.set` would wait forever for a waiting process that was killed.
    reader, writer = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(
        count, mp_context=context, initializer=_end_with, initargs=(reader,)
    )  # fmt: skip
    try:
        yield pool
    except BaseException:
        # No one needs the results of the batches that are being computed.
        writer.close()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
        writer.close()
        reader.close()


def _end_with(pipe: Connection) -> None:
    """Make a worker process ignore interrupts and end when the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def wait() -> None:
        pipe.poll(None)
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


@contextmanager
def dask_pool(address: str, *, workers: int = 1) -> Iterator[Executor]:
    """Provide the workers of a running dask scheduler for a ``with`` block.

    Parameters
    ----------
    address : str
        Such as ``tcp://127.0.0.1:8786``.
    workers : int
        Number of workers that must have connected to the scheduler, at most a few seconds after
        the call.

    Yields
    ------
    concurrent.futures.Executor

    Raises
    ------
    InputError
        If distributed is not installed, the scheduler does not answer within seconds, it has too
        few workers, or a worker has another version of hertzchain.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.sweeps.executors import dask_pool
    >>> try:
    ...     with dask_pool("no address"):
    ...         pass
    ... except hc.InputError as error:
    ...     print(error)
    a scheduler's address looks like tcp://127.0.0.1:8786, got 'no address'
    """
    try:
        from distributed import Security
    except ImportError:
        raise InputError(
            "a dask scheduler needs the package distributed: pip install '.[cluster]' in the "
            "folder of the source code"
        ) from None
    # For an invalid address, dask would show a second, long error at exit.
    if not isinstance(address, str) or not ADDRESS.fullmatch(address):
        raise InputError(
            f"a scheduler's address looks like tcp://127.0.0.1:8786, got {short_repr(address)}"
        )
    secured = Security().get_connection_args("client").get("ssl_context")  # type: ignore[no-untyped-call]
    if address.startswith("tls:") and not secured:
        raise InputError(
            f"{address} needs certificates: name them in dask's configuration, distributed.comm.tls"
        )
    with _silenced("distributed.client"), _client(address) as client:
        threads = _wait_for(client, workers, address)
        _check_versions(client.run(_version_here))
        with client.get_executor(pure=False) as pool:
            _numbers_of_workers[pool] = threads
            yield pool


@contextmanager
def _silenced(name: str) -> Iterator[None]:
    """Silence a log: the sweep itself raises an error if the scheduler ends."""
    log = logging.getLogger(name)
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        log.setLevel(level)


@contextmanager
def _client(address: str) -> Iterator[Any]:
    from distributed import Client

    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        raise InputError(
            f"no dask scheduler answers at {address!r} within {PATIENCE:g} s ({error}): check that "
            "it runs there (dask scheduler --host 127.0.0.1 --port 8786), the port, and firewalls "
            "between"
        ) from None
    try:
        yield client
    finally:
        client.close()  # type: ignore[no-untyped-call]


def _wait_for(client: Any, workers: int, address: str) -> int:
    """Wait until there are enough workers, and return the number of threads of all of them."""
    try:
        client.wait_for_workers(workers, timeout=PATIENCE)
    except TimeoutError:
        raise InputError(
            f"the dask scheduler at {address!r} has {len(client.nthreads())} workers, but "
            f"{workers} are needed: start more (dask worker {address} --nthreads 1)"
        ) from None
    return int(sum(client.nthreads().values()))


def _version_here() -> str:
    """Version of hertzchain on this machine; the text of the error if it cannot be imported."""
    try:
        from .. import __version__ as version
    except ImportError as error:
        return str(error)
    return version


def _check_versions(by_worker: dict[str, str]) -> None:
    for worker, version in by_worker.items():
        check_version(version, f"worker {worker}")


def check_version(version: str, who: str) -> None:
    """Raise `InputError` for a worker with another version of hertzchain."""
    if version != __version__:
        raise InputError(
            f"{who} has hertzchain {version}, this is {__version__}: install the same version "
            "everywhere"
        )
