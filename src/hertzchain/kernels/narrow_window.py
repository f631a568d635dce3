r"""Integration of a few beads around the pulse, in a window that moves with it.

A pulse extends over a few beads.  Ahead of it all beads are at rest; behind it the contacts open,
or their forces become negligible.  Therefore only a *window* of beads is integrated.  It is moved
by one bead (`shift_window`) each time the velocity of the *candidate*, the bead next to reach its
velocity maximum, passes this maximum::

      dropped                the window                       not yet reached
      . . . o | o  o  o  o  o  O  o  o  o | o . . .
      slot      0           p-1 p p+1    W-1
                rear            |        front
                                candidate (p = slots behind it)

Contact ``s`` of the window joins slots ``s`` and ``s + 1``; the last contact joins the last slot
and a bead at rest.  All numbers of the window are in one array ``w``, with a *row* for positions,
one for velocities, and so on; in a row, slot ``s`` of lane ``l`` has index ``s * lanes + l``::

      w = [ position        | velocity | trial | ... | stage 0 | ... | stage 7 ]
            ^ slot 0: lanes 0..7, slot 1: lanes 0..7, ...

Each *lane* is a separate chain with its own step; several chains are integrated side by side.  One
array with constant offsets, and loops without branches over a row, allow the compiler to process
several lanes with one instruction.

The method is RKN8(6)9FM (`hertzchain.kernels.rkn8`); its steps are a fixed fraction of the time
that the pulse takes per bead.  The method would lose its order where the force grows like a power p
of time: at the impact, and at each contact that opens behind the pulse.  At the impact, the first
steps are therefore graded; at the opening of a contact, `release` integrates the end of the push in
closed form.  A chain that does not satisfy the assumptions of the window is rejected with a status
code.

Forces of Hertz's law require only a square root, `hertz`; other exponents, which may differ between
contacts, use `hertzchain.kernels.powers.power`.  The kernel is compiled for either kind when it is
first needed.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from .compilation import CONTRACTED
from .hermite import curvature, hermite, slope, third, value
from .powers import power
from .rkn8_stages import Rows, step_on

LANES = 8
MAX_SLOTS = 32
# Length of a row: the longest window and a few more entries, so that the rows are not mapped to the
# same lines of the processor's cache.
ROW = (MAX_SLOTS + 3) * LANES
(
    POSITION, VELOCITY, TRIAL, STIFFNESS, EXPONENT, INVERSE_MASS, FORCE, STEP, ERROR,
    OLD_POSITION, OLD_VELOCITY, OLD_STAGE_0,
    STAGE_0, STAGE_1, STAGE_2, STAGE_3, STAGE_4, STAGE_5, STAGE_6, STAGE_7, CLOCK, END,
) = range(0, 22 * ROW, ROW)  # fmt: skip
# Scalars of each lane: entries of the row CLOCK, LANES for each. Time is counted from the last
# arrival. ARRIVED is 1 from the arrival at the candidate on, LAST is 1 if the candidate is the last
# bead, WATCH is 1 if an event may have occurred in the last step.
(
    ARRIVAL_TIME, TIME, OLD_STEP, TARGET_STEP, FREE_STEP, MAX_FORCE, ARRIVED, LAST, STEPS,
    NEXT_STEP, WATCH, CLOCK_SIZE,
) = range(0, 12 * LANES, LANES)  # fmt: skip
CHAIN, FIRST, BEAD, BEADS, PLACE_SIZE = range(5)

# Status codes of a chain.
WAITING, FOLLOWED, OUT_OF_ORDER, REAR_CUT, FRONT_CUT, INACCURATE, STALLED, BROKEN = range(8)
# Entries of `signal`, through which other threads stop the kernel and monitor its progress.
STOP, PASSED = 0, 1
# Argument of `follow` for one chain at a time and for LANES chains side by side; because the tuples
# have different types, a separate version is compiled for each.
ALONE, ABREAST = (0,), (0,) * LANES
# Rows of `chains`, the parameters of every bead, and of `results`.
GIVEN_INVERSE_MASS, GIVEN_STIFFNESS, GIVEN_EXPONENT = 0, 1, 2
PEAK_VELOCITY, PEAK_TIME, ARRIVAL, PEAK_OVERLAP, RESIDENCE, COLUMNS = range(6)

# First step as a fraction of the local time scale, and growth factor of the steps that follow.
FIRST_STEP, GRADING = 1e-3, 1.4
# Before a contact opens, steps are at most this fraction of the time left until it opens.
APPROACH = 0.5
# A contact that opens within this fraction of a step is released even if an arrival is about to
# occur.
SOON = 1e-4
# Contacts behind the candidate that are watched for opening.
WATCHED = 4
# Beads slower than this fraction of the candidate's velocity are at the foot of the pulse, where
# rounding errors may have maxima.
FOOT = 1e-6
# Maximum number of steps per bead: ten times the number that any taper needs.
MAX_STEPS = 400

# In these short functions, reference counting would take longer than the computation; contraction
# saves 5% of the time. The second option is for functions called in every step and for the events,
# whose many arguments would take as long to pass as a step.
compiled = njit(**CONTRACTED)
inlined = njit(forceinline=True, **CONTRACTED)


@inlined
def hertz(overlap, stiffness):
    """Contact force k d^1.5; zero without overlap."""
    d = overlap if overlap > 0.0 else 0.0
    return stiffness * d * math.sqrt(d)


@inlined
def pushing(w, i, overlap, exponents):
    """Force of contact i at an overlap; ``exponents`` is `None` for Hertz's law."""
    if exponents is None:
        return hertz(overlap, w[STIFFNESS + i])
    return w[STIFFNESS + i] * power(overlap, w[EXPONENT + i])


@inlined
def accelerate(w, low, high, out, stage, lanes, exponents):
    """Forces and accelerations of slots at a stage, Eq. (4) of the paper."""
    positions = POSITION if stage == 0 else TRIAL
    for i in range(low, high):
        overlap = w[positions + i] - w[positions + i + lanes]
        w[FORCE + lanes + i] = pushing(w, i, overlap, exponents)
    for i in range(low, high):
        net = w[FORCE + i] - w[FORCE + lanes + i]
        w[out + i] = net * w[INVERSE_MASS + i]


try_step, velocity_error = step_on(
    Rows(
        POSITION, VELOCITY, TRIAL, POSITION, VELOCITY,
        (STAGE_0, STAGE_1, STAGE_2, STAGE_3, STAGE_4, STAGE_5, STAGE_6, STAGE_7), STEP,
    ),
    accelerate,
)  # fmt: skip


@inlined
def take_step(w, size, lanes, exponents):
    """One step of order 8 in every lane; stage 0 must hold the accelerations at its start."""
    try_step(w, 0, size, None, lanes, exponents)


@inlined
def keep_old(w, candidates, lanes):
    """Copy the values at the start of the step that the interpolation of events needs.

    These are the positions and velocities of the candidate, of the two slots behind it and of the
    slot ahead, and the accelerations of the candidate and of the slot behind it.
    """
    for i in range(candidates - 2 * lanes, candidates + 2 * lanes):
        w[OLD_POSITION + i] = w[POSITION + i]
        w[OLD_VELOCITY + i] = w[VELOCITY + i]
    for i in range(candidates - lanes, candidates + lanes):
        w[OLD_STAGE_0 + i] = w[STAGE_0 + i]


@inlined
def note_error(w, candidates, lanes):
    """Update the largest estimated velocity error of each candidate.

    Requires stages 1 to 7 of the step, the old stage 0 and, in stage 0, the accelerations at the
    end of the step (the ninth stage).
    """
    for i in range(candidates, candidates + lanes):
        error = velocity_error(w, i, OLD_STAGE_0, STAGE_0)
        error = abs(w[STEP + i] * error)
        w[ERROR + i] = error if error > w[ERROR + i] else w[ERROR + i]


@compiled
def force_rate(w, i, lanes, positions, velocities, exponents):
    """Rate of change of the force of contact i: p F d'/d."""
    overlap = w[positions + i] - w[positions + i + lanes]
    if overlap <= 0.0:
        return 0.0
    closing = w[velocities + i] - w[velocities + i + lanes]
    if exponents is None:
        return 1.5 * w[STIFFNESS + i] * math.sqrt(overlap) * closing
    return w[EXPONENT + i] * pushing(w, i, overlap, exponents) / overlap * closing


@compiled
def jerk(w, i, lanes, positions, velocities, exponents):
    """Rate of change of the acceleration of slot i."""
    push = force_rate(w, i - lanes, lanes, positions, velocities, exponents)
    return (push - force_rate(w, i, lanes, positions, velocities, exponents)) * w[INVERSE_MASS + i]


@compiled
def overlap_jerk(w, i, lanes, positions, velocities, exponents):
    """Rate of change of the relative acceleration of the two slots of contact i."""
    k = i + lanes
    behind = force_rate(w, i - lanes, lanes, positions, velocities, exponents) * w[INVERSE_MASS + i]
    ahead = force_rate(w, k, lanes, positions, velocities, exponents) * w[INVERSE_MASS + k]
    between = force_rate(w, i, lanes, positions, velocities, exponents)
    return behind + ahead - between * (w[INVERSE_MASS + i] + w[INVERSE_MASS + k])


@compiled
def largest_overlap(w, i, lanes, h, exponents):
    """Overlap of contact i when its beads have equal velocities, and the fraction of the step.

    Newton's method on the slope of the Hermite polynomial of the overlap.
    """
    k = i + lanes
    u0 = w[OLD_VELOCITY + i] - w[OLD_VELOCITY + k]
    u1 = w[VELOCITY + i] - w[VELOCITY + k]
    c = hermite(
        h,
        w[OLD_POSITION + i] - w[OLD_POSITION + k], u0, w[OLD_STAGE_0 + i] - w[OLD_STAGE_0 + k],
        overlap_jerk(w, i, lanes, OLD_POSITION, OLD_VELOCITY, exponents),
        w[POSITION + i] - w[POSITION + k], u1, w[STAGE_0 + i] - w[STAGE_0 + k],
        overlap_jerk(w, i, lanes, POSITION, VELOCITY, exponents),
    )  # fmt: skip
    s = u0 / (u0 - u1)
    for _ in range(3):
        s -= slope(c, s) / curvature(c, s)
    return value(c, s), s


@compiled
def velocity_maximum(w, i, lanes, h, exponents):
    """Largest velocity of slot i within the step, and its fraction (zero of the acceleration)."""
    a0, a1 = w[OLD_STAGE_0 + i], w[STAGE_0 + i]
    c = hermite(
        h,
        w[OLD_POSITION + i], w[OLD_VELOCITY + i], a0,
        jerk(w, i, lanes, OLD_POSITION, OLD_VELOCITY, exponents),
        w[POSITION + i], w[VELOCITY + i], a1, jerk(w, i, lanes, POSITION, VELOCITY, exponents),
    )  # fmt: skip
    s = a0 / (a0 - a1)
    for _ in range(3):
        s -= curvature(c, s) / third(c, s)
    return slope(c, s) / h, s


@compiled
def remaining_push(w, i, lanes, left, exponents):
    r"""Time left until contact i opens, its remaining impulse and the first moment of its force.

    The overlap is extrapolated as a cubic in time, from its present derivatives, to its zero
    :math:`\sigma`.  As a function of :math:`u = 1 - t/\sigma` it is
    :math:`D u (1 + e_1 u + e_2 u^2)`, and with the expansion

    .. math:: (1 + e_1 u + e_2 u^2)^p \approx 1 + q_1 u + q_2 u^2 + q_3 u^3

    the integrals of the force :math:`k d^p` are sums of powers.
    """
    k = i + lanes
    d0, d1 = w[POSITION + i] - w[POSITION + k], w[VELOCITY + i] - w[VELOCITY + k]
    d2 = w[STAGE_0 + i] - w[STAGE_0 + k]
    d3 = overlap_jerk(w, i, lanes, POSITION, VELOCITY, exponents)
    for _ in range(3):
        gap = d0 + left * (d1 + left * (d2 / 2.0 + left * d3 / 6.0))
        left -= gap / (d1 + left * (d2 + left * d3 / 2.0))
    opening = -(d1 + left * (d2 + left * d3 / 2.0))
    e1 = (d2 + left * d3) / (2.0 * opening) * left
    e2 = -d3 / (6.0 * opening) * left * left
    p = 1.5 if exponents is None else w[EXPONENT + i]
    q1 = p * e1
    q2 = p * (e2 + 0.5 * (p - 1.0) * e1 * e1)
    q3 = p * (p - 1.0) * e1 * (e2 + (p - 2.0) / 6.0 * e1 * e1)
    scale = pushing(w, i, opening * left, exponents) * left
    a, b, c = p + 1.0, p + 2.0, p + 3.0
    impulse = scale * (1.0 / a + q1 / b + q2 / c + q3 / (p + 4.0))
    moment = scale * left * (1.0 / b + q1 / c + q2 / (p + 4.0) + q3 / (p + 5.0))
    return left, impulse, moment


@compiled
def release(w, i, lanes, left, exponents):
    """Transfer the remaining impulse of contact i to the bead ahead, and remove the contact.

    The position of this bead is corrected so that position and velocity are exact from the time
    at which the contact would have opened.  Returns the time left until then.
    """
    left, impulse, moment = remaining_push(w, i, lanes, left, exponents)
    ahead = i + lanes
    overlap = w[POSITION + i] - w[POSITION + ahead]
    w[STAGE_0 + ahead] -= pushing(w, i, overlap, exponents) * w[INVERSE_MASS + ahead]
    w[VELOCITY + ahead] += impulse * w[INVERSE_MASS + ahead]
    w[POSITION + ahead] -= (impulse * left - moment) * w[INVERSE_MASS + ahead]
    w[STIFFNESS + i] = 0.0
    return left


@inlined
def time_to_opening(w, i, lanes, horizon):
    """Time until contact i opens, by a parabola; ``inf`` if not within the horizon."""
    k = i + lanes
    d0, d1 = w[POSITION + i] - w[POSITION + k], w[VELOCITY + i] - w[VELOCITY + k]
    square = d1 * d1 - 2.0 * d0 * (w[STAGE_0 + i] - w[STAGE_0 + k])
    opens = (d1 < 0.0) & (d0 <= -d1 * horizon) & (square > 0.0)
    root = math.sqrt(square if opens else 1.0)
    return 2.0 * d0 / (root - d1) if opens else math.inf


@compiled
def time_to_arrival(w, candidate, lanes):
    """Time until the candidate is as fast as the bead behind it, by linear extrapolation."""
    closing = w[VELOCITY + candidate - lanes] - w[VELOCITY + candidate]
    return closing / (w[STAGE_0 + candidate] - w[STAGE_0 + candidate - lanes])


@inlined
def handle_openings(w, clock, place, lane, lanes, behind, release_part, given):
    """Release contacts that are opening, restore those that close again; returns the next step."""
    target = clock[TARGET_STEP + lane]
    step = target
    for back in range(2, WATCHED + 1):
        i = (behind - back) * lanes + lane
        left = time_to_opening(w, i, lanes, 4.0 * target)
        if w[STIFFNESS + i] == 0.0:
            if w[POSITION + i] <= w[POSITION + i + lanes]:
                bead = place[BEAD, lane] - back
                w[STIFFNESS + i] = given[0][GIVEN_STIFFNESS, place[FIRST, lane] + bead]
        elif 0.0 < left < release_part * target:
            if back == 2 and clock[ARRIVED + lane] == 0.0 and left > SOON * target:
                # Until the contact opens, its impulse would make the bead too fast and the arrival
                # too late.
                arrival = time_to_arrival(w, behind * lanes + lane, lanes)
                if 0.0 < arrival < left:
                    step = min(step, 0.5 * (arrival + left))
                    continue
            release(w, i, lanes, left, given[3])
        elif left > 0.0:
            step = min(step, APPROACH * left)
    return step


@compiled
def load_slot(w, i, given, place, lane, bead):
    """Load a bead at rest into a slot; beyond the ends of the chain, leave the slot empty."""
    chains, exponents = given[0], given[3]
    inside = 0 <= bead < place[BEADS, lane]
    at = place[FIRST, lane] + bead
    w[STIFFNESS + i] = chains[GIVEN_STIFFNESS, at] if inside else 0.0
    w[INVERSE_MASS + i] = chains[GIVEN_INVERSE_MASS, at] if inside else 0.0
    if exponents is not None:
        w[EXPONENT + i] = chains[GIVEN_EXPONENT, at] if inside else 1.5
    w[POSITION + i] = 0.0
    w[VELOCITY + i] = 0.0
    w[STAGE_0 + i] = 0.0
    w[ERROR + i] = 0.0


@compiled
def load_chain(scratch, lane, lanes, window, given, chain):
    """Begin a chain in a lane; bead 1 is struck, bead 2 is the candidate."""
    w, clock, place = scratch
    slots, behind, step_part, _ = window
    _, first, beads, exponents = given
    place[CHAIN, lane] = chain
    place[FIRST, lane] = first[chain]
    place[BEADS, lane] = beads[chain]
    place[BEAD, lane] = 1
    for s in range(slots):
        load_slot(w, s * lanes + lane, given, place, lane, s - behind + 1)
    striker = (behind - 1) * lanes + lane
    w[VELOCITY + striker] = 1.0
    # Compression time of the first two beads if they were isolated.
    reduced = 1.0 / (w[INVERSE_MASS + striker] + w[INVERSE_MASS + striker + lanes])
    p = 1.5 if exponents is None else w[EXPONENT + striker]
    largest = (0.5 * (p + 1.0) * reduced / w[STIFFNESS + striker]) ** (1.0 / (p + 1.0))
    time_scale = 1.4716 * largest
    for entry in (ARRIVAL_TIME, TIME, OLD_STEP, MAX_FORCE, ARRIVED, STEPS):
        clock[entry + lane] = 0.0
    clock[LAST + lane] = 1.0 if beads[chain] == 2 else 0.0
    clock[TARGET_STEP + lane] = step_part * time_scale
    clock[FREE_STEP + lane] = FIRST_STEP * time_scale


@compiled
def clear_lane(scratch, lane, lanes, window, given):
    """Empty a lane."""
    w, clock, place = scratch
    place[CHAIN, lane] = -1
    place[BEADS, lane] = 0
    for s in range(window[0]):
        load_slot(w, s * lanes + lane, given, place, lane, s)
    for entry in range(0, CLOCK_SIZE, LANES):
        clock[entry + lane] = 0.0
    clock[TARGET_STEP + lane] = 1.0
    clock[FREE_STEP + lane] = 1.0


@compiled
def shift_window(w, clock, place, lane, lanes, slots, behind, given):
    """Move the window by one bead: each slot is copied from the next, the last is loaded."""
    last = (slots - 1) * lanes + lane
    exponents = given[3]
    for i in range(lane, last, lanes):
        w[POSITION + i] = w[POSITION + i + lanes]
        w[VELOCITY + i] = w[VELOCITY + i + lanes]
        w[STIFFNESS + i] = w[STIFFNESS + i + lanes]
        w[INVERSE_MASS + i] = w[INVERSE_MASS + i + lanes]
        w[STAGE_0 + i] = w[STAGE_0 + i + lanes]
        if exponents is not None:
            w[EXPONENT + i] = w[EXPONENT + i + lanes]
    w[ERROR + behind * lanes + lane] = 0.0
    place[BEAD, lane] += 1
    clock[LAST + lane] = 1.0 if place[BEAD, lane] == place[BEADS, lane] - 1 else 0.0
    load_slot(w, last, given, place, lane, place[BEAD, lane] + slots - behind - 1)
    push = pushing(w, last - lanes, w[POSITION + last - lanes], exponents)
    w[STAGE_0 + last] = push * w[INVERSE_MASS + last]


@compiled
def window_status(w, clock, lane, lanes, slots, candidate, limits, exponents):
    """Check the cut-off forces and the error estimate before the window is moved."""
    rear_limit, front_limit, error_limit = limits
    speed = w[VELOCITY + candidate]
    largest = clock[MAX_FORCE + lane]
    rear = pushing(w, lane, w[POSITION + lane] - w[POSITION + lane + lanes], exponents)
    last = (slots - 1) * lanes + lane
    front = pushing(w, last, w[POSITION + last], exponents)
    if not (speed > 0.0 and largest > 0.0 and speed < math.inf):
        return BROKEN
    if rear > rear_limit * largest:
        return REAR_CUT
    if front > front_limit * largest:
        return FRONT_CUT
    return WAITING if w[ERROR + candidate] <= error_limit * speed else INACCURATE


@inlined
def opening_step(w, i, lanes, release_part, target):
    """The step that contact i allows, negative if it must be released or restored first."""
    # With one lane the branch avoids a square root; with several lanes it would rarely do so.
    if lanes == 1 and w[STIFFNESS + i] != 0.0 and w[VELOCITY + i] >= w[VELOCITY + i + lanes]:
        return math.inf
    left = time_to_opening(w, i, lanes, 4.0 * target)
    cut = w[STIFFNESS + i] == 0.0
    returned = cut & (w[POSITION + i] <= w[POSITION + i + lanes])
    ends = (left > 0.0) & (left < release_part * target)
    allowed = APPROACH * left if (left > 0.0) & (not cut) else math.inf
    return -1.0 if returned | (ends & (not cut)) else allowed


@inlined
def choose_steps(watched, lanes, release_part):
    """Choose the next step of every lane; determine whether an event may have occurred in the last.

    In most steps there is no event, and all lanes are processed with the same instructions.  For
    this purpose ``watched`` is the part of the window from the rearmost watched contact on, so that
    the slot of the candidate and the offset of the clock are compile-time constants.
    """
    for lane in range(lanes):
        candidate = WATCHED * lanes + lane
        pushed, ahead = watched[STAGE_0 + candidate], watched[STAGE_0 + candidate + lanes]
        further = watched[STAGE_0 + candidate + 2 * lanes]
        arriving = watched[VELOCITY + candidate - lanes] <= watched[VELOCITY + candidate]
        event = (
            (pushed <= 0.0) | (ahead < 0.0) | (further < 0.0) | (watched[CLOCK + LAST + lane] > 0.0)
        )
        event = event | ((watched[CLOCK + ARRIVED + lane] == 0.0) & arriving)
        target = watched[CLOCK + TARGET_STEP + lane]
        step = target
        for contact in range(WATCHED - 1):
            allowed = opening_step(watched, contact * lanes + lane, lanes, release_part, target)
            step = allowed if allowed < step else step
        free = watched[CLOCK + FREE_STEP + lane] * GRADING
        event = event | (step < 0.0) | (watched[CLOCK + STEPS + lane] >= MAX_STEPS)
        watched[CLOCK + NEXT_STEP + lane] = step if step < free else free
        watched[CLOCK + WATCH + lane] = 1.0 if event else 0.0


@compiled
def out_of_order(w, candidate, lanes, arrived):
    """Whether a velocity maximum occurs too early, at the candidate or ahead of it."""
    if not arrived and w[STAGE_0 + candidate] < 0.0:
        return True
    foot = FOOT * w[VELOCITY + candidate]
    for ahead in (candidate + lanes, candidate + 2 * lanes):
        if w[STAGE_0 + ahead] < 0.0 and w[VELOCITY + ahead] > foot:
            return True
    return False


@inlined
def record_arrival(w, clock, lane, candidate, lanes, at, step_part, results, exponents):
    """Record the largest overlap behind the candidate, and count time from there."""
    contact = candidate - lanes
    h = clock[OLD_STEP + lane]
    overlap, part = largest_overlap(w, contact, lanes, h, exponents)
    residence = clock[TIME + lane] - (1.0 - part) * h
    results[PEAK_OVERLAP, at - 1] = overlap
    results[RESIDENCE, at - 1] = residence
    clock[TIME + lane] -= residence
    clock[ARRIVAL_TIME + lane] += residence
    results[ARRIVAL, at] = clock[ARRIVAL_TIME + lane]
    clock[TARGET_STEP + lane] = step_part * residence
    clock[MAX_FORCE + lane] = pushing(w, contact, overlap, exponents)
    clock[ARRIVED + lane] = 1.0


@inlined
def record_events(scratch, lane, lanes, window, limits, given, results):
    """Record the events of the last step, and move the window if the candidate has peaked.

    Returns WAITING while the chain continues, otherwise its status code.
    """
    w, clock, place = scratch
    slots, behind, step_part, release_part = window
    exponents = given[3]
    candidate = behind * lanes + lane
    contact = candidate - lanes
    at = place[FIRST, lane] + place[BEAD, lane]
    if clock[ARRIVED + lane] == 0.0 and w[VELOCITY + contact] <= w[VELOCITY + candidate]:
        record_arrival(w, clock, lane, candidate, lanes, at, step_part, results, exponents)
    arrived = clock[ARRIVED + lane] == 1.0
    if out_of_order(w, candidate, lanes, arrived):
        return OUT_OF_ORDER

    if arrived and clock[LAST + lane] == 1.0:
        left = time_to_opening(w, contact, lanes, 4.0 * clock[TARGET_STEP + lane])
        if left < release_part * clock[TARGET_STEP + lane]:
            code = window_status(w, clock, lane, lanes, slots, candidate, limits, exponents)
            left = release(w, contact, lanes, left, exponents)
            results[PEAK_VELOCITY, at] = w[VELOCITY + candidate]
            results[PEAK_TIME, at] = clock[ARRIVAL_TIME + lane] + clock[TIME + lane] + left
            return FOLLOWED if code == WAITING else code
        clock[FREE_STEP + lane] = min(clock[FREE_STEP + lane], APPROACH * left)
    elif arrived and w[STAGE_0 + candidate] <= 0.0:
        h = clock[OLD_STEP + lane]
        velocity, part = velocity_maximum(w, candidate, lanes, h, exponents)
        results[PEAK_VELOCITY, at] = velocity
        delay = clock[TIME + lane] - (1.0 - part) * h
        results[PEAK_TIME, at] = clock[ARRIVAL_TIME + lane] + delay
        code = window_status(w, clock, lane, lanes, slots, candidate, limits, exponents)
        if code != WAITING:
            return code
        shift_window(w, clock, place, lane, lanes, slots, behind, given)
        clock[ARRIVED + lane] = 0.0
        clock[STEPS + lane] = 0.0
        early = w[VELOCITY + contact] <= w[VELOCITY + candidate]
        if early or w[STAGE_0 + candidate] <= 0.0:
            return OUT_OF_ORDER
    return WAITING


@inlined
def process_events(scratch, lane, lanes, window, limits, given, results):
    """Record the events of a lane and choose its next step; returns the status of its chain."""
    w, clock, place = scratch
    code = record_events(scratch, lane, lanes, window, limits, given, results)
    if code != WAITING:
        return code
    step = handle_openings(w, clock, place, lane, lanes, window[1], window[3], given)
    clock[NEXT_STEP + lane] = min(step, clock[FREE_STEP + lane] * GRADING)
    return STALLED if clock[STEPS + lane] >= MAX_STEPS else WAITING


@inlined
def begin_steps(w, clock, slots, lanes):
    """Set the clocks, and the step of every slot, to the chosen steps."""
    for lane in range(lanes):
        step = clock[NEXT_STEP + lane]
        clock[FREE_STEP + lane] *= GRADING
        clock[TIME + lane] += step
        clock[STEPS + lane] += 1.0
        clock[OLD_STEP + lane] = step
    for s in range(slots):
        for lane in range(lanes):
            w[STEP + s * lanes + lane] = clock[NEXT_STEP + lane]


@compiled
def next_chain(scratch, lane, lanes, window, given, waiting, chains):
    """Fill a lane with the next waiting chain, if there is one; returns the number begun."""
    if waiting == chains:
        clear_lane(scratch, lane, lanes, window, given)
        return 0
    load_chain(scratch, lane, lanes, window, given, waiting)
    clock = scratch[1]
    clock[NEXT_STEP + lane] = min(clock[TARGET_STEP + lane], clock[FREE_STEP + lane] * GRADING)
    return 1


@compiled
def follow(abreast, window, limits, given, results, status, signal, scratch):
    """Follow the pulse along many chains, ``len(abreast)`` at a time.

    Parameters
    ----------
    abreast : ALONE or ABREAST
    window : (slots; slots behind the candidate, at least WATCHED; step as a fraction of the time
        that the pulse takes per bead; time before the opening of a contact at which it is released,
        as a fraction of such a step)
    limits : (force cut off at the rear, at the front, both as fractions of the largest force;
        estimated error of a step as a fraction of the velocity), above which the chain is rejected
    given : (chains, first, beads, exponents): (3, M) inverse masses, stiffness and exponents of all
        beads of all chains, where the contact after the last bead of a chain has stiffness 0;
        index among the M beads at which each of the C chains begins; its number of beads; `None`
        if all exponents are 3/2, otherwise any other value
    results : (COLUMNS, M) first maximum of each bead's velocity and its time, arrival time,
        largest overlap with the next bead, and residence time; the striker's velocity and times
        are not changed
    status : (C,) status code of each chain
    signal : (2,) set entry STOP to end early; entry PASSED counts beads
    scratch : result of `scratch_of`

    Returns
    -------
    int
        Steps of the window taken.
    """
    lanes = len(abreast)
    w, place = scratch
    slots, behind, _, release_part = window
    exponents = given[3]
    size = slots * lanes
    candidates = behind * lanes
    watched = w[candidates - WATCHED * lanes :]
    clock = watched[CLOCK:]
    known = w, clock, place
    # NumPy integers, because numba would compile further versions of the functions for literals.
    waiting, active = np.int64(0), np.int64(0)
    for lane in range(lanes):
        begun = next_chain(known, lane, lanes, window, given, waiting, len(status))
        waiting += begun
        active += begun

    steps = 0
    while active > 0 and signal[STOP] == 0:
        accelerate(w, 0, size, STAGE_0, 0, lanes, exponents)
        note_error(w, candidates, lanes)
        choose_steps(watched, lanes, release_part)
        for lane in range(lanes):
            if clock[WATCH + lane] == 0.0 or place[CHAIN, lane] < 0:
                continue
            bead = place[BEAD, lane]
            code = process_events(known, lane, lanes, window, limits, given, results)
            signal[PASSED] += place[BEAD, lane] - bead
            if code != WAITING:
                status[place[CHAIN, lane]] = code
                begun = next_chain(known, lane, lanes, window, given, waiting, len(status))
                waiting += begun
                active += begun - 1
        begin_steps(w, clock, slots, lanes)
        keep_old(w, candidates, lanes)
        take_step(w, size, lanes, exponents)
        steps += 1
    return steps


def scratch_of(abreast: tuple[int, ...]) -> tuple[Any, Any]:
    """The window and the scalars of each lane, for `follow`."""
    # Rows are aligned to the processor's cache lines: unaligned reads take a tenth longer.
    line = 64
    w = np.zeros(END + line // 8)
    w = w[-w.ctypes.data % line // 8 :][:END]
    return w, np.zeros((PLACE_SIZE, len(abreast)), np.int64)
