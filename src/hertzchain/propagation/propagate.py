"""Simulate the leading pulse, in 0.3 to 0.4 ms for a tapered chain of a hundred beads.

`propagate` simulates one chain, `propagate_many` an ensemble.  Both integrate the same
equation of motion as `hertzchain.simulate`, but only for the beads around the pulse
(`hertzchain.propagation.window_choice`).
"""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..chain.chain import Chain
from ..chain.feature_support import (
    require_chain,
    require_same_units,
    require_struck,
    require_supported,
)
from ..chain.hertz_warnings import warn_outside_hertz
from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError, SimulationError, short_repr
from ..frozen import once
from ..pulse.notes import bouncing_notes
from ..pulse.pulse import Pulse, assemble_pulse
from ..pulse.pulse_table import PulseTable
from ..pulse.table_warnings import warn_failed, warn_outside_hertz_once
from ..threads import run_in_threads
from ..validation.keywords import checked_arguments
from ..validation.numbers import number, real_numbers, worker_count
from ..validation.objects import Progress, callback, check_list
from .batch import COLUMNS, Batch, PulseData
from .heterogeneous import MAX_RTOL
from .window_choice import follow

# Features of a chain, in addition to its radii, that are supported.
SUPPORTED: Final = (
    "SI units", "masses", "stiffness", "strikers", "velocities", "mixed exponents", "cap",
)  # fmt: skip
# Features that do not follow from the radii and the exponent of a chain.
OWN: Final = frozenset(SUPPORTED) - {"SI units"}

DEFAULT_RTOL: Final = 1e-8
# Below this tolerance, rounding and the treatment of opening contacts would dominate the error.
MIN_RTOL: Final = 1e-10
# Number of beads per task: at most a quarter of a second for tapers, and enough to use all lanes
# of the kernel, while a small ensemble of heterogeneous chains still has tasks for all threads.
BLOCK_BEADS, MIN_BLOCK = 100_000, 5_000
# Chains up to this length take so little time that they need not be interruptible.
SHORT: Final = 20_000


@checked_arguments("propagate")
def propagate(
    chain: Chain, *, rtol: float = DEFAULT_RTOL, progress: Progress | None = None
) -> Pulse:
    """Simulate the leading pulse of a chain by integrating the beads around it.

    The beads may have any masses, and the contacts any stiffness and exponents.

    Parameters
    ----------
    chain : Chain
        Chain to simulate, scaled or in SI units; at time 0 only bead 1 moves, forwards, and all
        beads touch.  Losses, walls, drives, gaps and static forces are not supported.
    rtol : float
        Relative tolerance, from 1e-10 to 1e-5.  For chains of a hundred beads, errors of
        velocities and times are at most ten times as large.  For smaller errors, see
        `hertzchain.simulate`.
    progress : callable, optional
        Called as ``progress(beads_passed, beads)`` a few times per second; strikers are not
        counted.

    Returns
    -------
    Pulse
        Leading pulse.

    Raises
    ------
    InputError
        If the chain has a feature that is not supported, or the tolerance is out of range.
    SimulationError
        If the pulse does not reach the end of the chain, or if its motion amplifies errors so
        much that the tolerance cannot be reached.

    Examples
    --------
    In a chain of equal beads, the leading pulse approaches a solitary wave of amplitude
    0.681631549:

    >>> import hertzchain as hc
    >>> round(float(hc.propagate(hc.Chain.uniform(60)).velocity[50]), 8)
    0.68163155
    """
    require_chain("propagate", chain)
    short = chain.beads <= SHORT
    batch = _batch_of(chain) if short else _new_batch(chain)
    callback("progress", progress)
    rtol = checked_rtol(rtol)
    if short and progress is None:
        data = follow(batch, rtol, np.zeros(2, np.int64))
    else:
        data = _follow_with_progress(batch, rtol, progress, chain.strikers)
    if data.reasons:
        raise SimulationError(data.reasons[0])
    columns = data.columns
    columns.setflags(write=False)
    velocity, peak_time, arrival, overlap, residence = columns
    overlap, residence = overlap[:-1], residence[:-1]
    warn_outside_hertz(chain, overlap, method="propagation")
    # Two times of the struck bead are 0, and two entries after the last contact NaN.
    sound = np.count_nonzero((columns > 0.0) & (columns < np.inf)) == columns.size - 4
    build = assemble_pulse if sound else Pulse
    return build(
        chain=chain, method="propagation", velocity=velocity, peak_time=peak_time, arrival=arrival,
        peak_overlap=overlap, residence=residence, notes=bouncing_notes(chain.masses),
    )  # fmt: skip


@checked_arguments("propagate_many")
def propagate_many(
    chains: Iterable[Chain | ArrayLike] | ArrayLike,
    *,
    rtol: float = DEFAULT_RTOL,
    threads: int | None = None,
    progress: Progress | None = None,
) -> PulseTable:
    """Simulate the leading pulses of many chains in parallel.

    Parameters
    ----------
    chains : iterable of Chain or array_like, or array_like of shape (C, N)
        Chains as for `propagate`, or rows of radii in any unit, each starting with the struck
        bead.  Rows may differ in length.  Results of a row are in units of its first bead; for
        random chains in the same units, use `Chain.with_scatter`.
    rtol : float
        Relative tolerance, as for `propagate`.
    threads : int, optional
        Number of threads.  The default is one per processor.
    progress : callable, optional
        Called as ``progress(chains_done, chains)`` a few times per second.

    Returns
    -------
    PulseTable
        Leading pulses of all chains.  If a chain fails, its row is NaN and the table states
        the reason.

    Raises
    ------
    InputError
        If an option is out of range.

    Warns
    -----
    IncompleteWarning
        If chains fail, with the reason of the first.
    ModelRangeWarning
        If chains exceed the limits of Hertz's law.

    Examples
    --------
    >>> import hertzchain as hc
    >>> rates = [0.02, 0.04, 0.06]
    >>> chains = [hc.Chain.tapered("forward-exponential", q, beads=50) for q in rates]
    >>> hc.propagate_many(chains).velocity[:, -1].round(3)
    array([ 4.053, 14.765, 46.469])
    """
    callback("progress", progress)
    rtol, threads = checked_rtol(rtol), worker_count("threads", threads)
    ensemble = _Ensemble.of(chains)
    blocks = list(ensemble.blocks(threads))
    run_in_threads(
        blocks, lambda rows, signal: follow(ensemble.batch(rows), rtol, signal), ensemble.store,
        threads=threads, of="chains", total=len(ensemble.beads), done=len(ensemble.reasons),
        counted=False, progress=progress,
    )  # fmt: skip
    table = ensemble.table()
    warn_failed(len(table), table.reasons)
    warn_outside_hertz_once(table)
    return table


def _new_batch(chain: Chain) -> Batch:
    """One chain as a batch, if its pulse can be computed in a window."""
    _require_supported("propagate", chain)
    return Batch.of([chain])


_batch_of = once(_new_batch)


def _require_supported(method: str, chain: Chain) -> None:
    """Raise an error for a chain whose pulse cannot be computed in a window."""
    require_supported(chain, method, supported=SUPPORTED, alternative="use simulate")
    moving = np.flatnonzero(chain.velocities)
    if len(moving) and moving[-1] > 0:
        raise InputError(
            f"{method} needs a chain in which only bead 1 moves at time 0, but bead "
            f"{moving[-1] + 1} has velocity {chain.velocities[moving[-1]]:g}; use simulate "
            f"(chain: {chain.description})"
        )
    require_struck(method, chain)


def rows_of(chains: Iterable[Chain | ArrayLike] | ArrayLike) -> list[Chain | ArrayLike]:
    """Check a list of chains or rows of radii; a single chain is rejected."""
    if isinstance(chains, Chain):
        raise InputError(
            "propagate_many requires a list of chains, got one chain; use propagate(chain)"
        )
    given = check_list("chains", chains, "chains or rows of radii")
    if given and all(isinstance(item, numbers.Real) for item in given):
        raise InputError(
            f"chains must be a list of chains or rows of radii, got {short_repr(given)}; "
            "put a single row of radii in a list, [[...]]"
        )
    for count, item in enumerate(given, start=1):
        if not isinstance(item, Chain | list | tuple) and np.ndim(item) == 0:
            raise InputError(
                f"item {count} of chains must be a chain or a row of radii, got {short_repr(item)}"
            )
    return given


@dataclass(eq=False)
class _Ensemble:
    """Radii of all chains in padded rows, and the results so far."""

    radii: Array
    beads: NDArray[np.int64]
    exponents: Array
    reasons: dict[int, str]
    # All chains, unless they are rows of radii; None where there is no chain.
    chains: list[Chain | None] = field(default_factory=list)
    columns: Array = field(init=False)

    def __post_init__(self) -> None:
        self.columns = np.full((COLUMNS, *self.radii.shape), np.nan)

    @classmethod
    def of(cls, chains: Iterable[Chain | ArrayLike] | ArrayLike) -> _Ensemble:
        if isinstance(chains, np.ndarray) and chains.ndim == 2:
            return cls._of_rows(chains, np.full(len(chains), chains.shape[1]))
        given = rows_of(chains)
        rows = [item for item in given if _is_row(item)]
        if len(rows) == len(given) > 0:
            return cls._of_rows(*_pad(rows))
        require_same_units("propagate_many", given)
        found: list[Chain | None] = []
        lengths, reasons = [], {}
        for row, item in enumerate(given):
            chain = None
            try:
                chain = item if isinstance(item, Chain) else Chain.from_radii(item)
                lengths.append(chain.beads)
                _require_supported("propagate_many", chain)
            except InputError as error:
                reasons[row] = str(error)
                if chain is None:
                    lengths.append(np.size(item) if isinstance(item, np.ndarray | Sequence) else 0)
            found.append(chain)
        beads = np.array(lengths, np.int64)
        radii = np.full((len(found), int(beads.max(initial=0))), np.nan)
        exponents = np.full(len(found), HERTZ_EXPONENT)
        for row, each in enumerate(found):
            if each is not None:
                radii[row, : each.beads] = each.radii
                exponents[row] = each.exponents if isinstance(each.exponents, float) else np.nan
        return cls(radii, beads, exponents, reasons, found)

    @classmethod
    def _of_rows(cls, rows: NDArray[np.float64], beads: NDArray[np.int64]) -> _Ensemble:
        given = real_numbers("radii", rows, "chain", unit="m")
        inside = np.arange(given.shape[1]) < beads[:, np.newaxis]
        reasons = {}
        with np.errstate(all="ignore"):
            radii = given / given[:, :1] if given.shape[1] else given.copy()
            masses = radii**3
            sound = (given > 0.0) & (masses >= np.finfo(float).tiny) & (masses < np.inf)
        for row in np.flatnonzero(~(sound | ~inside).all(axis=1) | (beads < 2)):
            try:
                _require_supported("propagate_many", Chain.from_radii(given[row, : beads[row]]))
            except InputError as error:
                reasons[int(row)] = str(error)
        return cls(radii, beads, np.full(len(given), HERTZ_EXPONENT), reasons)

    def blocks(self, threads: int) -> Iterator[NDArray[np.int64]]:
        """Rows of each task, without chains that cannot be simulated."""
        sound = np.setdiff1d(np.arange(len(self.beads)), list(self.reasons))
        beads = np.cumsum(self.beads[sound])
        share = int(beads[-1]) // (4 * threads) if len(beads) else 0
        ends = beads // min(BLOCK_BEADS, max(MIN_BLOCK, share))
        for rows in np.split(sound, np.flatnonzero(np.diff(ends)) + 1):
            if len(rows):
                yield rows

    def batch(self, rows: NDArray[np.int64]) -> Batch:
        if self.chains:
            return Batch.of([chain for row in rows if (chain := self.chains[row]) is not None])
        return Batch.of_radii(self.radii[rows][self._inside(rows)], self.beads[rows])

    def store(self, rows: NDArray[np.int64], data: PulseData) -> None:
        inside = self._inside(rows)
        for column, values in zip(self.columns, data.columns, strict=True):
            padded = np.full(inside.shape, np.nan)
            padded[inside] = values
            column[rows] = padded
        for index, reason in data.reasons.items():
            self.reasons[int(rows[index])] = reason
            for column in self.columns:
                column[rows[index]] = np.nan

    def _inside(self, rows: NDArray[np.int64]) -> NDArray[np.bool_]:
        inside: NDArray[np.bool_] = np.arange(self.radii.shape[1]) < self.beads[rows, np.newaxis]
        return inside

    def table(self) -> PulseTable:
        velocity, peak_time, arrival, overlap, residence = self.columns
        known = [chain for chain in self.chains if chain is not None]
        own = any(not chain.scaled or OWN.intersection(chain.features) for chain in known)
        return PulseTable(
            self.radii, self.beads, self.exponents,
            velocity, peak_time, arrival, overlap[:, :-1], residence[:, :-1], self.reasons,
            tuple(self.chains) if own else (),
        )  # fmt: skip


def _is_row(item: object) -> TypeGuard[NDArray[np.float64]]:
    # Subclasses are excluded because they may have a mask or a unit.
    return type(item) is np.ndarray and item.ndim == 1 and item.dtype.kind in "iuf"


def _pad(rows: Sequence[NDArray[np.float64]]) -> tuple[Array, NDArray[np.int64]]:
    """Store rows of different lengths in one array; return it with the lengths."""
    lengths = np.array([len(row) for row in rows], np.int64)
    padded = np.full((len(rows), int(lengths.max())), np.nan)
    padded[np.arange(padded.shape[1]) < lengths[:, np.newaxis]] = np.concatenate(rows)
    return padded, lengths


def _follow_with_progress(
    batch: Batch, rtol: float, progress: Progress | None, strikers: int
) -> PulseData:
    """Integrate in another thread, to handle interrupts and report progress."""
    beads = range(len(batch.masses))
    found: list[PulseData] = []

    def report(passed: int, all_beads: int) -> None:
        if progress is not None:
            progress(max(0, passed - strikers), all_beads - strikers)

    run_in_threads(
        [beads], lambda _, signal: follow(batch, rtol, signal), lambda _, data: found.append(data),
        threads=1, of="beads", total=len(beads), progress=report,
    )  # fmt: skip
    return found[0]


def checked_rtol(rtol: float) -> float:
    """Check a relative tolerance of the pulse, from 1e-10 to 1e-5."""
    smaller = isinstance(rtol, float) and 0.0 < rtol < MIN_RTOL
    hint = "for smaller errors use hertzchain.simulate(chain, times=0, rtol=1e-13).pulse()"
    return number(
        "rtol", rtol, least=MIN_RTOL, most=MAX_RTOL, hint=hint if smaller else ""
    )  # fmt: skip
