r"""Events in the narrow window: arrivals, velocity maxima, and contacts that open behind the pulse.

At the opening of a contact, `release` integrates the end of the push in closed form.
"""

from __future__ import annotations

import math

from .hermite import curvature, hermite, slope, third, value
from .narrow_window_rows import (
    APPROACH,
    ARRIVAL,
    ARRIVAL_TIME,
    ARRIVED,
    BEAD,
    EXPONENT,
    FIRST,
    FOLLOWED,
    FREE_STEP,
    GIVEN_STIFFNESS,
    GRADING,
    INVERSE_MASS,
    LAST,
    MAX_FORCE,
    MAX_STEPS,
    NEXT_STEP,
    OLD_POSITION,
    OLD_STAGE_0,
    OLD_STEP,
    OLD_VELOCITY,
    OUT_OF_ORDER,
    PEAK_OVERLAP,
    PEAK_TIME,
    PEAK_VELOCITY,
    POSITION,
    RESIDENCE,
    STAGE_0,
    STALLED,
    STEPS,
    STIFFNESS,
    TARGET_STEP,
    TIME,
    VELOCITY,
    WAITING,
    compiled,
    inlined,
    pushing,
)
from .narrow_window_slots import shift_window, window_status

# A contact that opens within this fraction of a step is released even if an arrival is about to
# occur.
SOON = 1e-4
# Contacts behind the candidate that are watched for opening.
WATCHED = 4
# Beads slower than this fraction of the candidate's velocity are at the foot of the pulse, where
# rounding errors may have maxima.
FOOT = 1e-6


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
