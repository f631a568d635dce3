"""Long runs on disk: a folder of netCDF files, written as the run goes on.

Each file holds some saved times and is written whole or not at all; after each, the state of
the run is stored, from which the next call goes on, to the last bit.  So the memory that a
run needs does not grow with its length, and what is on disk can be read at any time, by any
reader of netCDF, whatever becomes of the run.
"""

from __future__ import annotations

import math
import os
import sys
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from hertzchain.arguments import callback, file_path
from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import check_chain
from hertzchain.chain.hertz_range import warn_outside_hertz
from hertzchain.checks import real_numbers
from hertzchain.contacts import Array
from hertzchain.errors import InputError, ModelRangeWarning, StoreError, real_number, shown
from hertzchain.simulation.run import beginning_of
from hertzchain.simulation.simulate import DEFAULT_RTOL, Progress, checked_rtol, simulate
from hertzchain.simulation.state import State
from hertzchain.store.lock import lock
from hertzchain.store.results import load_state, save_run, save_state

if TYPE_CHECKING:
    import xarray as xr

# Size of a file [bytes], roughly, at most.
FILE_SIZE: Final = 2**24
# Files grow from so many times on, until one takes so long [s]: no more is lost when interrupted.
FIRST_TIMES: Final = 100
SECONDS_PER_FILE: Final = 10.0
STATE_FILE: Final = "state.npz"
FIRST_PART: Final = "part-000001.nc"


@dataclass(frozen=True)
class StoredRun:
    """A run in a folder.

    Attributes
    ----------
    folder : pathlib.Path
        The folder.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     stored = hc.stream(hc.Chain.uniform(5), folder, times=np.linspace(0, 9, 10))
    ...     float(stored.load(start=4.0).velocity.sel(bead=1)[0].round(6))
    -0.071085
    """

    folder: Path

    def __post_init__(self) -> None:
        object.__setattr__(self, "folder", file_path("folder", self.folder))

    @property
    def files(self) -> list[Path]:
        """The files, in order of time."""
        return sorted(self.folder.glob("part-*.nc"))

    def parts(self) -> Iterator[xr.Dataset]:
        """One dataset after another, in order of time.

        Yields
        ------
        xarray.Dataset
            As `Run.to_xarray` gives it.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     stored = hc.stream(hc.Chain.uniform(5), folder, times=[1.0, 2.0])
        ...     [part.sizes["time"] for part in stored.parts()]
        [2]
        """
        for file in self.files:
            with _opened(file) as part:
                whole = part.load()
            yield whole

    def load(self, start: float = -np.inf, stop: float = np.inf) -> xr.Dataset:
        """The saved times from ``start`` to ``stop`` in one dataset.

        Parameters
        ----------
        start, stop : float
            First and last time, both included [scaled, or s].

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        InputError
            If nothing was saved in that time, or a file is damaged.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     stored = hc.stream(hc.Chain.uniform(5), folder, times=[1.0, 2.0, 3.0])
        ...     stored.load(start=2.0).sizes["time"]
        2
        """
        import xarray as xr

        for name, given in (("start", start), ("stop", stop)):
            if math.isnan(real_number(name, given)):
                raise InputError(f"{name} must be a time, got nan")
        chosen = []
        for file in self.files:
            with _opened(file) as part:
                within = part.sel(time=slice(start, stop))
                if within.sizes["time"]:
                    chosen.append(within.load())
        if not chosen:
            raise InputError(
                f"{os.fspath(self.folder)!r} holds no times from {start:g} to {stop:g}"
            )
        return xr.concat(chosen, "time", data_vars="minimal", combine_attrs="override")


def stream(
    chain: Chain,
    folder: str | os.PathLike[str],
    *,
    times: ArrayLike,
    rtol: float = DEFAULT_RTOL,
    progress: Progress | None = None,
) -> StoredRun:
    """Simulate a chain, writing saved times into a folder as they come.

    Called again with the same chain, times and folder, it goes on where it stopped.  There
    is no step limit.

    Parameters
    ----------
    chain : Chain
        The chain.
    folder : path-like
        Folder for the files, new, empty or with this run in it; made if it does not exist.
    times : array_like
        Increasing times >= 0 at which to save [scaled, or s].
    rtol : float
        Tolerated error of a step.
    progress : callable, optional
        Called as ``progress(times_saved, times)``.

    Returns
    -------
    StoredRun

    Raises
    ------
    InputError
        If times are not increasing, the folder holds another run, one with another tolerance
        or anything else, is in use by another process, or damaged.
    hertzchain.StoreError
        If a file cannot be written; what was written before stays readable.
    SimulationError
        If the run fails.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     len(hc.stream(hc.Chain.uniform(5), folder, times=[1.0, 2.0]).files)
    1
    """
    check_chain("stream", chain)
    callback("progress", progress)
    rtol = checked_rtol(rtol)
    stored = StoredRun(file_path("folder", folder))
    wanted = real_numbers("time", times, unit=chain._unit("s"))
    row = wanted.ndim == 1 and wanted.size > 0
    if not (row and np.isfinite(wanted).all() and wanted[0] >= 0.0 and np.all(np.diff(wanted) > 0)):
        raise InputError(
            f"times to save at must be a list of increasing numbers >= 0, got {shown(times)}"
        )
    _make_folder(stored.folder)
    with lock(stored.folder / ".lock", stored.folder):
        _go_on(chain, stored, wanted, rtol, progress)
    return stored


def _go_on(
    chain: Chain, stored: StoredRun, wanted: Array, rtol: float, progress: Progress | None
) -> None:
    """Write what is missing, a file at a time."""
    state, done = _where_it_stopped(chain, stored, wanted, rtol)
    most = max(1, FILE_SIZE // (8 * (3 * chain.beads + 1)))
    count = min(FIRST_TIMES, most)
    overlaps = np.zeros(chain.beads + 1)
    while done < len(wanted):
        started, chunk = time.monotonic(), wanted[done : done + count]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelRangeWarning)  # once, at the end
            run = simulate(chain, start=state, times=chunk, rtol=rtol, max_steps=sys.maxsize)
        overlaps = np.maximum(overlaps, run.largest_overlaps)
        if done + count < len(wanted):
            # The end cut the last step short: what is saved within it comes again, uncut.
            run = beginning_of(run, int(np.searchsorted(chunk, run.state.time, "right")))
            if not len(run.times):
                count *= 2
                continue
        try:
            save_run(run, stored.folder / f"part-{len(stored.files) + 1:06d}.nc")
            save_state(run.state, stored.folder / STATE_FILE)
        except InputError as error:
            kept = f"times up to {wanted[done - 1]:g} are stored" if done else "nothing is stored"
            raise StoreError(f"{error}; {kept}, and a further call goes on from there") from None
        state, done = run.state, done + len(run.times)
        if progress is not None:
            progress(done, len(wanted))
        if time.monotonic() - started < SECONDS_PER_FILE:
            count = max(count, min(2 * count, most))
    warn_outside_hertz(chain, overlaps)


def _make_folder(folder: Path) -> None:
    """Make the folder; refuse one in use for something else, whose files are not ours."""
    name = os.fspath(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        found = sorted(file.name for file in folder.iterdir() if not file.name.startswith("."))
    except FileExistsError:
        raise InputError(
            f"{name!r} is a file, and a run needs a folder: choose another name"
        ) from None
    except OSError as error:
        raise InputError(
            f"cannot make folder {name!r} ({error.strerror}); choose another place"
        ) from None
    # The first part may have come without its state; then it is written anew.
    if STATE_FILE in found and FIRST_PART in found:
        return
    for other in (other for other in found if other != FIRST_PART):
        raise InputError(
            f"{name!r} holds {other!r} and no run of stream: choose a new or an empty folder"
        )


def _where_it_stopped(
    chain: Chain, stored: StoredRun, wanted: Array, rtol: float
) -> tuple[State | None, int]:
    """State to go on from and how many times are stored; of a file without its state, none."""
    if not (stored.folder / STATE_FILE).exists():
        for file in stored.files:
            file.unlink()
        return None, 0
    state = load_state(stored.folder / STATE_FILE, chain)
    with _opened(stored.files[0]) as part:
        began = float(part.attrs["rtol"])
    if began != rtol:
        raise InputError(
            f"{os.fspath(stored.folder)!r} holds a run with rtol = {began:g}, and now rtol is "
            f"{rtol:g}: go on with {began:g}, or choose another folder"
        )
    saved = np.concatenate([_times(file) for file in stored.files])
    # A file is written before its state: the last one may be ahead of it.
    if len(saved) > len(wanted) or not np.array_equal(saved, wanted[: len(saved)]):
        raise InputError(
            f"{os.fspath(stored.folder)!r} holds a run with other times: choose another folder"
        )
    while stored.files and state.time < (first := _times(stored.files[-1])[0]):
        saved = saved[saved < first]
        stored.files[-1].unlink()
    return state, len(saved)


def _times(file: Path) -> Array:
    with _opened(file) as part:
        return np.array(part.time)


@contextmanager
def _opened(file: Path) -> Iterator[xr.Dataset]:
    """A file, of which only what is looked at is read."""
    import xarray as xr

    try:
        with xr.open_dataset(file, engine="scipy") as part:
            yield part
    # SciPy raises what it likes of a file that is not as it was written.
    except (OSError, ValueError, TypeError, LookupError) as error:
        reason = str(error).partition("\n")[0]
        raise InputError(
            f"{os.fspath(file)!r} is damaged ({reason}): move its folder away and stream again"
        ) from None
