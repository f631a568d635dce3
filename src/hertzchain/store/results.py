"""Write pulses and runs as JSON, CSV and netCDF; save and load states."""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from .. import __version__
from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..collision import Array
from ..errors import InputError
from ..pulse.pulse import Pulse
from ..pulse.quantities import RUN_QUANTITIES, TIME
from ..simulation.checked_state import check_state
from ..simulation.run import Run
from ..simulation.state import State, fingerprint
from ..validation.json_types import finite
from ..validation.keywords import checked_arguments
from ..validation.objects import check_type, file_path
from .chain_as_toml import chain_document
from .digests import array_digest
from .record_versions import RECORDS_VERSION, check_records
from .run_files import chain_file_of, run_as_netcdf
from .writing import write_bytes

SCHEMA_VERSION: Final = 1
# Digits of the largest force in files of forces.
DIGITS: Final = 8


def pulses_as_json(pulses: Sequence[Pulse], more: Sequence[str] = ()) -> str:
    """Convert several pulses of one chain to one versioned JSON object.

    Parameters
    ----------
    pulses : sequence of Pulse
        At least one; all of the same chain.
    more : sequence of str
        Quantities that `Pulse.columns` omits, such as ``"speed"``.

    Examples
    --------
    >>> import hertzchain as hc
    >>> import json
    >>> from hertzchain.store.results import pulses_as_json
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
            | {name: finite(values.tolist()) for name, values in _columns(pulse, more).items()}
            | ({"notes": dict(pulse.notes)} if pulse.notes else {})
            for pulse in pulses
        ],
    }
    return json.dumps(document, indent=2, allow_nan=False)


def chain_as_dict(chain: Chain) -> dict[str, Any]:
    """Convert a chain to plain data for JSON.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.store.results import chain_as_dict
    >>> chain_as_dict(hc.Chain.uniform(2))["radii"]
    [1.0, 1.0]
    """
    return {
        "description": chain.description,
        "features": list(chain.features),
        "units": chain.units,
        "taper": chain.taper,
        **({"rate": None} | dict(chain.taper_parameters)),
        "beads": chain.beads,
        "exponent": np.asarray(chain.exponents).tolist(),
        "radii": chain.radii.tolist(),
        "masses": chain.masses.tolist(),
        "stiffness": chain.stiffness.tolist(),
    }


def document_of(chain: Chain) -> dict[str, Any]:
    """The versions, and the chain as arrays and as the tables of a chain file, for JSON."""
    return {
        "schema_version": SCHEMA_VERSION,
        "hertzchain_version": __version__,
        "chain": chain_as_dict(chain),
        "chain_file": chain_document(chain),
    }


def pulses_as_csv(pulses: Sequence[Pulse], more: Sequence[str] = ()) -> str:
    """Convert pulses to CSV text with one row per method and bead.

    Quantities of contact k are in row k.

    Parameters
    ----------
    pulses : sequence of Pulse
        At least one; all of the same chain.
    more : sequence of str
        As for `pulses_as_json`.

    Returns
    -------
    str
        Values that a method does not predict, or a run has not determined, are empty.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.store.results import pulses_as_csv
    >>> print(pulses_as_csv([hc.bca(hc.Chain.uniform(2))]).splitlines()[0])
    method,bead,radius,velocity,momentum,energy,arrival,residence,peak_overlap,peak_force
    """
    names = list(dict.fromkeys(name for pulse in pulses for name in _columns(pulse, more)))
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


def _columns(pulse: Pulse, more: Sequence[str]) -> dict[str, Array]:
    """The columns of a pulse, and further quantities that its method predicts."""
    further = {name: pulse.column(name) for name in more}
    return pulse.columns() | {name: each for name, each in further.items() if each is not None}


@checked_arguments("save_run")
def save_run(run: Run, path: str | os.PathLike[str]) -> None:
    """Save the trajectories of a run as ``.nc`` (netCDF) or ``.csv``, by the file's extension.

    `load_run` reads a netCDF file as a `Run` again.  Any netCDF reader reads its variables, which
    are those of `Run.to_xarray`, and its attribute ``chain_file``, the chain as TOML.  A CSV file
    has one row per saved time and bead.  The force of contact k, on bead k + 1 or the right wall,
    is in the row of bead k; a left wall has rows of bead 0.

    Parameters
    ----------
    run : Run
        A run with saved times.
    path : path-like
        File to write; an existing file is replaced when the new one is complete.

    Raises
    ------
    InputError
        For another extension, or if no times were saved or the file cannot be written.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     hc.save_run(hc.simulate(hc.Chain.uniform(3), times=10), Path(folder) / "run.csv")
    """
    check_type("run", run, Run, "simulate makes one")
    if not len(run.times):
        raise InputError("the run has no saved times to write; give simulate times of at least 2")
    target = file_path("file of a run", path)
    if target.suffix == ".nc":
        content = run_as_netcdf(run, chain_file_of(run.chain), records=True)
    elif target.suffix == ".csv":
        content = _run_as_csv(run).encode()
    else:
        raise InputError(f"the name of a run file must end in .nc or .csv, got {target.name!r}")
    write_bytes(target, content)


@checked_arguments("save_state")
def save_state(state: State, path: str | os.PathLike[str]) -> None:
    """Save the state of a run to a ``.npz`` file, from which the run can be resumed.

    Parameters
    ----------
    state : State
        For example ``run.state``.
    path : path-like
        File to write; an existing file is replaced when the new one is complete.

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
    ...     file = Path(folder) / "run.npz"
    ...     hc.save_state(hc.simulate(chain, until=2.0).state, file)
    ...     later = hc.simulate(chain, start=hc.load_state(file, chain), until=4.0)
    """
    check_type("state", state, State, "run.state is one")
    target = file_path("state file", path)
    content = io.BytesIO()
    about = {"version": __version__, "chain": fingerprint(state.chain)}
    about["digest"] = array_digest(state.arrays, f"{about['version']} {about['chain']}")
    about["records"] = str(RECORDS_VERSION)
    texts = {name: np.array(text) for name, text in about.items()}
    np.savez(content, **texts, **state.arrays)  # type: ignore[arg-type]
    write_bytes(target, content.getvalue())


@checked_arguments("load_state")
def load_state(path: str | os.PathLike[str], chain: Chain) -> State:
    """Load a state from a file of `save_state`.

    Parameters
    ----------
    path : path-like
        The file.
    chain : Chain
        The chain of the saved run.

    Raises
    ------
    InputError
        If the file is missing, damaged, not a file of `save_state`, or from another chain, or
        if its records have another version than those of this version of hertzchain.

    Warns
    -----
    InputWarning
        If another version of hertzchain wrote the file: the rest of the run may differ from that
        version's.

    Examples
    --------
    See `save_state`.
    """
    require_chain("load_state", chain)
    source, name = file_path("state file", path), os.fspath(path)
    try:
        with np.load(io.BytesIO(source.read_bytes())) as file:
            arrays = {key: np.asarray(file[key], order="C") for key in file.files}
        about = {key: str(arrays.pop(key)) for key in ("version", "chain", "digest")}
        # Files without it have version 1.
        records = arrays.pop("records", 1)
    # NumPy and zipfile raise errors of many types for a damaged file.
    except Exception as error:  # noqa: BLE001
        reason = getattr(error, "strerror", None) or "it is damaged or not a file of save_state"
        raise InputError(f"cannot read state {name!r}: {reason}") from None
    advice = f"restart the run, or resume it with {about['version']}"
    check_records(f"state {name!r}", records, about["version"], advice)
    if about["chain"] != fingerprint(chain):
        raise InputError(
            f"state {name!r} belongs to another chain than {chain.description}; give the chain "
            "of the saved run"
        )
    if about["digest"] != array_digest(arrays, f"{about['version']} {about['chain']}"):
        raise InputError(
            f"state {name!r} was changed after it was written; restore it from a copy, or restart "
            "the run"
        )
    state = State(chain, arrays)
    try:
        check_state(state)
    except InputError as error:
        raise InputError(f"state {name!r} cannot be used: {error}") from None
    return state


def _run_as_csv(run: Run) -> str:
    """Table of a run: one row per saved time and bead, with the force on the next bead or wall."""
    beads = np.arange(1, run.chain.beads + 1)
    columns = [run.positions, run.velocities, run.forces[:, 1:]]
    if run.chain.left_wall is not None:
        # Bead 0 is the wall; its motion is not recorded.
        nothing = np.full((len(run.times), 1), np.nan)
        beads = np.insert(beads, 0, 0)
        columns = [np.hstack((nothing, each)) for each in columns[:2]] + [run.forces]
    names = ("time", "position", "velocity", "force")
    time, position, velocity, force = (_header(name, run.chain.units) for name in names)
    lines = io.StringIO()
    lines.write(f"{time},bead,{position},{velocity},{force}\n")
    times, numbers = np.meshgrid(run.times, beads, indexing="ij")
    table = np.column_stack([each.ravel() for each in (times, numbers, *columns)])
    np.savetxt(lines, table, fmt=("%.12g", "%d", "%.12g", "%.12g", "%.12g"), delimiter=",")
    return lines.getvalue().replace("nan", "")


def _header(name: str, units: str) -> str:
    """Header of a column, with a unit in SI units, such as ``velocity [m/s]``."""
    unit = {"time": TIME, **RUN_QUANTITIES}[name].unit_in(units)
    return name if unit == "1" else f"{name} [{unit}]"


def write_forces(
    times: Array, columns: Mapping[str, Array], units: str, path: str | os.PathLike[str],
    acceleration: Array | None = None,
) -> None:  # fmt: skip
    """Write forces over time, and the acceleration of a body, as CSV; see `Run.save_forces`."""
    target = file_path("file of forces", path)
    if target.suffix != ".csv":
        raise InputError(f"the name of a file of forces must end in .csv, got {target.name!r}")
    si = units == "SI"
    headers = ["time [us]" if si else "time", *(f"{name} [N]" if si else name for name in columns)]
    decimals = [_decimals(columns.values())] * len(columns)
    values = [*columns.values()]
    if acceleration is not None:
        headers.append("body acceleration [m/s^2]" if si else "body acceleration")
        decimals.append(_decimals([acceleration]))
        values.append(acceleration)
    rounded = [np.round(each, n) + 0.0 for each, n in zip(values, decimals, strict=True)]
    lines = io.StringIO()
    lines.write(",".join(headers) + "\n")
    table = np.column_stack([1e6 * times if si else times, *rounded])
    np.savetxt(lines, table, fmt=["%.12g", *(f"%.{max(n, 0)}f" for n in decimals)], delimiter=",")
    write_bytes(target, lines.getvalue().encode())


def _decimals(columns: Iterable[Array]) -> int:
    """Decimals of columns with the same unit, from the largest value."""
    largest = max(float(np.abs(each).max()) for each in columns)
    # Rounded forces have a step, from which load_traces determines their uncertainty.
    return DIGITS - 1 - math.floor(math.log10(largest)) if largest > 0.0 else 0
