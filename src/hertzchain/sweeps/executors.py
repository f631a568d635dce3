"""Where batches are computed: threads here, processes here, a dask scheduler anywhere."""

from __future__ import annotations

import logging
import multiprocessing
import multiprocessing.process
import os
import re
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, Final

from hertzchain import __version__
from hertzchain.checks import worker_count
from hertzchain.errors import InputError, shown, unknown_name

POOLS: Final = ("threads", "processes")
# Of a scheduler: scheme, host and port.
ADDRESS: Final = re.compile(r"(tcp|tls|ws|wss|ucx)://(\[[^]/]+\]|[^:/\[\]]+):\d{1,5}/?")
# Seconds until a scheduler counts as unreachable.
PATIENCE: Final = 5.0


@contextmanager
def local_pool(kind: str = "threads", workers: int | None = None) -> Iterator[Executor]:
    """A pool of this machine for the time of a ``with`` block.

    Threads are the default: the compiled kernels let go of the interpreter, and threads start at
    once.  Processes pay where most of the time is Python's own, as in sweeps of theories alone.

    Parameters
    ----------
    kind : str
        ``"threads"`` or ``"processes"``.
    workers : int, optional
        How many; by default, one for each processor.

    Yields
    ------
    concurrent.futures.Executor

    Raises
    ------
    InputError
        For an unknown kind, or fewer than one worker.

    Examples
    --------
    >>> with local_pool(workers=2) as pool:
    ...     pool.submit(abs, -1).result()
    1
    """
    if kind not in POOLS:
        raise unknown_name("pool", kind, POOLS)
    count = worker_count("workers", workers)
    pool: Executor
    if kind == "threads":
        pool = ThreadPoolExecutor(count)
    else:
        # A fork would copy the threads' locks in whatever state they are.
        context = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(count, mp_context=context, initializer=_serve)
    try:
        yield pool
    except BaseException:
        # Nobody waits for what they compute.
        end_processes(pool)
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _serve() -> None:
    """A worker process leaves interrupts to its parent, and ends with it, however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


def lost_a_process(pool: Executor) -> bool:
    """Whether a pool of processes has lost one of them.

    Parameters
    ----------
    pool : concurrent.futures.Executor
        Any executor.

    Returns
    -------
    bool

    Examples
    --------
    >>> with local_pool() as pool:
    ...     lost_a_process(pool)
    False
    """
    return any(process.exitcode for process in _processes(pool))


def end_processes(pool: Executor) -> None:
    """Kill the workers of a pool of processes, whose futures then break; nothing in any other.

    A worker that is killed while it sends a result leaves half of it, for the rest of which the
    pool would wait forever: it holds a writing end of its own pipe.

    Parameters
    ----------
    pool : concurrent.futures.Executor
        Any executor.

    Examples
    --------
    >>> with local_pool() as pool:
    ...     end_processes(pool)
    ...     pool.submit(abs, -1).result()
    1
    """
    for process in _processes(pool):
        process.kill()
    if isinstance(pool, ProcessPoolExecutor):
        # There is no public way to its pipe.
        writer = getattr(getattr(pool, "_result_queue", None), "_writer", None)
        if writer is not None:
            writer.close()


def _processes(pool: Executor) -> list[multiprocessing.process.BaseProcess]:
    known = getattr(pool, "_processes", None) if isinstance(pool, ProcessPoolExecutor) else None
    return list((known or {}).values())


@contextmanager
def dask_pool(address: str, *, workers: int = 1) -> Iterator[Executor]:
    """The workers of a running dask scheduler for the time of a ``with`` block.

    Parameters
    ----------
    address : str
        Such as ``tcp://127.0.0.1:8786``.
    workers : int
        So many must be there, or come within seconds, before anything is computed.

    Yields
    ------
    concurrent.futures.Executor

    Raises
    ------
    InputError
        If distributed is not installed, the scheduler does not answer within seconds, has too
        few workers, or one with another version of the package.

    Examples
    --------
    >>> try:
    ...     with dask_pool("no address"):
    ...         pass
    ... except InputError as error:
    ...     print(error)
    a scheduler's address looks like tcp://127.0.0.1:8786, got 'no address'
    """
    try:
        from distributed import Security
    except ImportError:
        raise InputError(
            "a dask scheduler needs the package distributed: pip install 'hertzchain[cluster]'"
        ) from None
    # Of what cannot be an address, dask would complain at the end once more, for long.
    if not isinstance(address, str) or not ADDRESS.fullmatch(address):
        raise InputError(
            f"a scheduler's address looks like tcp://127.0.0.1:8786, got {shown(address)}"
        )
    secured = Security().get_connection_args("client").get("ssl_context")  # type: ignore[no-untyped-call]
    if address.startswith("tls:") and not secured:
        raise InputError(
            f"{address} needs certificates: name them in dask's configuration, distributed.comm.tls"
        )
    with _quiet("distributed.client"), _client(address) as client:
        threads = _wait_for(client, workers, address)
        _check_versions(client.run(_version_here))
        with client.get_executor(pure=False) as pool:
            pool.workers = threads
            yield pool


@contextmanager
def _quiet(name: str) -> Iterator[None]:
    """What becomes of a scheduler is told by the sweep, not by a log."""
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
    """Threads of all workers, once there are enough of these."""
    try:
        client.wait_for_workers(workers, timeout=PATIENCE)
    except TimeoutError:
        raise InputError(
            f"the dask scheduler at {address!r} has {len(client.nthreads())} workers, and needs "
            f"{workers}: start them (dask worker {address} --nthreads 1)"
        ) from None
    return int(sum(client.nthreads().values()))


def _version_here() -> str:
    """Version of the package where this runs; the words of the error if there is none."""
    try:
        from hertzchain import __version__ as version
    except ImportError as error:
        return str(error)
    return version


def _check_versions(by_worker: dict[str, str]) -> None:
    for worker, version in by_worker.items():
        check_version(version, f"worker {worker}")


def check_version(version: str, who: str) -> None:
    """Refuse what another version of the package computes.

    Parameters
    ----------
    version : str
        The version found.
    who : str
        Where.

    Raises
    ------
    InputError
        If it is not this one.

    Examples
    --------
    >>> check_version(__version__, "this process")
    """
    if version != __version__:
        raise InputError(
            f"{who} has hertzchain {version}, this is {__version__}: install the same everywhere"
        )
