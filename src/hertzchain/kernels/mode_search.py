r"""Search for the first contact that must leave its mode within a step.

A contact may leave its mode and return to it before the end of the step.  The ends and stages of
the step determine which contacts are searched.  On the interpolant of the step, the first zero or
the minimum of the margin (`hertzchain.kernels.contact_margins`) of each such contact is located.
"""

from __future__ import annotations

import numpy as np

from .change_of_sign import BISECTIONS, PARTS
from .compilation import compiled
from .contact_law import LOADED, RELEASED, STUCK, force, has_modes, is_plastic, law_of
from .contact_margins import leaves_mode, margin_of, must_switch, pull_free_force, vanishes_between
from .dop853 import STEP_STAGES
from .driving import wall_motion
from .forces import LEFT_IMPULSE, PUSHED, derivative, overlap_and_closing
from .interpolant import state_within, value
from .law_kinds import DAMPED, UNLOADING
from .stepping import interpolate

# A stuck contact is searched if its force is closer than NEAR to a bound at a stage.  The stages
# are checked only if it is closer than NEAR_AT_END at an end of the step.  Both are fractions of
# the distance between the bounds.
NEAR, NEAR_AT_END = 0.05, 0.1
# The stages that are checked, in the order of their times: both ends, and those of the highest
# order, from a quarter of the step on.
LATE_STAGES = (0, 7, 9, 8, 10, STEP_STAGES)
# A damped force larger than this fraction of the elastic force will not soon be cut off.
WEAK = 0.5
# Fraction of a step over which the slope of a force is estimated.
SHORT = 1e-3
# Number of times that the interval around a minimum is reduced to two thirds.  The minimum is
# located only if a parabola predicts that it is below NEAR_AT_LEAST times the least margin found.
SECTIONS, NEAR_AT_LEAST = 20, 0.5


@compiled
def turned(c, beads, wall_speed, sign, stages, still):
    """Whether contact c is opening (sign 1) or closing (-1) at some stage of the step."""
    for j in range(1, STEP_STAGES):
        left = stages[j, c - 1] if c > 0 else wall_speed
        right = stages[j, c] if c < beads else 0.0
        if sign * (left - right) < -still:
            return True
    return False


@compiled
def relative_acceleration(c, beads, wall, rates):
    """Rate of change of the closing speed of contact c, from the derivative of the state."""
    left = rates[beads + c - 1] if c > 0 else wall[2]
    return left - rates[beads + c] if c < beads else left


@compiled
def may_turn_twice(sign, h, closing, still_closing, slope, last_slope):
    """Whether a contact, closing (sign 1) or opening (-1) at both ends, may rest in between."""
    return vanishes_between(
        sign * closing, sign * h * slope, sign * still_closing, sign * h * last_slope
    )


@compiled
def may_be_cut_off(h, mode, before, after, slope, last_slope, stiffness, damping, law):
    """Whether the force of a damped contact, cut off at neither or both ends, may change within.

    ``before`` and ``after`` are overlap and closing speed at the ends; the slopes are those of the
    closing speed.
    """
    overlap, closing = before
    last, still_closing = after
    if mode != LOADED and overlap <= 0.0 < last:
        # The contact has closed and pushed, although its force is cut off again at the end.
        return True
    if min(overlap, last) <= 0.0 or min(closing, still_closing) >= 0.0:
        return False
    sign = 1.0 if mode == LOADED else -1.0
    # If the beads separate, their damping must first grow and then shrink.
    if sign * last_slope <= 0.0 and sign * still_closing <= 0.0:
        return False
    first = sign * pull_free_force(overlap, closing, stiffness, damping, law)
    end = sign * pull_free_force(last, still_closing, stiffness, damping, law)
    if not law.attractive and first > WEAK * force(overlap, stiffness, law.exponent):
        if end > WEAK * force(last, stiffness, law.exponent):
            return False
    short = SHORT * h
    soon = sign * pull_free_force(
        overlap + short * (closing + 0.5 * short * slope), closing + short * slope, stiffness,
        damping, law,
    )  # fmt: skip
    late = sign * pull_free_force(
        last - short * (still_closing - 0.5 * short * last_slope),
        still_closing - short * last_slope, stiffness, damping, law,
    )  # fmt: skip
    return vanishes_between(first, (soon - first) / SHORT, end, (end - late) / SHORT)


@compiled
def may_release(c, loading, stages, setup, contacts):
    """Whether the force of stuck contact c may exceed one of its bounds and return within a step.

    The force is then near the bound at a stage and, because the bounds are constant, both rises and
    falls.  At the stages, it is computed from the force on the left wall and the accelerations.
    """
    kept, beads = law_of(c, setup).kept, len(setup.inverse_mass)
    least, apart = kept * loading, (1.0 - kept) * loading
    inner, outer = NEAR_AT_END * apart, NEAR * apart
    nearest = min(contacts.force[c], contacts.last_force[c]) - least
    if min(nearest, loading - max(contacts.force[c], contacts.last_force[c])) > inner:
        return False
    near, rises, falls, before = False, False, False, 0.0
    for j in LATE_STAGES:
        held = stages[j, 2 * beads + LEFT_IMPULSE] + stages[j, 2 * beads + PUSHED]
        held -= stages[j, 2 * beads + PUSHED] if c == 0 else 0.0
        for k in range(c):
            held += setup.body_force[k] - stages[j, beads + k] / setup.inverse_mass[k]
        near = near or not least + outer < held < loading - outer
        rises = rises or (j > 0 and held > before)
        falls = falls or (j > 0 and held < before)
        before = held
    return near and rises and falls


@compiled
def may_switch(c, h, y, y_new, stages, setup, contacts, walls, still):
    """Whether, according to the stages of a step, contact c may have to leave its mode within it.

    ``walls`` is the motion of the left wall at both ends of the step.
    """
    if setup.law.implicit:
        return leaves_mode(c, 1.0, y_new, walls[1], setup, contacts, still)
    law, mode, beads = law_of(c, setup), contacts.mode[c], len(setup.inverse_mass)
    gap, stiffness, damping = setup.gap[c], setup.stiffness[c], setup.damping[c]
    before = overlap_and_closing(c, y, beads, gap, walls[0])
    after = overlap_and_closing(c, y_new, beads, gap, walls[1])
    remembers = law.kind == UNLOADING or is_plastic(law)
    if remembers and mode != STUCK and before[0] <= 0.0 and after[0] <= 0.0:
        # Open at both ends: without a force, the mode has no effect.
        return False
    if must_switch(
        after[0], after[1], stiffness, damping, mode, contacts.largest[c], contacts.force[c], law,
        still,
    ):  # fmt: skip
        return True
    if mode == STUCK:
        loading = force(after[0], stiffness, law.exponent)
        return may_release(c, loading, stages, setup, contacts)
    if is_plastic(law) and mode == RELEASED:
        # The overlap may exceed its largest value so far and decrease again.
        return before[1] > still and turned(c, beads, walls[1][1], 1.0, stages, still)
    slope = relative_acceleration(c, beads, walls[0], stages[0])
    last_slope = relative_acceleration(c, beads, walls[1], stages[STEP_STAGES])
    if law.kind == DAMPED:
        return may_be_cut_off(h, mode, before, after, slope, last_slope, stiffness, damping, law)
    sign = 1.0 if mode == LOADED else -1.0
    return turned(c, beads, walls[1][1], sign, stages, still) or may_turn_twice(
        sign, h, before[1], after[1], slope, last_slope
    )


@compiled
def closing_until(c, time, y, h, dense, setup, segment, still):
    """Fraction of the step until which contact c, closing at its start, closes."""
    beads, low, high = len(setup.inverse_mass), 0.0, 2.0
    for part in range(1, PARTS + BISECTIONS + 1):
        if high > 1.0 and part > PARTS:
            return 1.0
        theta = part / PARTS if high > 1.0 else 0.5 * (low + high)
        left = wall_motion(time + theta * h, setup, segment)[1]
        if c > 0:
            left = value(beads + c - 1, theta, y, dense)
        right = value(beads + c, theta, y, dense) if c < beads else 0.0
        if left - right > still:
            low = theta
        else:
            high = theta
    return low


@compiled
def state_of_contact(c, theta, time, y, h, dense, setup, contacts, segment, trial, scratch):
    """Interpolate the state of the beads of contact c; returns the motion of the left wall.

    The force of a stuck contact depends on all beads, that of any other contact on two.
    """
    beads = len(setup.inverse_mass)
    if contacts.mode[c] == STUCK:
        state_within(theta, y, dense, trial)
        derivative(time + theta * h, trial, setup, contacts, segment, scratch)
    for k in range(max(c - 1, 0), min(c + 1, beads)):
        trial[k] = value(k, theta, y, dense)
        trial[beads + k] = value(beads + k, theta, y, dense)
    return wall_motion(time + theta * h, setup, segment)


@compiled
def examine(c, theta, time, y, h, dense, setup, contacts, segment, still, trial, scratch):
    """Whether contact c must leave its mode at the fraction theta of the step, and its margin."""
    wall = state_of_contact(c, theta, time, y, h, dense, setup, contacts, segment, trial, scratch)
    leaves = leaves_mode(c, theta, trial, wall, setup, contacts, still)
    return leaves, margin_of(c, trial, wall, setup, contacts)


@compiled
def dips(left, least, right):
    """Whether a parabola through the least margin and its neighbours is much closer to zero."""
    bend = left - 2.0 * least + right
    return 0.125 * (right - left) ** 2 > (1.0 - NEAR_AT_LEAST) * least * bend


@compiled
def least_margin(c, low, high, time, y, h, dense, setup, contacts, segment, still, trial, scratch):
    """Fraction of the step, between two others, at which the margin of contact c is least."""
    for _ in range(SECTIONS):
        one, two = (2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0
        at_one = examine(
            c, one, time, y, h, dense, setup, contacts, segment, still, trial, scratch
        )[1]
        at_two = examine(
            c, two, time, y, h, dense, setup, contacts, segment, still, trial, scratch
        )[1]
        low, high = (low, two) if at_one < at_two else (one, high)
    return 0.5 * (low + high)


@compiled
def switch_within(c, time, y, h, dense, setup, contacts, segment, still, trial, scratch):
    """Fraction of the step at which contact c first must leave its mode; 2 if none."""
    low, high, end = 0.0, 2.0, 1.0
    if is_plastic(law_of(c, setup)) and contacts.mode[c] == RELEASED:
        end = closing_until(c, time, y, h, dense, setup, segment, still)
    nearest, least, left, right, before = 0, np.inf, np.inf, np.inf, np.inf
    for part in range(PARTS + 1):
        leaves, margin = examine(
            c, end * part / PARTS, time, y, h, dense, setup, contacts, segment, still, trial,
            scratch,
        )  # fmt: skip
        if leaves and part > 0:
            low, high = end * (part - 1) / PARTS, end * part / PARTS
            break
        if margin < least:
            nearest, least, left, right = part, margin, before, np.inf
        elif part == nearest + 1:
            right = margin
        before = margin
    inside = 0 < nearest < PARTS and dips(left, least, right)
    if nearest == PARTS and high > 1.0:
        inside = least > examine(
            c, end * (1.0 - SHORT), time, y, h, dense, setup, contacts, segment, still, trial,
            scratch,
        )[1]  # fmt: skip
    if high > 1.0 and not setup.law.implicit and inside:
        low = end * (nearest - 1) / PARTS
        theta = least_margin(
            c, low, end * min(nearest + 1, PARTS) / PARTS, time, y, h, dense, setup, contacts,
            segment, still, trial, scratch,
        )  # fmt: skip
        low = min(low, theta)
        if examine(c, theta, time, y, h, dense, setup, contacts, segment, still, trial, scratch)[0]:
            high = theta
    if high > 1.0:
        return 2.0
    for _ in range(BISECTIONS):
        theta = 0.5 * (low + high)
        if examine(c, theta, time, y, h, dense, setup, contacts, segment, still, trial, scratch)[0]:
            high = theta
        else:
            low = theta
    return high


@compiled
def first_switch(
    time, y, h, y_new, stages, dense, setup, contacts, segment, still, trial, scratch, on_positions
):
    """Find the first contact that must leave its mode within the step, and when; -1 if none.

    Also returns whether the stages are complete and the coefficients in ``dense`` are computed.
    Contacts have no modes if ``on_positions`` is not `None`: numba then omits the search.
    """
    if on_positions is not None or not has_modes(setup.law):
        return -1, 2.0, False
    beads = len(setup.inverse_mass)
    walls = wall_motion(time, setup, segment), wall_motion(time + h, setup, segment)
    first, earliest, dense_is_found = -1, 2.0, False
    for c in range(beads + 1):
        if setup.stiffness[c] == 0.0 or not has_modes(law_of(c, setup)):
            continue
        if not may_switch(c, h, y, y_new, stages, setup, contacts, walls, still):
            continue
        if not dense_is_found:
            interpolate(time, y, h, y_new, setup, contacts, segment, stages, dense, trial, scratch)
            dense_is_found = True
        theta = switch_within(c, time, y, h, dense, setup, contacts, segment, still, trial, scratch)
        if setup.law.kind == UNLOADING:
            # The forces of stuck contacts were overwritten.
            derivative(time + h, y_new, setup, contacts, segment, scratch)
        if first < 0 or theta < earliest:
            first, earliest = c, theta
    return first if earliest <= 1.0 else -1, earliest, dense_is_found
