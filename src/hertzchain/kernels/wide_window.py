r"""Integration of the beads around the pulse in heterogeneous chains, in a wide moving window.

Unequal beads scatter a pulse.  Light beads bounce between heavy ones, contacts open and close
repeatedly, beads reach their maxima out of order, and beads left behind catch up again.  Therefore
nothing is assumed about the order of events; the window is wide, and the first maximum of each bead
and the largest overlap of each contact are located independently::

      dropped                    the window                     not yet reached
      . . o o | o  o  o  o  o  o  O  o  o  o  o  o  o  o  o | o o . . .
      slot      0                 waiting                size-1
                rear: ``behind``  |    taken in as they are reached: front
                                  first bead that has not passed all its events

The method is RKN8(6)9FM (`hertzchain.kernels.rkn8`); its error estimate determines the steps.  If a
contact opens or closes within a step, the method loses its order, because the force begins or ends
like a power p of time: the error is :math:`O(h^{p+1})`.  When several contacts of a bead open and
close together, there is no closed form for the end of the push.  Instead, steps end where the next
contact is predicted to open or close, and the error estimate accounts for the remaining error.  The
further a bead is behind, the less it affects the pulse; the tolerated error therefore grows from
bead to bead (`hertzchain.kernels.wide_window_rows.grade`).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .compilation import compiled, entry_point
from .wide_window_events import record_events
from .wide_window_rows import (
    BEADS,
    CLOCK_SIZE,
    CREST,
    END,
    EXPONENT,
    FIRST,
    FORCE,
    GIVEN_EXPONENT,
    GIVEN_INVERSE_MASS,
    GIVEN_STIFFNESS,
    INVERSE_MASS,
    LAST_CROSSING,
    LOW,
    MAX_FORCE,
    NEW_VELOCITY,
    PLACE_SIZE,
    POSITION,
    SINCE_CROSSING,
    SIZE,
    SLOTS,
    STAGE_0,
    STAGE_8,
    STEP,
    STIFFNESS,
    TIME,
    TRIAL,
    VELOCITY,
    WAITING,
    accelerate,
    error_of_step,
    force,
    grade,
    measure,
    try_step,
)

# Status codes of a chain.
RUNNING, FOLLOWED, WINDOW_FULL, STALLED, BROKEN, STOPPED = range(6)
# Entries of `signal`, through which other threads stop the kernel and monitor its progress.
STOP, PASSED = 0, 1

# First step, as a fraction of the local time scale.
FIRST_STEP = 1e-3
# Bounds of the change of a step, and safety factor of its choice.
GROWTH, SHRINKAGE, SAFETY = 4.0, 0.1, 0.9
# Number of contacts behind `waiting` whose openings and closings end a step, and shortest such step
# as a fraction of the one chosen.
LANDING, MIN_PART = 12, 0.02
# Beads are added while the force on the last ones exceeds this fraction of the largest.
REACHED_FORCE = 1e-15
# Number of slots by which the window moves or grows.
STRIDE = 4
# Maximum number of steps per bead: ten times the number that random radii need.
MAX_STEPS = 1000
MIN_STEP, MIN_CREST, ENDLESS = 1e-280, 1e-280, 1e300


@compiled
def load_slot(w, place, given, i):
    """Load the bead of slot i, at rest; beyond the end of the chain, leave the slot empty."""
    bead = place[LOW] + i
    inside = bead < place[BEADS]
    at = place[FIRST] + bead
    w[STIFFNESS + i] = given[GIVEN_STIFFNESS, at] if inside else 0.0
    w[EXPONENT + i] = given[GIVEN_EXPONENT, at] if inside else 1.5
    w[INVERSE_MASS + i] = given[GIVEN_INVERSE_MASS, at] if inside else 0.0
    w[POSITION + i] = 0.0
    w[VELOCITY + i] = 0.0


@compiled
def start(w, clock, place, given):
    """Begin a chain; bead 1 is struck, bead 2 is the first that waits for an event."""
    w[:] = 0.0
    clock[:] = 0.0
    place[LOW], place[SIZE], place[WAITING], place[LAST_CROSSING] = 0, 2 * STRIDE, 1, -1
    for i in range(place[SIZE]):
        load_slot(w, place, given, i)
    w[VELOCITY] = 1.0
    # Largest overlap and force of the first two beads if they were isolated.
    reduced = 1.0 / (w[INVERSE_MASS] + w[INVERSE_MASS + 1])
    power_of_energy = w[EXPONENT] + 1.0
    overlap = (0.5 * power_of_energy * reduced / w[STIFFNESS]) ** (1.0 / power_of_energy)
    clock[STEP] = FIRST_STEP * overlap
    clock[CREST] = 1.0
    clock[MAX_FORCE] = force(w, 0, overlap)


@compiled
def take_in(w, clock, place, given):
    """Add beads if the pulse has reached the last ones of the window; False if it is full."""
    size = place[SIZE]
    reached = w[FORCE + 1 + size - STRIDE] > REACHED_FORCE * clock[MAX_FORCE]
    if not reached or place[LOW] + size >= place[BEADS]:
        return True
    if size + STRIDE > SLOTS:
        return False
    for i in range(size, size + STRIDE):
        load_slot(w, place, given, i)
    place[SIZE] += STRIDE
    return True


@compiled
def drop(w, place, exponent, given):
    """Move the window by STRIDE beads: drop the rearmost slots and load as many at the front."""
    size = place[SIZE]
    for i in range(size - STRIDE):
        for row in (POSITION, VELOCITY, STIFFNESS, EXPONENT, INVERSE_MASS):
            w[row + i] = w[row + i + STRIDE]
    place[LOW] += STRIDE
    for i in range(size - STRIDE, size):
        load_slot(w, place, given, i)
    for i in range(size):
        w[TRIAL + i] = w[POSITION + i]
    accelerate(w, size, exponent, STAGE_0)


@compiled
def step_to_contact(w, size, waiting, h):
    """The step, shortened to end where the next contact opens or closes, by a parabola."""
    longest = h
    for i in range(max(waiting - LANDING, 0), size - 1):
        overlap = w[POSITION + i] - w[POSITION + i + 1]
        closing = w[VELOCITY + i] - w[VELOCITY + i + 1]
        if overlap * closing >= 0.0 or abs(overlap) > 2.0 * abs(closing) * h:
            continue
        square = closing * closing - 2.0 * overlap * (w[STAGE_0 + i] - w[STAGE_0 + i + 1])
        if square > 0.0:
            time = 2.0 * abs(overlap) / (math.sqrt(square) + abs(closing))
            if MIN_PART * longest < time < h:
                h = time
    return h


@compiled
def accept(w, size):
    """Make the end of the step the present state."""
    for i in range(size):
        w[POSITION + i] = w[TRIAL + i]
        w[VELOCITY + i] = w[NEW_VELOCITY + i]
        w[STAGE_0 + i] = w[STAGE_8 + i]


@compiled
def advance(scratch, window, exponent, given, results):
    """Try one step and accept or shorten it; returns RUNNING or the final status of the chain."""
    w, clock, place = scratch
    behind, tolerance, grading = window
    size, h = place[SIZE], clock[STEP]
    measure(w, size, clock[CREST])
    try_step(w, size, h, exponent)
    error = error_of_step(w, size, h) / tolerance
    change = SAFETY * error ** (-1.0 / 7.0) if error > 0.0 else GROWTH
    if not error <= 1.0:
        clock[STEP] = h * (max(SHRINKAGE, change) if error > 1.0 else SHRINKAGE)
        return RUNNING if clock[STEP] > MIN_STEP else BROKEN
    record_events(w, clock, place, h, results)
    accept(w, size)
    clock[TIME] += h
    clock[SINCE_CROSSING] += h
    if place[WAITING] == place[BEADS]:
        return FOLLOWED
    if not clock[CREST] > MIN_CREST or not clock[TIME] < ENDLESS:
        return BROKEN
    if not take_in(w, clock, place, given):
        return WINDOW_FULL
    if place[WAITING] - place[LOW] >= behind + STRIDE:
        drop(w, place, exponent, given)
    grade(w, place[SIZE], place[WAITING] - place[LOW], grading)
    h *= min(GROWTH, max(SHRINKAGE, change))
    clock[STEP] = step_to_contact(w, place[SIZE], place[WAITING] - place[LOW], h)
    return RUNNING


@entry_point
def follow(window, given, results, status, work, signal, scratch):
    """Follow the pulse along many chains, one after the other.

    Parameters
    ----------
    window : (beads kept behind the first one that still waits for an event; tolerated error of a
        step, in units of the speeds around each bead; factor by which this error grows from bead
        to bead behind)
    given : (chains, first, beads, exponents): (3, M) inverse masses, stiffness and exponents of all
        beads of all chains, where the contact after the last bead of a chain has stiffness 0;
        index among the M beads at which each of the C chains begins; its number of beads; the
        exponent of its contacts if they share one, otherwise NaN
    results : (COLUMNS, M) zeros on entry; filled as by `hertzchain.kernels.narrow_window.follow`,
        except that the residence time is 0 for a contact that does not cross right after the one
        before it
    status : (C,) status code of each chain
    work : (C,) number of slots times steps left to each chain, counted down to 0; the chain is then
        rejected
    signal : (2,) set entry STOP to end early; entry PASSED counts beads
    scratch : result of `new_scratch`
    """
    chains, first, beads, exponents = given
    w, clock, place = scratch
    for index in range(len(status)):
        place[FIRST], place[BEADS] = first[index], beads[index]
        start(w, clock, place, chains)
        grade(w, place[SIZE], place[WAITING], window[2])
        code = RUNNING
        trials = MAX_STEPS * beads[index]
        while code == RUNNING:
            if signal[STOP] != 0:
                status[index] = STOPPED
                return
            waiting = place[WAITING]
            code = advance(scratch, window, exponents[index], chains, results)
            signal[PASSED] += place[WAITING] - waiting
            trials -= 1
            work[index] -= place[SIZE]
            if (trials == 0 or work[index] <= 0) and code == RUNNING:
                code = STALLED
        status[index] = code


def new_scratch() -> tuple[Any, Any, Any]:
    """The window and the scalars of a chain, for `follow`."""
    line = 64
    w = np.zeros(END + line // 8)
    w = w[-w.ctypes.data % line // 8 :][:END]
    return w, np.zeros(CLOCK_SIZE), np.zeros(PLACE_SIZE, np.int64)
