"""How many beads to integrate around a pulse: as few as will do, as many as it takes.

The cost of following a pulse is that of the window of beads that is integrated.  A
chain is tried in turn with

1. a *narrow* window, if its radii never shrink: the contacts behind the pulse open
   and what is behind them is out of reach, which the kernel checks;
2. a *wide* window, if it is a taper: its radii only grow or only shrink, and the rate
   at which they do never turns back.  Forward tapers push on from behind for longer;
3. two still wider windows, one of them with smaller steps, whose results are taken
   only if they agree: chains with radii that go up and down by at most `EVEN`;
4. whatever it takes (`hertzchain.propagation.uneven`): beads that differ, light beads that rattle
   between heavy ones, beads that reach their maxima out of order, force laws other than
   that of Hertz.

Each gives a chain up, to the next, by its own criteria; the last raises.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hertzchain.contacts import HERTZ_EXPONENT, Array
from hertzchain.propagation.batch import (
    COLUMNS,
    STOP,
    STRIKER_KNOWS,
    STRUCK,
    Batch,
    Indices,
    Passage,
    difference,
)  # fmt: skip
from hertzchain.propagation.uneven import follow_uneven

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
    >>> from hertzchain.chain.chain import Chain
    >>> batch = Batch.of([Chain.uniform(9)])
    >>> follow(batch, 1e-8, np.zeros(2, np.int64)).columns[0, 1].round(8)
    np.float64(0.75147174)
    """
    columns = np.full((COLUMNS, len(batch.radii)), np.nan)
    given = batch.given()
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

    columns[:STRIKER_KNOWS, batch.first] = STRUCK
    reasons: dict[int, str] = {}
    for smooth in (True, False):
        some = todo[(taper | even)[todo] == smooth]
        reasons |= follow_uneven(some, smooth, rtol, batch, columns, signal)
    return Passage(columns, reasons)


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
    agree = difference(columns, check, batch.first) <= rtol
    agreed = np.setdiff1d(tried, failed)
    agreed = agreed[agree[agreed]]
    taken = batch.beads_of(agreed)
    columns[:, taken] = check[:, taken]
    return np.setdiff1d(todo, agreed)
