"""The store of a sweep: a zarr folder with an array for each quantity, a chunk for each batch.

Any program that reads zarr reads it, while the sweep still runs.  A batch is written whole:
its data first, then its chunk of ``status``, which says that it is done.  Nothing in the store
depends on when or by whom it was computed, so that a sweep that was interrupted and taken up
again leaves the same bytes as one that was not.
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import os
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from hertzchain.errors import InputError, StoreError
from hertzchain.store.lock import lock

if TYPE_CHECKING:
    import xarray as xr

SCHEMA: Final = "hertzchain sweep 1"
MARKER: Final = "schema"
STATUS: Final = "status"
# Errors of a disk that is full.
FULL: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
# Of `status`: what it says, by its value.
MEANINGS: Final = ("missing", "done", "failed")
MISSING, DONE, FAILED = range(len(MEANINGS))


@dataclass(frozen=True, eq=False)
class Variable:
    """One array of a store.

    Attributes
    ----------
    dimensions : tuple of str
        Names of its dimensions.
    shape, chunk : tuple of int
        Of all of it, and of one batch.
    dtype : str
        ``"f8"``, ``"i8"``, ``"i1"`` or ``"str"``.
    attributes : mapping
        Units, long name.
    values : ndarray, optional
        All values of a coordinate.

    Examples
    --------
    >>> Variable(("rate",), (3,), (3,), "f8", {"units": "1"}).dimensions
    ('rate',)
    """

    dimensions: tuple[str, ...]
    shape: tuple[int, ...]
    chunk: tuple[int, ...]
    dtype: str
    attributes: Mapping[str, Any]
    values: NDArray[Any] | None = None

    @property
    def size(self) -> int:
        """Bytes of all of it, text left out."""
        width = {"f8": 8, "i8": 8, "i1": 1}.get(self.dtype, 0)
        return width * int(np.prod(self.shape, dtype=float))


class SweepStore:
    """A store that exists.

    Parameters
    ----------
    folder : path-like
        Where it is.

    Raises
    ------
    InputError
        If there is none, or what is there is no sweep, or damaged.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        import zarr

        self.folder = Path(folder)
        name = os.fspath(folder)
        _refuse_others(folder)
        if not os.path.isdir(folder):  # noqa: PTH112  (a name that is too long is no error)
            raise InputError(f"there is no sweep store {name!r}: it would be a folder")
        try:
            group: Any = zarr.open_group(self.folder, mode="r+", zarr_format=3)
            self.attributes: dict[str, Any] = dict(group.attrs)
            if self.attributes.get(MARKER) != SCHEMA:
                raise InputError(f"{name!r} is no store of a sweep: it is left as it is")
            # A chunk that is there proves that its batch is done; of reasons there are few.
            self.arrays: dict[str, Any] = {
                key: group[key].with_config({"write_empty_chunks": key != "reason"})
                for key in self.attributes["arrays"]
            }
            self.status = self.arrays[STATUS]
            self._check_coordinates()
        except InputError:
            raise
        # Whatever zarr stumbles over in a file that is not as it was written.
        except Exception as error:  # noqa: BLE001
            reason = f"there is no {error}" if isinstance(error, KeyError) else error
            raise InputError(
                f"the sweep store {name!r} is damaged ({reason}): move it away and sweep again"
            ) from None

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
        import zarr

        target = Path(folder)
        beside = target.with_name(f".{target.name}.new")
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.rmtree(beside, ignore_errors=True)
            group = zarr.create_group(
                beside,
                attributes={MARKER: SCHEMA, "arrays": list(variables), **attributes},
            )
            for name, variable in variables.items():
                _create_array(group, name, variable)
            beside.replace(target)
        except OSError as error:
            with contextlib.suppress(OSError):
                shutil.rmtree(beside, ignore_errors=True)
            if error.errno in FULL:
                raise StoreError(f"cannot make the store {target}: {error.strerror}") from None
            raise InputError(
                f"cannot make the store {os.fspath(folder)!r} ({error.strerror}); choose another "
                "place"
            ) from None
        return cls(target)

    @property
    def specification(self) -> str:
        """JSON text of what is swept."""
        return str(self.attributes.get("specification", "{}"))

    @property
    def grid(self) -> tuple[int, ...]:
        """Number of batches along each dimension."""
        shape, chunk = self.status.shape, self.status.chunks
        return tuple(-(-n // c) for n, c in zip(shape, chunk, strict=True))[:-1] or (1,)

    def missing(self) -> NDArray[np.int64]:
        """Numbers of the batches that are not done.

        Returns
        -------
        ndarray of int

        Raises
        ------
        InputError
            If data of a batch that is done are not there.

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
        missing = []
        for batch in range(int(np.prod(self.grid))):
            if not self._chunk(STATUS, batch).is_file():
                missing.append(batch)
                continue
            for name in (*self._data, STATUS):
                file = self._chunk(name, batch)
                if not file.is_file() or file.stat().st_size == 0:
                    how = "empty" if file.is_file() else "missing"
                    raise self._damaged(file, how, batch)
        return np.array(missing, np.int64)

    def check(self) -> None:
        """Read all that is there, to find what is not as it was written.

        Raises
        ------
        InputError
            For the first chunk that cannot be read.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = hc.sweep(spec, Path(folder) / "sweep")
        ...     SweepStore(Path(folder) / "sweep").check()
        """
        missing = {*self.missing().tolist()}
        for batch in range(int(np.prod(self.grid))):
            for name in self._by_batch:
                file = self._chunk(name, batch)
                # Of reasons, only those of batches that have some are there.
                if batch in missing or not file.exists():
                    continue
                corner = file.relative_to(self.folder / name / "c").parts
                try:
                    self.arrays[name].blocks[tuple(map(int, corner))]
                # Codecs raise what they like.
                except Exception:  # noqa: BLE001
                    raise self._damaged(file, "not as it was written", batch) from None

    def _damaged(self, file: Path, how: str, batch: int) -> InputError:
        return InputError(
            f"the sweep store {os.fspath(self.folder)!r} is damaged: {file} is {how}; delete "
            f"{self._chunk(STATUS, batch)} to compute that batch anew"
        )

    @contextlib.contextmanager
    def read(self) -> Iterator[None]:
        """For the time of a ``with`` block, say which file is damaged if reading fails.

        Raises
        ------
        InputError
            If a chunk is not as it was written.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = hc.sweep(spec, Path(folder) / "sweep")
        ...     store = SweepStore(Path(folder) / "sweep")
        ...     with store.read():
        ...         int(store.open().status.sum())
        2
        """
        try:
            yield
        except InputError:
            raise
        except Exception:
            self.check()
            raise

    def _check_coordinates(self) -> None:
        """Values of axes that are not there would be read as zeros."""
        for name in self._coordinates:
            if not (self.folder / name / "c" / "0").is_file():
                raise KeyError(f"{name}/c/0")
            np.asarray(self.arrays[name][...])

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
            for name in sorted(columns, key=lambda name: name == STATUS):
                if name == STATUS:
                    self._settle(batch)
                array = self.arrays[name]
                shape = tuple(part.stop - part.start for part in region)
                values = np.asarray(columns[name]).reshape(shape + array.shape[len(region) :])
                array[(*region, ...)] = values
        except OSError as error:
            raise StoreError(
                f"cannot write to {os.fspath(self.folder)!r}: {error.strerror or error}"
            ) from None

    def _settle(self, batch: int) -> None:
        """Have the disk hold the data of a batch, lest a power cut leave a status without them."""
        for name in self._by_batch[:-1]:
            file = self._chunk(name, batch)
            if file.exists():
                with file.open("r+b") as data:
                    os.fsync(data.fileno())

    def clean(self) -> None:
        """Remove what a killed process left half written.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [20, 40]}}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = hc.sweep(spec, Path(folder) / "sweep")
        ...     store = SweepStore(Path(folder) / "sweep")
        ...     (store.folder / "velocity" / "half.partial").touch()
        ...     store.clean()
        ...     sum(1 for _ in store.folder.rglob("*.partial"))
        0
        """
        try:
            for file in self.folder.rglob("*.partial"):
                file.unlink(missing_ok=True)
        except OSError as error:
            raise StoreError(f"cannot write to {os.fspath(self.folder)!r}: {error}") from None

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
            for name in self._by_batch:
                if name == STATUS:
                    self._settle(batch)
                source, target = other._chunk(name, batch), self._chunk(name, batch)
                if source.is_file():
                    target.parent.mkdir(parents=True, exist_ok=True)
                    partial = target.with_name(f"{target.name}.partial")
                    shutil.copyfile(source, partial)
                    partial.replace(target)
        except OSError as error:
            raise StoreError(f"cannot copy into {os.fspath(self.folder)!r}: {error}") from None

    def open(self) -> xr.Dataset:
        """All of it as a dataset, read when looked at.

        Returns
        -------
        xarray.Dataset

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

        found = xr.open_zarr(self.folder, chunks=None, consolidated=False, mask_and_scale=False)
        found = plain_text(found.set_coords(self._coordinates))
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
        with self.read():
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
        with self.read():
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
        with self.read():
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

    @property
    def _coordinates(self) -> list[str]:
        """Names of the arrays that are whole from the start."""
        return [
            name for name, array in self.arrays.items()
            if not array.metadata.attributes.get("by_batch")
        ]  # fmt: skip

    @property
    def _by_batch(self) -> list[str]:
        """Names of the other arrays, the status last."""
        others = (STATUS, *self._coordinates)
        return [*(name for name in self.arrays if name not in others), STATUS]

    @property
    def _data(self) -> list[str]:
        """Names of the arrays of which every batch writes a chunk, but for the status."""
        return [name for name in self._by_batch if name not in ("reason", STATUS)]

    def _chunk(self, name: str, batch: int) -> Path:
        """File of a batch; each holds whole beads and methods."""
        corner = [str(int(i)) for i in np.unravel_index(batch, self.grid)]
        more = ["0"] * (self.arrays[name].ndim - len(corner))
        return self.folder.joinpath(name, "c", *corner, *more)


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


def _create_array(group: Any, name: str, variable: Variable) -> None:
    from zarr.codecs import ZstdCodec

    by_batch = variable.values is None
    fill: Any = {"f8": np.nan, "str": ""}.get(variable.dtype, 0)
    array = group.create_array(
        name,
        shape=variable.shape,
        chunks=tuple(max(1, n) for n in variable.chunk),
        dtype=str if variable.dtype == "str" else variable.dtype,
        fill_value=fill,
        # A flipped bit is an error, not a number.
        compressors=ZstdCodec(checksum=True),
        config={"write_empty_chunks": True},
        dimension_names=variable.dimensions,
        attributes={**variable.attributes, **({"by_batch": 1} if by_batch else {})},
    )
    if variable.values is not None:
        array[...] = variable.values
