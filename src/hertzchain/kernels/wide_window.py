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

One chain is followed at a time, and the loops without branches over the slots of the window allow
the compiler to process several *slots* with one instruction.  All numbers are in one array ``w``,
in *rows* with constant offsets; in a row, slot ``s`` is entry ``s``, and contact ``s`` joins slots
``s`` and ``s + 1``.

The method is RKN8(6)9FM (`hertzchain.kernels.rkn8`); its error estimate determines the steps.  If a
contact opens or closes within a step, the method loses its order, because the force begins or ends
like a power p of time: the error is :math:`O(h^{p+1})`.  When several contacts of a bead open and
close together, there is no closed form for the end of the push.  Instead, steps end where the next
contact is predicted to open or close, and the error estimate accounts for the remaining error.  The
further a bead is behind, the less it affects the pulse; the tolerated error therefore grows from
bead to bead (`grade`).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from .compilation import OPTIONS, compiled
from .hermite import hermite, slope, value
from .powers import power
from .rkn8_stages import Rows, step_on

SLOTS = 256
# Entries before and after a row, for reads beyond its ends; rows are aligned to the lines of the
# processor's cache.
MARGIN = 8
ROW = SLOTS + 2 * MARGIN
(
    POSITION, VELOCITY, TRIAL, STIFFNESS, EXPONENT, INVERSE_MASS, FORCE, SPEED, SCALE, GRADE,
    ERROR, NEW_VELOCITY,
    STAGE_0, STAGE_1, STAGE_2, STAGE_3, STAGE_4, STAGE_5, STAGE_6, STAGE_7, STAGE_8, END,
) = range(MARGIN, MARGIN + 22 * ROW, ROW)  # fmt: skip

# Scalars of the chain: time, time since the last crossing, next step; velocity of the bead and
# force of the contact at the last crossing.
TIME, SINCE_CROSSING, STEP, CREST, MAX_FORCE, CLOCK_SIZE = range(6)
# The chain's first entry in `given` and its number of beads; bead in slot 0, slots in use, first
# bead that still waits for an event, contact of the last crossing.
FIRST, BEADS, LOW, SIZE, WAITING, LAST_CROSSING, PLACE_SIZE = range(7)

# Status codes of a chain.
RUNNING, FOLLOWED, WINDOW_FULL, STALLED, BROKEN, STOPPED = range(6)
# Entries of `signal`, through which other threads stop the kernel and monitor its progress.
STOP, PASSED = 0, 1
# Rows of `given`, the parameters of every bead, and of `results`; 0 = not yet.
GIVEN_INVERSE_MASS, GIVEN_STIFFNESS, GIVEN_EXPONENT = 0, 1, 2
PEAK_VELOCITY, PEAK_TIME, ARRIVAL, PEAK_OVERLAP, RESIDENCE, COLUMNS = range(6)

# First step, as a fraction of the local time scale.
FIRST_STEP = 1e-3
# Bounds of the change of a step, and safety factor of its choice.
GROWTH, SHRINKAGE, SAFETY = 4.0, 0.1, 0.9
# Beads behind `waiting` from which on the tolerated error grows from bead to bead.
UNGRADED = 4
# Number of contacts behind `waiting` whose openings and closings end a step, and shortest such step
# as a fraction of the one chosen.
LANDING, MIN_PART = 12, 0.02
# Beads are added while the force on the last ones exceeds this fraction of the largest.
REACHED_FORCE = 1e-15
# The pulse has not reached a bead that is slower than this fraction of the speeds around it.  Ahead
# of the pulse, rounding errors may have maxima.
REACHED = 1e-11
# Lower bound of the speeds that scale the errors, as a fraction of the crest's velocity.
AT_REST = 1e-9
# Number of slots by which the window moves or grows.
STRIDE = 4
# Number of parts of a step that are searched, one after the other, for the first event (a light
# bead may reverse its direction twice in a step), and of bisections of a part: to 1e-12 of a step.
PARTS, BISECTIONS = 8, 36
# Maximum number of steps per bead: ten times the number that random radii need.
MAX_STEPS = 1000
MIN_STEP, MIN_CREST, ENDLESS = 1e-280, 1e-280, 1e300

inlined = njit(forceinline=True, **OPTIONS)


@inlined
def force(w, i, overlap):
    """Force k d^p of contact i at an overlap."""
    if overlap <= 0.0:
        return 0.0
    if w[EXPONENT + i] == 1.5:
        return w[STIFFNESS + i] * overlap * math.sqrt(overlap)
    return w[STIFFNESS + i] * power(overlap, w[EXPONENT + i])


@compiled
def force_rate(w, i, overlap, closing):
    """Rate of change p F d'/d of the force of contact i."""
    if overlap <= 0.0:
        return 0.0
    return w[EXPONENT + i] * force(w, i, overlap) / overlap * closing


@compiled
def press(w, size, exponent):
    """Forces of all contacts at the trial positions.

    If all contacts have ``exponent`` 1.5 or 2, no powers are computed; any other value selects
    their own exponents.
    """
    if exponent == 1.5:
        for i in range(size):
            d = w[TRIAL + i] - w[TRIAL + i + 1]
            d = d if d > 0.0 else 0.0
            w[FORCE + 1 + i] = w[STIFFNESS + i] * d * math.sqrt(d)
    elif exponent == 2.0:
        for i in range(size):
            d = w[TRIAL + i] - w[TRIAL + i + 1]
            d = d if d > 0.0 else 0.0
            w[FORCE + 1 + i] = w[STIFFNESS + i] * d * d
    else:
        for i in range(size):
            d = w[TRIAL + i] - w[TRIAL + i + 1]
            w[FORCE + 1 + i] = w[STIFFNESS + i] * power(d, w[EXPONENT + i])


@inlined
def accelerate(w, size, exponent, accelerations):
    """Accelerations of all slots at the trial positions, Eq. (4) of the paper."""
    press(w, size, exponent)
    for i in range(size):
        net = w[FORCE + i] - w[FORCE + 1 + i]
        w[accelerations + i] = net * w[INVERSE_MASS + i]


@inlined
def accelerate_stage(w, low, high, out, stage, exponent, nothing):  # noqa: ARG001
    """Accelerations at a stage."""
    accelerate(w, high, exponent, out)


take_step, velocity_error = step_on(
    Rows(
        POSITION, VELOCITY, TRIAL, TRIAL, NEW_VELOCITY,
        (STAGE_0, STAGE_1, STAGE_2, STAGE_3, STAGE_4, STAGE_5, STAGE_6, STAGE_7),
    ),
    accelerate_stage,
)  # fmt: skip


@inlined
def try_step(w, size, h, exponent):
    """One step of order 8; stage 0 must hold the accelerations at its start."""
    take_step(w, 0, size, h, exponent, None)
    accelerate(w, size, exponent, STAGE_8)


@inlined
def spread(w, size, speeds, wider):
    """Write the largest of the speeds of each slot and its two neighbours to row ``wider``."""
    for i in range(size):
        a, b, c = w[speeds + i - 1], w[speeds + i], w[speeds + i + 1]
        larger = a if a > b else b
        w[wider + i] = larger if larger > c else c


@compiled
def measure(w, size, crest):
    """Compute the speeds that scale the errors: the largest within three beads, graded."""
    for i in range(size):
        w[SPEED + i] = abs(w[VELOCITY + i]) + AT_REST * crest
    spread(w, size, SPEED, SCALE)
    spread(w, size, SCALE, SPEED)
    spread(w, size, SPEED, SCALE)
    for i in range(size):
        w[SCALE + i] *= w[GRADE + i]


@compiled
def grade(w, size, waiting, grading):
    """Compute the factors by which the tolerated error grows behind the waiting slot."""
    tolerated = 1.0
    for i in range(size - 1, -1, -1):
        if i < waiting - UNGRADED:
            tolerated *= grading
        w[GRADE + i] = tolerated


@compiled
def error_of_step(w, size, h):
    """Largest estimated error of the velocities, in units of their scales; NaN propagates."""
    for i in range(size):
        w[ERROR + i] = abs(h * velocity_error(w, i, STAGE_0, STAGE_8)) / w[SCALE + i]
    worst = 0.0
    for i in range(size):
        if not w[ERROR + i] <= worst:
            worst = w[ERROR + i]
    return worst


@compiled
def jerk(w, i, positions, velocities):
    """Rate of change of the acceleration of slot i."""
    x, v = positions + i, velocities + i
    push = 0.0
    if i > 0:
        push = force_rate(w, i - 1, w[x - 1] - w[x], w[v - 1] - w[v])
    push -= force_rate(w, i, w[x] - w[x + 1], w[v] - w[v + 1])
    return push * w[INVERSE_MASS + i]


@compiled
def motion(w, i, h):
    """Position of slot i within the step, as a polynomial."""
    return hermite(
        h,
        w[POSITION + i], w[VELOCITY + i], w[STAGE_0 + i],
        jerk(w, i, POSITION, VELOCITY),
        w[TRIAL + i], w[NEW_VELOCITY + i], w[STAGE_8 + i],
        jerk(w, i, TRIAL, NEW_VELOCITY),
    )  # fmt: skip


@compiled
def net_force(w, i, motions, s):
    """Net force on slot i within the step, from the positions of the slot and its neighbours."""
    left, here, right = motions
    x = value(here, s)
    return force(w, i - 1, value(left, s) - x) - force(w, i, x - value(right, s))


@compiled
def peak_within(w, i, motions):
    """Fraction of the step at which the net force on slot i is first not positive; 2 if none."""
    low = 0.0
    for part in range(1, PARTS + 1):
        high = part / PARTS
        if net_force(w, i, motions, high) <= 0.0:
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                rising = net_force(w, i, motions, middle) > 0.0
                low, high = (middle, high) if rising else (low, middle)
            return high
        low = high
    return 2.0


@compiled
def crossing_within(motions):
    """Fraction of the step at which a slot is first not faster than the next; 2 if none."""
    here, right = motions
    low = 0.0
    for part in range(1, PARTS + 1):
        high = part / PARTS
        if slope(here, high) <= slope(right, high):
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                closing = slope(here, middle) > slope(right, middle)
                low, high = (middle, high) if closing else (low, middle)
            return high
        low = high
    return 2.0


@compiled
def may_peak(w, i):
    """Whether slot i, pushed at the start of the step, is not pushed at some stage."""
    if w[STAGE_0 + i] <= 0.0:
        return False
    for stage in range(STAGE_0, END, ROW):
        if w[stage + i] <= 0.0:
            return True
    return False


@compiled
def may_cross(w, i):
    """Whether the overlap of contact i, growing at the start of the step, may stop within it."""
    if w[VELOCITY + i] <= w[VELOCITY + i + 1]:
        return False
    if w[NEW_VELOCITY + i] <= w[NEW_VELOCITY + i + 1]:
        return True
    return w[STAGE_0 + i] < w[STAGE_0 + i + 1] and w[STAGE_8 + i] > w[STAGE_8 + i + 1]


@compiled
def record_peak(w, i, h, time, at, results):
    """Record the velocity maximum of slot i, if it is within the step."""
    left, here = motion(w, i - 1, h), motion(w, i, h)
    motions = left, here, motion(w, i + 1, h)
    part = peak_within(w, i, motions)
    if part > 1.0:
        return
    # A bead that has left both neighbours keeps the velocity at the end of the step.
    in_flight = w[STAGE_8 + i] == 0.0 and net_force(w, i, motions, part) == 0.0
    results[PEAK_VELOCITY, at] = w[NEW_VELOCITY + i] if in_flight else slope(here, part) / h
    results[PEAK_TIME, at] = time + part * h


@compiled
def record_crossing(w, i, h, clock, place, at, results):
    """Record the largest overlap of contact i, if it is within the step.

    The residence time is counted from the previous crossing: a difference of two arrival times
    would suffer from cancellation where the pulse becomes much faster.
    """
    here, right = motion(w, i, h), motion(w, i + 1, h)
    part = crossing_within((here, right))
    if part > 1.0:
        return
    overlap = value(here, part) - value(right, part)
    results[ARRIVAL, at + 1] = clock[TIME] + part * h
    results[PEAK_OVERLAP, at] = overlap
    contact = place[LOW] + i
    if place[LAST_CROSSING] == contact - 1:
        results[RESIDENCE, at] = clock[SINCE_CROSSING] + part * h
    place[LAST_CROSSING] = contact
    clock[SINCE_CROSSING] = -part * h
    # A light bead may already have reversed its direction, or hardly move.
    clock[CREST] = max(abs(w[NEW_VELOCITY + i + 1]), abs(w[NEW_VELOCITY + i + 2]))
    clock[MAX_FORCE] = force(w, i, overlap)


@compiled
def record_events(w, clock, place, h, results):
    """Record the first maxima and largest overlaps of the step."""
    low = place[LOW]
    for i in range(place[WAITING] - low, min(place[SIZE], place[BEADS] - low)):
        # A bead may reverse its direction within the step.
        before, after = w[VELOCITY + i], w[NEW_VELOCITY + i]
        least = REACHED * w[SCALE + i]
        if not max(abs(before), abs(after)) > least:
            continue
        at = place[FIRST] + low + i
        if results[ARRIVAL, at] == 0.0 and may_cross(w, i - 1):
            record_crossing(w, i - 1, h, clock, place, at - 1, results)
        forward = max(before, after) > least
        if forward and results[PEAK_TIME, at] == 0.0 and may_peak(w, i):
            record_peak(w, i, h, clock[TIME], at, results)
    while place[WAITING] < place[BEADS]:
        at = place[FIRST] + place[WAITING]
        if results[ARRIVAL, at] == 0.0 or results[PEAK_TIME, at] == 0.0:
            break
        place[WAITING] += 1


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
    # Compression time and largest force of the first two beads if they were isolated.
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


@compiled
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
