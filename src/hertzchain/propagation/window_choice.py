"""Choose the window of beads that are integrated around the pulse.

The computing time is proportional to the width of the window.  For each chain, the following
windows are tried in turn:

1. a *narrow* window, if the radii never shrink.  Contacts behind the pulse open, and the beads
   behind them no longer influence it; the kernel checks this;
2. a *wide* window, if the chain is a taper: its radii only grow or only shrink, and their rate
   is monotonic.  In forward tapers, beads behind the pulse push it for longer;
3. two wider windows, one of them with smaller steps, if the radii grow and shrink by at most
   `MAX_RATE_IN_WINDOW`.  The results must agree;
4. increasingly wide windows, until two results agree (`hertzchain.propagation.heterogeneous`),
   for beads that bounce between others or reach their maxima out of order, and for force laws
   other than Hertz's.

A window that fails by its own criteria is followed by the next one; if the last one fails, an
error is raised.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..collision import HERTZ_EXPONENT, Array
from .batch import (
    COLUMNS,
    STOP,
    STRIKER_COLUMNS,
    STRUCK,
    Batch,
    Indices,
    PulseData,
    difference,
)  # fmt: skip
from .heterogeneous import follow_heterogeneous

# Number of beads in each window, and number of beads behind the crest.
NARROW, WIDE, WIDEST = (9, 4), (13, 8), (16, 11)
CHECKING: Final = (24, 18)
# The truncation error of the wide window is below 1e-9; for smaller tolerances use the widest.
WIDE_RTOL: Final = 3e-9
# Rates ln(R_k+1/R_k) below which radii shrink, changes of the rate above which it is not monotonic,
# and changes too large for a taper; a backward linear taper with S = 1 begins with 0.29.
SHRINKING, TURNING, KINK = -1e-4, 1e-6, 0.35
# Largest rate at which the beads of a chain other than a taper stay in order.
MAX_RATE_IN_WINDOW: Final = 0.05
# Growing tapers that begin with a larger ratio of radii use steps shorter by this factor.
STEEP, STEEP_PART = 1.4, 0.7

# Step size and release of opening contacts, as fractions of the time per bead and of a step, for
# a tolerance of 1e-8; the exponents were fitted to the errors measured at 1e-6 to 1e-10.
STEP_PART, STEP_ORDER, MAX_STEP_PART = 0.15, 6, 0.28
RELEASE_PART, RELEASE_ORDER, MAX_RELEASE_PART = 0.1, 4, 0.3
# Largest estimated error (of order 7) of a step of the fraction 0.15; above it the window fails.
ESTIMATED_ERROR: Final = 1e-6


def follow(batch: Batch, rtol: float, signal: Indices) -> PulseData:
    """Integrate the pulse in each chain of a batch, with a window that is wide enough."""
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

    columns[:STRIKER_COLUMNS, batch.first] = STRUCK
    reasons: dict[int, str] = {}
    for smooth in (True, False):
        some = todo[(taper | even)[todo] == smooth]
        reasons |= follow_heterogeneous(some, smooth, rtol, batch, columns, signal)
    return PulseData(columns, reasons)


def _shapes(batch: Batch) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Masks of tapers, of chains whose radii never shrink, and of nearly uniform chains."""
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
    even = np.maximum.reduceat(np.abs(rates), batch.first) <= MAX_RATE_IN_WINDOW
    return steady & (grows | shrinks), grows, even


def _step_part(rtol: float) -> float:
    return float(min(MAX_STEP_PART, STEP_PART * (rtol / 1e-8) ** (1 / STEP_ORDER)))


def _release_part(rtol: float) -> float:
    return float(min(MAX_RELEASE_PART, RELEASE_PART * (rtol / 1e-8) ** (1 / RELEASE_ORDER)))


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
    """Integrate chains with one window; return those for which it failed."""
    from ..kernels import narrow_front as kernel

    if not len(todo) or signal[STOP]:
        return todo
    # The motion at the rear of a narrow window must be negligible; wider ones need no check.
    rear = rtol if size == NARROW else np.inf
    limits = (rear, 0.1 * rtol, ESTIMATED_ERROR * (parts[0] / STEP_PART) ** 7)
    window = (*size, *parts)
    status = np.zeros(len(todo), np.int64)
    # With few chains, most lanes would be empty.
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
    """Integrate chains with two windows and step sizes; return those whose results differ.

    Contacts are released much later in the second integration, because a release changes the
    times of events between it and the opening of the contact.
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
