"""Slots of the narrow window: beads enter as the window moves, chains as lanes become free."""

from __future__ import annotations

import math

from .narrow_window_rows import (
    ARRIVAL_TIME,
    ARRIVED,
    BEAD,
    BEADS,
    BROKEN,
    CHAIN,
    CLOCK_SIZE,
    ERROR,
    EXPONENT,
    FIRST,
    FIRST_STEP,
    FREE_STEP,
    FRONT_CUT,
    GIVEN_EXPONENT,
    GIVEN_INVERSE_MASS,
    GIVEN_STIFFNESS,
    GRADING,
    INACCURATE,
    INVERSE_MASS,
    LANES,
    LAST,
    MAX_FORCE,
    NEXT_STEP,
    OLD_STEP,
    POSITION,
    REAR_CUT,
    STAGE_0,
    STEPS,
    STIFFNESS,
    TARGET_STEP,
    TIME,
    VELOCITY,
    WAITING,
    compiled,
    pushing,
)


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
    # Compression time of the first two beads if they were isolated; 1.4716 is exact for p = 3/2.
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
