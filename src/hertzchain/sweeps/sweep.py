"""Compute, estimate, merge and open sweeps."""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from .. import __version__
from ..errors import InputError, short_repr
from ..representation import counted, in_bytes
from ..store.sweep_store import SweepStore, locked
from ..validation.keywords import checked_arguments
from ..validation.memory import check_memory
from ..validation.numbers import whole_number, worker_count
from ..validation.objects import Progress, callback, check_bool, check_list, check_type, file_path
from .dataset import (
    MemoryStore,
    attributes_of,
    batch_variables,
    bytes_of,
    columns_of,
    variables_of,
    warn_failures,
    warn_outside_range,
)
from .dispatch import results_of
from .executors import local_pool, workers_of
from .plan import Plan, check_plan
from .specification import read_specification, specification_from_json
from .timing import time_per_point

if TYPE_CHECKING:
    import xarray as xr

# Fraction of the free disk or memory that a sweep may use.
USABLE_PART: Final = 0.95
# Approximate number of files of a store without batches.
FILES_OF_METADATA: Final = 10


@dataclass(frozen=True)
class Estimate:
    """Estimated time and size of a sweep.

    Attributes
    ----------
    points, batches : int
        Number of points and of batches.
    bytes_on_disk : int
        Number of bytes of all results, without text and before compression.
    seconds : float
        Time on this machine, extrapolated from a few points.
    unfinished : bool
        Whether a timed point took so long that it was not finished: ``seconds`` is a lower bound.
    files : int
        Approximate number of files on disk.
    renamed : dict
        Name in the dataset of each axis whose own name is taken there.
    """

    points: int
    batches: int
    bytes_on_disk: int
    seconds: float
    unfinished: bool
    files: int
    renamed: dict[str, str]


@checked_arguments("sweep")
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
        Parameters that vary, methods and quantities to keep: `hertzchain.sweeps.specification`.
    store : path-like, optional
        Zarr folder for the results.  If it holds a part of this sweep, only the missing batches
        are computed.  Without it, results are in memory only.
    executor : concurrent.futures.Executor, optional
        Executor that computes the batches; by default, threads of this machine.
    workers : int, optional
        Number of threads; by default, one per processor.  With an executor, its number of workers:
        twice as many batches are submitted at a time.  It is known for `local_pool` and
        `dask_pool`; for other executors, two workers per processor of this machine are assumed.
    shard : tuple of int, optional
        ``(i, n)``: compute only the i-th of n parts, i = 1..n, into a separate store;
        `merge_sweeps` joins the stores.
    skip_damaged : bool
        Compute batches of the store again if one of their files is damaged; by default a damaged
        file is an error.
    progress : callable, optional
        Called as ``progress(points_done, points)`` a few times a second.

    Returns
    -------
    xarray.Dataset
        One dimension per axis, then ``approach`` (the method) and ``bead``.  Chains may differ in
        length: values are NaN beyond the last bead.  ``status`` is 0 where a point is missing, 1
        where it is done and 2 where it failed; ``reason`` states why.

    Raises
    ------
    InputError
        If the specification has errors, or if the store belongs to another sweep, is in use, is
        damaged or would be too large for the disk.
    hertzchain.StoreError
        If the disk is full or a worker has ended.  The batches in the store remain valid, and the
        same call resumes the sweep.

    Warns
    -----
    IncompleteWarning
        Once, if points failed, with their number and the reason of the first.
    ModelRangeWarning
        Once, if points of a sweep in SI units are outside the range of a method or of Hertz's law.

    Examples
    --------
    >>> import hertzchain as hc
    >>> found = hc.sweep({
    ...     "chain": {"taper": "forward-exponential", "beads": 40},
    ...     "axes": {"rate": [0.02, 0.04, 0.06]},
    ...     "sweep": {"methods": ["propagate", "bca"], "at": "last"},
    ... })
    >>> found.velocity.sel(approach="bca").values.round(2)
    array([ 3.13,  9.27, 26.05])
    """
    callback("progress", progress)
    skip_damaged = check_bool("skip_damaged", skip_damaged)
    count = worker_count("workers", workers)
    if executor is not None:
        check_type("executor", executor, Executor, "concurrent.futures has some")
        count = count if workers is not None else workers_of(executor)
    part = None
    if store is not None:
        file_path("store", store)
        part = _checked_shard(shard)
    elif shard is not None:
        raise InputError("a shard needs a store, which merge_sweeps joins with the others")
    plan = Plan(read_specification(specification))
    _check_room(plan, store)
    # The memory of other executors is not that of this machine.
    _check_memory(plan, count if executor is None else 1)
    check_plan(plan, _heading(specification))
    with ExitStack() as stack:
        pool = executor
        if pool is None:
            pool = stack.enter_context(local_pool("threads", count))
        target, batches, folder = _target(plan, store, skip_damaged, stack)
        batches = _of_shard(batches, part)
        report = _reporter(plan, batches, progress, whole=part is None)
        results = stack.enter_context(closing(results_of(plan, batches, pool, count, folder)))
        for result in results:
            target.write(result.batch, plan.region(result.batch), columns_of(plan, result))
            report(result.batch)
        found = target.open()
    warn_failures(found)
    if plan.units == "SI":
        warn_outside_range(found)
    return found


def _target(
    plan: Plan, store: str | os.PathLike[str] | None, skip_damaged: bool, stack: ExitStack
) -> tuple[MemoryStore | SweepStore, list[int], Path | None]:
    """Where results are written, the batches that it lacks, and its folder."""
    if store is None:
        return MemoryStore(variables_of(plan), attributes_of(plan)), [*range(plan.batches)], None
    stack.enter_context(locked(store))
    found = _opened(plan, store, skip_damaged)
    return found, [int(batch) for batch in found.missing()], Path(os.path.realpath(store))


def estimate(specification: Any, *, workers: int | None = None, store: Any = None) -> Estimate:
    """Estimate the time and size of a sweep from its specification and a few timed points.

    Parameters
    ----------
    specification : path-like, mapping or Specification
        As in `sweep`.
    workers, store : optional
        As in `sweep`; the store is not changed.

    Raises
    ------
    InputError
        As in `sweep`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.sweeps.sweep import estimate
    >>> estimate({"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40, 60]}}).points
    3
    """
    count = worker_count("workers", workers)
    spec = read_specification(specification)
    plan = Plan(spec)
    check_plan(plan, _heading(specification))
    if store is not None and os.path.exists(store):  # noqa: PTH110
        _check_same(SweepStore(store), spec.as_json(), f"the store {os.fspath(store)!r}")
    each = time_per_point(spec)
    seconds = each.seconds * plan.points / count
    # Each batch has a file of each variable and of its digest; one of reasons is rare.
    files = FILES_OF_METADATA + plan.batches * len(batch_variables(plan))
    names = zip(spec.axes, plan.names, strict=True)
    renamed = {axis.long_name: name for axis, name in names if name != axis.name}
    return Estimate(
        plan.points, plan.batches, bytes_of(plan), seconds, each.unfinished, files, renamed
    )


@checked_arguments("merge_sweeps")
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
        Stores of the same specification.
    into : path-like
        Store for the whole sweep: a new one, or one of the same sweep.
    skip_damaged : bool
        Whether to omit batches with damaged files, with a `DamageWarning`; by default a damaged
        file is an error.

    Returns
    -------
    dataset : xarray.Dataset
        Contents of all stores.
    missing : int
        Number of points that none of the stores has.

    Raises
    ------
    InputError
        If a store belongs to another sweep or is damaged.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> from pathlib import Path
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
    paths = [file_path("store", each) for each in check_list("stores", stores, "paths")]
    file_path("store to merge into", into)
    if not paths:
        raise InputError("there are no stores to merge: give the stores of the shards")
    skip_damaged = check_bool("skip_damaged", skip_damaged)
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


@checked_arguments("open_sweep")
def open_sweep(store: str | os.PathLike[str], *, skip_damaged: bool = False) -> xr.Dataset:
    """Open the store of a sweep, even while the sweep is running.

    Parameters
    ----------
    store : path-like
        The store.
    skip_damaged : bool
        Whether to treat batches with damaged files as missing, with a `DamageWarning`; all files
        are then read once.  By default a damaged file is an error.

    Returns
    -------
    xarray.Dataset
        As returned by `sweep`; values are read, and compared with their digests, when they are
        used.

    Raises
    ------
    InputError
        If the folder does not exist or is not a sweep, or if a file is missing.  Later, if a file
        from which values are read is damaged or belongs to another batch.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> from pathlib import Path
    >>> spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = hc.sweep(spec, Path(folder) / "sweep")
    ...     hc.open_sweep(Path(folder) / "sweep").sizes["bead"]
    40
    """
    skip_damaged = check_bool("skip_damaged", skip_damaged)
    return SweepStore(file_path("store", store), skip_damaged=skip_damaged).open()


def _opened(plan: Plan, folder: str | os.PathLike[str], skip_damaged: bool) -> SweepStore:
    """Open the store of this sweep, or create it."""
    if Path(folder).exists():
        store = SweepStore(folder, skip_damaged=skip_damaged)
        _check_same(store, plan.specification.as_json(), f"the store {os.fspath(folder)!r}")
        store.check()
        store.clean()
        return store
    return SweepStore.create(folder, variables_of(plan), attributes_of(plan))


def _check_room(plan: Plan, folder: str | os.PathLike[str] | None) -> None:
    """Raise `InputError` if the results do not fit on the disk, or into memory without a store."""
    size, advice = bytes_of(plan), "keep fewer quantities, at = 'last', or"
    if folder is None:
        what = f"the results of {counted(plan.points, 'point')}"
        check_memory(what, size, f"{advice} give a store", USABLE_PART)
        return
    # Path.exists raises OSError for a name that is too long.
    if os.path.exists(folder):  # noqa: PTH110
        return
    parent = next(p for p in Path(folder).absolute().parents if os.path.exists(p))  # noqa: PTH110
    free = shutil.disk_usage(parent).free
    if size > USABLE_PART * free:
        raise InputError(
            f"the results of {counted(plan.points, 'point')} need {in_bytes(size)}, but {parent} "
            f"has {in_bytes(free)} free; {advice} another place"
        )


def _check_memory(plan: Plan, workers: int) -> None:
    """Raise `InputError` if the batches of all workers together do not fit into memory."""
    check_memory(
        f"{workers} {'batch' if workers == 1 else 'batches'} of "
        f"{counted(math.prod(plan.block), 'point')} of {counted(plan.longest, 'bead')}",
        workers * plan.bytes_in_memory, "use a smaller batch, fewer workers or shorter chains",
        USABLE_PART,
    )  # fmt: skip


def _check_same(store: SweepStore, text: str, what: str) -> None:
    found = differences(store.specification, text)
    if found:
        raise InputError(
            f"{what} belongs to another specification; move it away or choose another store. "
            "Differences:" + "".join(f"\n  {line}" for line in found)
        )
    if store.version != __version__:
        raise InputError(
            f"{what} was begun by hertzchain {store.version}, this is {__version__}: use that "
            "version, or choose another store"
        )


def differences(one: str, other: str) -> list[str]:
    """List the differences between two specifications given as JSON text."""
    documents = [json.loads(text) for text in (one, other)]
    left, right = (dict(_leaves(document)) for document in documents)
    # The order of the axes matters: it is the order of the dimensions.
    for leaves, document in zip((left, right), documents, strict=True):
        leaves["axes"] = ", ".join(document.get("axes", {}))
    return [
        f"{path}: {left.get(path, 'nothing')!r}, now {right.get(path, 'nothing')!r}"
        for path in sorted(left.keys() | right.keys())
        if left.get(path) != right.get(path)
    ]


def _leaves(entry: Any, path: str = "") -> Any:
    if isinstance(entry, Mapping):
        for key, value in entry.items():
            yield from _leaves(value, f"{path}.{key}" if path else key)
    else:
        yield path, entry


def _checked_shard(shard: Any) -> tuple[int, int] | None:
    if shard is None:
        return None
    parts = check_list("shard", shard, "two whole numbers")
    if len(parts) != 2:
        raise InputError(f"shard must be two whole numbers such as (1, 4), got {short_repr(shard)}")
    i, n = (whole_number("shard", part, least=0) for part in parts)
    if not 1 <= i <= n:
        raise InputError(f"shard {i} of {n} does not exist: shards are numbered 1 to {n}")
    return i, n


def _of_shard(batches: list[int], shard: tuple[int, int] | None) -> list[int]:
    if shard is None:
        return batches
    return [batch for batch in batches if batch % shard[1] == shard[0] - 1]


def _reporter(
    plan: Plan, batches: list[int], progress: Progress | None, *, whole: bool
) -> Callable[[int], None]:
    """Report progress in points, of the whole sweep or of these batches only."""
    sizes = {batch: math.prod(s.stop - s.start for s in plan.region(batch)) for batch in batches}
    left = sum(sizes.values())
    total = plan.points if whole else left
    if progress is not None:
        progress(total - left, total)

    def report(batch: int) -> None:
        nonlocal left
        left -= sizes[batch]
        if progress is not None:
            progress(total - left, total)

    return report


def _heading(given: Any) -> str:
    return f"{os.fspath(given)}: " if isinstance(given, str | os.PathLike) else ""
