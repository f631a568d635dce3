"""Reading of stored runs: files of `Run.save`, and folders of `stream`."""

from __future__ import annotations

import dataclasses
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from ..collision import Array
from ..errors import InputError, ModelRangeWarning
from ..recorded_warnings import ignore_warnings
from ..simulation.run import Run
from ..simulation.simulate import simulate
from ..validation.keywords import checked_arguments
from ..validation.memory import check_memory
from ..validation.objects import file_path
from .manifest import load_manifest
from .results import load_state
from .run_files import ACCUMULATORS, SAVED, read_run
from .stream_resume import STATE_FILE
from .streaming import StoredRun


@checked_arguments("load_run")
def load_run(path: str | os.PathLike[str]) -> Run:
    """Read a run from a netCDF file of `Run.save`, or from the folder of a stream.

    Parameters
    ----------
    path : path-like
        File, ``.nc``, of `Run.save` or ``hertzchain simulate --out``; or folder of `stream` or
        ``hertzchain simulate --stream``, also of a stream that is not complete.

    Returns
    -------
    Run
        The saved run with its chain; all its numbers are the same, bit for bit.  A streamed run is
        the same as one of `simulate` with these times; to read a part of its times, use
        `StoredRun.load`.

    Raises
    ------
    InputError
        If the file is missing, damaged, changed or not a file of `Run.save`; if its records have
        another version than those of this version of hertzchain; if a streamed run does not fit in
        memory; or if its chain cannot be described by a chain file, such as one with a custom loss
        law.

    Warns
    -----
    InputWarning
        If another version of hertzchain wrote the file: the stored values are unchanged, but
        results computed from them may differ.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> from pathlib import Path
    >>> run = hc.simulate(hc.Chain.uniform(9).replace(right_wall=hc.Wall()))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run.save(Path(folder) / "run.nc")
    ...     again = hc.load_run(Path(folder) / "run.nc")
    >>> again.wall_force().peak == run.wall_force().peak
    True
    """
    file = file_path("file of a run", path)
    return _streamed_run(file) if file.is_dir() else read_run(file)


def _streamed_run(folder: Path) -> Run:
    """All times of a stream, with the records at the last one."""
    stored, name = StoredRun(folder), os.fspath(folder)
    manifest = load_manifest(folder)
    parts = manifest.present(folder)
    if not parts:
        raise InputError(f"{name!r} has no saved times yet; read it later")
    chain, times = stored.chain, sum(part.times for part in parts)
    check_memory(
        f"{times} times of {chain.beads} beads", 2.0 * 8.0 * times * (3 * chain.beads + 7),
        "read some of the times with StoredRun(folder).load(start, stop)",
    )  # fmt: skip
    last, state = parts[-1].last, None
    if (folder / STATE_FILE).exists():
        state = load_state(folder / STATE_FILE, chain)
    # The state is that of the last whole step; the rest of the run is simulated again.
    end = last if state is None else max(last, state.time)
    with ignore_warnings(ModelRangeWarning):  # `stream` has issued it
        run = simulate(chain, start=state, times=[end], max_steps=sys.maxsize, **manifest.options)
    names = {**SAVED, "force": "_forces", ACCUMULATORS: "_accumulators"}
    columns: dict[str, list[Array]] = {name: [] for name in names}
    for dataset in stored._read(-np.inf, np.inf, skip_damaged=False):
        if ACCUMULATORS not in dataset:
            raise InputError(
                f"{name!r} was written by an earlier version and has no records of the run; read "
                "its times with StoredRun(folder).load(), or simulate its chain again"
            )
        for variable, found in columns.items():
            found.append(dataset[variable].to_numpy().astype(float, copy=False))
    fields: dict[str, Any] = {
        names[variable]: np.concatenate(found) for variable, found in columns.items()
    }
    if run._forces is None:
        del fields["_forces"]
    return dataclasses.replace(run, **fields)
