"""Where a streamed run stopped: the state to resume from, after checks of its folder."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError
from ..simulation.state import State
from .damage import DamagedFileError
from .manifest import MANIFEST_FILE, RESTORE, Manifest, load_manifest
from .results import load_state
from .writing import cannot_write

SavedTimes: TypeAlias = Callable[[], Array]
STATE_FILE: Final = "state.npz"
# Names of unfinished files of a killed run.
TEMPORARY: Final = re.compile(r"\.(part-\d{6}\.nc|state\.npz|manifest\.json)\.\d+\.partial")


def where_it_stopped(
    chain: Chain, folder: Path, wanted: Array, new: Manifest, saved: SavedTimes, *, any_step: bool
) -> tuple[Manifest, State | None, int]:
    """Manifest of the folder, state to resume from, and number of stored times.

    ``new`` is the manifest of a new run, and ``saved`` reads the stored times; with ``any_step``,
    the step of a stored run may differ.
    """
    name = os.fspath(folder)
    _remove_temporary(folder)
    if not (folder / MANIFEST_FILE).exists():
        return new, None, 0
    manifest = load_manifest(folder)
    if manifest.chain != new.chain:
        raise InputError(
            f"{name!r} contains a run of another chain than {chain.description}; choose another "
            "folder"
        )
    _check_same_steps(name, manifest, new, any_step)
    times = saved()
    if len(times) > len(wanted) or not np.array_equal(times, wanted[: len(times)]):
        raise InputError(f"{name!r} contains a run with other times; choose another folder")
    if len(manifest.present(folder)) > len(manifest.parts):
        manifest = manifest.written()
    state = _state_after(folder, manifest, chain)
    # A part is written before its state, so the last part may be later than the stored state.
    while manifest.parts and (state is None or state.time < manifest.parts[-1].first):
        manifest = manifest.without_last()
        manifest.save(folder)
        assert manifest.announced is not None
        (folder / manifest.announced.file).unlink()
    done = sum(part.times for part in manifest.parts)
    if state is not None and done < len(wanted) and state.time >= wanted[done]:
        how = f"has the time t = {state.time:g}, which is after the end of the last part"
        raise DamagedFileError(folder / STATE_FILE, how, folder, RESTORE)
    return manifest, state, done


def _check_same_steps(name: str, manifest: Manifest, new: Manifest, any_step: bool) -> None:
    """Raise `InputError` if a stored run has another method, tolerance or step."""
    if manifest.method != new.method:
        stored = f"method {manifest.method!r}"
        said = f"by {stored}, but now the method is {new.method!r}"
    elif new.step == 0.0 and manifest.rtol != new.rtol:
        stored = f"{manifest.rtol:g}"
        said = f"with rtol = {stored}, but now rtol is {new.rtol:g}"
    elif not any_step and manifest.step != new.step:
        stored = f"{manifest.step:g}"
        said = f"with step = {stored}, but now step is {new.step:g}"
    else:
        return
    raise InputError(
        f"{name!r} contains a run {said}; resume it with {stored}, or choose another folder"
    )


def _state_after(folder: Path, manifest: Manifest, chain: Chain) -> State | None:
    """The stored state; `None` if there is none yet."""
    file = folder / STATE_FILE
    if file.exists():
        return load_state(file, chain)
    if len(manifest.parts) > 1:
        raise DamagedFileError(file, "is missing", folder, RESTORE)
    return None


def _remove_temporary(folder: Path) -> None:
    """Remove unfinished files of a killed run."""
    try:
        for file in folder.iterdir():
            if TEMPORARY.fullmatch(file.name):
                file.unlink(missing_ok=True)
    except OSError as error:
        raise cannot_write(folder, error) from None


def start_again(folder: Path, manifest: Manifest, step: float) -> Manifest:
    """Remove the parts of a run, and return the manifest of the same run with another step."""
    while manifest.parts:
        manifest = manifest.without_last()
        manifest.save(folder)
        assert manifest.announced is not None
        (folder / manifest.announced.file).unlink()
        # Without parts, a state is the only trace of the run, and must not be resumed.
        if len(manifest.parts) == 1:
            (folder / STATE_FILE).unlink(missing_ok=True)
    manifest = replace(manifest, announced=None, step=step)
    manifest.save(folder)
    return manifest
