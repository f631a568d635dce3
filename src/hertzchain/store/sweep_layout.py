"""What a sweep store consists of before the first batch, and digests of that part.

Digests of the files are an attribute of the zarr group, and a digest of all other attributes is
another.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hertzchain.errors import InputError
from hertzchain.store.batch_files import DIGEST, ROW
from hertzchain.store.damage import DamagedFileError
from hertzchain.store.writing import cannot_write

# The layout, by the attribute `MARKER` of the group.
SCHEMA: Final = "hertzchain sweep 2"
FAMILY: Final = "hertzchain sweep "
MARKER: Final = "schema"
STATUS: Final = "status"
# Attributes of the group: digests of the files of no batch, and of the other attributes.
FILES, SEAL = "files", "seal"
GROUP_FILE: Final = "zarr.json"
# What to do about a damaged file that belongs to no batch.
RESTORE: Final = "restore it from a copy, or move the store away and sweep again"
_HEX: Final = r"\.[0-9a-f]{32}\.partial"
# Files of a store that was not made to its end.
UNFINISHED: Final = re.compile(rf"([^/]+/)?zarr(\.json|{_HEX})|[^/]+/c/(\d+/)*\d+({_HEX})?")


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


def create_store(
    folder: str | os.PathLike[str], variables: Mapping[str, Variable], attributes: Mapping[str, Any]
) -> None:
    """Make an empty store, whole or not at all.

    Parameters
    ----------
    folder : path-like
        Where it shall be; nothing may be there.
    variables : mapping of str to Variable
        Arrays by name, among them ``status``.
    attributes : mapping
        Of the dataset.

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
    ...     create_store(Path(parent) / "sweep", {"status": status}, {})
    ...     sorted(file.name for file in (Path(parent) / "sweep").iterdir())
    ['digest', 'status', 'zarr.json']
    """
    import zarr

    target = Path(folder)
    beside = target.with_name(f".{target.name}.new")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        _remove_unfinished(beside)
        group = zarr.create_group(
            beside, attributes={MARKER: SCHEMA, "arrays": list(variables), **attributes}
        )
        for name, variable in variables.items():
            _create_array(group, name, variable)
        _create_digests(group, variables)
        _seal_group(group, beside)
        beside.replace(target)
    except OSError as error:
        with contextlib.suppress(OSError, InputError):
            _remove_unfinished(beside)
        raise cannot_write(folder, error) from None


def grid_of(shape: tuple[int, ...], chunk: tuple[int, ...]) -> tuple[int, ...]:
    """Number of batches along each dimension, from the shapes of the status and of its chunks.

    Parameters
    ----------
    shape, chunk : tuple of int
        Of the status; the last dimension is that of methods.

    Returns
    -------
    tuple of int

    Examples
    --------
    >>> grid_of((5, 3, 1), (2, 3, 1))
    (3, 1)
    """
    return tuple(-(-n // c) for n, c in zip(shape, chunk, strict=True))[:-1] or (1,)


def check_layout(folder: Path, attributes: Mapping[str, Any]) -> None:
    """Compare attributes, descriptions of arrays and values of axes with their digests.

    Parameters
    ----------
    folder : pathlib.Path
        The store.
    attributes : mapping
        Of its group.

    Raises
    ------
    InputError
        If the folder is no store of a sweep, or a file is missing or not as it was written.

    Examples
    --------
    >>> check_layout(Path("other"), {})
    Traceback (most recent call last):
    ...
    hertzchain.errors.InputError: 'other' is no store of a sweep: it is left as it is
    """
    schema, name = attributes.get(MARKER), os.fspath(folder)
    if not str(schema).startswith(FAMILY):
        raise InputError(f"{name!r} is no store of a sweep: it is left as it is")
    if schema != SCHEMA:
        raise InputError(
            f"{name!r} has the layout {schema!r} of another version of hertzchain, and this "
            f"version reads {SCHEMA!r}: use the other version, or sweep again into another store"
        )
    others = {key: value for key, value in attributes.items() if key != SEAL}
    if _seal(others) != attributes.get(SEAL):
        raise DamagedFileError(folder / GROUP_FILE, "is not as it was written", folder, RESTORE)
    for relative, digest in others[FILES].items():
        file = folder / relative
        if not file.is_file():
            raise DamagedFileError(file, "is missing", folder, RESTORE)
        if _digest(file) != digest:
            raise DamagedFileError(file, "is not as it was written", folder, RESTORE)


def _remove_unfinished(folder: Path) -> None:
    """Remove a store that a killed process has not made to its end; nothing else."""
    if not os.path.lexists(folder):
        return
    found = [file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()]
    ours = folder.is_dir() and not folder.is_symlink() and all(map(UNFINISHED.fullmatch, found))
    if ours and GROUP_FILE in found:
        with contextlib.suppress(ValueError):
            attributes = json.loads((folder / GROUP_FILE).read_bytes()).get("attributes", {})
            ours = str(attributes.get(MARKER)).startswith(FAMILY)
    elif ours:
        ours = all(name.endswith(".partial") for name in found)
    if not ours:
        raise InputError(
            f"{os.fspath(folder)!r} is where the new store is made, but hertzchain did not write "
            "it: move it away, or choose another name for the store"
        )
    shutil.rmtree(folder)


def _create_digests(group: Any, variables: Mapping[str, Variable]) -> None:
    """An array with a row of digests per batch, one per array."""
    status = variables[STATUS]
    number = int(np.prod(grid_of(status.shape, status.chunk)))
    arrays = [name for name, variable in variables.items() if variable.values is None]
    group.create_array(
        DIGEST,
        shape=(number, len(arrays)),
        chunks=(1, len(arrays)),
        dtype=ROW,
        fill_value=0,
        compressors=None,
        dimension_names=("batch", "array"),
        attributes={"long_name": "digest of each chunk; 0 where there is none"},
    )


def _seal_group(group: Any, folder: Path) -> None:
    """Store digests of all files that are there before the first batch."""
    files = sorted(file for file in folder.rglob("*") if file.is_file())
    digests = {
        file.relative_to(folder).as_posix(): _digest(file)
        for file in files
        if file != folder / GROUP_FILE
    }
    attributes = {**group.attrs.asdict(), FILES: digests}
    group.update_attributes({**attributes, SEAL: _seal(attributes)})


def _digest(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _seal(attributes: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(attributes, sort_keys=True).encode()).hexdigest()


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
