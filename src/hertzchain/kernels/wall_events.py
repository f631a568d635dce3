"""Events at the walls: largest forces, ends of first contacts, and touches."""

from __future__ import annotations

from .compilation import compiled
from .contact_law import force, law_of
from .dop853 import STEP_STAGES
from .driving import wall_motion
from .forces import ACCUMULATORS, LEFT_IMPULSE, overlap_and_closing
from .interpolant import attainable, attainable_slope, slope, state_within, value
from .limits import MIN_PUSH
from .state_layout import (
    CROSSING_TIME,
    FIRST_END,
    FIRST_IMPULSE,
    LAST_END,
    LAST_IMPULSE,
    TOUCHES,
    TOUCHING,
    TURNED_BACK,
    WALL_PEAK,
    WALL_PEAK_TIME,
)
from .stepping import first_row, forces_within, on_positions

# Golden sections of a step, and their ratio.
SECTIONS, GOLDEN = 40, 0.6180339887498949
# Relative error of the slope of an interpolated impulse at the largest tolerance.
SLOPE = 1e-5


@compiled
def push_on_wall(side, theta, time, h, y, dense, setup, contacts, segment):
    """Force on a wall at the fraction theta of the step."""
    beads = len(setup.inverse_mass)
    if not on_positions(contacts):
        return slope(len(y) - ACCUMULATORS + LEFT_IMPULSE + side, theta, h, dense)
    c = side * beads
    if side == 0:
        wall = wall_motion(time + theta * h, setup, segment)[0]
        overlap = wall - value(0, theta, y, dense) - setup.gap[0]
    else:
        overlap = value(beads - 1, theta, y, dense) - setup.gap[beads]
    return force(overlap, setup.stiffness[c], law_of(c, setup).exponent)


@compiled
def change_of_push(side, time, h, y, push, setup, segment):
    """Change in a time h of the force of an elastic contact with a wall, from its rate."""
    beads = len(setup.inverse_mass)
    if push == 0.0:
        return 0.0
    c = side * beads
    wall = wall_motion(time, setup, segment)
    overlap, closing = overlap_and_closing(c, y, beads, setup.gap[c], wall)
    return law_of(c, setup).exponent * push / overlap * (h * closing)


@compiled
def largest_at_stages(i, stages, row):
    """Largest rate of component i at the stages of a step."""
    largest = stages[0, i]
    for j in range(row, STEP_STAGES + 1):
        largest = max(largest, stages[j, i])
    return largest


@compiled
def side_may_peak(side, time, h, y, y_new, stages, setup, contacts, segment, walls):
    """Whether the force on one wall may exceed its largest value so far within the step."""
    i, peak = len(y) - ACCUMULATORS + LEFT_IMPULSE + side, walls[WALL_PEAK, side]
    largest = largest_at_stages(i, stages, first_row(contacts))
    if largest > peak:
        return True
    if not on_positions(contacts):
        # The maximum may lie between the stages.
        return largest > 0.0
    first, last = stages[0, i], stages[STEP_STAGES, i]
    rise = change_of_push(side, time, h, y, first, setup, segment)
    fall = change_of_push(side, time + h, h, y_new, last, setup, segment)
    return attainable(first, rise, last, fall) > peak


@compiled
def wall_may_peak(time, h, y, y_new, stages, setup, contacts, segment, walls):
    """Whether the force on a wall may exceed its largest value so far within the step."""
    for side in range(2):
        if side_may_peak(side, time, h, y, y_new, stages, setup, contacts, segment, walls):
            return True
    return False


@compiled
def largest_push(side, time, h, y, dense, setup, contacts, segment):
    """Largest force on a wall and its fraction of the step, if there is only one maximum."""
    low, high, one, two = 0.0, 1.0, 1.0 - GOLDEN, GOLDEN
    before = push_on_wall(side, one, time, h, y, dense, setup, contacts, segment)
    after = push_on_wall(side, two, time, h, y, dense, setup, contacts, segment)
    for _ in range(SECTIONS):
        rises = before < after
        if rises:
            low, one, before = one, two, after
            place = two = low + GOLDEN * (high - low)
        else:
            high, two, after = two, one, before
            place = one = high - GOLDEN * (high - low)
        found = push_on_wall(side, place, time, h, y, dense, setup, contacts, segment)
        before, after = (before, found) if rises else (found, after)
    theta = 0.5 * (low + high)
    top = push_on_wall(side, theta, time, h, y, dense, setup, contacts, segment)
    return top, theta


@compiled
def record_walls(
    time, h, y, y_new, setup, contacts, segment, stages, dense, walls, trial, scratch
):  # fmt: skip
    """Record the largest force on each wall within the step, if it exceeds all earlier ones."""
    offset, row = len(y) - ACCUMULATORS + LEFT_IMPULSE, first_row(contacts)
    for side in range(2):
        i, peak = offset + side, walls[WALL_PEAK, side]
        if not side_may_peak(side, time, h, y, y_new, stages, setup, contacts, segment, walls):
            continue
        largest = largest_at_stages(i, stages, row)
        # In a very short step the slope of the impulse is dominated by rounding errors, and the
        # largest value at a stage is used.
        sharp = on_positions(contacts) or 1e-15 * abs(y_new[i]) < 1e-12 * h * largest
        if not sharp:
            top, theta = largest, 1.0
        elif on_positions(contacts):
            top, theta = largest_push(side, time, h, y, dense, setup, contacts, segment)
        elif largest > peak or (1.0 + SLOPE) * attainable_slope(i, h, dense) > peak:
            _, theta = largest_push(side, time, h, y, dense, setup, contacts, segment)
            # The interpolated positions are more accurate than the slope of the impulse.
            state_within(theta, y, dense, trial)
            forces_within(theta, time, h, trial, setup, contacts, segment, scratch)
            top = contacts.force[side * len(setup.inverse_mass)]
        else:
            continue
        if top > peak:
            walls[WALL_PEAK, side], walls[WALL_PEAK_TIME, side] = top, time + theta * h


@compiled
def record_wall_ends(time, y, rates, setup, segment, momentum, crossings, walls):
    """Record the impulse of the first contact with each wall, between two steps, once it has ended.

    If a bead comes close to a wall without touching it, rounding at the stages of a step may cause
    a small impulse, which is ignored.  ``momentum`` is the largest sum of the beads' absolute
    momenta so far.  For the right wall, also record the time at which the last bead first moves
    back after the crest has reached it.
    """
    beads = len(setup.inverse_mass)
    back = setup.stiffness[beads] > 0.0 and y[2 * beads - 1] < 0.0
    if back and walls[TURNED_BACK, 1] == 0.0 and crossings[CROSSING_TIME, -1] != 0.0:
        walls[TURNED_BACK, 1] = time
    for side in range(2):
        i, c = 2 * beads + LEFT_IMPULSE + side, side * beads
        pushed = abs(y[i]) > MIN_PUSH * momentum and rates[i] == 0.0 and setup.stiffness[c] > 0.0
        if not pushed or walls[FIRST_END, side] != 0.0:
            continue
        wall = wall_motion(time, setup, segment)
        _, closing = overlap_and_closing(c, y, beads, setup.gap[c], wall)
        if closing < 0.0:
            walls[FIRST_IMPULSE, side] = y[i]
            walls[FIRST_END, side] = time


@compiled
def count_touches(time, y, rates, walls):
    """Count contacts with each wall that a step has begun, and record the end of the last one."""
    for side in range(2):
        i = len(y) - ACCUMULATORS + LEFT_IMPULSE + side
        pressed = 1.0 if rates[i] != 0.0 else 0.0
        if pressed > walls[TOUCHING, side]:
            walls[TOUCHES, side] += 1.0
        elif pressed < walls[TOUCHING, side]:
            walls[LAST_END, side], walls[LAST_IMPULSE, side] = time, y[i]
        walls[TOUCHING, side] = pressed
