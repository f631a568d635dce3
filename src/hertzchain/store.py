"""Files: the only module that knows formats.

A chain file is TOML with one table ``[chain]`` that holds either a taper::

    [chain]
    taper = "backward-exponential"   # or "uniform", which has no rate
    rate = 0.05
    beads = 100

or any radii::

    [chain]
    radii = [5.0, 4.5, 4.0, 4.5, 5.0]

and, if the contacts are not Hertz', ``exponent``.
"""

from __future__ import annotations

import contextlib
import csv
import io
import json
import os
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from hertzchain import __version__
from hertzchain.chain import TAPERS, Chain
from hertzchain.errors import InputError, unknown_name
from hertzchain.pulse import Pulse
from hertzchain.run import Run

SCHEMA_VERSION: Final = 1
KEYS: Final = ("taper", "rate", "beads", "radii", "exponent")


def load_chain(path: str | os.PathLike[str]) -> Chain:
    r"""Read a chain from a TOML file.

    Parameters
    ----------
    path : path-like
        The file; its layout is at the top of this module.

    Returns
    -------
    Chain

    Raises
    ------
    InputError
        If the file is missing or unreadable, a key is unknown, missing or
        contradicts another, or a value is out of range; the file is named.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "chain.toml"
    ...     _ = file.write_text('[chain]\ntaper = "uniform"\nbeads = 20\n')
    ...     load_chain(file)
    Chain(uniform, 20 beads)
    """
    name = os.fspath(path)
    try:
        document = tomllib.loads(Path(path).read_text("utf-8-sig"))
    except OSError as error:
        raise InputError(
            f"cannot read chain file {name!r} ({error.strerror}); give the path of a TOML file"
        ) from None
    except UnicodeDecodeError:
        raise InputError(f"chain file {name!r} is not UTF-8 text; chain files are TOML") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"chain file {name!r} is not valid TOML: {error}") from None
    try:
        return _chain_from(document)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _chain_from(document: dict[str, Any]) -> Chain:
    for key in document:
        if key != "chain":
            raise unknown_name("table or key", key, ("chain",))
    table = document.get("chain")
    if not isinstance(table, dict):
        raise InputError("a chain file needs a table [chain]")
    for key in table:
        if key not in KEYS:
            raise unknown_name("key of [chain]", key, KEYS)
    law = {"exponent": table["exponent"]} if "exponent" in table else {}
    if "radii" in table:
        _refuse_beside("radii", table, ("taper", "rate", "beads"))
        return Chain.from_radii(table["radii"], **law)
    missing = [key for key in ("taper", "beads") if key not in table]
    if missing:
        raise InputError(
            f"[chain] has no {' and no '.join(missing)}; give taper, rate and beads, or radii"
        )
    if table["taper"] not in (*TAPERS, "uniform"):
        raise unknown_name("taper", table["taper"], (*TAPERS, "uniform"))
    if table["taper"] == "uniform":
        _refuse_beside('taper = "uniform"', table, ("rate",))
        return Chain.uniform(table["beads"], **law)
    if "rate" not in table:
        raise InputError(f"[chain] has taper = {table['taper']!r} but no rate, its S or q")
    return Chain.tapered(table["taper"], table["rate"], beads=table["beads"], **law)


def _refuse_beside(what: str, table: dict[str, Any], others: Sequence[str]) -> None:
    present = [key for key in others if key in table]
    if present:
        raise InputError(f"[chain] has {what} and also {', '.join(present)}: leave one out")


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
            | {name: values.tolist() for name, values in pulse.columns().items()}
            for pulse in pulses
        ],
    }
    return json.dumps(document, indent=2, allow_nan=False)


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
        "taper": chain.taper,
        "rate": chain.rate,
        "beads": chain.beads,
        "exponent": chain.exponent,
        "radii": chain.radii.tolist(),
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
        What a method does not predict is left empty.

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
            values = (column[i] if column is not None and i < len(column) else "" for column in
                      columns)  # fmt: skip
            writer.writerow([pulse.method, bead, pulse.chain.radii[i], *values])
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
    target = Path(path)
    if target.suffix == ".nc":
        # SciPy writes netCDF 3, which every netCDF reader reads, without another library.
        content: bytes = bytes(run.to_xarray().to_netcdf(engine="scipy"))
    elif target.suffix == ".csv":
        content = _run_as_csv(run).encode()
    else:
        raise InputError(f"cannot save a run as {target.name!r}: its ending must be .nc or .csv")
    write_bytes(target, content)


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
