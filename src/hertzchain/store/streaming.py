"""Long runs on disk: a folder of netCDF files that are written during the run.

Each file has some saved times and is written completely or not at all.  After each file, the state
of the run is stored, from which the next call resumes bit for bit.  The memory of a run therefore
does not grow with its length, and its files can be read at any time by any netCDF reader.  A
manifest lists the files with their digests (`hertzchain.store.manifest`), so that missing or
altered files are detected.
"""

from __future__ import annotations

import io
import math
import numbers
import os
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..chain.hertz_warnings import warn_outside_hertz
from ..collision import Array
from ..errors import (
    DamageWarning,
    InputError,
    InputWarning,
    ModelRangeWarning,
    StoreError,
    errors_at,
    real_number,
    warn_user,
)
from ..recorded_warnings import ignore_warnings
from ..representation import short
from ..simulation.fixed_steps import FixedSteps, fixed_steps
from ..simulation.run import Run
from ..simulation.saved_times import increasing_times
from ..simulation.simulate import DEFAULT_RTOL, checked_rtol, simulate
from ..simulation.state import State, fingerprint
from ..validation.keywords import checked_arguments, checked_fields, checked_methods
from ..validation.numbers import SCALED, plain_magnitude
from ..validation.objects import Progress, callback, check_bool, file_path
from .damage import DamagedFileError
from .file_lock import lock
from .manifest import (
    MANIFEST_FILE,
    RESTORE,
    SKIP,
    Manifest,
    Part,
    load_manifest,
)
from .results import save_state
from .run_files import ACCUMULATORS, chain_file_of, run_as_netcdf, stored_chain
from .stream_resume import STATE_FILE, start_again, where_it_stopped
from .writing import cannot_write, write_bytes

if TYPE_CHECKING:
    import xarray as xr

# Approximate maximum size of a file [bytes].
FILE_SIZE: Final = 2**24
# Number of times in the first file, and time that a file should take [s]; files grow until then,
# and an interruption loses at most one file.
FIRST_TIMES: Final = 100
SECONDS_PER_FILE: Final = 10.0
# Margin of the drift of a run that begins again, because its rest may drift further.
DRIFT_MARGIN: Final = 2.0


@checked_fields
@checked_methods
@dataclass(frozen=True)
class StoredRun:
    """A streamed run in a folder.

    Attributes
    ----------
    folder : pathlib.Path
        The folder.
    chain : Chain
        The chain of the run.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> import numpy as np
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     stored = hc.stream(hc.Chain.uniform(5), folder, times=np.linspace(0, 9, 10))
    ...     float(stored.load(start=4.0).velocity.sel(bead=1)[0].round(6)), stored.chain
    (-0.071085, Chain(uniform, 5 beads))
    """

    folder: Path

    def __post_init__(self) -> None:
        object.__setattr__(self, "folder", file_path("folder", self.folder))

    def __repr__(self) -> str:
        return short("StoredRun", repr(os.fspath(self.folder)))

    @property
    def files(self) -> list[Path]:
        """The files, in order of time."""
        with errors_at("StoredRun.files"):
            parts = load_manifest(self.folder).present(self.folder)
        return [self.folder / part.file for part in parts]

    @property
    def chain(self) -> Chain:
        """The chain of the run."""
        with errors_at("StoredRun.chain"):
            return stored_chain(load_manifest(self.folder).chain_file, os.fspath(self.folder))

    def parts(self, *, skip_damaged: bool = False) -> Iterator[xr.Dataset]:
        """Yield one dataset per file, in order of time.

        Parameters
        ----------
        skip_damaged : bool
            Whether to omit damaged files, with a `DamageWarning`.

        Yields
        ------
        xarray.Dataset
            As returned by `Run.to_xarray`.

        Raises
        ------
        InputError
            If there is no run, or a file is missing, altered or not part of this run.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     stored = hc.stream(hc.Chain.uniform(5), folder, times=[1.0, 2.0])
        ...     [part.sizes["time"] for part in stored.parts()]
        [2]
        """
        for part in self._read(-math.inf, math.inf, check_bool("skip_damaged", skip_damaged)):
            yield part.drop_vars(ACCUMULATORS, errors="ignore")

    def load(
        self,
        start: float | str = -np.inf,
        stop: float | str = np.inf,
        *,
        skip_damaged: bool = False,
    ) -> xr.Dataset:
        """Load the saved times from ``start`` to ``stop`` into one dataset.

        Parameters
        ----------
        start, stop : float or str
            First and last time, both included [scaled, or s]; in SI units also ``"1 ms"``.
        skip_damaged : bool
            Whether to omit damaged files, with a `DamageWarning`.

        Raises
        ------
        InputError
            If no time in this interval was saved, or a file is missing, altered or not part of
            this run.

        Examples
        --------
        >>> import hertzchain as hc, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     stored = hc.stream(hc.Chain.uniform(5), folder, times=[1.0, 2.0, 3.0])
        ...     stored.load(start=2.0).sizes["time"]
        2
        """
        import xarray as xr

        check_bool("skip_damaged", skip_damaged)
        first, last = self._checked_time("start", start), self._checked_time("stop", stop)
        within = (
            part.drop_vars(ACCUMULATORS, errors="ignore").sel(time=slice(first, last))
            for part in self._read(first, last, skip_damaged)
        )
        # A view would keep the other times of the part in memory.
        chosen = [part.copy(deep=True) for part in within if part.sizes["time"]]
        if not chosen:
            raise InputError(
                f"{os.fspath(self.folder)!r} has no saved times from {first:g} to {last:g}"
            )
        return xr.concat(chosen, "time", data_vars="minimal", combine_attrs="override")

    def _saved_times(self) -> Array:
        """All saved times."""
        return np.concatenate([np.array(part.time) for part in self.parts()] or [np.empty(0)])

    def _checked_time(self, name: str, given: object) -> float:
        # The unit is in the parts, which need not be read for a plain number.
        unit = None if isinstance(given, numbers.Real) else self._unit_of_time()
        time = real_number(name, plain_magnitude(name, given, unit))
        if math.isnan(time):
            raise InputError(f"{name} must be a time, got nan")
        return time

    def _unit_of_time(self) -> str:
        """Unit of the saved times."""
        for part in load_manifest(self.folder).present(self.folder):
            try:
                content = part.content(self.folder)
                unit = _dataset(self.folder / part.file, content).time.attrs.get("units")
            except DamagedFileError:
                continue
            return SCALED if unit is None else str(unit)
        return "s"  # without any part that can be read, which is the error to report

    def _read(self, start: float, stop: float, skip_damaged: bool) -> Iterator[xr.Dataset]:
        """Parts with times from ``start`` to ``stop``, after a check that all files exist."""

        def damaged(error: DamagedFileError) -> None:
            if not skip_damaged:
                raise error
            warn_user(f"{os.fspath(error.file)} {error.how}; it is omitted", DamageWarning)

        parts = _checked_parts(self.folder, damaged)
        for part in parts:
            if part.last >= start and part.first <= stop:
                try:
                    content = part.content(self.folder)
                except DamagedFileError as error:
                    damaged(error)
                    continue
                yield _dataset(self.folder / part.file, content)


@checked_arguments("stream")
def stream(
    chain: Chain,
    folder: str | os.PathLike[str],
    *,
    times: ArrayLike,
    rtol: float = DEFAULT_RTOL,
    method: str = "adaptive",
    step: float | None = None,
    drift: float | None = None,
    progress: Progress | None = None,
) -> StoredRun:
    """Simulate a chain and write saved times to a folder during the run.

    If a run was interrupted, call `stream` again with the same chain, times and folder to resume
    it.  There is no step limit.

    Parameters
    ----------
    chain : Chain
        The chain.
    folder : path-like
        Folder for the files: new, empty, or with this run.  It is created if necessary.
    times : array_like
        Increasing times >= 0 at which to save [scaled, or s].
    rtol : float
        Tolerated error of a step of the adaptive method.
    method, step, drift : str, float, float, optional
        As in `simulate`: ``"symplectic"`` takes fixed steps, which are faster in long runs of
        elastic chains.  If the energy drift exceeds ``drift``, the run begins again with shorter
        steps.  A run that is resumed keeps its step.
    progress : callable, optional
        Called as ``progress(times_saved, times)``.

    Raises
    ------
    InputError
        If times are not increasing, the method does not support the chain, or the folder contains
        another run, a run with another tolerance, method or step, or other files, is in use by
        another process, is damaged or cannot be written.
    hertzchain.StoreError
        If the disk is full; files written before remain readable.
    SimulationError
        If the run fails.

    Examples
    --------
    >>> import hertzchain as hc, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     len(hc.stream(hc.Chain.uniform(5), folder, times=[1.0, 2.0]).files)
    1
    """
    require_chain("stream", chain)
    callback("progress", progress)
    rtol = checked_rtol(rtol)
    stored = StoredRun(file_path("folder", folder))
    wanted = increasing_times(chain, times)
    fixed = fixed_steps(chain, method, step, drift, float(wanted[-1]) or None)
    new = Manifest(fingerprint(chain), rtol, chain_file_of(chain))
    if fixed is not None:
        new = replace(new, method=fixed.name, step=fixed.step)
    _make_folder(stored.folder)
    with lock(stored.folder / ".lock", stored.folder):
        found = where_it_stopped(
            chain, stored.folder, wanted, new, stored._saved_times, any_step=step is None
        )
        _resume(chain, stored, wanted, found, fixed, progress)
    return stored


def _resume(
    chain: Chain,
    stored: StoredRun,
    wanted: Array,
    found: tuple[Manifest, State | None, int],
    fixed: FixedSteps | None,
    progress: Progress | None,
) -> None:
    """Compute the missing times and write them, one file at a time."""
    manifest, state, done = found
    most = max(1, FILE_SIZE // (8 * (3 * chain.beads + 1)))
    count = min(FIRST_TIMES, most)
    overlaps, drift = np.zeros(chain.beads + 1), 0.0
    while done < len(wanted):
        started, chunk = time.monotonic(), wanted[done : done + count]
        with ignore_warnings(ModelRangeWarning, InputWarning):  # once, at the end
            run = simulate(
                chain, start=state, times=chunk, max_steps=sys.maxsize, **manifest.options
            )
        if fixed is not None and run.energy_drift > fixed.drift:
            excess = DRIFT_MARGIN * run.energy_drift / fixed.drift
            now = replace(fixed, step=manifest.step).shorter(excess)
            manifest = start_again(stored.folder, manifest, now.step)
            state, done, overlaps[:] = None, 0, 0.0
            continue
        overlaps, drift = np.maximum(overlaps, run.largest_overlaps), run.energy_drift
        if done + count < len(wanted):
            # The last step was shortened, so times saved within it are computed again.
            run = _beginning_of(run, int(np.searchsorted(chunk, run.state.time, "right")))
            if not len(run.times):
                count *= 2
                continue
        try:
            manifest = _write_part(stored.folder, manifest, run)
        except (InputError, StoreError) as error:
            kept = f"times up to {wanted[done - 1]:g} are stored" if done else "nothing is stored"
            raise type(error)(f"{error}; {kept}, from which another call resumes") from None
        state, done = run.state, done + len(run.times)
        if progress is not None:
            progress(done, len(wanted))
        if time.monotonic() - started < SECONDS_PER_FILE:
            count = max(count, min(2 * count, most))
    if fixed is not None:
        fixed.warn(drift)
    warn_outside_hertz(chain, overlaps, method="simulation")


def _write_part(folder: Path, manifest: Manifest, run: Run) -> Manifest:
    """Write a part and the state after it; return the manifest that lists the part."""
    content = run_as_netcdf(run, manifest.chain_file)
    announcing = manifest.announcing(Part.of(len(manifest.parts) + 1, content, run.times))
    announcing.save(folder)
    assert announcing.announced is not None
    write_bytes(folder / announcing.announced.file, content)
    save_state(run.state, folder / STATE_FILE)
    written = announcing.written()
    written.save(folder)
    return written


def _make_folder(folder: Path) -> None:
    """Create the folder; raise `InputError` if it contains other files."""
    name = os.fspath(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        found = sorted(file.name for file in folder.iterdir() if not file.name.startswith("."))
    except FileExistsError:
        raise InputError(
            f"{name!r} is a file, but a run requires a folder; choose another name"
        ) from None
    except OSError as error:
        raise cannot_write(folder, error) from None
    if found and MANIFEST_FILE not in found:
        raise InputError(
            f"{name!r} contains {found[0]!r} but no run of stream; choose a new or empty folder"
        )


def _checked_parts(folder: Path, damaged: Callable[[DamagedFileError], None]) -> tuple[Part, ...]:
    """The parts of a folder; reports files that are missing or not listed."""
    # The folder is read before the manifest, because a part is listed before it is written.
    found = sorted(file.name for file in folder.glob("part-*.nc"))
    manifest = load_manifest(folder)
    announced = () if manifest.announced is None else (manifest.announced,)
    known = {part.file for part in (*manifest.parts, *announced)}
    for name in found:
        if name not in known:
            advice = f"move it away: {MANIFEST_FILE} does not list it"
            damaged(DamagedFileError(folder / name, "is not part of this run", folder, advice))
    parts = manifest.present(folder)
    lost = [part for part in parts if not (folder / part.file).exists()]
    for part in lost:
        damaged(DamagedFileError(folder / part.file, "is missing", folder, SKIP))
    return tuple(part for part in parts if part not in lost)


def _dataset(file: Path, content: bytes) -> xr.Dataset:
    """The content of a part, in memory."""
    import xarray as xr

    try:
        with xr.open_dataset(io.BytesIO(content), engine="scipy") as part:
            return part.load()
    # SciPy raises errors of any type for a file that is not netCDF.
    except (OSError, ValueError, TypeError, LookupError) as error:
        reason = str(error).partition("\n")[0]
        raise DamagedFileError(file, f"is not netCDF ({reason})", file.parent, RESTORE) from None


def _beginning_of(run: Run, count: int) -> Run:
    """The run with only its first saved times."""
    return replace(
        run,
        times=run.times[:count],
        positions=run.positions[:count],
        velocities=run.velocities[:count],
        _forces=None if run._forces is None else run._forces[:count],
        _accumulators=run._accumulators[:count],
    )
