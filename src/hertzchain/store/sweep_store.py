"""The store of a sweep: a zarr folder with an array for each quantity, a chunk for each batch.

Any program that reads zarr reads it, while the sweep still runs.  A batch is written whole:
its data first, then its chunk of ``status``, then the digests of both, by which it counts as done
(`hertzchain.store.batch_files`).  Digests of all other files are attributes of the group.
Nothing in the store depends on when or by whom it was computed, so that a sweep that was
interrupted and resumed leaves the same bytes as one that was not.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import os
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from hertzchain.errors import DamageWarning, InputError, StoreError
from hertzchain.store.batch_files import DIGEST, TEMPORARY, BatchFiles
from hertzchain.store.damage import DamagedFileError
from hertzchain.store.lock import lock
from hertzchain.store.sweep_layout import (
    FILES,
    RESTORE,
    SEAL,
    STATUS,
    Variable,
    check_layout,
    create_store,
    grid_of,
)
from hertzchain.store.writing import cannot_write, replace_file, temporary_name

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[int, int], None]

# Of `status`: what it says, by its value.
MEANINGS: Final = ("missing", "done", "failed")
MISSING, DONE, FAILED = range(len(MEANINGS))


class SweepStore:
    """A store that exists.

    Parameters
    ----------
    folder : path-like
        Where it is.
    skip_damaged : bool
        Whether batches with damaged files count as missing, which gives a `DamageWarning`.
        Otherwise reading them is an error.

    Raises
    ------
    InputError
        If there is none, or what is there is no sweep, or damaged.
    """

    def __init__(self, folder: str | os.PathLike[str], *, skip_damaged: bool = False) -> None:
        import zarr

        self.folder = Path(folder)
        name = os.fspath(folder)
        _refuse_others(folder)
        if not os.path.isdir(folder):  # noqa: PTH112  (a name that is too long is no error)
            raise InputError(f"there is no sweep store {name!r}: it would be a folder")
        try:
            group: Any = zarr.open_group(self.folder, mode="r", zarr_format=3)
            self.attributes: dict[str, Any] = dict(group.attrs)
            check_layout(self.folder, self.attributes)
            self.files = self._batch_files(group)
            self.arrays: dict[str, Any] = self._checked_arrays()
            self.status = self.arrays[STATUS]
        except InputError:
            raise
        # Whatever zarr stumbles over in a file that is not as it was written.
        except Exception as error:  # noqa: BLE001
            reason = f"there is no {error}" if isinstance(error, KeyError) else error
            raise InputError(f"{name!r} is damaged ({reason}): {RESTORE}") from None
        if skip_damaged:
            self._skip_damaged()

    def _batch_files(self, group: Any) -> BatchFiles:
        names: list[str] = self.attributes["arrays"]
        by_batch = [name for name in names if group[name].attrs.get("by_batch")]
        arrays = {name: group[name] for name in by_batch if name != STATUS}
        arrays[STATUS] = status = group[STATUS]
        sweep = hashlib.sha256(f"{self._version}\0{self.specification}".encode()).hexdigest()
        return BatchFiles(self.folder, sweep, arrays, group[DIGEST],
                          grid_of(status.shape, status.chunks))  # fmt: skip

    def _checked_arrays(self) -> dict[str, Any]:
        """Arrays whose chunks are compared with their digests when they are read."""
        import zarr

        group: Any = zarr.open_group(self._checked_store(), mode="r+", zarr_format=3)
        # Every batch has a chunk of each array, except of `reason`: of reasons there are few.
        return {
            key: group[key].with_config({"write_empty_chunks": key != "reason"})
            for key in self.attributes["arrays"]
        }

    def _checked_store(self) -> Any:
        # zarr is loaded when a store is opened.
        from hertzchain.store.checked_store import checked_store

        return checked_store(self.files)

    def _skip_damaged(self) -> None:
        faults = self._faults(contents=True)
        self.files.skipped.update(faults)
        if faults:
            first = next(iter(faults.values()))
            batches = "1 batch is" if len(faults) == 1 else f"{len(faults)} batches are"
            warnings.warn(
                f"{os.fspath(self.folder)!r} is damaged: {batches} left out as missing, the first "
                f"since {os.fspath(first.file)} {first.how}",
                DamageWarning,
                stacklevel=4,
            )

    @classmethod
    def create(
        cls,
        folder: str | os.PathLike[str],
        variables: Mapping[str, Variable],
        attributes: Mapping[str, Any],
    ) -> SweepStore:
        """Make an empty store, whole or not at all.

        Parameters
        ----------
        folder : path-like
            Where it shall be; nothing may be there.
        variables : mapping of str to Variable
            Arrays by name, among them ``status``.
        attributes : mapping
            Of the dataset.

        Returns
        -------
        SweepStore

        Raises
        ------
        InputError
            If it cannot be made there.
        StoreError
            If the disk is full.

        Examples
        --------
        >>> import tempfile
        >>> status = Variable(("rate", "by"), (4, 1), (2, 1), "i1", {})
        >>> with tempfile.TemporaryDirectory() as parent:
        ...     store = SweepStore.create(Path(parent) / "sweep", {"status": status}, {})
        ...     store.missing().tolist()
        [0, 1]
        """
        create_store(folder, variables, attributes)
        return cls(folder)

    @property
    def specification(self) -> str:
        """JSON text of what is swept."""
        return str(self.attributes.get("specification", "{}"))

    @property
    def _version(self) -> str:
        return str(self.attributes.get("hertzchain_version", "of unknown version"))

    @property
    def grid(self) -> tuple[int, ...]:
        """Number of batches along each dimension."""
        return self.files.grid

    def missing(self) -> NDArray[np.int64]:
        """Numbers of the batches that are not done.

        Returns
        -------
        ndarray of int

        Raises
        ------
        InputError
            If files of a batch that is done are missing.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = hc.sweep(spec, Path(folder) / "sweep")
        ...     store = SweepStore(Path(folder) / "sweep")
        ...     store.missing()
        array([], dtype=int64)
        """
        self.check(contents=False)
        batches = range(self.files.number)
        return np.array([batch for batch in batches if not self.files.done(batch)], np.int64)

    def check(self, *, contents: bool = True, progress: Progress | None = None) -> None:
        """Compare the files of all batches with their digests.

        Parameters
        ----------
        contents : bool
            Whether to read the files; otherwise only see that they are there.
        progress : callable, optional
            Called as ``progress(batches_checked, batches)``.

        Raises
        ------
        InputError
            If a file is missing, damaged or from another place; it names the first.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = hc.sweep(spec, Path(folder) / "sweep")
        ...     SweepStore(Path(folder) / "sweep").check()
        """
        faults = self._faults(contents=contents, progress=progress)
        if faults:
            raise next(iter(faults.values())).among(len(faults))

    def _faults(
        self, *, contents: bool, progress: Progress | None = None
    ) -> dict[int, DamagedFileError]:
        """What is wrong with each damaged batch that is not skipped."""
        found = {}
        for batch in range(self.files.number):
            if batch not in self.files.skipped:
                fault = self.files.fault(batch, contents=contents)
                if fault is not None:
                    found[batch] = fault
            if progress is not None:
                progress(batch + 1, self.files.number)
        return found

    def write(self, batch: int, region: tuple[slice, ...], columns: Mapping[str, Any]) -> None:
        """Write a batch: data, then that it is done.

        Parameters
        ----------
        batch : int
            Its number.
        region : tuple of slice
            Where its points are.
        columns : mapping
            Values by name of the array, ``status`` among them.

        Raises
        ------
        StoreError
            If they cannot be written; the batch then counts as not done.

        Examples
        --------
        >>> import tempfile
        >>> status = Variable(("rate", "by"), (4, 1), (2, 1), "i1", {})
        >>> with tempfile.TemporaryDirectory() as parent:
        ...     store = SweepStore.create(Path(parent) / "sweep", {"status": status}, {})
        ...     store.write(0, (slice(0, 2),), {"status": [1, 1]})
        ...     store.missing()
        array([1])
        """
        if not (self.folder / STATUS / "zarr.json").is_file():
            raise StoreError(f"the store {os.fspath(self.folder)!r} was moved or removed meanwhile")
        try:
            self.files.forget(batch)
            # Other programs take a batch that has a status as done, we one that has digests:
            # whatever a power cut leaves, what they vouch for is there.
            for names in (columns.keys() - {STATUS}, (STATUS,)):
                for name in names:
                    self._write_array(name, region, columns[name])
                self.files.settle(batch, names)
            self.files.commit(batch)
        except OSError as error:
            raise cannot_write(self.folder, error) from None

    def _write_array(self, name: str, region: tuple[slice, ...], column: Any) -> None:
        array = self.arrays[name]
        shape = tuple(part.stop - part.start for part in region)
        array[(*region, ...)] = np.asarray(column).reshape(shape + array.shape[len(region) :])

    def clean(self) -> None:
        """Remove what a killed process left half written.

        Raises
        ------
        InputError
            If a file looks like that, and is not of this store.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = hc.sweep(spec, Path(folder) / "sweep")
        ...     store = SweepStore(Path(folder) / "sweep")
        ...     (store.folder / "velocity/c/0/0" / f"0.{32 * 'a'}.partial").touch()
        ...     store.clean()
        ...     sum(1 for _ in store.folder.rglob("*.partial"))
        0
        """
        found = sorted(self.folder.rglob("*.partial"))
        for file in found:
            key = TEMPORARY.sub(r"\1", file.relative_to(self.folder).as_posix())
            if self.files.place(key) is None:
                raise InputError(
                    f"{os.fspath(file)!r} looks like a temporary file, but hertzchain did not "
                    "write it: move it out of the store"
                )
        try:
            for file in found:
                file.unlink(missing_ok=True)
        except OSError as error:
            raise cannot_write(self.folder, error) from None

    def copy_batch(self, other: SweepStore, batch: int) -> None:
        """Take a batch that another store of the same sweep has done.

        Parameters
        ----------
        other : SweepStore
            Where it is done.
        batch : int
            Its number.

        Raises
        ------
        StoreError
            If it cannot be copied.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = hc.sweep(spec, Path(folder) / "sweep")
        ...     store = SweepStore(Path(folder) / "sweep")
        ...     _ = hc.sweep(spec, Path(folder) / "part", shard=(2, 2))  # no batch is left for it
        ...     part = SweepStore(Path(folder) / "part")
        ...     part.copy_batch(store, 0)
        ...     part.missing()
        array([], dtype=int64)
        """
        try:
            self.files.forget(batch)
            for name in self.files.arrays:
                content = other.files.content(name, batch)
                if content is not None:
                    target = self.files.file(name, batch)
                    target.parent.mkdir(parents=True, exist_ok=True)
                    replace_file(temporary_name(target), target, content)
            self.files.commit(batch)
        except OSError as error:
            raise cannot_write(self.folder, error) from None

    def open(self) -> xr.Dataset:
        """All of it as a dataset, whose values are read, and checked, when they are used.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        InputError
            If files are missing; later, if values are read from a damaged file.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = hc.sweep(spec, Path(folder) / "sweep")
        ...     store = SweepStore(Path(folder) / "sweep")
        ...     dict(store.open().sizes)
        {'beads': 2, 'by': 1, 'bead': 40}
        """
        import xarray as xr

        self.check(contents=False)
        found = xr.open_zarr(
            self._checked_store(), chunks=None, consolidated=False, mask_and_scale=False
        )
        coordinates = [name for name in self.arrays if name not in self.files.arrays]
        found = plain_text(found.set_coords(coordinates))
        found.attrs = {key: text for key, text in found.attrs.items() if key not in (FILES, SEAL)}
        # In the order in which they were made, not in that of the folder.
        return found[[name for name in self.arrays if name in found.data_vars]]

    def counts(self) -> dict[str, int]:
        """How many points are missing, done and failed; failed is one where a method failed.

        Returns
        -------
        dict of str to int

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = hc.sweep(spec, Path(folder) / "sweep")
        ...     store = SweepStore(Path(folder) / "sweep")
        ...     store.counts()
        {'missing': 0, 'done': 2, 'failed': 0}
        """
        counts = dict.fromkeys(MEANINGS, 0)
        for part in self._rows_of(STATUS):
            worst = np.where((part == MISSING).any(axis=-1), MISSING, part.max(axis=-1))
            for value, meaning in enumerate(MEANINGS):
                counts[meaning] += int((worst == value).sum())
        return counts

    def flagged(self, name: str) -> int:
        """How many points are flagged: by some method, as outside its range or as incomplete.

        Parameters
        ----------
        name : str
            ``"outside_range"`` or ``"incomplete"``.

        Returns
        -------
        int

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> methods = {"methods": ["propagate", "local-rate"]}
        >>> axes = {"rate": [0.02, 0.2], "beads": [20]}
        >>> spec = {"chain": {"taper": "forward-exponential"}, "axes": axes, "sweep": methods}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = hc.sweep(spec, Path(folder) / "sweep")
        ...     SweepStore(Path(folder) / "sweep").flagged("outside_range")
        1
        """
        if name not in self.arrays:
            return 0
        return sum(int(part.any(axis=-1).sum()) for part in self._rows_of(name))

    def failures(self, most: int) -> list[tuple[dict[str, Any], str]]:
        """Where points failed, and why.

        Parameters
        ----------
        most : int
            How many at most.

        Returns
        -------
        list of tuple of dict and str
            Values of the axes and of ``by``, and the reason.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> axes = {"rate": [0.02, 0.05], "beads": [20, 40]}
        >>> spec = {"chain": {"taper": "forward-linear"}, "axes": axes}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = hc.sweep(spec, Path(folder) / "sweep")
        ...     (place, reason), = SweepStore(Path(folder) / "sweep").failures(5)
        >>> place
        {'rate': 0.05, 'beads': 40, 'by': 'propagate'}
        >>> reason[:66]
        'a forward-linear taper with S = 0.05 runs out of radius at bead 21'
        """
        return list(itertools.islice(self._failures(), most))

    def _failures(self) -> Iterator[tuple[dict[str, Any], str]]:
        dataset, rows = self.open(), self.status.chunks[0]
        for start in range(0, self.status.shape[0], rows):
            part = dataset.isel({dataset.status.dims[0]: slice(start, start + rows)})
            for place in np.argwhere(part.status.values == FAILED):
                at = part.reason.isel(dict(zip(part.status.dims, place, strict=True)))
                named = {str(name): value.item() for name, value in at.coords.items()}
                yield named, str(at.item())

    def _rows_of(self, name: str) -> Iterator[NDArray[np.int8]]:
        """An array, as many rows at a time as a batch has."""
        array, rows = self.arrays[name], self.status.chunks[0]
        for start in range(0, array.shape[0], rows):
            yield np.asarray(array[start : start + rows])


def plain_text(dataset: xr.Dataset) -> xr.Dataset:
    """A dataset whose text coordinates are NumPy's fixed-width text, which can be selected by.

    Parameters
    ----------
    dataset : xarray.Dataset
        Any dataset.

    Returns
    -------
    xarray.Dataset

    Examples
    --------
    >>> import xarray as xr
    >>> names = np.array(["a", "b"], dtype=np.dtypes.StringDType())
    >>> plain_text(xr.Dataset(coords={"name": names})).name.dtype.kind
    'U'
    """
    texts = {
        name: (values.dims, np.array([str(text) for text in values.values]), values.attrs)
        for name, values in dataset.coords.items()
        if values.dtype.kind == "T"
    }
    return dataset.drop_vars(texts).assign_coords(texts)


def locked(folder: str | os.PathLike[str]) -> contextlib.AbstractContextManager[None]:
    """Keep others out of a store for the time of a ``with`` block, by a lock beside it.

    Parameters
    ----------
    folder : path-like
        The store.

    Returns
    -------
    context manager

    Raises
    ------
    InputError
        If another process has it, or what is there is no store of a sweep.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as parent, locked(Path(parent) / "sweep"):
    ...     pass
    """
    _refuse_others(folder)
    # A store has one lock, by whatever name it is called.
    target = Path(os.path.realpath(folder))
    return lock(target.with_name(f".{target.name}.lock"), folder)


def _refuse_others(folder: str | os.PathLike[str]) -> None:
    """Nothing is done to, or beside, what is no store of a sweep."""
    # A name that is too long is neither here, and no error.
    there = os.path.exists(folder)  # noqa: PTH110
    if there and not (Path(folder) / "zarr.json").is_file():
        raise InputError(
            f"{os.fspath(folder)!r} is no store of a sweep: it is left as it is; choose another "
            "name"
        )
