"""Layout of a new sweep store, and digests of the files that it has before the first batch.

The digests of these files are one attribute of the zarr group; the digest of all other attributes
is another.
"""

from __future__ import annotations

import contextlib
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

from ..errors import InputError
from .batch_files import DIGEST, ROW
from .damage import DamagedFileError
from .digests import document_digest, file_digest
from .writing import cannot_write

# Version of the layout, stored in the attribute `MARKER` of the group.
SCHEMA: Final = "hertzchain sweep 3"
FAMILY: Final = "hertzchain sweep "
MARKER: Final = "schema"
STATUS: Final = "status"
# Attributes of the group: digests of the files that belong to no batch; digest of the attributes.
FILES, SEAL = "files", "seal"
# Attributes of the group, its arrays in order, and of an array that each batch writes a part of.
ARRAYS, BY_BATCH = "arrays", "by_batch"
GROUP_FILE: Final = "zarr.json"
# Its keys (zarr itself does not miss the format), and one that zarr may add.
GROUP_KEYS: Final = {"attributes", "node_type", "zarr_format"}
CONSOLIDATED: Final = "consolidated_metadata"
# Advice for a damaged file that belongs to no batch.
RESTORE: Final = "restore it from a copy, or move the store away and sweep again"
# Names that zarr gives to files: descriptions, chunks, and temporary files of both.
ZARR_FILE: Final = re.compile(r"zarr\.json|\d+|(zarr|\d+)\.[0-9a-f]{32}\.partial")


@dataclass(frozen=True, eq=False)
class Variable:
    """One array of a store.

    Attributes
    ----------
    dimensions : tuple of str
        Names of its dimensions.
    shape, chunk : tuple of int
        Shape of the array and of one batch.
    dtype : str
        ``"f8"``, ``"i8"``, ``"i1"`` or ``"str"``.
    attributes : mapping
        Attributes such as units and long name.
    values : ndarray, optional
        Values of a coordinate.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.store.sweep_layout import Variable
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
        """Number of bytes of the array; 0 for text."""
        width = {"f8": 8, "i8": 8, "i1": 1}.get(self.dtype, 0)
        return width * int(np.prod(self.shape, dtype=float))


def create_store(
    folder: str | os.PathLike[str], variables: Mapping[str, Variable], attributes: Mapping[str, Any]
) -> None:
    """Create a store without batches, completely or not at all."""
    import zarr

    target = Path(folder)
    beside = target.with_name(f".{target.name}.new")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        _remove_unfinished(beside)
        group = zarr.create_group(
            beside, attributes={MARKER: SCHEMA, ARRAYS: list(variables), **attributes}
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
    """Number of batches along each dimension, from the shapes of the status and of its chunks."""
    return tuple(-(-n // c) for n, c in zip(shape, chunk, strict=True))[:-1] or (1,)


def check_layout(folder: Path, attributes: Mapping[str, Any]) -> None:
    """Compare attributes, descriptions of arrays and values of axes with their digests."""
    schema, name = attributes.get(MARKER), os.fspath(folder)
    if not str(schema).startswith(FAMILY):
        raise InputError(f"{name!r} is not the store of a sweep and was not changed")
    if schema != SCHEMA:
        raise InputError(
            f"{name!r} has the layout {schema!r} of another version of hertzchain, and this "
            f"version reads {SCHEMA!r}: use the other version, or sweep again into another store"
        )
    others = {key: value for key, value in attributes.items() if key != SEAL}
    keys = json.loads((folder / GROUP_FILE).read_bytes()).keys() - {CONSOLIDATED}
    if document_digest(others) != attributes.get(SEAL) or keys != GROUP_KEYS:
        raise DamagedFileError(folder / GROUP_FILE, "is not as it was written", folder, RESTORE)
    for relative, digest in others[FILES].items():
        file = folder / relative
        if not file.is_file():
            raise DamagedFileError(file, "is missing", folder, RESTORE)
        if file_digest(file) != digest:
            raise DamagedFileError(file, "is not as it was written", folder, RESTORE)


def _remove_unfinished(folder: Path) -> None:
    """Remove a store that a killed process has not completed; raise an error for anything else."""
    if not os.path.lexists(folder):
        return
    files = [file for file in folder.rglob("*") if file.is_file()]
    ours = folder.is_dir() and not folder.is_symlink()
    ours = ours and all(ZARR_FILE.fullmatch(file.name) for file in files)
    if ours and folder / GROUP_FILE in files:
        with contextlib.suppress(ValueError):
            attributes = json.loads((folder / GROUP_FILE).read_bytes()).get("attributes", {})
            ours = str(attributes.get(MARKER)).startswith(FAMILY)
    elif ours:
        ours = all(file.suffix == ".partial" for file in files)
    if not ours:
        raise InputError(
            f"{os.fspath(folder)!r} is needed to create the new store, but hertzchain did not "
            "write it: move it away, or choose another name for the store"
        )
    shutil.rmtree(folder)


def _create_digests(group: Any, variables: Mapping[str, Variable]) -> None:
    """Create an array with one row of digests per batch, one digest per array."""
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
    """Store digests of all files that exist before the first batch."""
    files = sorted(file for file in folder.rglob("*") if file.is_file())
    digests = {
        file.relative_to(folder).as_posix(): file_digest(file)
        for file in files
        if file != folder / GROUP_FILE
    }
    attributes = {**group.attrs.asdict(), FILES: digests}
    group.update_attributes({**attributes, SEAL: document_digest(attributes)})


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
        # With a checksum, reading a chunk with a flipped bit is an error.
        compressors=ZstdCodec(checksum=True),
        config={"write_empty_chunks": True},
        dimension_names=variable.dimensions,
        attributes={**variable.attributes, **({BY_BATCH: 1} if by_batch else {})},
    )
    if variable.values is not None:
        array[...] = variable.values
