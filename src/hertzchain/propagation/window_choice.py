"""Choose the window of beads that are integrated around the pulse.

The kernels `hertzchain.kernels.narrow_window` and `hertzchain.kernels.wide_window` integrate the
beads in the window and move it along with the pulse.  The computing time is proportional to the
width of the window.  A taper is a chain of spheres whose radii only grow or only shrink, at a
monotonic rate.  For each chain, the following windows are tried in turn:

1. a *narrow* window, if the chain is a taper whose radii never shrink.  Contacts behind the pulse
   open, and the beads behind them no longer influence it; the kernel checks this;
2. a *wide* window, if the chain is a taper.  In forward tapers, beads behind the pulse push it for
   longer;
3. two wider windows, one of them with smaller steps, if the radii grow and shrink by at most
   `MAX_RATE_IN_WINDOW`.  The results must agree;
4. increasingly wide windows, until two results agree (`hertzchain.propagation.heterogeneous`),
   for beads that bounce between others or reach their maxima out of order, and for contacts with
   different or extreme exponents.

If a window fails by its own criteria, the next one is tried; if the last one fails, an error is
raised.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..collision import HERTZ_EXPONENT, Array
from ..frozen import once
from ..threads import STOP
from .batch import (
    COLUMNS,
    STRIKER_COLUMNS,
    STRUCK,
    Batch,
    Indices,
    PulseData,
    difference,
)  # fmt: skip
from .geometric_series import RTOL, continue_series
from .heterogeneous import follow_heterogeneous


class Windows(NamedTuple):
    """Number of beads in each window, and number of beads behind the crest."""

    narrow: tuple[int, int]
    wide: tuple[int, int]
    widest: tuple[int, int]
    checking: tuple[int, int]


WINDOWS: Final = Windows((9, 4), (13, 8), (16, 11), (24, 18))
# With lower exponents, more beads move at the same time: ten if the exponent is 1.2.
SOFT_WINDOWS: Final = Windows((12, 4), (18, 9), (24, 14), (32, 20))
SOFT_EXPONENT: Final = 1.4
# The truncation error of the wide window is below 1e-9; for smaller tolerances use the widest.
WIDE_RTOL: Final = 3e-9
# Rates ln(R_k+1/R_k) below which radii shrink, changes of the rate above which it is not monotonic,
# and changes too large for a taper; a backward linear taper with S = 1 begins with 0.29.
SHRINKING, TURNING, KINK = -1e-4, 1e-6, 0.35
# Largest spread of the stiffness of contacts, relative to those of spheres, of a taper and of a
# nearly uniform chain.
SPHERES, EVEN_STIFFNESS = 1e-9, 0.05
# Range of exponents that the window of few beads supports, and mark of all others.
LOWEST_EXPONENT, HIGHEST_EXPONENT, OTHER = 1.15, 3.0, 0.0
# Minimum number of beads of a chain that is continued by geometric series.
LONG: Final = 600
# Mark of a chain that need not be integrated.
DONE: Final = 100.0
# Index of a single chain of a batch.
FIRST_CHAIN: Final = np.zeros(1, np.int64)
# Units of the columns: entries of a row of `Batch.units`, which has velocity, time and length.
UNITS_OF_COLUMNS: Final = [0, 1, 1, 2, 1]
# Largest rate at which the beads of a chain other than a taper stay in order.
MAX_RATE_IN_WINDOW: Final = 0.05
# Growing tapers that begin with a larger ratio of radii use steps shorter by this factor.
STEEP, STEEP_PART = 1.4, 0.7

# Step size and release of opening contacts, as fractions of the time per bead and of a step, for
# a tolerance of 1e-8; the exponents were fitted to the errors measured at 1e-6 to 1e-10.
STEP_PART, STEP_ORDER, MAX_STEP_PART = 0.15, 6, 0.28
# Forces of higher exponents change faster: their steps are shorter by (p/1.5) to this power.
STEP_BY_EXPONENT: Final = -0.45
RELEASE_PART, RELEASE_ORDER, MAX_RELEASE_PART = 0.1, 4, 0.3
# Largest estimated error (of order 7) of a step of this fraction; above it the window fails.
ESTIMATED_ERROR, ESTIMATED_PART = 1e-6, 0.15


def follow(batch: Batch, rtol: float, signal: Indices) -> PulseData:
    """Integrate the pulse in each chain of a batch, with a window that is wide enough."""
    columns = np.full((COLUMNS, len(batch.masses)), np.nan)
    reasons: dict[int, str] = {}
    if len(batch.beads) > 1 or not _follow_taper(batch, rtol, columns, signal):
        continued = np.zeros(len(batch.beads), bool)
        for index in np.flatnonzero(batch.beads >= LONG):
            continued[index] = _continue(batch, int(index), rtol, columns, signal)
        if not continued.all():
            reasons = _follow_others(batch, ~continued, rtol, columns, signal)
    columns[:STRIKER_COLUMNS, batch.first] = STRUCK
    if batch.units is not None:
        columns *= np.repeat(batch.units[:, UNITS_OF_COLUMNS].T, batch.beads, axis=1)
    return PulseData(columns, reasons)


def _follow_taper(batch: Batch, rtol: float, columns: Array, signal: Indices) -> bool:
    """Integrate a single taper as `_follow_others` does, in less time; return whether it did."""
    law, grows = _taper_of(batch)
    if law in (OTHER, DONE):
        return False
    group = _LawGroup(batch, law, rtol, columns, signal)
    failed = group.narrow(FIRST_CHAIN) if grows else group.wide(FIRST_CHAIN)
    return not len(failed)


@once
def _taper_of(batch: Batch) -> tuple[float, bool]:
    """Law of a single taper, `DONE` if it is none or long, and whether its radii never shrink."""
    if batch.beads[0] >= LONG:
        return DONE, False
    taper, grows, _ = _shapes(batch)
    return float(_laws(batch)[0]) if taper[0] else DONE, bool(grows[0])


def _continue(batch: Batch, index: int, rtol: float, columns: Array, signal: Indices) -> bool:
    """Compute a long chain if its columns are geometric series."""
    finer = min(rtol, RTOL)
    series = continue_series(batch, index, rtol, lambda head: follow(head, finer, signal).columns)
    if series is None:
        return False
    begin = batch.first[index]
    columns[:, begin : begin + batch.beads[index]] = series
    return True


def _follow_others(
    batch: Batch, chosen: NDArray[np.bool_], rtol: float, columns: Array, signal: Indices
) -> dict[int, str]:
    """Integrate the chosen chains, each with a window that is wide enough."""
    taper, grows, even = _shapes(batch)
    laws = np.where(chosen, _laws(batch), DONE)
    todo = [_chosen(laws == OTHER)]
    for law in set(laws.tolist()) - {OTHER, DONE}:
        group = _LawGroup(batch, law, rtol, columns, signal)
        own = laws == law
        failed = group.narrow(_chosen(own & taper & grows))
        failed = group.wide(_together(failed, _chosen(own & taper & ~grows)))
        again = _together(failed[even[failed]], _chosen(own & even & ~taper))
        rest = _chosen(own & ~even & ~taper)
        todo += [failed[~even[failed]], rest, group.twice(again)]
    rest = _together(*todo)

    reasons: dict[int, str] = {}
    for smooth in (True, False) if len(rest) else ():
        some = rest[(taper | even)[rest] == smooth]
        if len(some):
            reasons |= follow_heterogeneous(some, smooth, rtol, batch, columns, signal)
    return reasons


def _chosen(mask: NDArray[np.bool_]) -> Indices:
    """Indices at which a mask is set."""
    return np.nonzero(mask)[0]


def _together(*parts: Indices) -> Indices:
    """Indices of several lists without common ones, in order."""
    filled = [part for part in parts if len(part)]
    if len(filled) > 1:
        return np.sort(np.concatenate(filled))
    return filled[0] if filled else parts[0]


@once
def _shapes(batch: Batch) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Masks of tapers, of chains whose radii never shrink, and of nearly uniform chains.

    The radii are those of spheres of the masses; a chain whose contacts are not those of such
    spheres, except for a common factor, is not a taper.
    """
    first, last = batch.first, batch.first + batch.beads - 1
    logs = np.log(batch.masses) / 3.0
    rates, turns = np.zeros_like(logs), np.zeros_like(logs)
    np.subtract(logs[1:], logs[:-1], out=rates[:-1])
    rates[last] = 0.0
    np.subtract(rates[1:], rates[:-1], out=turns[:-1])
    turns[last] = 0.0
    turns[last - 1] = 0.0
    up, down = np.maximum.reduceat(turns, first), np.minimum.reduceat(turns, first)
    steady = ((up < TURNING) | (down > -TURNING)) & (up < KINK) & (down > -KINK)
    # The rate of the last bead, which has no contact ahead, is that of the one before.
    rates[last] = rates[last - 1]
    least, most = np.minimum.reduceat(rates, first), np.maximum.reduceat(rates, first)
    grows = least > SHRINKING
    even = np.maximum(most, -least) <= MAX_RATE_IN_WINDOW
    spread = _spread_of_stiffness(batch, logs, rates, last)
    taper = steady & (grows | (most < -SHRINKING)) & (spread < SPHERES)
    return taper, grows, even & (spread < EVEN_STIFFNESS)


def _spread_of_stiffness(batch: Batch, logs: Array, rates: Array, last: Indices) -> Array:
    """Logarithm of the largest ratio of two contacts' stiffness to that of spheres."""
    # log of [2 R R'/(R + R')]^(1/2), from the logarithm of R and that of R'/R.
    spheres = 0.5 * (logs + rates - np.log(0.5 + 0.5 * np.exp(rates)))
    with np.errstate(divide="ignore"):
        ratio = np.log(batch.stiffness) - spheres
    ratio[last] = ratio[last - 1]
    found: Array = np.maximum.reduceat(ratio, batch.first)
    return found - np.minimum.reduceat(ratio, batch.first)


@once
def _laws(batch: Batch) -> Array:
    """Exponent of each chain that the window of few beads supports, otherwise `OTHER`."""
    p = batch.chain_exponents
    return np.where((p >= LOWEST_EXPONENT) & (p <= HIGHEST_EXPONENT), p, OTHER)


def _step_part(rtol: float) -> float:
    return float(min(MAX_STEP_PART, STEP_PART * (rtol / 1e-8) ** (1 / STEP_ORDER)))


def _release_part(rtol: float) -> float:
    return float(min(MAX_RELEASE_PART, RELEASE_PART * (rtol / 1e-8) ** (1 / RELEASE_ORDER)))


@dataclass(frozen=True, eq=False)
class _LawGroup:
    """Chains of a batch that have the same force law, and the windows to integrate them with."""

    batch: Batch
    law: float
    rtol: float
    columns: Array
    signal: Indices

    @cached_property
    def parts(self) -> tuple[float, float]:
        """Step size and release."""
        shorter = max(1.0, self.law / HERTZ_EXPONENT) ** STEP_BY_EXPONENT
        return shorter * _step_part(self.rtol), _release_part(self.rtol)

    @property
    def windows(self) -> Windows:
        return WINDOWS if self.law >= SOFT_EXPONENT else SOFT_WINDOWS

    def narrow(self, todo: Indices) -> Indices:
        """Integrate growing tapers; if they begin with a large ratio of radii, by shorter steps."""
        if not len(todo):
            return todo
        first, size = self.batch.first[todo], self.windows.narrow
        steep = self.batch.masses[first + 1] > STEEP**3 * self.batch.masses[first]
        finer = (STEEP_PART * self.parts[0], self.parts[1])
        if not steep.any():
            return self.attempt(todo, size, self.parts)
        failed = self.attempt(todo[~steep], size, self.parts)
        return _together(failed, self.attempt(todo[steep], size, finer))

    def wide(self, todo: Indices) -> Indices:
        enough = self.rtol >= WIDE_RTOL
        size = self.windows.wide if enough else self.windows.widest
        return self.attempt(todo, size, self.parts)

    def twice(self, todo: Indices) -> Indices:
        """Integrate chains with two windows and step sizes; return those whose results differ.

        Contacts are released much later in the second integration, because a release changes the
        times of events between it and the opening of the contact.
        """
        if not len(todo):
            return todo
        failed = self.attempt(todo, self.windows.widest, self.parts)
        tried = np.setdiff1d(todo, failed)
        if not len(tried):
            return todo
        check = np.full_like(self.columns, np.nan)
        finer = (0.8 * self.parts[0], 0.25 * self.parts[1])
        failed = self.attempt(tried, self.windows.checking, finer, check)
        agree = difference(self.columns, check, self.batch.first) <= self.rtol
        agreed = np.setdiff1d(tried, failed)
        agreed = agreed[agree[agreed]]
        taken = self.batch.beads_of(agreed)
        self.columns[:, taken] = check[:, taken]
        return np.setdiff1d(todo, agreed)

    def attempt(
        self,
        todo: Indices,
        size: tuple[int, int],
        parts: tuple[float, float],
        columns: Array | None = None,
    ) -> Indices:
        """Integrate chains with one window; return those for which it failed."""
        from ..kernels import narrow_window as kernel
        from ..kernels.narrow_window_rows import FOLLOWED

        if not len(todo) or self.signal[STOP]:
            return todo
        batch = self.batch
        # The motion at the rear of a narrow window must be negligible; wider ones need no check.
        rear = self.rtol if size == self.windows.narrow else np.inf
        limits = (rear, 0.1 * self.rtol, ESTIMATED_ERROR * (parts[0] / ESTIMATED_PART) ** 7)
        status = np.zeros(len(todo), np.int64)
        # With few chains, most lanes would be empty.
        lanes = kernel.ALONE if len(todo) < 3 else kernel.ABREAST
        exponents = None if self.law == HERTZ_EXPONENT else self.law
        kernel.follow(
            lanes,
            (*size, *parts),
            limits,
            (batch.given, batch.first[todo], batch.beads[todo], exponents),
            self.columns if columns is None else columns,
            status,
            self.signal,
            kernel.scratch_of(lanes),
        )
        return todo[status != FOLLOWED]
