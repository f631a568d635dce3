"""Reading of netCDF files of results."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError

if TYPE_CHECKING:
    import xarray as xr


def read_netcdf(file: Path, result: str) -> xr.Dataset:
    """The dataset of a file that `save` of a result, a ``"run"`` or ``"pulse"``, has written."""
    import xarray as xr

    name = os.fspath(file)
    try:
        content = file.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read the {result} {name!r}: {error.strerror}") from None
    try:
        with xr.open_dataset(io.BytesIO(content), engine="scipy") as dataset:
            return dataset.load()
    # SciPy raises errors of many types for a damaged file.
    except Exception:  # noqa: BLE001
        if file.suffix.lower() == ".csv":
            raise InputError(
                f"{name!r} is a CSV file, which cannot be read back as a {result}: only a netCDF "
                f"file keeps its chain; save it with {result}.save('{result}.nc')"
            ) from None
        raise InputError(
            f"cannot read the {result} {name!r}: it is damaged or not a netCDF file of "
            f"{result.capitalize()}.save"
        ) from None
