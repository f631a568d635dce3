"""The store of a sweep: a zarr folder with one array per quantity and one chunk per batch.

Programs that read zarr can read it, even while the sweep is running.  A batch is written as a
whole: first its data, then its chunk of ``status``, then the digests of both, which mark it as done
(`hertzchain.store.batch_files`).  Digests of all other files are attributes of the group.
The contents of the store do not depend on when or by which worker they were computed: a
sweep that was interrupted and resumed leaves the same bytes as one that was not.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ..errors import DamageWarning, InputError, StoreError, warn_user
from ..validation.objects import Progress
from .batch_files import DIGEST, TEMPORARY, BatchFiles
from .damage import DamagedFileError
from .file_lock import lock
from .sweep_layout import (
    ARRAYS,
    BY_BATCH,
    FILES,
    RESTORE,
    SEAL,
    STATUS,
    Variable,
    check_layout,
    create_store,
    grid_of,
)
from .writing import cannot_write, replace_file, temporary_name

if TYPE_CHECKING:
    import xarray as xr


# Meanings of the values of `status`.
MEANINGS: Final = ("missing", "done", "failed")
MISSING, DONE, FAILED = range(len(MEANINGS))


class SweepStore:
    """An existing store.

    Parameters
    ----------
    folder : path-like
        Folder of the store.
    skip_damaged : bool
        Whether to treat batches with damaged files as missing, with a `DamageWarning`.
        Otherwise reading them is an error.

    Raises
    ------
    InputError
        If the folder does not exist, is not the store of a sweep, or is damaged.
    """

    def __init__(self, folder: str | os.PathLike[str], *, skip_damaged: bool = False) -> None:
        import zarr

        self.folder = Path(folder)
        name = os.fspath(folder)
        _check_folder(folder)
        if not os.path.isdir(folder):  # noqa: PTH112  (pathlib raises for names that are too long)
            raise InputError(
                f"there is no sweep store {name!r}: give the folder of a sweep; a sweep that was "
                "interrupted before its first results has none"
            )
        try:
            group: Any = zarr.open_group(self.folder, mode="r", zarr_format=3)
            self.attributes: dict[str, Any] = dict(group.attrs)
            check_layout(self.folder, self.attributes)
            self.files = self._batch_files(group)
            self.arrays: dict[str, Any] = self._checked_arrays()
            self.status = self.arrays[STATUS]
        except InputError:
            raise
        # zarr raises errors of any type for damaged files.
        except Exception as error:  # noqa: BLE001
            reason = f"there is no {error}" if isinstance(error, KeyError) else error
            raise InputError(f"{name!r} is damaged ({reason}): {RESTORE}") from None
        if skip_damaged:
            self._skip_damaged()

    def _batch_files(self, group: Any) -> BatchFiles:
        names: list[str] = self.attributes[ARRAYS]
        by_batch = [name for name in names if group[name].attrs.get(BY_BATCH)]
        arrays = {name: group[name] for name in by_batch if name != STATUS}
        arrays[STATUS] = status = group[STATUS]
        sweep = hashlib.sha256(f"{self.version}\0{self.specification}".encode()).hexdigest()
        return BatchFiles(self.folder, sweep, arrays, group[DIGEST],
                          grid_of(status.shape, status.chunks))  # fmt: skip

    def _checked_arrays(self) -> dict[str, Any]:
        """Arrays whose chunks are compared with their digests when they are read."""
        import zarr

        group: Any = zarr.open_group(self._checked_store(), mode="r+", zarr_format=3)
        # Every batch has a chunk of each array except `reason`, since reasons are rare.
        return {
            key: group[key].with_config({"write_empty_chunks": key != "reason"})
            for key in self.attributes[ARRAYS]
        }

    def _checked_store(self) -> Any:
        # Loads zarr, which is not needed before a store is opened.
        from .checked_store import checked_store

        return checked_store(self.files)

    def _skip_damaged(self) -> None:
        faults = self._faults(contents=True)
        self.files.skipped.update(faults)
        if faults:
            first = next(iter(faults.values()))
            batches = "1 batch is" if len(faults) == 1 else f"{len(faults)} batches are"
            warn_user(
                f"{os.fspath(self.folder)!r} is damaged: {batches} omitted as missing, the first "
                f"because {os.fspath(first.file)} {first.how}",
                DamageWarning,
            )

    @classmethod
    def create(
        cls,
        folder: str | os.PathLike[str],
        variables: Mapping[str, Variable],
        attributes: Mapping[str, Any],
    ) -> SweepStore:
        """Create a store without batches, completely or not at all."""
        create_store(folder, variables, attributes)
        return cls(folder)

    @property
    def specification(self) -> str:
        """Specification of the sweep as JSON text."""
        return str(self.attributes.get("specification", "{}"))

    @property
    def version(self) -> str:
        """Version of hertzchain that began the sweep."""
        return str(self.attributes.get("hertzchain_version", "of unknown version"))

    @property
    def grid(self) -> tuple[int, ...]:
        """Number of batches along each dimension."""
        return self.files.grid

    def missing(self) -> NDArray[np.int64]:
        """Numbers of the batches that are not done."""
        self.check(contents=False)
        batches = range(self.files.number)
        return np.array([batch for batch in batches if not self.files.done(batch)], np.int64)

    def check(self, *, contents: bool = True, progress: Progress | None = None) -> None:
        """Compare the files of all batches with their digests."""
        faults = self._faults(contents=contents, progress=progress)
        if faults:
            raise next(iter(faults.values())).among(len(faults))

    def _faults(
        self, *, contents: bool, progress: Progress | None = None
    ) -> dict[int, DamagedFileError]:
        """The error for each damaged batch that is not skipped."""
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
        """Write a batch: first its data, then the mark that it is done."""
        if not (self.folder / STATUS / "zarr.json").is_file():
            raise StoreError(
                f"the store {os.fspath(self.folder)!r} was moved or removed during the sweep"
            )
        try:
            self.files.forget(batch)
            # For other programs a batch with a status is done, for hertzchain one with digests:
            # the data must have reached the disk before the status, and both before the digests.
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
        """Remove temporary files of a process that was killed."""
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
        """Copy a batch that is done from another store of the same sweep."""
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
        """Open the store as a dataset, whose values are read and checked when they are used."""
        import xarray as xr

        self.check(contents=False)
        found = xr.open_zarr(
            self._checked_store(), chunks=None, consolidated=False, mask_and_scale=False
        )
        coordinates = [name for name in self.arrays if name not in self.files.arrays]
        found = plain_text(found.set_coords(coordinates))
        internal = (ARRAYS, FILES, SEAL)
        found.attrs = {key: text for key, text in found.attrs.items() if key not in internal}
        for variable in found.data_vars.values():
            variable.attrs.pop(BY_BATCH, None)
        # In the order in which the variables were created, not in the order of the folder.
        return found[[name for name in self.arrays if name in found.data_vars]]

    def counts(self) -> dict[str, int]:
        """Numbers of points that are missing, done and failed (for at least one method)."""
        counts = dict.fromkeys(MEANINGS, 0)
        for part in self._rows_of(STATUS):
            worst = np.where((part == MISSING).any(axis=-1), MISSING, part.max(axis=-1))
            for value, meaning in enumerate(MEANINGS):
                counts[meaning] += int((worst == value).sum())
        return counts

    def flagged(self, name: str) -> int:
        """Number of points with a flag for at least one method: outside range or incomplete."""
        if name not in self.arrays:
            return 0
        return sum(int(part.any(axis=-1).sum()) for part in self._rows_of(name))

    def explained(self, words: str) -> int:
        """Number of points whose reason has these words for at least one method."""
        parts = (np.strings.find(part.astype("T"), words) >= 0 for part in self._rows_of("reason"))
        return sum(int(part.any(axis=-1).sum()) for part in parts)

    def failures(self, most: int) -> list[tuple[dict[str, Any], str]]:
        """Coordinates of failed points, and the reasons."""
        return list(itertools.islice(self._failures(), most))

    def failures_by_reason(self, most: int) -> list[tuple[str, int, dict[str, Any]]]:
        """Reasons of failed points, how many have each but for its numbers, and the first point."""
        found: dict[str, list[tuple[dict[str, Any], str]]] = {}
        for place, reason in self.failures(most):
            found.setdefault(re.sub(r"\d[\d.e+-]*", "#", reason), []).append((place, reason))
        return [(group[0][1], _points_of(group), group[0][0]) for group in found.values()]

    def _failures(self) -> Iterator[tuple[dict[str, Any], str]]:
        dataset, rows = self.open(), self.status.chunks[0]
        for start in range(0, self.status.shape[0], rows):
            part = dataset.isel({dataset.status.dims[0]: slice(start, start + rows)})
            for place in np.argwhere(part.status.values == FAILED):
                at = part.reason.isel(dict(zip(part.status.dims, place, strict=True)))
                named = {str(name): value.item() for name, value in at.coords.items()}
                yield named, str(at.item())

    def _rows_of(self, name: str) -> Iterator[NDArray[Any]]:
        """Yield an array in parts of as many rows as a batch has."""
        array, rows = self.arrays[name], self.status.chunks[0]
        for start in range(0, array.shape[0], rows):
            yield np.asarray(array[start : start + rows])


def _points_of(failures: list[tuple[dict[str, Any], str]]) -> int:
    """Number of points of failures, each of which has those of several methods."""
    places = (tuple(place.items()) for place, _ in failures)
    return len({tuple(pair for pair in place if pair[0] != "approach") for place in places})


def plain_text(dataset: xr.Dataset) -> xr.Dataset:
    """Convert text coordinates to NumPy's fixed-width text, which xarray can select by."""
    texts = {
        name: (values.dims, np.array([str(text) for text in values.values]), values.attrs)
        for name, values in dataset.coords.items()
        if values.dtype.kind == "T"
    }
    return dataset.drop_vars(texts).assign_coords(texts)


def locked(folder: str | os.PathLike[str]) -> contextlib.AbstractContextManager[None]:
    """Lock a store for a ``with`` block by a file next to it."""
    _check_folder(folder)
    # A store has one lock, even if it is opened through a symbolic link.
    target = Path(os.path.realpath(folder))
    return lock(target.with_name(f".{target.name}.lock"), folder)


def _check_folder(folder: str | os.PathLike[str]) -> None:
    """Raise `InputError` for an existing file or folder that is not the store of a sweep."""
    # Path.exists raises OSError for a name that is too long.
    there = os.path.exists(folder)  # noqa: PTH110
    if there and not (Path(folder) / "zarr.json").is_file():
        raise InputError(
            f"{os.fspath(folder)!r} is not the store of a sweep and was not changed: choose "
            "another name"
        )
