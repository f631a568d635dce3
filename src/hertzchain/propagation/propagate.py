"""Follow the leading pulse alone: a fraction of a millisecond for a chain of a hundred beads.

`propagate` takes one chain, `propagate_many` an ensemble.  Both integrate the same
equation of motion as `hertzchain.simulate`, on the beads around the pulse only
(`hertzchain.propagation.windows`).
"""

from __future__ import annotations

import numbers
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from typing import Final, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hertzchain.arguments import callback, listed
from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import require
from hertzchain.checks import number, real_numbers, worker_count
from hertzchain.contacts import HERTZ_EXPONENT, Array
from hertzchain.errors import InputError, SimulationError, shown
from hertzchain.propagation.batch import COLUMNS, PASSED, STOP, Batch, Passage
from hertzchain.propagation.uneven import LARGEST_RTOL
from hertzchain.propagation.windows import follow
from hertzchain.pulse.pulse import Pulse
from hertzchain.pulse.pulse_table import PulseTable

Progress = Callable[[int, int], None]

DEFAULT_RTOL: Final = 1e-8
# Below, rounding and the treatment of contacts count.
SMALLEST_RTOL: Final = 1e-10
# Beads of one piece of work: at most a quarter of a second of tapers; at least what keeps the
# lanes of the kernel busy, so that a small ensemble of uneven chains has work for all threads.
BLOCK_BEADS, LEAST_BLOCK = 100_000, 5_000
# A chain up to this length is followed before anybody could interrupt it.
SHORT: Final = 20_000
POLL: Final = 0.1


def propagate(
    chain: Chain, *, rtol: float = DEFAULT_RTOL, progress: Progress | None = None
) -> Pulse:
    """Follow the leading pulse along a chain, integrating the beads around it.

    Parameters
    ----------
    chain : Chain
        The chain to strike.
    rtol : float
        Tolerance, 1e-10 .. 1e-5: velocities and times are within ten times it for
        chains of a hundred beads. For less, see `hertzchain.simulate`.
    progress : callable, optional
        Called as ``progress(beads_passed, beads)`` a few times a second.

    Returns
    -------
    Pulse

    Raises
    ------
    InputError
        For a tolerance out of range.
    SimulationError
        If the pulse could not be followed to the end, or if its motion magnifies errors so much
        that the tolerance cannot be met.

    Examples
    --------
    The leading pulse of equal beads runs into a solitary wave of amplitude
    0.681631549:

    >>> import hertzchain as hc
    >>> round(float(hc.propagate(hc.Chain.uniform(60)).velocity[50]), 8)
    0.68163155
    """
    require(chain, "propagate", instead="use simulate")
    callback("progress", progress)
    rtol = checked_rtol(rtol)
    batch, signal = Batch.of([chain]), np.zeros(2, np.int64)
    if chain.beads <= SHORT and progress is None:
        passage = follow(batch, rtol, signal)
    else:
        passage = _followed_while_watching(batch, rtol, signal, progress)
    if passage.reasons:
        raise SimulationError(passage.reasons[0])
    velocity, peak_time, arrival, overlap, residence = passage.columns
    return Pulse(chain, "propagation", velocity, peak_time, arrival, overlap[:-1], residence[:-1])


def propagate_many(
    chains: Iterable[Chain | ArrayLike] | ArrayLike,
    *,
    rtol: float = DEFAULT_RTOL,
    threads: int | None = None,
    progress: Progress | None = None,
) -> PulseTable:
    """Follow the leading pulse along each of many chains, several at a time.

    Parameters
    ----------
    chains : iterable of Chain or array_like, or array_like of shape (C, N)
        Chains, or rows of radii in any one unit, struck bead first; rows may differ
        in length.
    rtol : float
        Tolerance, as of `propagate`.
    threads : int, optional
        Number of threads; by default, one for each processor.
    progress : callable, optional
        Called as ``progress(chains_done, chains)`` a few times a second.

    Returns
    -------
    PulseTable
        A chain that cannot be followed has its reason there; the others go on.

    Raises
    ------
    InputError
        For an option out of its range.

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
    bad = len(ensemble.reasons)
    done, signals = bad, [np.zeros(2, np.int64) for _ in blocks]
    executor = ThreadPoolExecutor(max_workers=threads)
    try:
        running: dict[Future[Passage], NDArray[np.int64]] = {
            executor.submit(_follow_block, ensemble, rows, rtol, signal): rows
            for rows, signal in zip(blocks, signals, strict=True)
        }
        while running:
            finished, _ = wait(running, timeout=POLL, return_when=FIRST_COMPLETED)
            for future in finished:
                rows = running.pop(future)
                ensemble.store(rows, future.result())
                done += len(rows)
            if progress is not None:
                progress(done, len(ensemble.beads))
    except BaseException as error:
        for signal in signals:
            signal[STOP] = 1
        error.add_note(f"stopped after {done} of {len(ensemble.beads)} chains")
        raise
    finally:
        executor.shutdown(wait=True, cancel_futures=True)
    return ensemble.table()


def rows_of(chains: Iterable[Chain | ArrayLike] | ArrayLike) -> list[Chain | ArrayLike]:
    """Chains or rows of radii, as a list; not one chain alone.

    Parameters
    ----------
    chains : iterable of Chain or array_like
        What was given.

    Returns
    -------
    list

    Raises
    ------
    InputError
        If it is no list, or its items are numbers, as in one row of radii.

    Examples
    --------
    >>> rows_of([[1.0, 2.0]])
    [[1.0, 2.0]]
    """
    if isinstance(chains, Chain):
        raise InputError("propagate_many takes a list of chains, got one: use propagate(chain)")
    given = listed("chains", chains, "chains or rows of radii")
    if given and all(isinstance(item, numbers.Real) for item in given):
        raise InputError(
            f"chains must be a list of chains or rows of radii, got {shown(given)}: of one row of "
            "radii make a list, [[...]]"
        )
    return given


@dataclass(eq=False)
class _Ensemble:
    """Radii of all chains in padded rows, and the results as they come in."""

    radii: Array
    beads: NDArray[np.int64]
    exponents: Array
    reasons: dict[int, str]
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
            return cls._of_rows(*_padded(rows))
        found: list[Chain | str] = []
        lengths = []
        for item in given:
            try:
                chain = item if isinstance(item, Chain) else Chain.from_radii(item)
                require(chain, "propagate_many", instead="use simulate")
                lengths.append(chain.beads)
                found.append(chain)
            except InputError as error:
                lengths.append(np.size(item) if isinstance(item, np.ndarray | Sequence) else 0)
                found.append(str(error))
        beads = np.array(lengths, np.int64)
        radii = np.full((len(found), int(beads.max(initial=0))), np.nan)
        exponents = np.full(len(found), HERTZ_EXPONENT)
        reasons = {}
        for row, each in enumerate(found):
            if isinstance(each, str):
                reasons[row] = each
            else:
                radii[row, : each.beads] = each.radii
                exponents[row] = each.exponent
        return cls(radii, beads, exponents, reasons)

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
                Chain.from_radii(given[row, : beads[row]])
            except InputError as error:
                reasons[int(row)] = str(error)
        return cls(radii, beads, np.full(len(given), HERTZ_EXPONENT), reasons)

    def blocks(self, threads: int) -> Iterator[NDArray[np.int64]]:
        """Rows of one piece of work after the other, without the impossible chains."""
        sound = np.setdiff1d(np.arange(len(self.beads)), list(self.reasons))
        beads = np.cumsum(self.beads[sound])
        share = int(beads[-1]) // (4 * threads) if len(beads) else 0
        ends = beads // min(BLOCK_BEADS, max(LEAST_BLOCK, share))
        for rows in np.split(sound, np.flatnonzero(np.diff(ends)) + 1):
            if len(rows):
                yield rows

    def batch(self, rows: NDArray[np.int64]) -> Batch:
        beads = self.beads[rows]
        return Batch(
            radii=self.radii[rows][self._inside(rows)],
            first=np.cumsum(beads) - beads,
            beads=beads,
            exponents=self.exponents[rows],
        )

    def store(self, rows: NDArray[np.int64], passage: Passage) -> None:
        inside = self._inside(rows)
        for column, values in zip(self.columns, passage.columns, strict=True):
            padded = np.full(inside.shape, np.nan)
            padded[inside] = values
            column[rows] = padded
        for index, reason in passage.reasons.items():
            self.reasons[int(rows[index])] = reason

    def _inside(self, rows: NDArray[np.int64]) -> NDArray[np.bool_]:
        inside: NDArray[np.bool_] = np.arange(self.radii.shape[1]) < self.beads[rows, np.newaxis]
        return inside

    def table(self) -> PulseTable:
        velocity, peak_time, arrival, overlap, residence = self.columns
        return PulseTable(
            self.radii, self.beads, self.exponents,
            velocity, peak_time, arrival, overlap[:, :-1], residence[:, :-1], self.reasons,
        )  # fmt: skip


def _is_row(item: object) -> TypeGuard[NDArray[np.float64]]:
    # No subclass, which may carry a mask or a unit.
    return type(item) is np.ndarray and item.ndim == 1 and item.dtype.kind in "iuf"


def _padded(rows: Sequence[NDArray[np.float64]]) -> tuple[Array, NDArray[np.int64]]:
    """Rows of unlike lengths as one array, and their lengths."""
    lengths = np.array([len(row) for row in rows], np.int64)
    padded = np.full((len(rows), int(lengths.max())), np.nan)
    padded[np.arange(padded.shape[1]) < lengths[:, np.newaxis]] = np.concatenate(rows)
    return padded, lengths


def _follow_block(
    ensemble: _Ensemble, rows: NDArray[np.int64], rtol: float, signal: NDArray[np.int64]
) -> Passage:
    return follow(ensemble.batch(rows), rtol, signal)


def _followed_while_watching(
    batch: Batch, rtol: float, signal: NDArray[np.int64], progress: Progress | None
) -> Passage:
    """Follow in another thread, so that an interrupt is heard and progress told."""
    beads = len(batch.radii)
    with ThreadPoolExecutor(max_workers=1) as executor:
        future = executor.submit(follow, batch, rtol, signal)
        try:
            while not wait([future], timeout=POLL).done:
                if progress is not None:
                    progress(min(int(signal[PASSED]), beads), beads)
        except BaseException as error:
            signal[STOP] = 1
            error.add_note(f"stopped after {min(int(signal[PASSED]), beads)} of {beads} beads")
            raise
        if progress is not None:
            progress(beads, beads)
        return future.result()


def checked_rtol(rtol: float) -> float:
    """A tolerance of the pulse, 1e-10 .. 1e-5.

    Parameters
    ----------
    rtol : float
        What was given.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If it is out of this range.

    Examples
    --------
    >>> checked_rtol(1e-8)
    1e-08
    """
    return number(
        "rtol", rtol, least=SMALLEST_RTOL, most=LARGEST_RTOL,
        hint="hertzchain.simulate(chain, times=0, rtol=1e-13).pulse() goes below",
    )  # fmt: skip
