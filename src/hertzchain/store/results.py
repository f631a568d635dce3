"""Files of results: pulses and runs as JSON, CSV and netCDF."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import math
import os
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from hertzchain import __version__
from hertzchain.arguments import file_path, instance
from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import check_chain
from hertzchain.contacts import Array
from hertzchain.errors import InputError
from hertzchain.pulse.pulse import Pulse
from hertzchain.simulation.checked_state import check_state
from hertzchain.simulation.run import Run
from hertzchain.simulation.state import State, fingerprint
from hertzchain.store.writing import write_bytes

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
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_run(hc.simulate(hc.Chain.uniform(3), times=10), Path(folder) / "run.csv")
    """
    if not len(run.times):
        raise InputError("the run has saved no times to write; give times of at least 2")
    target = file_path("file of a run", path)
    if target.suffix == ".nc":
        content = run_as_netcdf(run)
    elif target.suffix == ".csv":
        content = _run_as_csv(run).encode()
    else:
        raise InputError(f"cannot save a run as {target.name!r}: its ending must be .nc or .csv")
    write_bytes(target, content)


def run_as_netcdf(run: Run) -> bytes:
    """Content of a netCDF file with a run's trajectories.

    Parameters
    ----------
    run : Run
        A run with saved times.

    Returns
    -------
    bytes

    Examples
    --------
    >>> import hertzchain as hc
    >>> run_as_netcdf(hc.simulate(hc.Chain.uniform(3), times=10))[:3]
    b'CDF'
    """
    # SciPy writes netCDF 3, which every netCDF reader reads, without another library.
    return bytes(run.to_xarray().to_netcdf(engine="scipy"))


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
    >>> from pathlib import Path
    >>> chain = hc.Chain.uniform(5)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_state(hc.simulate(chain, until=2.0).state, Path(folder) / "run.npz")
    ...     later = hc.simulate(chain, start=load_state(Path(folder) / "run.npz", chain), until=4.0)
    """
    instance("state", state, State, "run.state is one")
    target = file_path("state file", path)
    content = io.BytesIO()
    about = {"version": __version__, "chain": fingerprint(state.chain)}
    about["digest"] = _state_digest(about, state.arrays)
    texts = {name: np.array(text) for name, text in about.items()}
    np.savez(content, **texts, **state.arrays)  # type: ignore[arg-type]
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
        If the file is missing, is no such file or not as it was written, or comes from another
        chain or another version of hertzchain.

    Examples
    --------
    See `save_state`.
    """
    check_chain("load_state", chain)
    source, name = file_path("state file", path), os.fspath(path)
    try:
        with np.load(io.BytesIO(source.read_bytes())) as file:
            arrays = {key: np.asarray(file[key], order="C") for key in file.files}
        about = {key: str(arrays.pop(key)) for key in ("version", "chain", "digest")}
    # NumPy and zipfile raise many things for a file that is not as it was written.
    except Exception as error:  # noqa: BLE001
        reason = getattr(error, "strerror", None) or "it is no file of save_state, or damaged"
        raise InputError(f"cannot read state {name!r}: {reason}") from None
    if about["version"] != __version__:
        raise InputError(
            f"state {name!r} was written by hertzchain {about['version']}, and this is "
            f"{__version__}: start the run again, or continue with that version"
        )
    if about["chain"] != fingerprint(chain):
        raise InputError(
            f"state {name!r} is one of another chain than {chain.description}: give the chain "
            "that it is from"
        )
    if about.pop("digest") != _state_digest(about, arrays):
        raise InputError(
            f"state {name!r} is not as it was written: restore it from a copy, or start the run "
            "again"
        )
    state = State(chain, arrays)
    try:
        check_state(state)
    except InputError as error:
        raise InputError(f"state {name!r} cannot be used: {error}") from None
    return state


def _state_digest(about: Mapping[str, str], arrays: Mapping[str, Array]) -> str:
    found = hashlib.sha256(f"{about['version']} {about['chain']}".encode())
    for name in sorted(arrays):
        values = arrays[name]
        found.update(f"\0{name} {values.dtype.str} {values.shape}\0".encode())
        found.update(np.ascontiguousarray(values).tobytes())
    return found.hexdigest()


def _run_as_csv(run: Run) -> str:
    time, bead = np.meshgrid(run.times, np.arange(1, run.chain.beads + 1), indexing="ij")
    table = np.column_stack(
        [time.ravel(), bead.ravel(), run.positions.ravel(), run.velocities.ravel()]
    )
    lines = io.StringIO()
    lines.write("time,bead,position,velocity\n")
    np.savetxt(lines, table, fmt=("%.12g", "%d", "%.12g", "%.12g"), delimiter=",")
    return lines.getvalue()
