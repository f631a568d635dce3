r"""Integration of a few beads around the pulse, in a window that moves with it.

A pulse extends over a few beads.  Ahead of it all beads are at rest; behind it the contacts open,
or their forces become negligible.  Therefore only a *window* of beads is integrated.  It is moved
by one bead (`hertzchain.kernels.narrow_window_slots`) each time the velocity of the *candidate*,
the bead next to reach its velocity maximum, passes this maximum::

      dropped                the window                       not yet reached
      . . . o | o  o  o  o  o  O  o  o  o | o . . .
      slot      0           p-1 p p+1    W-1
                rear            |        front
                                candidate (p = slots behind it)

The method is RKN8(6)9FM (`hertzchain.kernels.rkn8`); its steps are a fixed fraction of the time
that the pulse takes per bead.  The method would lose its order where the force grows like a power p
of time: at the impact, and at each contact that opens behind the pulse.  At the impact, the first
steps are therefore graded; at the opening of a contact, the end of the push is integrated in closed
form (`hertzchain.kernels.narrow_window_events`).  A chain that does not satisfy the assumptions of
the window is rejected with a status code.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .narrow_window_events import WATCHED, process_events, time_to_opening
from .narrow_window_rows import (
    APPROACH,
    ARRIVED,
    BEAD,
    CHAIN,
    CLOCK,
    END,
    ERROR,
    FREE_STEP,
    GRADING,
    LANES,
    LAST,
    MAX_STEPS,
    NEXT_STEP,
    OLD_POSITION,
    OLD_STAGE_0,
    OLD_STEP,
    OLD_VELOCITY,
    PLACE_SIZE,
    POSITION,
    STAGE_0,
    STEP,
    STEPS,
    STIFFNESS,
    TARGET_STEP,
    TIME,
    VELOCITY,
    WAITING,
    WATCH,
    accelerate,
    entry_point,
    inlined,
    take_step,
    velocity_error,
)
from .narrow_window_slots import next_chain
from .scratch import aligned_zeros

# Entries of `signal`, through which other threads stop the kernel and monitor its progress.
STOP, PASSED = 0, 1
# Argument of `follow` for one chain at a time and for LANES chains side by side; because the tuples
# have different types, a separate version is compiled for each.
ALONE, ABREAST = (0,), (0,) * LANES


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


@entry_point
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
        accelerate(w, 0, size, STAGE_0, lanes, exponents)
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
    return aligned_zeros(END), np.zeros((PLACE_SIZE, len(abreast)), np.int64)
