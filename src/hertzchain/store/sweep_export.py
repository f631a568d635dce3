"""Export a sweep to CSV, Parquet or netCDF."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

from ..errors import InputError
from ..validation.keywords import checked_arguments
from ..validation.objects import check_type, file_path
from .writing import cannot_write

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

# Variables that are 1 at points whose values are subject to a reservation.
FLAGS: Final = ("outside_range", "incomplete", "sensitive")
ENDINGS: Final = (".csv", ".parquet", ".nc")
# Approximate number of rows that are in memory at a time.
ROWS: Final = 500_000


@checked_arguments("export_sweep")
def export_sweep(dataset: xr.Dataset, path: str | os.PathLike[str]) -> None:
    """Write a sweep to a table with one row per point, method and bead, or to netCDF.

    Parameters
    ----------
    dataset : xarray.Dataset
        Result of `hertzchain.sweep` or `hertzchain.open_sweep`.
    path : path-like
        File to write.  Its ending selects the format: ``.csv``, ``.parquet`` or ``.nc``
        (netCDF-4).

    Raises
    ------
    InputError
        If the ending is another one, a package is not installed, the file cannot be written, or
        the store has damaged files.
    StoreError
        If the disk is full.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> from pathlib import Path
    >>> spec = {"chain": {"taper": "uniform"}, "axes": {"beads": [9]}, "sweep": {"at": "last"}}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     hc.export_sweep(hc.sweep(spec), Path(folder) / "sweep.csv")
    ...     print((Path(folder) / "sweep.csv").read_text().splitlines()[0])
    beads,approach,velocity,reason,status
    """
    target = file_path("file to export to", path)
    check_sweep(dataset)
    if target.suffix not in ENDINGS:
        raise InputError(f"a sweep is exported as {', '.join(ENDINGS)}, got {target.name!r}")
    beside = target.with_name(f".{target.name}.{os.getpid()}.partial")
    write = {".csv": _write_csv, ".parquet": _write_parquet, ".nc": _write_netcdf}[target.suffix]
    try:
        write(dataset, beside)
        beside.replace(target)
    except ImportError as error:
        raise InputError(
            f"{target.suffix} files need the package {error.name}: pip install '.[export]' in the "
            "folder of the source code"
        ) from None
    except OSError as error:
        raise cannot_write(path, error) from None
    finally:
        with contextlib.suppress(OSError):
            beside.unlink(missing_ok=True)


def check_sweep(dataset: object) -> None:
    """Raise `InputError` for anything but the dataset of a sweep."""
    import xarray as xr

    hint = "use the result of hertzchain.sweep or open_sweep"
    check_type("dataset", dataset, xr.Dataset, hint)
    if isinstance(dataset, xr.Dataset) and not {"status", "approach"} <= dataset.variables.keys():
        raise InputError(f"the dataset has no status, so it is not the result of a sweep: {hint}")


def _write_csv(dataset: xr.Dataset, file: Path) -> None:
    with file.open("w", encoding="utf-8", newline="") as stream:
        for number, table in enumerate(tables_of(dataset)):
            header = [_with_unit(dataset, str(name)) for name in table] if number == 0 else False
            table.to_csv(
                stream, header=header, index=False, lineterminator="\n", float_format="%.9g"
            )


def _with_unit(dataset: xr.Dataset, name: str) -> str:
    """Heading of a column, such as ``radius [mm]``; CSV files have no other place for units."""
    unit = dataset[name].attrs.get("units", "1") if name in dataset.variables else "1"
    return name if unit == "1" else f"{name} [{unit}]"


def _write_parquet(dataset: xr.Dataset, file: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    writer = None
    try:
        for frame in tables_of(dataset):
            table = pa.Table.from_pandas(frame, preserve_index=False)
            if writer is None:
                metadata = {key: str(value) for key, value in dataset.attrs.items()}
                schema = table.schema.with_metadata({**(table.schema.metadata or {}), **metadata})
                writer = pq.ParquetWriter(file, schema)
            writer.write_table(table.cast(writer.schema))
    finally:
        if writer is not None:
            writer.close()


def _write_netcdf(dataset: xr.Dataset, file: Path) -> None:
    # An ImportError names the missing package.
    import h5netcdf  # noqa: F401
    import h5py  # noqa: F401

    texts = {
        name: values.astype(object)
        for name, values in dataset.variables.items()
        if values.dtype.kind == "T"
    }
    dataset.assign(texts).to_netcdf(file, engine="h5netcdf")


def tables_of(dataset: xr.Dataset) -> Iterator[pd.DataFrame]:
    """Yield consecutive parts of a sweep as tables that fit into memory."""
    first = str(dataset.status.dims[0])
    beads = max(dataset.sizes.get("bead", 1), dataset.sizes.get("contact", 1))
    rows = max(1, ROWS * dataset.sizes[first] // max(1, dataset.status.size * beads))
    for start in range(0, dataset.sizes[first], rows):
        # Contacts and beads are merged part by part, since merging loads all values.
        part = _by_bead(dataset.isel({first: slice(start, start + rows)}).load())
        order = [str(name) for name in (*part.status.dims, "bead") if name in part.dims]
        table = part.to_dataframe(dim_order=order).reset_index()
        if "bead" in table and "beads" in table:
            table = table[table.bead <= table.beads]
        yield table[_in_reading_order(part, order, list(table))]


def _by_bead(dataset: xr.Dataset) -> xr.Dataset:
    """Move the values of contact k to bead k."""
    import xarray as xr

    if "contact" not in dataset.dims:
        return dataset
    contacts = dataset[[name for name in dataset if "contact" in dataset[name].dims]]
    others = dataset.drop_dims("contact")
    return xr.merge([others, contacts.rename(contact="bead")], join="outer")


def _in_reading_order(dataset: xr.Dataset, dimensions: list[str], names: list[str]) -> list[str]:
    """Order columns: coordinates, quantities, status."""
    parameters = [name for name in names if dataset[name].dims == ("point",)]
    known = (*FLAGS, "reason", "status")
    outcome = [name for name in known if name in names]
    first = list(dict.fromkeys([*dimensions[:1], *parameters, *dimensions]))
    return [*first, *(name for name in names if name not in (*first, *outcome)), *outcome]
