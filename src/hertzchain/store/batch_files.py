"""Files of the batches of a sweep store, each with a digest.

The digests of a batch are one chunk of the array ``digest``, which is written after all other
files of the batch: a batch without digests is not done, and is read as if it were empty.
A digest also depends on the sweep and on the name of the file: files copied from another
batch or another store are detected.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .damage import DamagedFileError
from .writing import replace_file, temporary_name

DIGEST: Final = "digest"
# Type of a digest.
ROW: Final = np.dtype("<u8")
TEMPORARY: Final = re.compile(r"(.+)\.[0-9a-f]{32}\.partial")


@dataclass(frozen=True, eq=False)
class BatchFiles:
    """Paths of the files of each batch, and checks of their contents.

    Attributes
    ----------
    folder : pathlib.Path
        The store.
    sweep : str
        Digest of the specification, which is a part of every digest.
    arrays : mapping of str to zarr.Array
        Arrays of which each batch is one chunk, in the order of the digests; status is last.
    digests : zarr.Array
        One row of digests per batch, 0 where there is no file.
    grid : tuple of int
        Number of batches along each dimension.
    skipped : set of int
        Damaged batches that are read as if they were not done.
    """

    folder: Path
    sweep: str
    arrays: Mapping[str, Any]
    digests: Any
    grid: tuple[int, ...]
    skipped: set[int] = field(default_factory=set)
    _rows: dict[int, NDArray[np.uint64]] = field(default_factory=dict)

    @property
    def number(self) -> int:
        """Number of batches, whether done or not."""
        return int(np.prod(self.grid))

    def file(self, name: str, batch: int) -> Path:
        """Path of the file of a batch; each chunk has all beads and methods of its points."""
        return self.folder / self._key(name, batch)

    def place(self, key: str) -> tuple[str, int] | None:
        """Array and batch of a file; `None` for files of no batch."""
        name, _, rest = key.partition("/")
        if name not in self.arrays and name != DIGEST:
            return None
        # zarr only encodes keys: the numbers in the key are a guess, which is checked below.
        numbers = [int(each) for each in re.findall(r"\d{1,9}", rest)]
        corner = numbers[:1] if name == DIGEST else numbers[: len(self.grid)]
        grid = (self.number,) if name == DIGEST else self.grid
        inside = len(corner) == len(grid) and all(i < n for i, n in zip(corner, grid, strict=True))
        if not inside:
            return None
        batch = int(np.ravel_multi_index(corner, grid))
        return (name, batch) if self._key(name, batch) == key else None

    def done(self, batch: int) -> bool:
        """Whether a batch was written completely and is not skipped."""
        return batch not in self.skipped and self._row(batch) is not None

    def content(self, name: str, batch: int) -> bytes | None:
        """Read and check a file; `None` if the batch is not done or has no such file."""
        row = None if batch in self.skipped else self._row(batch)
        if row is None:
            return None
        file = self.file(name, batch)
        try:
            content = file.read_bytes()
        except FileNotFoundError:
            content = None
        except OSError as error:
            raise self._damaged(file, f"cannot be read ({error.strerror})") from None
        written = int(row[list(self.arrays).index(name)])
        if content is None and written:
            raise self._damaged(file, "is missing")
        if content == b"" and written:
            raise self._damaged(file, "is empty")
        if self._checksum(name, batch, content) != written:
            raise self._damaged(file, "is not as it was written")
        return content

    def fault(self, batch: int, *, contents: bool) -> DamagedFileError | None:
        """The error for a batch that is done but damaged."""
        try:
            row = self._row(batch)
            if row is None:
                return None
            for name, written in zip(self.arrays, row, strict=True):
                file = self.file(name, batch)
                if contents or (file.is_file() and file.stat().st_size > 0) != bool(written):
                    self.content(name, batch)
        except DamagedFileError as error:
            return error
        return None

    def settle(self, batch: int, names: Iterable[str]) -> None:
        """Wait until files of a batch have reached the disk."""
        for name in names:
            file = self.file(name, batch)
            if file.exists():
                with file.open("r+b") as data:
                    os.fsync(data.fileno())

    def commit(self, batch: int) -> None:
        """Mark a batch as done, after its files have reached the disk."""
        row = np.zeros(len(self.arrays), ROW)
        for column, name in enumerate(self.arrays):
            file = self.file(name, batch)
            if file.exists():
                row[column] = self._checksum(name, batch, file.read_bytes())
        file = self.file(DIGEST, batch)
        file.parent.mkdir(parents=True, exist_ok=True)
        replace_file(temporary_name(file), file, row.tobytes())
        self._rows.pop(batch, None)
        self.skipped.discard(batch)

    def forget(self, batch: int) -> None:
        """Remove all files of a batch, its digests first."""
        self._rows.pop(batch, None)
        for name in (DIGEST, *list(self.arrays)[::-1]):
            self.file(name, batch).unlink(missing_ok=True)

    def _row(self, batch: int) -> NDArray[np.uint64] | None:
        """Digests of a batch; `None` if it is not done."""
        if batch not in self._rows:
            file = self.file(DIGEST, batch)
            try:
                content = file.read_bytes()
            except FileNotFoundError:
                return None
            except OSError as error:
                raise self._damaged(file, f"cannot be read ({error.strerror})") from None
            whole = len(content) == ROW.itemsize * len(self.arrays)
            row = np.frombuffer(content, ROW) if whole else np.zeros(1, ROW)
            # The last digest is that of the status, which every finished batch has.
            if not row[-1]:
                raise self._damaged(file, "is not as it was written")
            self._rows[batch] = row
        return self._rows[batch]

    def _key(self, name: str, batch: int) -> str:
        array = self.digests if name == DIGEST else self.arrays[name]
        grid = (self.number,) if name == DIGEST else self.grid
        corner = [int(i) for i in np.unravel_index(batch, grid)]
        more = [0] * (array.ndim - len(corner))
        return f"{array.path}/{array.metadata.encode_chunk_key((*corner, *more))}"

    def _checksum(self, name: str, batch: int, content: bytes | None) -> int:
        if content is None:
            return 0
        label = f"{self.sweep}\0{self._key(name, batch)}\0"
        found = hashlib.blake2b(label.encode(), digest_size=ROW.itemsize)
        found.update(content)
        return int.from_bytes(found.digest(), "little")

    def _damaged(self, file: Path, how: str) -> DamagedFileError:
        advice = (
            "skip_damaged=True (--skip-damaged) reads the rest; with it, a repeated sweep computes "
            "this batch again"
        )
        return DamagedFileError(file, how, self.folder, advice)
