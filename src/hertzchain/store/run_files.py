"""Runs as netCDF files, with the chain and everything that is needed to read the run back."""

from __future__ import annotations

import io
import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from .. import __version__
from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError
from ..simulation.checked_state import check_state
from ..simulation.run import Run
from ..simulation.state import State, fingerprint
from .chain_as_toml import chain_as_toml
from .chain_files import chain_from
from .digests import array_digest
from .netcdf_files import read_netcdf
from .record_versions import RECORDS_VERSION, check_records

if TYPE_CHECKING:
    import xarray as xr

# Attribute with the chain as a chain file, and the variable with the records of a run.
CHAIN_FILE: Final = "chain_file"
RECORDS: Final = "run_records"
# Attribute with the version of the records; files without it have version 1.
VERSION: Final = "records_version"
# Attribute of a file of `Pulse.save`.
PULSE: Final = "pulse_version"
# Variable of a part of a stream with the accumulators at the saved times.
ACCUMULATORS: Final = "run_accumulators"
# Fields of a run that are saved as variables of the dataset, and other numbers and texts.
SAVED: Final = {"time": "times", "position": "positions", "velocity": "velocities"}
NUMBERS: Final = (
    "end_time", "energy_drift", "momentum_drift", "steps", "evaluations", "rtol", "status",
    "method",
)  # fmt: skip
ARRAYS: Final = (
    "_accumulators", "_peaks", "_crossings", "_walls", "_impulses", "_completion", "_approaches",
    "_complete",
)  # fmt: skip


def run_as_netcdf(run: Run, chain_file: str, *, records: bool = False) -> bytes:
    """Content of a netCDF file with the trajectories and the chain file.

    With all records, it is a file of `Run.save`; otherwise it is a part of a stream.
    """
    dataset = run.to_xarray().assign_attrs({CHAIN_FILE: chain_file})
    if records:
        what = {"long_name": "records of the run, read by hertzchain.load_run"}
        dataset[RECORDS] = ("byte", np.frombuffer(_records(run), np.int8), what)
        dataset.attrs[VERSION] = RECORDS_VERSION
    else:
        what = {"long_name": "exchanged energies and momenta, read by hertzchain.load_run"}
        dataset[ACCUMULATORS] = (("time", "accumulator"), run._accumulators, what)
    # SciPy writes netCDF 3, which every netCDF reader supports, without another library.
    return bytes(dataset.to_netcdf(engine="scipy"))


def chain_file_of(chain: Chain) -> str:
    """The chain as a chain file; empty if there is none, as for custom loss laws."""
    try:
        return chain_as_toml(chain)
    except InputError:
        return ""


def _records(run: Run) -> bytes:
    """Everything in a run apart from its chain and saved times, with a digest."""
    arrays = {name: np.asarray(getattr(run, name)) for name in (*NUMBERS, *ARRAYS)}
    arrays |= {f"state_{name}": values for name, values in run.state.arrays.items()}
    if run._forces is not None:
        arrays["_forces"] = run._forces
    arrays["chain"] = np.array(fingerprint(run.chain))
    saved = {name: getattr(run, name) for name in SAVED.values()}
    arrays["digest"] = np.array(array_digest(arrays | saved))
    content = io.BytesIO()
    np.savez_compressed(content, **arrays)  # type: ignore[arg-type]
    return content.getvalue()


def read_run(file: Path) -> Run:
    """Read a file of `Run.save`."""
    name = os.fspath(file)
    dataset = read_netcdf(file, "run")
    saved, attributes = _variables(dataset), dataset.attrs
    if RECORDS not in saved:
        hint = (
            "read other netCDF files with xarray.open_dataset, and a part of a stream with "
            "load_run(FOLDER)"
        )
        if PULSE in attributes:
            hint = f"it contains a pulse; read it with load_pulse({name!r})"
        raise InputError(f"{name!r} is not a file of Run.save; {hint}")
    version = attributes.get("hertzchain_version")
    advice = "read its dataset with xarray.open_dataset, or simulate its chain again"
    check_records(repr(name), attributes.get(VERSION, 1), version, advice)
    chain = stored_chain(attributes.get(CHAIN_FILE), name)
    try:
        return _run_from(chain, saved)
    # NumPy and zipfile raise errors of many types for damaged records.
    except Exception as error:  # noqa: BLE001
        reason = f": {error}" if isinstance(error, InputError) else ""
        if version != __version__:
            raise InputError(
                f"{name!r} was written by hertzchain {version} and cannot be read as a run by "
                f"{__version__}{reason}; {advice}"
            ) from None
        raise InputError(
            f"{name!r} is damaged or was changed after it was written{reason}; restore it from a "
            "copy, or simulate its chain again"
        ) from None


def stored_chain(chain_file: object, name: str) -> Chain:
    """The chain of a stored run."""
    if not chain_file:
        raise InputError(
            f"{name!r} has no chain, because no chain file can describe it; simulate the chain "
            "again"
        )
    try:
        return chain_from(tomllib.loads(str(chain_file)))
    except (InputError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"the chain of {name!r} cannot be read: {error}") from None


def _variables(dataset: xr.Dataset) -> dict[str, Array]:
    names = (*SAVED, RECORDS)
    return {name: np.array(dataset[name]) for name in names if name in dataset.variables}


def _run_from(chain: Chain, saved: Mapping[str, Array]) -> Run:
    """Put a run together; raises errors of several types if parts of it are missing or changed."""
    motion = {field: saved[name].astype(float, copy=False) for name, field in SAVED.items()}
    with np.load(io.BytesIO(saved[RECORDS].astype(np.int8).tobytes())) as file:
        arrays = {name: np.asarray(file[name], order="C") for name in file.files}
    digest = str(arrays.pop("digest"))
    if digest != array_digest(arrays | motion):
        raise InputError("its numbers are not those of the run")
    if str(arrays["chain"]) != fingerprint(chain):
        raise InputError("its chain is not that of the run")
    prefix = "state_"
    inner = {
        name.removeprefix(prefix): values
        for name, values in arrays.items()
        if name.startswith(prefix)
    }
    state = State(chain, inner)
    check_state(state)
    fields: dict[str, Any] = {**motion, "_forces": arrays.get("_forces")}
    fields |= {name: arrays[name].item() for name in NUMBERS}
    fields |= {name: arrays[name] for name in ARRAYS}
    return Run(chain=chain, state=state, **fields)
