r"""Events in the wide window: first velocity maximum of each bead, largest overlap of each contact.

Nothing is assumed about their order; each is located on the interpolated motion of the step.
"""

from __future__ import annotations

from .change_of_sign import first_change_of
from .compilation import compiled
from .hermite import hermite, slope, value
from .limits import REACHED
from .wide_window_rows import (
    ARRIVAL,
    BEADS,
    CREST,
    END,
    EXPONENT,
    FIRST,
    INVERSE_MASS,
    LAST_CROSSING,
    LOW,
    MAX_FORCE,
    NEW_VELOCITY,
    PEAK_OVERLAP,
    PEAK_TIME,
    PEAK_VELOCITY,
    POSITION,
    RESIDENCE,
    ROW,
    SCALE,
    SINCE_CROSSING,
    SIZE,
    STAGE_0,
    STAGE_8,
    TIME,
    TRIAL,
    VELOCITY,
    WAITING,
    force,
)


@compiled
def force_rate(w, i, overlap, closing):
    """Rate of change p F d'/d of the force of contact i."""
    if overlap <= 0.0:
        return 0.0
    return w[EXPONENT + i] * force(w, i, overlap) / overlap * closing


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
def net_force(s, w, i, left, here, right):
    """Net force on a slot within the step, from the positions of the slot and its neighbours."""
    x = value(here, s)
    return force(w, i - 1, value(left, s) - x) - force(w, i, x - value(right, s))


@compiled
def closing(s, here, right):
    """Difference of the velocities of two slots within the step, times its length."""
    return slope(here, s) - slope(right, s)


first_peak, first_crossing = first_change_of(net_force), first_change_of(closing)


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
    here = motion(w, i, h)
    of_slot = w, i, motion(w, i - 1, h), here, motion(w, i + 1, h)
    part = first_peak(net_force(0.0, *of_slot), of_slot)
    if part > 1.0:
        return
    # A bead that has left both neighbours keeps the velocity at the end of the step.
    in_flight = w[STAGE_8 + i] == 0.0 and net_force(part, *of_slot) == 0.0
    results[PEAK_VELOCITY, at] = w[NEW_VELOCITY + i] if in_flight else slope(here, part) / h
    results[PEAK_TIME, at] = time + part * h


@compiled
def record_crossing(w, i, h, clock, place, at, results):
    """Record the largest overlap of contact i, if it is within the step.

    The residence time is counted from the previous crossing: a difference of two arrival times
    would suffer from cancellation where the pulse becomes much faster.
    """
    here, right = motion(w, i, h), motion(w, i + 1, h)
    part = first_crossing(closing(0.0, here, right), (here, right))
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
