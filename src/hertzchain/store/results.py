"""Files of results: pulses and runs as JSON, CSV and netCDF."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
import os
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from hertzchain import __version__
from hertzchain.arguments import file_path, instance
from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import check_chain
from hertzchain.contacts import Array
from hertzchain.errors import InputError
from hertzchain.pulse.pulse import Pulse
from hertzchain.simulation.run import Run
from hertzchain.simulation.state import State, fingerprint

SCHEMA_VERSION: Final = 1


def pulses_as_json(pulses: Sequence[Pulse]) -> str:
    """One versioned JSON object with several pulses of one chain.

    Parameters
    ----------
    pulses : sequence of Pulse
        At least one; all of the same chain.

    Returns
    -------
    str

    Examples
    --------
    >>> import hertzchain as hc
    >>> document = json.loads(pulses_as_json([hc.bca(hc.Chain.uniform(3))]))
    >>> document["schema_version"], document["pulses"][0]["velocity"]
    (1, [1.0, 1.0, 1.0])
    """
    document = {
        "schema_version": SCHEMA_VERSION,
        "hertzchain_version": __version__,
        "chain": chain_as_dict(pulses[0].chain),
        "pulses": [
            {"method": pulse.method}
            | {name: _as_list(values) for name, values in pulse.columns().items()}
            | ({"notes": dict(pulse.notes)} if pulse.notes else {})
            for pulse in pulses
        ],
    }
    return json.dumps(document, indent=2, allow_nan=False)


def _as_list(values: Array) -> list[float | None]:
    """Numbers for JSON, which has no NaN."""
    return [None if math.isnan(value) else value for value in values.tolist()]


def chain_as_dict(chain: Chain) -> dict[str, Any]:
    """A chain as plain data, for JSON.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    dict

    Examples
    --------
    >>> chain_as_dict(Chain.uniform(2))["radii"]
    [1.0, 1.0]
    """
    return {
        "description": chain.description,
        "features": list(chain.features),
        "units": chain.units,
        "taper": chain.taper,
        "rate": chain.rate,
        "beads": chain.beads,
        "exponent": chain.exponent,
        "radii": chain.radii.tolist(),
        "masses": chain.masses.tolist(),
        "stiffness": chain.stiffness.tolist(),
    }


def pulses_as_csv(pulses: Sequence[Pulse]) -> str:
    """A row per method and bead; a quantity of contact k stands in row k.

    Parameters
    ----------
    pulses : sequence of Pulse
        At least one; all of the same chain.

    Returns
    -------
    str
        What a method does not predict, or a run has not seen, is left empty.

    Examples
    --------
    >>> import hertzchain as hc
    >>> print(pulses_as_csv([hc.bca(hc.Chain.uniform(2))]).splitlines()[0])
    method,bead,radius,velocity,momentum,energy,arrival,residence,peak_overlap,peak_force
    """
    names = list(dict.fromkeys(name for pulse in pulses for name in pulse.columns()))
    lines = io.StringIO()
    writer = csv.writer(lines, lineterminator="\n")
    writer.writerow(["method", "bead", "radius", *names])
    for pulse in pulses:
        columns = [pulse.column(name) for name in names]
        for i, bead in enumerate(pulse.bead):
            values = (column[i] if column is not None and i < len(column) else np.nan
                      for column in columns)  # fmt: skip
            cells = ("" if np.isnan(value) else value for value in values)
            writer.writerow([pulse.method, bead, pulse.chain.radii[i], *cells])
    return lines.getvalue()


def save_run(run: Run, path: str | os.PathLike[str]) -> None:
    """Save a run's trajectories: ``.nc`` (netCDF) or ``.csv``, by the file's ending.

    Parameters
    ----------
    run : Run
        A run with saved times.
    path : path-like
        File to write; an existing one is replaced once the new one is whole.

    Raises
    ------
    InputError
        For another ending, or if the file cannot be written.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_run(hc.simulate(hc.Chain.uniform(3), times=10), Path(folder) / "run.csv")
    """
    if not len(run.times):
        raise InputError("the run has saved no times to write; give times of at least 2")
    target = file_path("file of a run", path)
    if target.suffix == ".nc":
        # SciPy writes netCDF 3, which every netCDF reader reads, without another library.
        content: bytes = bytes(run.to_xarray().to_netcdf(engine="scipy"))
    elif target.suffix == ".csv":
        content = _run_as_csv(run).encode()
    else:
        raise InputError(f"cannot save a run as {target.name!r}: its ending must be .nc or .csv")
    write_bytes(target, content)


def save_state(state: State, path: str | os.PathLike[str]) -> None:
    """Save the state of a run, to go on from it later: ``.npz``.

    Parameters
    ----------
    state : State
        Such as ``run.state``.
    path : path-like
        File to write; an existing one is replaced once the new one is whole.

    Raises
    ------
    InputError
        If the file cannot be written.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> chain = hc.Chain.uniform(5)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_state(hc.simulate(chain, until=2.0).state, Path(folder) / "run.npz")
    ...     later = hc.simulate(chain, start=load_state(Path(folder) / "run.npz", chain), until=4.0)
    """
    instance("state", state, State, "run.state is one")
    target = file_path("state file", path)
    content = io.BytesIO()
    about = {"version": np.array(__version__), "chain": np.array(fingerprint(state.chain))}
    np.savez(content, **about, **state.arrays)  # type: ignore[arg-type]
    write_bytes(target, content.getvalue())


def load_state(path: str | os.PathLike[str], chain: Chain) -> State:
    """Read a state that `save_state` wrote.

    Parameters
    ----------
    path : path-like
        The file.
    chain : Chain
        The chain that it is a state of.

    Returns
    -------
    State

    Raises
    ------
    InputError
        If the file is missing or no such file, or comes from another chain or another
        version of hertzchain.

    Examples
    --------
    See `save_state`.
    """
    check_chain("load_state", chain)
    file_path("state file", path)
    name = os.fspath(path)
    try:
        with np.load(path) as file:
            arrays = {key: file[key] for key in file.files}
        version, of_chain = str(arrays.pop("version")), str(arrays.pop("chain"))
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        reason = getattr(error, "strerror", None) or "it is no file of save_state"
        raise InputError(f"cannot read state {name!r}: {reason}") from None
    if version != __version__:
        raise InputError(
            f"state {name!r} was written by hertzchain {version}, and this is {__version__}: "
            "start the run anew, or go on with that version"
        )
    if of_chain != fingerprint(chain):
        raise InputError(
            f"state {name!r} is one of another chain than {chain.description}: give the chain "
            "that it is from"
        )
    return State(chain, arrays)


def write_bytes(target: Path, content: bytes) -> None:
    """Write a file whole or not at all.

    Parameters
    ----------
    target : pathlib.Path
        File to write.
    content : bytes
        What it shall hold.

    Raises
    ------
    InputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_bytes(Path(folder) / "a.txt", b"done")
    """
    beside = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        beside.write_bytes(content)
        beside.replace(target)
    except OSError as error:
        with contextlib.suppress(OSError):
            beside.unlink(missing_ok=True)
        raise InputError(
            f"cannot write {os.fspath(target)!r} ({error.strerror}); choose another place"
        ) from None


def _run_as_csv(run: Run) -> str:
    time, bead = np.meshgrid(run.times, np.arange(1, run.chain.beads + 1), indexing="ij")
    table = np.column_stack(
        [time.ravel(), bead.ravel(), run.positions.ravel(), run.velocities.ravel()]
    )
    lines = io.StringIO()
    lines.write("time,bead,position,velocity\n")
    np.savetxt(lines, table, fmt=("%.12g", "%d", "%.12g", "%.12g"), delimiter=",")
    return lines.getvalue()
