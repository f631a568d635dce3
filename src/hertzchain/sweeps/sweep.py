"""Sweep: points in batches to an executor, results to a store or into memory."""

from __future__ import annotations

import math
import os
import shutil
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hertzchain import __version__
from hertzchain.arguments import callback, file_path, instance, listed, truth
from hertzchain.checks import whole_number, worker_count
from hertzchain.errors import InputError, StoreError, shown
from hertzchain.store.sweep_store import SweepStore, locked, plain_text
from hertzchain.sweeps.checking import check_plan
from hertzchain.sweeps.dataset import attributes_of, bytes_of, columns_of, variables_of
from hertzchain.sweeps.executors import (
    check_version,
    end_processes,
    local_pool,
    lost_a_process,
)
from hertzchain.sweeps.plan import Plan
from hertzchain.sweeps.reading import read_specification, specification_from_json
from hertzchain.sweeps.specification import differences
from hertzchain.sweeps.work import Result, run_batch, run_planned

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[int, int], None]

# Batches that wait for each worker, so that none waits for us.
AHEAD: Final = 2
# So often an interrupt is heard and progress told, in seconds.
POLL: Final = 0.1
# So often a pool is seen without one of its workers before it is given up.
LOST: Final = 10
# A batch is timed for an estimate if it takes at most so long, in seconds.
SAMPLE_SECONDS: Final = 5.0
# Part of the free disk that a sweep may fill.
FREE: Final = 0.95


@dataclass(frozen=True)
class Estimate:
    """What a sweep would take.

    Attributes
    ----------
    points, batches : int
        How many there are.
    bytes_on_disk : int
        Of all results, text left out and nothing compressed.
    seconds : float
        On this machine, from a few points that were timed.
    """

    points: int
    batches: int
    bytes_on_disk: int
    seconds: float


def sweep(
    specification: Any,
    store: str | os.PathLike[str] | None = None,
    *,
    executor: Executor | None = None,
    workers: int | None = None,
    shard: tuple[int, int] | None = None,
    skip_damaged: bool = False,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Compute the pulses of many chains, one for each point of a grid of parameters.

    Parameters
    ----------
    specification : path-like, mapping or Specification
        What varies, by which methods, what is kept: `hertzchain.sweeps.specification`.
    store : path-like, optional
        Zarr folder for the results.  If it holds a part of this sweep, only what is missing is
        computed.  Without it results are in memory alone.
    executor : concurrent.futures.Executor, optional
        Where batches are computed; by default, threads of this machine.
    workers : int, optional
        Number of threads, if there is no executor; by default, one for each processor.
    shard : tuple of int, optional
        ``(i, n)``: compute the i-th of n parts alone, i = 1..n, into a store of its own;
        `merge_sweeps` joins them.
    skip_damaged : bool
        Compute batches of the store again if one of their files is damaged; by default a damaged
        file is an error.
    progress : callable, optional
        Called as ``progress(points_done, points)`` a few times a second.

    Returns
    -------
    xarray.Dataset
        One dimension for each axis, then ``by`` (the method) and ``bead``.  Chains may differ
        in length: beside the shorter there is NaN.  ``status`` is 0 where a point is missing,
        1 where it is done, 2 where it failed, with its ``reason``.

    Raises
    ------
    InputError
        For anything in the specification that cannot be used, or a store that is not of this
        sweep, is in use, damaged or too large for the disk.
    hertzchain.StoreError
        If the disk is full or a worker has ended; what is in the store stays good.

    Examples
    --------
    >>> import hertzchain as hc
    >>> found = hc.sweep({
    ...     "chain": {"taper": "forward-exponential", "beads": 40},
    ...     "axes": {"rate": [0.02, 0.04, 0.06]},
    ...     "sweep": {"methods": ["propagate", "bca"], "at": "last"},
    ... })
    >>> found.velocity.sel(by="bca").values.round(2)
    array([ 3.13,  9.27, 26.05])
    """
    callback("progress", progress)
    skip_damaged = truth("skip_damaged", skip_damaged)
    if executor is not None:
        instance("executor", executor, Executor, "concurrent.futures has some")
    part = None
    if store is not None:
        file_path("store", store)
        part = _checked_shard(shard)
    elif shard is not None:
        raise InputError("a shard needs a store, which merge_sweeps joins with the others")
    plan = Plan(read_specification(specification))
    _check_room(plan, store)
    _check_memory(plan, executor, workers)
    check_plan(plan, _heading(specification))
    with ExitStack() as stack:
        pool = executor
        if pool is None:
            pool = stack.enter_context(local_pool("threads", workers))
        if store is None:
            return _in_memory(plan, pool, progress)
        stack.enter_context(locked(store))
        target = _opened(plan, store, skip_damaged)
        missing = _of_shard([int(batch) for batch in target.missing()], part)
        tell = _counted(plan, missing, progress, whole=part is None)
        for result in _results(plan, missing, pool, tell):
            target.write(result.batch, plan.region(result.batch), columns_of(plan, result))
        return target.open()


def estimate(specification: Any, *, workers: int | None = None) -> Estimate:
    """What a sweep would take, from its specification and a few points that are timed.

    Parameters
    ----------
    specification : path-like, mapping or Specification
        As of `sweep`.
    workers : int, optional
        Number of threads; by default, one for each processor.

    Returns
    -------
    Estimate

    Raises
    ------
    InputError
        As `sweep`.

    Examples
    --------
    >>> estimate({"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40, 60]}}).points
    3
    """
    count = worker_count("workers", workers)
    spec = read_specification(specification)
    plan = Plan(spec)
    check_plan(plan, _heading(specification))
    size = bytes_of(plan)
    # The first point alone compiles, another is timed; a whole batch if that is soon done.
    alone = Plan(replace(spec, batch=1))
    _timed(alone, 0)
    each = _timed(alone, alone.batches // 2)
    batch = plan.batches // 2
    size_of_batch = sum(1 for _ in plan.indices(batch))
    if each * size_of_batch < SAMPLE_SECONDS:
        each = _timed(plan, batch) / size_of_batch
    seconds = each * plan.points / count
    return Estimate(plan.points, plan.batches, size, seconds)


def merge_sweeps(
    stores: Sequence[str | os.PathLike[str]],
    into: str | os.PathLike[str],
    *,
    skip_damaged: bool = False,
) -> tuple[xr.Dataset, int]:
    """Join the stores of the shards of one sweep.

    Parameters
    ----------
    stores : list of path-like
        Stores of one specification.
    into : path-like
        Store for all of it: none yet, or of the same sweep.
    skip_damaged : bool
        Whether to leave out batches with damaged files, with a `DamageWarning`; by default a
        damaged file is an error.

    Returns
    -------
    dataset : xarray.Dataset
        All that they hold.
    missing : int
        Points that none of them has yet.

    Raises
    ------
    InputError
        If a store is not of the same sweep, or is damaged.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> axes = {"beads": list(range(10, 50))}
    >>> spec = {"chain": {"taper": "uniform"}, "axes": axes, "sweep": {"at": "last"}}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     parts = [Path(folder) / "a", Path(folder) / "b"]
    ...     for i, part in enumerate(parts, start=1):
    ...         _ = hc.sweep(spec, part, shard=(i, 2))
    ...     found, missing = hc.merge_sweeps(parts, Path(folder) / "all")
    ...     missing, bool((found.status == 1).all())
    (0, True)
    """
    paths = [file_path("store", each) for each in listed("stores", stores, "paths")]
    file_path("store to merge into", into)
    if not paths:
        raise InputError("there are no stores to merge: name those of the shards")
    skip_damaged = truth("skip_damaged", skip_damaged)
    parts = [SweepStore(path, skip_damaged=skip_damaged) for path in paths]
    text = parts[0].specification
    for part in parts:
        _check_same(part, text, f"the store {os.fspath(part.folder)!r}")
        part.check()
    plan = Plan(specification_from_json(text))
    _check_room(plan, into)
    with locked(into):
        target = _opened(plan, into, skip_damaged)
        for part in parts:
            done = set(range(plan.batches)) - {int(batch) for batch in part.missing()}
            for batch in sorted(done & {int(batch) for batch in target.missing()}):
                target.copy_batch(part, batch)
        return target.open(), target.counts()["missing"]


def open_sweep(store: str | os.PathLike[str], *, skip_damaged: bool = False) -> xr.Dataset:
    """What the store of a sweep holds, also while the sweep runs.

    Parameters
    ----------
    store : path-like
        The store.
    skip_damaged : bool
        Whether batches with damaged files count as missing, with a `DamageWarning`; all files
        are then read once.  By default a damaged file is an error.

    Returns
    -------
    xarray.Dataset
        As of `sweep`; values are read, and compared with their digests, when they are used.

    Raises
    ------
    InputError
        If there is none, what is there is no sweep, or a file is missing.  Later, if a file from
        which values are read is damaged, or is that of another batch.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = hc.sweep(spec, Path(folder) / "sweep")
    ...     hc.open_sweep(Path(folder) / "sweep").sizes["bead"]
    40
    """
    skip_damaged = truth("skip_damaged", skip_damaged)
    return SweepStore(file_path("store", store), skip_damaged=skip_damaged).open()


def _opened(plan: Plan, folder: str | os.PathLike[str], skip_damaged: bool) -> SweepStore:
    """The store of this sweep: the one that is there, or a new one."""
    if Path(folder).exists():
        store = SweepStore(folder, skip_damaged=skip_damaged)
        _check_same(store, plan.specification.as_json(), f"the store {os.fspath(folder)!r}")
        store.check()
        store.clean()
        return store
    return SweepStore.create(folder, variables_of(plan), attributes_of(plan))


def _check_room(plan: Plan, folder: str | os.PathLike[str] | None) -> None:
    """Refuse a sweep that does not fit on the disk, or without a store into memory."""
    size = bytes_of(plan)
    if folder is None:
        import psutil

        free, where, other = psutil.virtual_memory().available, "there are", "give a store"
        what = "GB of memory free"
    # A name that is too long is no error yet, as it would be to pathlib.
    elif os.path.exists(folder):  # noqa: PTH110
        return
    else:
        parent = next(p for p in Path(folder).absolute().parents if os.path.exists(p))  # noqa: PTH110
        free, where, other = shutil.disk_usage(parent).free, f"{parent} has", "another place"
        what = "GB free"
    if size > FREE * free:
        raise InputError(
            f"the sweep needs {size / 1e9:.3g} GB for {plan.points} points, but {where} "
            f"{free / 1e9:.3g} {what}: keep fewer quantities, at = 'last', or {other}"
        )


def _check_memory(plan: Plan, executor: Executor | None, workers: int | None) -> None:
    """Refuse batches that do not fit into memory, those of all threads together."""
    import psutil

    count = worker_count("workers", workers) if executor is None else 1
    size, free = count * plan.bytes_held, psutil.virtual_memory().available
    if size > FREE * free:
        raise InputError(
            f"{count} batches of {math.prod(plan.block)} points of {plan.longest} beads need about "
            f"{size / 1e9:.3g} GB of memory at a time, and {free / 1e9:.3g} GB are free: use a "
            "smaller batch, fewer workers or shorter chains"
        )


def _check_same(store: SweepStore, text: str, what: str) -> None:
    found = differences(store.specification, text)
    if found:
        raise InputError(
            f"{what} is of another specification; move it away or choose another store. It has"
            + "".join(f"\n  {line}" for line in found)
        )
    version = store.attributes.get("hertzchain_version", "of unknown version")
    if version != __version__:
        raise InputError(
            f"{what} was begun by hertzchain {version}, this is {__version__}: go on with that "
            "version, or choose another store"
        )


def _checked_shard(shard: Any) -> tuple[int, int] | None:
    if shard is None:
        return None
    parts = listed("shard", shard, "two whole numbers")
    if len(parts) != 2:
        raise InputError(f"shard must be two whole numbers, such as (1, 4), got {shown(shard)}")
    i, n = (whole_number("shard", part, least=1) for part in parts)
    if not 1 <= i <= n:
        raise InputError(f"shard {i} of {n} does not exist: they are numbered 1 to {n}")
    return i, n


def _of_shard(batches: list[int], shard: tuple[int, int] | None) -> list[int]:
    if shard is None:
        return batches
    return [batch for batch in batches if batch % shard[1] == shard[0] - 1]


def _counted(
    plan: Plan, batches: list[int], progress: Progress | None, *, whole: bool = True
) -> Callable[[int | None], None]:
    """Tells progress in points; of the whole sweep, or of these batches alone."""
    sizes = {batch: math.prod(s.stop - s.start for s in plan.region(batch)) for batch in batches}
    left = sum(sizes.values())
    total = plan.points if whole else left

    def tell(batch: int | None) -> None:
        nonlocal left
        left -= 0 if batch is None else sizes[batch]
        if progress is not None:
            progress(total - left, total)

    return tell


def _results(
    plan: Plan, batches: list[int], pool: Executor, tell: Callable[[int | None], None]
) -> Iterator[Result]:
    """Results as they are finished; a few batches for each worker are under way."""
    waiting, stop = iter(batches), threading.Event()
    submit: Callable[[int], Future[Result]]
    if isinstance(pool, ThreadPoolExecutor):
        submit = lambda batch: _submitted(pool, run_planned, plan, batch, stop.is_set)  # noqa: E731
    else:
        # What runs elsewhere ends with its batch.
        text = plan.specification.as_json()
        submit = lambda batch: _submitted(pool, run_batch, text, batch)  # noqa: E731
    running: set[Future[Result]] = set()
    left, ahead = len(batches), AHEAD * _workers_of(pool)
    try:
        tell(None)
        while left:
            for batch in waiting:
                running.add(submit(batch))
                if len(running) >= ahead:
                    break
            finished, running = _wait(running, pool)
            for future in finished:
                result = future.result()
                check_version(result.version, "a worker")
                left -= 1
                yield result
                tell(result.batch)
    except CancelledError:
        raise StoreError(
            f"the executor gave up with {left} of {len(batches)} batches to go (did its scheduler "
            "end?)"
        ) from None
    except BrokenExecutor:
        raise StoreError(
            f"a worker process ended abruptly with {left} of {len(batches)} batches to go (killed, "
            "or out of memory?)"
        ) from None
    finally:
        stop.set()
        for future in running:
            future.cancel()


def _submitted(pool: Executor, function: Callable[..., Result], *arguments: Any) -> Future[Result]:
    try:
        return pool.submit(function, *arguments)
    except BrokenExecutor:
        raise
    except RuntimeError as error:
        raise InputError(f"the executor takes no work ({error}): give one that runs") from None


def _wait(
    running: set[Future[Result]], pool: Executor
) -> tuple[set[Future[Result]], set[Future[Result]]]:
    lost = 0
    while True:
        finished, others = wait(running, timeout=POLL, return_when=FIRST_COMPLETED)
        if finished:
            return finished, others
        # A pool soon finds out by itself that a worker is gone, but not always.
        lost += lost_a_process(pool)
        if lost > LOST:
            end_processes(pool)


def _workers_of(pool: Executor) -> int:
    known = getattr(pool, "workers", None) or getattr(pool, "_max_workers", None)
    return int(known or 2 * worker_count("workers", None))


def _in_memory(plan: Plan, pool: Executor, progress: Progress | None) -> xr.Dataset:
    import xarray as xr

    variables = variables_of(plan)
    arrays: dict[str, Any] = {}
    for name, variable in variables.items():
        text = np.dtypes.StringDType()
        empty = np.full(variable.shape, "", text) if variable.dtype == "str" else None
        fill = np.nan if variable.dtype == "f8" else 0
        arrays[name] = np.full(variable.shape, fill, variable.dtype) if empty is None else empty
        if variable.values is not None:
            arrays[name] = variable.values
    batches = list(range(plan.batches))
    tell = _counted(plan, batches, progress)
    for result in _results(plan, batches, pool, tell):
        region = plan.region(result.batch)
        sizes = tuple(part.stop - part.start for part in region)
        for name, values in columns_of(plan, result).items():
            target = arrays[name]
            target[region] = np.asarray(values).reshape(sizes + target.shape[len(region) :])
    columns = {
        name: (variable.dimensions, arrays[name], dict(variable.attributes))
        for name, variable in variables.items()
    }
    kept = {name: column for name, column in columns.items() if variables[name].values is None}
    coordinates = {name: column for name, column in columns.items() if name not in kept}
    return plain_text(xr.Dataset(kept, coords=coordinates, attrs=attributes_of(plan)))


def _timed(plan: Plan, batch: int) -> float:
    begun = time.perf_counter()
    run_planned(plan, batch, lambda: False)
    return time.perf_counter() - begun


def _heading(given: Any) -> str:
    return f"{os.fspath(given)}: " if isinstance(given, str | os.PathLike) else ""
