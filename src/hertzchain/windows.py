"""How many beads to integrate around a pulse: as few as will do, as many as it takes.

The cost of following a pulse is that of the window of beads that is integrated.  A
chain is tried in turn with

1. a *narrow* window, if its radii never shrink: the contacts behind the pulse open
   and what is behind them is out of reach, which the kernel checks;
2. a *wide* window, if it is a taper: its radii only grow or only shrink, and the rate
   at which they do never turns back.  Forward tapers push on from behind for longer;
3. two still wider windows, one of them with smaller steps, whose results are taken
   only if they agree: chains with radii that go up and down by at most `EVEN`;
4. the full-chain integrator on a moving window of at least `FULL_BEHIND` beads behind
   the pulse and all in front that move: beads that reach their maxima out of order,
   light beads that rattle between heavy ones, force laws other than that of Hertz.

Each gives a chain up, to the next, by its own criteria; the last raises.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hertzchain.chain import Chain
from hertzchain.contacts import HERTZ_EXPONENT, Array, compression_time, reduced_mass
from hertzchain.errors import InputError, SimulationError

Indices = NDArray[np.int64]

# Entries of the array by which another thread stops the work, and sees how far it is.
STOP, PASSED = 0, 1

# Rows of the result.
VELOCITY, PEAK_TIME, ARRIVAL, PEAK_OVERLAP, RESIDENCE, COLUMNS = range(6)

# Beads in the window, and how many of them are behind the one at its crest.
NARROW, WIDE, WIDEST = (9, 4), (13, 8), (16, 11)
CHECKING: Final = (24, 18)
# A wide window's truncation is below 1e-9; below this tolerance it is the widest.
WIDE_RTOL: Final = 3e-9
# Rates ln(R_k+1/R_k) that count as shrinking, changes of them that count as turning back, and
# changes too large for a taper: a backward linear one with S = 1 begins with one of 0.29.
SHRINKING, TURNING, KINK = -1e-4, 1e-6, 0.35
# Rates up to which beads keep their order well enough for a window, if the chain is no taper.
EVEN: Final = 0.05
# Growing tapers that begin with a larger ratio of radii take steps shorter by this factor.
STEEP, STEEP_PART = 1.4, 0.7

# Step and release of opening contacts, as parts of the time a bead takes and of a step, for
# a tolerance of 1e-8; exponents from the errors measured at 1e-6 .. 1e-10.
STEP_PART, STEP_ORDER, LARGEST_STEP_PART = 0.15, 6, 0.28
RELEASE_PART, RELEASE_ORDER, LARGEST_RELEASE_PART = 0.1, 4, 0.3
# Estimated error of a step of that part 0.15, of order 7, above which a chain is given up.
ESTIMATED_ERROR: Final = 1e-6

# Chains up to this length are integrated whole where a window of the kernel will not do.
WHOLE: Final = 96
FULL_BEHIND, FULL_AHEAD, FULL_MARGIN = 48, 48, 16
FULL_STEPS_PER_CALL, FULL_STEPS_PER_BEAD = 20, 20_000
# Its steps are held to what `simulate` does: beads that nearly peak, and then do not, must be
# judged alike.
FULL_RTOL: Final = 1e-13
# The pulse is slower than this only where numbers underflow.
SMALLEST_SPEED: Final = 1e-290


@dataclass(frozen=True, eq=False)
class Batch:
    """Chains put end to end: the beads of all of them in one row.

    Attributes
    ----------
    radii : ndarray, shape (M,)
        Radii of all beads [scaled].
    first, beads : ndarray, shape (C,)
        Where each chain begins in that row, and how many beads it has.
    exponents : ndarray, shape (C,)
        Exponent of each chain's force law.
    """

    radii: Array
    first: Indices
    beads: Indices
    exponents: Array

    @classmethod
    def of(cls, chains: Iterable[Chain]) -> Batch:
        """Put chains end to end.

        Parameters
        ----------
        chains : iterable of Chain
            At least one chain.

        Returns
        -------
        Batch

        Examples
        --------
        >>> Batch.of([Chain.uniform(2), Chain.uniform(3)]).first
        array([0, 2])
        """
        listed = list(chains)
        beads = np.array([chain.beads for chain in listed])
        return cls(
            radii=np.concatenate([chain.radii for chain in listed]),
            first=np.cumsum(beads) - beads,
            beads=beads,
            exponents=np.array([chain.exponent for chain in listed]),
        )

    def chain(self, index: int) -> Chain:
        """One of the chains.

        Parameters
        ----------
        index : int
            Its number, from 0.

        Returns
        -------
        Chain

        Examples
        --------
        >>> Batch.of([Chain.uniform(2), Chain.uniform(3)]).chain(1).beads
        3
        """
        start = self.first[index]
        return Chain(self.radii[start : start + self.beads[index]], float(self.exponents[index]))


@dataclass(frozen=True, eq=False)
class Passage:
    """What passed the beads of a `Batch`.

    Attributes
    ----------
    columns : ndarray, shape (5, M)
        First velocity maxima, their times, arrival times, largest overlaps and residence
        times; the last entry of the overlaps and residences of each chain is NaN.
    reasons : dict
        Why a chain could not be followed, by its number; its columns are NaN.
    """

    columns: Array
    reasons: dict[int, str]


def follow(batch: Batch, rtol: float, signal: Indices) -> Passage:
    """Follow the pulse along each chain of a batch, with as many beads as it takes.

    Parameters
    ----------
    batch : Batch
        The chains.
    rtol : float
        Tolerance of the results.
    signal : ndarray, shape (2,)
        Set entry STOP to end early, with columns unfinished; entry PASSED counts beads.

    Returns
    -------
    Passage

    Examples
    --------
    >>> batch = Batch.of([Chain.uniform(9)])
    >>> follow(batch, 1e-8, np.zeros(2, np.int64)).columns[VELOCITY, 1].round(8)
    np.float64(0.75147174)
    """
    columns = np.full((COLUMNS, len(batch.radii)), np.nan)
    given = _given(batch)
    taper, grows, even = _shapes(batch)
    hertz = batch.exponents == HERTZ_EXPONENT
    wide = WIDE if rtol >= WIDE_RTOL else WIDEST
    parts = (_step_part(rtol), _release_part(rtol))

    steep = (STEEP_PART * parts[0], parts[1])
    gentle = batch.radii[batch.first + 1] <= STEEP * batch.radii[batch.first]
    growing = hertz & taper & grows
    todo = np.concatenate([
        _attempt(np.flatnonzero(growing & some), NARROW, these, rtol, given, batch, columns, signal)
        for some, these in ((gentle, parts), (~gentle, steep))
    ])  # fmt: skip
    todo = np.union1d(todo, np.flatnonzero(hertz & taper & ~grows))
    todo = _attempt(todo, wide, parts, rtol, given, batch, columns, signal)
    uneven = np.union1d(todo[~even[todo]], np.flatnonzero(~(hertz & (taper | even))))
    todo = np.union1d(todo[even[todo]], np.flatnonzero(hertz & even & ~taper))
    todo = _attempt_twice(todo, parts, rtol, given, batch, columns, signal)
    todo = np.union1d(todo, uneven)

    reasons = {}
    columns[VELOCITY, batch.first] = 1.0
    columns[PEAK_TIME, batch.first] = 0.0
    columns[ARRIVAL, batch.first] = 0.0
    for index in todo:
        if signal[STOP]:
            break
        here = slice(batch.first[index], batch.first[index] + batch.beads[index])
        try:
            columns[:, here] = follow_full(batch.chain(int(index)), signal)
        except (SimulationError, InputError) as error:
            columns[:, here] = np.nan
            reasons[int(index)] = str(error)
    return Passage(columns, reasons)


def follow_full(chain: Chain, signal: Indices) -> Array:
    """Follow a pulse by the full-chain integrator, on a wide window if the chain is long.

    Parameters
    ----------
    chain : Chain
        Any chain.
    signal : ndarray, shape (2,)
        As for `follow`.

    Returns
    -------
    ndarray, shape (5, N)
        Columns as of `Passage`.

    Raises
    ------
    SimulationError
        If the pulse could not be followed to the end.

    Examples
    --------
    >>> chain = Chain.uniform(9, exponent=2.0)
    >>> follow_full(chain, np.zeros(2, np.int64))[VELOCITY, 1].round(6)
    np.float64(0.818363)
    """
    from hertzchain.simulation import LEAST_STEP_LIMIT, simulate

    if chain.beads > WHOLE:
        return _MovingWindow(chain).run(signal)
    steps = max(FULL_STEPS_PER_BEAD * chain.beads, LEAST_STEP_LIMIT)
    pulse = simulate(chain, times=0, rtol=FULL_RTOL, max_steps=steps).pulse()
    signal[PASSED] += chain.beads
    found = pulse.columns()
    of_contacts = (np.append(found[name], np.nan) for name in ("peak_overlap", "residence"))
    return np.array([pulse.velocity, pulse.peak_time, pulse.arrival, *of_contacts])


def _given(batch: Batch) -> Array:
    """Inverse masses and stiffness of all beads, as the kernel takes them."""
    from hertzchain.contacts import hertz_stiffness

    given = np.zeros((2, len(batch.radii)))
    given[0] = batch.radii**-3.0
    given[1, :-1] = hertz_stiffness(batch.radii[:-1], batch.radii[1:])
    given[1, batch.first + batch.beads - 1] = 0.0
    return given


def _shapes(batch: Batch) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Which chains are tapers, in which the radii never shrink, and which are nearly even."""
    rates = np.append(np.diff(np.log(batch.radii)), 0.0)
    last = batch.first + batch.beads - 1
    rates[last] = 0.0
    turns = np.append(np.diff(rates), 0.0)
    turns[last] = 0.0
    turns[last - 1] = 0.0
    up = np.maximum.reduceat(turns, batch.first)
    down = np.minimum.reduceat(turns, batch.first)
    steady = ((up < TURNING) | (down > -TURNING)) & (up < KINK) & (down > -KINK)
    grows = np.minimum.reduceat(rates, batch.first) > SHRINKING
    shrinks = np.maximum.reduceat(rates, batch.first) < -SHRINKING
    even = np.maximum.reduceat(np.abs(rates), batch.first) <= EVEN
    return steady & (grows | shrinks), grows, even


def _step_part(rtol: float) -> float:
    return float(min(LARGEST_STEP_PART, STEP_PART * (rtol / 1e-8) ** (1 / STEP_ORDER)))


def _release_part(rtol: float) -> float:
    return float(min(LARGEST_RELEASE_PART, RELEASE_PART * (rtol / 1e-8) ** (1 / RELEASE_ORDER)))


def _attempt(
    todo: Indices,
    size: tuple[int, int],
    parts: tuple[float, float],
    rtol: float,
    given: Array,
    batch: Batch,
    columns: Array,
    signal: Indices,
) -> Indices:
    """Follow some chains with one window; returns those given up."""
    from hertzchain.kernels import front as kernel

    if not len(todo) or signal[STOP]:
        return todo
    # What is cut off of a narrow window must be next to nothing; a wider one is safe by width.
    rear = rtol if size == NARROW else np.inf
    limits = (rear, 0.1 * rtol, ESTIMATED_ERROR * (parts[0] / STEP_PART) ** 7)
    window = (*size, *parts)
    status = np.zeros(len(todo), np.int64)
    # Lanes next to a few chains would stay empty.
    lanes, run = (1, kernel.follow_one) if len(todo) < 3 else (kernel.LANES, kernel.follow_many)
    run(
        window,
        limits,
        (given, batch.first[todo], batch.beads[todo]),
        columns,
        status,
        signal,
        kernel.scratch_of(lanes),
    )
    return todo[status != kernel.FOLLOWED]


def _attempt_twice(
    todo: Indices,
    parts: tuple[float, float],
    rtol: float,
    given: Array,
    batch: Batch,
    columns: Array,
    signal: Indices,
) -> Indices:
    """Follow some chains with two windows and steps; returns those in which they disagree.

    Contacts are released much later the second time, as a release changes the times of events
    that fall between it and the opening.
    """
    failed = _attempt(todo, WIDEST, parts, rtol, given, batch, columns, signal)
    tried = np.setdiff1d(todo, failed)
    if not len(tried):
        return todo
    check = np.full_like(columns, np.nan)
    finer = (0.8 * parts[0], 0.25 * parts[1])
    failed = _attempt(tried, CHECKING, finer, rtol, given, batch, check, signal)
    # No number stands for the striker, nor for a contact after the last bead.
    difference = np.nan_to_num(np.abs(columns / check - 1.0), nan=0.0).max(axis=0)
    agree = np.maximum.reduceat(difference, batch.first) <= rtol
    agreed = np.setdiff1d(tried, failed)
    agreed = agreed[agree[agreed]]
    taken = np.isin(np.repeat(np.arange(len(batch.beads)), batch.beads), agreed)
    columns[:, taken] = check[:, taken]
    return np.setdiff1d(todo, agreed)


class _MovingWindow:
    """The full-chain integrator on a part of a long chain that moves along with the pulse."""

    def __init__(self, chain: Chain) -> None:
        from hertzchain.kernels import full_chain

        self.kernel: Any = full_chain
        self.chain = chain
        self.masses, self.stiffness = chain.masses, chain.stiffness
        self.low, self.high = 0, min(chain.beads, FULL_AHEAD)
        self.columns = np.full((COLUMNS, chain.beads), np.nan)
        self.columns[:3, 0] = 1.0, 0.0, 0.0
        beads = self.high
        self.state = np.zeros((2, beads))
        self.state[1, 0] = 1.0
        self.peaks, self.crossings = np.zeros((2, beads)), np.zeros((3, beads - 1))
        self.peaks[1, 0] = 1.0
        self.clock = np.zeros(full_chain.CLOCK_SIZE)
        self.counts = np.zeros(full_chain.COUNTS_SIZE, np.int64)
        reduced = reduced_mass(self.masses[0], self.masses[1])
        transit = float(compression_time(reduced, self.stiffness[0], 1.0, chain.exponent))
        full_chain.start(
            self.state.reshape(-1), self.clock, self.counts, self._equation, None, 1e-4 * transit
        )

    @property
    def _equation(self) -> Any:
        """Inverse masses, stiffness and exponent within the window."""
        masses, stiffness = self.masses[self.low : self.high], self.stiffness
        return self.kernel.Plain(
            1.0 / masses, stiffness[self.low : self.high - 1], self.chain.exponent
        )

    def run(self, signal: Indices) -> Array:
        code = self.kernel.RUNNING
        while code != self.kernel.PULSE_LEFT and not signal[STOP]:
            code = self._advance()
            steps = int(self.counts[self.kernel.STEPS])
            failed = code in (self.kernel.STEP_TOO_SMALL, self.kernel.PULSE_LOST)
            if failed or steps > FULL_STEPS_PER_BEAD * self.high:
                raise SimulationError(
                    f"the pulse could not be followed past bead {self._waiting() + 1} of "
                    f"{self.chain.beads}: its steps became too small or too many; use fewer beads "
                    "or a weaker taper"
                )
            speeds = np.abs(self.state[1])
            if not speeds.max() > SMALLEST_SPEED:
                raise SimulationError(
                    f"the motion became too small to represent near bead {self.high} of "
                    f"{self.chain.beads}; use fewer beads or a weaker taper"
                )
            front = self._front()
            if self.high < self.chain.beads and front > self.high - FULL_MARGIN:
                signal[PASSED] += self._move(front)
        self._note()
        return self.columns

    def _advance(self) -> int:
        from hertzchain.kernels import dop853

        beads = self.high - self.low
        code: int = self.kernel.advance(
            self.state.reshape(-1), self.clock, self.counts, self._equation, None,
            np.inf, self.high == self.chain.beads, FULL_RTOL, FULL_STEPS_PER_CALL, False,
            np.empty(0), False, np.empty((0, 2 * beads)), np.empty((0, 0)), self.peaks,
            self.crossings, np.empty((0, 2)), np.empty((dop853.STAGES, 2 * beads)),
            np.empty((6, 2 * beads)),
            np.zeros((2, beads), np.bool_),
        )  # fmt: skip
        return code

    def _note(self) -> None:
        """Copy what has been found in the window to the columns."""
        peaked, crossed = self.peaks[0] > 0.0, self.crossings[0] > 0.0
        beads = np.arange(self.low, self.high)
        self.columns[VELOCITY, beads[peaked]] = self.peaks[1, peaked]
        self.columns[PEAK_TIME, beads[peaked]] = self.peaks[0, peaked]
        self.columns[ARRIVAL, beads[1:][crossed]] = self.crossings[0, crossed]
        self.columns[PEAK_OVERLAP, beads[:-1][crossed]] = self.crossings[1, crossed]
        since_last, times = self.crossings[2], self.columns[ARRIVAL, beads]
        residence = np.where(since_last > 0.0, since_last, np.diff(times))
        self.columns[RESIDENCE, beads[:-1][crossed]] = residence[crossed]

    def _front(self) -> int:
        """Last bead of the chain that has peaked or overtaken the one behind."""
        reached = (self.peaks[0, 1:] > 0.0) | (self.crossings[0] > 0.0)
        return self.low + int(np.max(np.flatnonzero(reached) + 1, initial=0))

    def _waiting(self) -> int:
        """First bead of the chain that has not peaked, or not overtaken the one behind."""
        waits = (self.peaks[0, 1:] == 0.0) | (self.crossings[0] == 0.0)
        return self.low + 1 + int(np.argmax(waits)) if waits.any() else self.high

    def _move(self, front: int) -> int:
        """Drop beads far behind, take in beads ahead; returns how many were dropped."""
        self._note()
        low = max(self.low, self._waiting() - FULL_BEHIND)
        high = min(self.chain.beads, front + FULL_AHEAD)
        dropped, added = low - self.low, high - self.high

        def moved(values: Array) -> Array:
            return np.pad(values[:, dropped:], ((0, 0), (0, added)))

        self.state = moved(self.state)
        self.peaks, self.crossings = moved(self.peaks), moved(self.crossings)
        self.low, self.high = low, high
        self.counts[self.kernel.LAST_CROSSING] -= dropped
        self.counts[self.kernel.PEAKS] = np.count_nonzero(self.peaks[0, 1:])
        self.counts[self.kernel.CROSSINGS] = np.count_nonzero(self.crossings[0])
        return dropped
