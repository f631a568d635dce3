r"""Following the front: a few beads around the pulse, several chains side by side.

A pulse lives on a handful of beads.  Ahead of it everything is at rest; behind it
the contacts open, or grow too weak to matter.  So only a *window* of beads is
integrated, and moved along by one bead whenever the *candidate*, the bead whose
velocity is still rising, has passed its maximum::

      dropped                the window                       not yet reached
      . . . o | o  o  o  o  o  O  o  o  o | o . . .
      slot      0           p-1 p p+1    W-1
                rear            |        front
                                candidate (p = slots behind it)

Contact ``s`` of the window joins slots ``s`` and ``s + 1``; the last one presses
against a bead at rest.  All numbers of the window are in one array ``w``, a *row*
for positions, one for velocities, and so on; in a row, slot ``s`` of lane ``l``
stands at ``s * lanes + l``::

      w = [ position        | velocity | trial | ... | stage 0 | ... | stage 7 ]
            ^ slot 0: lanes 0..7, slot 1: lanes 0..7, ...

Each lane is a chain of its own, with its own step.  One array with constant
offsets, and loops without branches over a row, let the compiler work on several
chains with one instruction.

The method is RKN8(6)9FM (`hertzchain.kernels.rkn8`) with steps that are a fixed part of the
time the pulse takes per bead.  Two things would spoil its order, because there the force
grows like a power 3/2 of time: the strike, where the first steps are graded, and each contact
that opens behind the pulse, where `release` puts the exact end of the push in its place.
What the window cannot follow is noticed and reported by a status code, never patched up.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numba.misc.special import literally

from .compilation import CONTRACTED
from .hermite import curvature, hermite, slope, third, value
from .rkn8 import (
    A1,
    A2,
    A3,
    A4,
    A5,
    A6,
    A7,
    B_POSITION,
    B_VELOCITY,
    C1,
    C2,
    C3,
    C4,
    C5,
    C6,
    C7,
    E_VELOCITY,
)

LANES = 8
MAX_SLOTS = 24
# A row has room for the longest window and, not to map all rows to the same lines of the
# processor's cache, a little more.
ROW = (MAX_SLOTS + 3) * LANES
(
    POSITION, VELOCITY, TRIAL, STIFFNESS, INVERSE_MASS, FORCE, STEP, ERROR,
    OLD_POSITION, OLD_VELOCITY, OLD_STAGE_0,
    STAGE_0, STAGE_1, STAGE_2, STAGE_3, STAGE_4, STAGE_5, STAGE_6, STAGE_7, END,
) = range(0, 20 * ROW, ROW)  # fmt: skip

# What a lane knows besides its window. Its time is counted from the last arrival.
ARRIVAL_TIME, TIME, OLD_STEP, TARGET_STEP, FREE_STEP, MAX_FORCE, CLOCK_SIZE = range(7)
CHAIN, FIRST, BEAD, BEADS, ARRIVED, STEPS, PLACE_SIZE = range(7)

# What becomes of a chain.
WAITING, FOLLOWED, OUT_OF_ORDER, REAR_CUT, FRONT_CUT, INACCURATE, STALLED, BROKEN = range(8)
# Entries of `signal`, through which other threads stop the kernel and watch it.
STOP, PASSED = 0, 1
# Rows of `chains`, what is given of every bead, and of `passed`, what is found.
GIVEN_INVERSE_MASS, GIVEN_STIFFNESS = 0, 1
PEAK_VELOCITY, PEAK_TIME, ARRIVAL, PEAK_OVERLAP, RESIDENCE, COLUMNS = range(6)

# Part of the local time scale taken for the first step, and its growth from step to step.
FIRST_STEP, GRADING = 1e-3, 1.4
# Before a contact opens, steps are at most this part of the time left to it.
APPROACH = 0.5
# Contacts behind the candidate that are watched for opening.
WATCHED = 4
# A bead much slower than the candidate is the foot of the pulse, where rounding may look
# like a maximum.
FOOT = 1e-6
# Steps a bead may take to pass: ten times what any taper needs.
MAX_STEPS = 400

# With so many short functions, counting references took longer than the work, and contraction is
# 5 % of the time. The second kind is for every step.
compiled = njit(**CONTRACTED)
inlined = njit(forceinline=True, **CONTRACTED)


@inlined
def hertz(overlap, stiffness):
    """Contact force k d^1.5; none without overlap."""
    d = overlap if overlap > 0.0 else 0.0
    return stiffness * d * math.sqrt(d)


@inlined
def accelerate(w, size, lanes, positions, accelerations):
    """Forces and accelerations of all slots, Eq. (4) of the paper."""
    for i in range(size):
        overlap = w[positions + i] - w[positions + i + lanes]
        w[FORCE + lanes + i] = hertz(overlap, w[STIFFNESS + i])
    for i in range(size):
        net = w[FORCE + i] - w[FORCE + lanes + i]
        w[accelerations + i] = net * w[INVERSE_MASS + i]


@inlined
def place(w, size, c, weights):
    """Trial positions of a stage: after the part c of the step."""
    for i in range(size):
        push, stage = 0.0, STAGE_0 + i
        for weight in weights:
            push += weight * w[stage]
            stage += ROW
        h = w[STEP + i]
        w[TRIAL + i] = w[POSITION + i] + h * (c * w[VELOCITY + i] + h * push)


@inlined
def complete_step(w, size):
    """Positions and velocities at the end of the step (B is symmetric in the velocities)."""
    b0, _, b2, b3, b4, b5, b6 = B_POSITION
    v0, _, v2, v3, v4, _, _, _ = B_VELOCITY
    for i in range(size):
        h = w[STEP + i]
        push = b0 * w[STAGE_0 + i] + b2 * w[STAGE_2 + i] + b3 * w[STAGE_3 + i]
        push += b4 * w[STAGE_4 + i] + b5 * w[STAGE_5 + i] + b6 * w[STAGE_6 + i]
        change = v0 * (w[STAGE_0 + i] + w[STAGE_7 + i]) + v2 * (w[STAGE_2 + i] + w[STAGE_6 + i])
        change += v3 * (w[STAGE_3 + i] + w[STAGE_5 + i]) + v4 * w[STAGE_4 + i]
        w[POSITION + i] += h * (w[VELOCITY + i] + h * push)
        w[VELOCITY + i] += h * change


@inlined
def take_step(w, size, lanes):
    """One step of order 8 in every lane; stage 0 must hold the accelerations at its start."""
    place(w, size, C1, A1)
    accelerate(w, size, lanes, TRIAL, STAGE_1)
    place(w, size, C2, A2)
    accelerate(w, size, lanes, TRIAL, STAGE_2)
    place(w, size, C3, A3)
    accelerate(w, size, lanes, TRIAL, STAGE_3)
    place(w, size, C4, A4)
    accelerate(w, size, lanes, TRIAL, STAGE_4)
    place(w, size, C5, A5)
    accelerate(w, size, lanes, TRIAL, STAGE_5)
    place(w, size, C6, A6)
    accelerate(w, size, lanes, TRIAL, STAGE_6)
    place(w, size, C7, A7)
    accelerate(w, size, lanes, TRIAL, STAGE_7)
    complete_step(w, size)


@inlined
def keep_old(w, candidates, lanes):
    """Copy what the interpolation of events needs of the start of the step.

    Motions of the candidate, of the two slots behind it and of the one ahead;
    accelerations of the candidate and of the slot behind it.
    """
    for i in range(candidates - 2 * lanes, candidates + 2 * lanes):
        w[OLD_POSITION + i] = w[POSITION + i]
        w[OLD_VELOCITY + i] = w[VELOCITY + i]
    for i in range(candidates - lanes, candidates + lanes):
        w[OLD_STAGE_0 + i] = w[STAGE_0 + i]


@inlined
def note_error(w, candidates, lanes):
    """Largest estimated velocity error of the candidates since they became that.

    To be called with the step's stages 1..7, the old stage 0 and, in stage 0, the
    accelerations at the end of the step: the ninth stage.
    """
    e0, _, e2, e3, e4, e5, e6, e7, e8 = E_VELOCITY
    for i in range(candidates, candidates + lanes):
        error = e0 * w[OLD_STAGE_0 + i] + e2 * w[STAGE_2 + i] + e3 * w[STAGE_3 + i]
        error += e4 * w[STAGE_4 + i] + e5 * w[STAGE_5 + i] + e6 * w[STAGE_6 + i]
        error += e7 * w[STAGE_7 + i] + e8 * w[STAGE_0 + i]
        error = abs(w[STEP + i] * error)
        w[ERROR + i] = error if error > w[ERROR + i] else w[ERROR + i]


@compiled
def force_rate(w, i, lanes, positions, velocities):
    """Rate of change of the force of contact i: 1.5 k sqrt(d) d'."""
    overlap = w[positions + i] - w[positions + i + lanes]
    if overlap <= 0.0:
        return 0.0
    closing = w[velocities + i] - w[velocities + i + lanes]
    return 1.5 * w[STIFFNESS + i] * math.sqrt(overlap) * closing


@compiled
def jerk(w, i, lanes, positions, velocities):
    """Rate of change of the acceleration of slot i."""
    push = force_rate(w, i - lanes, lanes, positions, velocities)
    return (push - force_rate(w, i, lanes, positions, velocities)) * w[INVERSE_MASS + i]


@compiled
def overlap_jerk(w, i, lanes, positions, velocities):
    """Rate of change of the relative acceleration of the two slots of contact i."""
    k = i + lanes
    behind = force_rate(w, i - lanes, lanes, positions, velocities) * w[INVERSE_MASS + i]
    ahead = force_rate(w, k, lanes, positions, velocities) * w[INVERSE_MASS + k]
    between = force_rate(w, i, lanes, positions, velocities)
    return behind + ahead - between * (w[INVERSE_MASS + i] + w[INVERSE_MASS + k])


@compiled
def largest_overlap(w, i, lanes, h):
    """Overlap of contact i where its beads have equal velocities, and where in the step.

    Newton's method on the slope of the Hermite polynomial of the overlap.
    """
    k = i + lanes
    u0 = w[OLD_VELOCITY + i] - w[OLD_VELOCITY + k]
    u1 = w[VELOCITY + i] - w[VELOCITY + k]
    c = hermite(
        h,
        w[OLD_POSITION + i] - w[OLD_POSITION + k], u0, w[OLD_STAGE_0 + i] - w[OLD_STAGE_0 + k],
        overlap_jerk(w, i, lanes, OLD_POSITION, OLD_VELOCITY),
        w[POSITION + i] - w[POSITION + k], u1, w[STAGE_0 + i] - w[STAGE_0 + k],
        overlap_jerk(w, i, lanes, POSITION, VELOCITY),
    )  # fmt: skip
    s = u0 / (u0 - u1)
    for _ in range(3):
        s -= slope(c, s) / curvature(c, s)
    return value(c, s), s


@compiled
def velocity_maximum(w, i, lanes, h):
    """Largest velocity of slot i within the step, and where: zero of the acceleration."""
    a0, a1 = w[OLD_STAGE_0 + i], w[STAGE_0 + i]
    c = hermite(
        h,
        w[OLD_POSITION + i], w[OLD_VELOCITY + i], a0,
        jerk(w, i, lanes, OLD_POSITION, OLD_VELOCITY),
        w[POSITION + i], w[VELOCITY + i], a1, jerk(w, i, lanes, POSITION, VELOCITY),
    )  # fmt: skip
    s = a0 / (a0 - a1)
    for _ in range(3):
        s -= curvature(c, s) / third(c, s)
    return slope(c, s) / h, s


@compiled
def remaining_push(w, i, lanes, left):
    r"""How contact i ends: time left, remaining impulse and its first moment.

    The overlap is continued as a cubic in time, from its derivatives now, to its zero
    :math:`\sigma`.  Written in the time :math:`u = 1 - t/\sigma` left, it is
    :math:`D u (1 + e_1 u + e_2 u^2)`, and with the expansion

    .. math:: (1 + e_1 u + e_2 u^2)^{3/2} \approx 1 + q_1 u + q_2 u^2 + q_3 u^3

    the integrals of the force :math:`k d^{3/2}` are sums of powers.
    """
    k = i + lanes
    d0, d1 = w[POSITION + i] - w[POSITION + k], w[VELOCITY + i] - w[VELOCITY + k]
    d2 = w[STAGE_0 + i] - w[STAGE_0 + k]
    d3 = overlap_jerk(w, i, lanes, POSITION, VELOCITY)
    for _ in range(3):
        gap = d0 + left * (d1 + left * (d2 / 2.0 + left * d3 / 6.0))
        left -= gap / (d1 + left * (d2 + left * d3 / 2.0))
    opening = -(d1 + left * (d2 + left * d3 / 2.0))
    e1 = (d2 + left * d3) / (2.0 * opening) * left
    e2 = -d3 / (6.0 * opening) * left * left
    q1 = 1.5 * e1
    q2 = 1.5 * e2 + 0.375 * e1 * e1
    q3 = 0.75 * e1 * e2 - 0.0625 * e1 * e1 * e1
    scale = hertz(opening * left, w[STIFFNESS + i]) * left
    impulse = scale * (2 / 5 + q1 * 2 / 7 + q2 * 2 / 9 + q3 * 2 / 11)
    moment = scale * left * (2 / 7 + q1 * 2 / 9 + q2 * 2 / 11 + q3 * 2 / 13)
    return left, impulse, moment


@compiled
def release(w, i, lanes, left):
    """Give the bead ahead of contact i the rest of its push at once, and cut the contact.

    The bead's position is set back by what it would not yet have moved, so that position
    and velocity are right once the contact would have opened.  Returns the time left.
    """
    left, impulse, moment = remaining_push(w, i, lanes, left)
    ahead = i + lanes
    overlap = w[POSITION + i] - w[POSITION + ahead]
    w[STAGE_0 + ahead] -= hertz(overlap, w[STIFFNESS + i]) * w[INVERSE_MASS + ahead]
    w[VELOCITY + ahead] += impulse * w[INVERSE_MASS + ahead]
    w[POSITION + ahead] -= (impulse * left - moment) * w[INVERSE_MASS + ahead]
    w[STIFFNESS + i] = 0.0
    return left


@inlined
def time_to_opening(w, i, lanes, horizon):
    """Time after which contact i opens, by a parabola; ``inf`` if not within the horizon."""
    k = i + lanes
    d0, d1 = w[POSITION + i] - w[POSITION + k], w[VELOCITY + i] - w[VELOCITY + k]
    if d1 >= 0.0 or d0 > -d1 * horizon:
        return math.inf
    d2 = w[STAGE_0 + i] - w[STAGE_0 + k]
    square = d1 * d1 - 2.0 * d0 * d2
    return 2.0 * d0 / (math.sqrt(square) - d1) if square > 0.0 else math.inf


@inlined
def handle_openings(w, clock, place, lane, lanes, behind, release_part, chains):
    """Release contacts that are opening, and put back those that have; returns the next step."""
    target = clock[TARGET_STEP, lane]
    step = target
    for back in range(2, WATCHED + 1):
        i = (behind - back) * lanes + lane
        if i < 0:
            break
        left = time_to_opening(w, i, lanes, 4.0 * target)
        if w[STIFFNESS + i] == 0.0:
            if w[POSITION + i] <= w[POSITION + i + lanes]:
                bead = place[BEAD, lane] - back
                w[STIFFNESS + i] = chains[GIVEN_STIFFNESS, place[FIRST, lane] + bead]
        elif 0.0 < left < release_part * target:
            release(w, i, lanes, left)
        elif left > 0.0:
            step = min(step, APPROACH * left)
    return step


@compiled
def load_slot(w, i, chains, place, lane, bead):
    """Put a bead at rest into a slot; beyond the ends of the chain, nothing at all."""
    inside = 0 <= bead < place[BEADS, lane]
    at = place[FIRST, lane] + bead
    w[STIFFNESS + i] = chains[GIVEN_STIFFNESS, at] if inside else 0.0
    w[INVERSE_MASS + i] = chains[GIVEN_INVERSE_MASS, at] if inside else 0.0
    w[POSITION + i] = 0.0
    w[VELOCITY + i] = 0.0
    w[STAGE_0 + i] = 0.0
    w[ERROR + i] = 0.0


@compiled
def load_chain(scratch, lane, lanes, window, given, chain):
    """Begin a chain in a lane: bead 1 struck, bead 2 the candidate."""
    w, clock, place = scratch
    slots, behind, step_part, _ = window
    chains, first, beads = given
    place[CHAIN, lane] = chain
    place[FIRST, lane] = first[chain]
    place[BEADS, lane] = beads[chain]
    place[BEAD, lane] = 1
    place[ARRIVED, lane] = 0
    place[STEPS, lane] = 0
    for s in range(slots):
        load_slot(w, s * lanes + lane, chains, place, lane, s - behind + 1)
    striker = (behind - 1) * lanes + lane
    w[VELOCITY + striker] = 1.0
    # Compression time of the first two beads, as if they were alone.
    reduced = 1.0 / (w[INVERSE_MASS + striker] + w[INVERSE_MASS + striker + lanes])
    time_scale = 1.609 * (reduced / w[STIFFNESS + striker]) ** 0.4
    clock[ARRIVAL_TIME, lane] = 0.0
    clock[TIME, lane] = 0.0
    clock[OLD_STEP, lane] = 0.0
    clock[TARGET_STEP, lane] = step_part * time_scale
    clock[FREE_STEP, lane] = FIRST_STEP * time_scale
    clock[MAX_FORCE, lane] = 0.0


@compiled
def clear_lane(scratch, lane, lanes, window, given):
    """Leave a lane with nothing in it."""
    w, clock, place = scratch
    place[CHAIN, lane] = -1
    place[BEADS, lane] = 0
    for s in range(window[0]):
        load_slot(w, s * lanes + lane, given[0], place, lane, s)
    clock[TARGET_STEP, lane] = 1.0
    clock[FREE_STEP, lane] = 1.0


@compiled
def shift_window(w, place, lane, lanes, slots, behind, chains):
    """Move the window by one bead: each slot takes over from the next, the last is loaded."""
    last = (slots - 1) * lanes + lane
    for i in range(lane, last, lanes):
        w[POSITION + i] = w[POSITION + i + lanes]
        w[VELOCITY + i] = w[VELOCITY + i + lanes]
        w[STIFFNESS + i] = w[STIFFNESS + i + lanes]
        w[INVERSE_MASS + i] = w[INVERSE_MASS + i + lanes]
        w[STAGE_0 + i] = w[STAGE_0 + i + lanes]
    w[ERROR + behind * lanes + lane] = 0.0
    place[BEAD, lane] += 1
    load_slot(w, last, chains, place, lane, place[BEAD, lane] + slots - behind - 1)
    push = hertz(w[POSITION + last - lanes], w[STIFFNESS + last - lanes])
    w[STAGE_0 + last] = push * w[INVERSE_MASS + last]


@compiled
def window_status(w, clock, lane, lanes, slots, candidate, limits):
    """Whether the window still holds what matters, looked at before it is moved."""
    rear_limit, front_limit, error_limit = limits
    speed = w[VELOCITY + candidate]
    largest = clock[MAX_FORCE, lane]
    rear = hertz(w[POSITION + lane] - w[POSITION + lane + lanes], w[STIFFNESS + lane])
    last = (slots - 1) * lanes + lane
    front = hertz(w[POSITION + last], w[STIFFNESS + last])
    if not (speed > 0.0 and largest > 0.0 and speed < math.inf):
        return BROKEN
    if rear > rear_limit * largest:
        return REAR_CUT
    if front > front_limit * largest:
        return FRONT_CUT
    return WAITING if w[ERROR + candidate] <= error_limit * speed else INACCURATE


@inlined
def may_have_events(w, place, lane, lanes, behind):
    """Whether there may be anything to record after a step; most often there is not."""
    candidate = behind * lanes + lane
    last_bead = place[BEAD, lane] == place[BEADS, lane] - 1
    if last_bead or w[STAGE_0 + candidate] <= 0.0:
        return True
    if place[ARRIVED, lane] == 0 and w[VELOCITY + candidate - lanes] <= w[VELOCITY + candidate]:
        return True
    return w[STAGE_0 + candidate + lanes] < 0.0 or w[STAGE_0 + candidate + 2 * lanes] < 0.0


@compiled
def out_of_order(w, candidate, lanes, arrived):
    """Whether a velocity maximum comes before its turn, at the candidate or ahead of it."""
    if not arrived and w[STAGE_0 + candidate] < 0.0:
        return True
    foot = FOOT * w[VELOCITY + candidate]
    for ahead in (candidate + lanes, candidate + 2 * lanes):
        if w[STAGE_0 + ahead] < 0.0 and w[VELOCITY + ahead] > foot:
            return True
    return False


@compiled
def record_events(scratch, lane, lanes, window, limits, chains, passed):
    """Record what happened in the last step, and move the window if the candidate has peaked.

    Returns WAITING while the chain goes on, otherwise what became of it.
    """
    w, clock, place = scratch
    slots, behind, step_part, release_part = window
    candidate = behind * lanes + lane
    contact = candidate - lanes
    at = place[FIRST, lane] + place[BEAD, lane]
    last_bead = place[BEAD, lane] == place[BEADS, lane] - 1
    h = clock[OLD_STEP, lane]

    if place[ARRIVED, lane] == 0 and w[VELOCITY + contact] <= w[VELOCITY + candidate]:
        overlap, part = largest_overlap(w, contact, lanes, h)
        residence = clock[TIME, lane] - (1.0 - part) * h
        passed[PEAK_OVERLAP, at - 1] = overlap
        passed[RESIDENCE, at - 1] = residence
        clock[TIME, lane] -= residence
        clock[ARRIVAL_TIME, lane] += residence
        passed[ARRIVAL, at] = clock[ARRIVAL_TIME, lane]
        clock[TARGET_STEP, lane] = step_part * residence
        clock[MAX_FORCE, lane] = hertz(overlap, w[STIFFNESS + contact])
        place[ARRIVED, lane] = 1
    arrived = place[ARRIVED, lane] == 1
    if out_of_order(w, candidate, lanes, arrived):
        return OUT_OF_ORDER

    if arrived and last_bead:
        left = time_to_opening(w, contact, lanes, 4.0 * clock[TARGET_STEP, lane])
        if left < release_part * clock[TARGET_STEP, lane]:
            code = window_status(w, clock, lane, lanes, slots, candidate, limits)
            left = release(w, contact, lanes, left)
            passed[PEAK_VELOCITY, at] = w[VELOCITY + candidate]
            passed[PEAK_TIME, at] = clock[ARRIVAL_TIME, lane] + clock[TIME, lane] + left
            return FOLLOWED if code == WAITING else code
        clock[FREE_STEP, lane] = min(clock[FREE_STEP, lane], APPROACH * left)
    elif arrived and w[STAGE_0 + candidate] <= 0.0:
        velocity, part = velocity_maximum(w, candidate, lanes, h)
        passed[PEAK_VELOCITY, at] = velocity
        delay = clock[TIME, lane] - (1.0 - part) * h
        passed[PEAK_TIME, at] = clock[ARRIVAL_TIME, lane] + delay
        code = window_status(w, clock, lane, lanes, slots, candidate, limits)
        if code != WAITING:
            return code
        shift_window(w, place, lane, lanes, slots, behind, chains)
        place[ARRIVED, lane] = 0
        place[STEPS, lane] = 0
        early = w[VELOCITY + contact] <= w[VELOCITY + candidate]
        if early or w[STAGE_0 + candidate] <= 0.0:
            return OUT_OF_ORDER
    return WAITING


@inlined
def choose_step(scratch, lane, lanes, window, chains):
    """Step of a lane: its part of the local time scale, less after the strike and at openings."""
    w, clock, place = scratch
    slots, behind, _, release_part = window
    step = handle_openings(w, clock, place, lane, lanes, behind, release_part, chains)
    place[STEPS, lane] += 1
    if place[STEPS, lane] > MAX_STEPS:
        return STALLED
    clock[FREE_STEP, lane] *= GRADING
    step = min(step, clock[FREE_STEP, lane])
    clock[TIME, lane] += step
    if step != clock[OLD_STEP, lane]:
        clock[OLD_STEP, lane] = step
        for s in range(slots):
            w[STEP + s * lanes + lane] = step
    return WAITING


@compiled
def follow(lanes, window, limits, given, passed, status, signal, scratch):
    """Follow the pulse along many chains, ``lanes`` at a time.

    Parameters
    ----------
    lanes : 1 or LANES; a compiled version of its own for each
    window : (slots, slots behind the candidate, step in parts of the time the pulse takes per
        bead, time before the opening of a contact at which it is released in parts of such a
        step)
    limits : (force cut off at the rear, at the front, both in parts of the largest force;
        estimated error of a step in parts of the velocity), above which the chain is given up
    given : (chains, first, beads): (2, M) inverse masses and stiffness of all beads of all
        chains, where the contact after the last bead of a chain has stiffness 0; where each of
        the C chains begins among the M beads; how many it has
    passed : (COLUMNS, M) first maximum of each bead's velocity and its time, arrival time,
        largest overlap with the next bead, and residence time; the striker's velocity and times
        are left alone
    status : (C,) what became of each chain
    signal : (2,) set entry STOP to end early; entry PASSED counts beads
    scratch : what `scratch_of` gives

    Returns
    -------
    int
        Steps of the window taken.
    """
    lanes = literally(lanes)
    w, _, place = scratch
    slots, behind, _, _ = window
    chains = given[0]
    size = slots * lanes
    candidates = behind * lanes
    waiting, active = 0, 0
    for lane in range(lanes):
        clear_lane(scratch, lane, lanes, window, given)
        if waiting < len(status):
            load_chain(scratch, lane, lanes, window, given, waiting)
            waiting += 1
            active += 1

    steps = 0
    while active > 0 and signal[STOP] == 0:
        accelerate(w, size, lanes, POSITION, STAGE_0)
        note_error(w, candidates, lanes)
        for lane in range(lanes):
            if place[CHAIN, lane] < 0:
                continue
            code = WAITING
            if may_have_events(w, place, lane, lanes, behind):
                bead = place[BEAD, lane]
                code = record_events(scratch, lane, lanes, window, limits, chains, passed)
                signal[PASSED] += place[BEAD, lane] - bead
            if code == WAITING:
                code = choose_step(scratch, lane, lanes, window, chains)
            if code == WAITING:
                continue
            status[place[CHAIN, lane]] = code
            if waiting < len(status):
                load_chain(scratch, lane, lanes, window, given, waiting)
                choose_step(scratch, lane, lanes, window, chains)
                waiting += 1
            else:
                clear_lane(scratch, lane, lanes, window, given)
                active -= 1
        keep_old(w, candidates, lanes)
        take_step(w, size, lanes)
        steps += 1
    return steps


def scratch_of(lanes: int) -> tuple[Any, Any, Any]:
    """The window and what each lane knows, for `follow_one` (1) or `follow_many` (LANES)."""
    # Rows begin with a line of the processor's cache: reads across two lines cost a tenth.
    line = 64
    w = np.zeros(END + line // 8)
    w = w[-w.ctypes.data % line // 8 :][:END]
    return w, np.zeros((CLOCK_SIZE, lanes)), np.zeros((PLACE_SIZE, lanes), np.int64)


@compiled
def follow_one(window, limits, given, passed, status, signal, scratch):
    """`follow` one chain after the other, as is quickest for a single one."""
    return follow(1, window, limits, given, passed, status, signal, scratch)


@compiled
def follow_many(window, limits, given, passed, status, signal, scratch):
    """`follow` LANES chains side by side."""
    return follow(LANES, window, limits, given, passed, status, signal, scratch)
