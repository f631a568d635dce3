"""Pulses as netCDF files, with their chain, and as CSV files."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from .. import __version__
from ..errors import InputError
from ..pulse.pulse import Pulse
from ..pulse.quantities import QUANTITIES
from ..validation.keywords import checked_arguments
from ..validation.objects import file_path
from .digests import array_digest
from .netcdf_files import read_netcdf
from .results import pulses_as_csv
from .run_files import CHAIN_FILE, PULSE, RECORDS, chain_file_of, stored_chain
from .writing import write_bytes

if TYPE_CHECKING:
    import xarray as xr

# Version of the layout of these files.
VERSION: Final = 1
# Attributes from which a pulse is read, in addition to its variables.
TEXTS: Final = ("method", "notes", CHAIN_FILE)
AGAIN: Final = "restore it from a copy, or compute the pulse again"


def save_pulse(pulse: Pulse, path: str | os.PathLike[str]) -> None:
    """Write a pulse as ``.nc`` or ``.csv``, by the file's extension."""
    target = file_path("file of a pulse", path)
    if target.suffix == ".nc":
        content = _as_netcdf(pulse)
    elif target.suffix == ".csv":
        content = pulses_as_csv([pulse]).encode()
    else:
        raise InputError(f"the name of a pulse file must end in .nc or .csv, got {target.name!r}")
    write_bytes(target, content)


def _as_netcdf(pulse: Pulse) -> bytes:
    dataset = pulse.to_xarray().assign_attrs(
        {
            "hertzchain_version": __version__,
            PULSE: VERSION,
            CHAIN_FILE: chain_file_of(pulse.chain),
            "notes": json.dumps(dict(pulse.notes)),
            "restitution": float(pulse.restitution),
        }
    )
    dataset.attrs["digest"] = _digest(dataset)
    return bytes(dataset.to_netcdf(engine="scipy"))


def _digest(dataset: xr.Dataset) -> str:
    """Digest of everything from which a pulse is read."""
    arrays = {
        str(name): np.asarray(values, float).astype("<f8")
        for name, values in dataset.data_vars.items()
    }
    arrays["restitution"] = np.array(float(dataset.attrs["restitution"]))
    return array_digest(arrays, json.dumps([str(dataset.attrs[name]) for name in TEXTS]))


@checked_arguments("load_pulse")
def load_pulse(path: str | os.PathLike[str]) -> Pulse:
    """Read a pulse from a netCDF file of `Pulse.save`.

    Parameters
    ----------
    path : path-like
        File, ``.nc``, of `Pulse.save`.

    Returns
    -------
    Pulse
        The saved pulse with its chain and notes; all its numbers are the same, bit for bit.

    Raises
    ------
    InputError
        If the file is missing, damaged, changed or not a file of `Pulse.save`, or has a layout that
        this version does not read; or if its chain cannot be described by a chain file, such as one
        with a custom loss law.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> from pathlib import Path
    >>> chain = hc.Chain.uniform(9)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     hc.propagate(chain).save(Path(folder) / "pulse.nc")
    ...     pulse = hc.load_pulse(Path(folder) / "pulse.nc")
    >>> hc.bca(chain).compare(pulse).worst("velocity") > 0.1
    True
    """
    file = file_path("file of a pulse", path)
    name = os.fspath(file)
    dataset = read_netcdf(file, "pulse")
    attributes = dataset.attrs
    if PULSE not in attributes:
        hint = f"read it with load_run({name!r}).pulse()" if RECORDS in dataset else (
            "read other netCDF files with xarray.open_dataset"
        )  # fmt: skip
        raise InputError(f"{name!r} is not a file of Pulse.save; {hint}")
    if str(attributes[PULSE]) != str(VERSION):
        raise InputError(
            f"{name!r} was written by hertzchain {attributes.get('hertzchain_version')} with "
            f"layout {attributes[PULSE]}, but hertzchain {__version__} reads layout {VERSION}; "
            "read its dataset with xarray.open_dataset, or compute the pulse again"
        )
    try:
        whole = attributes["digest"] == _digest(dataset)
    # Attributes or values of another type than those that were written.
    except (KeyError, TypeError, ValueError):
        whole = False
    if not whole:
        raise InputError(f"{name!r} is damaged or was changed after it was written; {AGAIN}")
    return _pulse_from(dataset, name)


def _pulse_from(dataset: xr.Dataset, name: str) -> Pulse:
    attributes = dataset.attrs
    chain = stored_chain(attributes[CHAIN_FILE], name)
    for quantity, expected in (("radius", chain.radii), ("mass", chain.masses)):
        if not np.array_equal(np.asarray(dataset[quantity]), expected):
            raise InputError(
                f"the chain of {name!r} has another {quantity} in hertzchain {__version__} than in "
                f"{attributes.get('hertzchain_version')}, which wrote it; compute the pulse again"
            )
    columns: dict[str, Any] = {
        each.name: np.asarray(dataset[each.name], float)
        for each in QUANTITIES.values()
        if each.stored and each.name in dataset
    }
    return Pulse(
        chain, str(attributes["method"]), notes=json.loads(attributes["notes"]),
        restitution=float(attributes["restitution"]), **columns,
    )  # fmt: skip
