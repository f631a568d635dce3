"""Adaptive integration of one elastic chain that stores what its adjoint needs.

`advance` fills a block of steps: state at the start, length and window of each step, and the
overlaps at all stages.  Beads ahead of the front are not integrated before motion reaches them.
"""

from __future__ import annotations

import math

from .adjoint_damped import damped_rate, part_before_release, release
from .adjoint_events import event_function, load_state, locate
from .adjoint_layout import (
    ALL_FOUND,
    AT_REST,
    AT_STEP,
    AT_TIME,
    BASE,
    BLOCK_FULL,
    CANDIDATES,
    CLOSING,
    EVENT_A,
    EVENT_V,
    EVENT_X,
    EXPONENT,
    F0,
    F2,
    F8,
    FRACTION,
    GAUGE,
    HIGH,
    KEPT_SWITCHES,
    KIND,
    LOW,
    MAXIMUM,
    MOST,
    NEW_V,
    NEW_X,
    NOISE,
    PLACE,
    RELEASED,
    ROW,
    SCALE,
    SECOND,
    STEP,
    STEP_LIMIT,
    STEP_TOO_SMALL,
    STEPS,
    STIFFNESS,
    TIME,
    TIME_REACHED,
    TRIED,
    VELOCITY,
    V,
    X,
)
from .adjoint_step import compiled, entry_point, error_of, try_step
from .limits import REACHED, ROUNDED, ROUNDING
from .rkn8_step import GROWTH, SAFETY, SHRINKAGE

# Smallest step; factor by which a step is shortened if a contact may have closed unnoticed.
MIN_STEP, HALF = 1e-280, 0.5
# Motion advances by at most this number of beads per step.
REACH = 9


@compiled
def closes_unseen(w, low, high, h, hertz):
    """Whether a contact that is open at both ends of a step may have been closed in between."""
    for c in range(low, high + 1):
        first = w[AT_REST + c] + (w[X + c] - w[X + c + 1])
        last = w[AT_REST + c] + (w[NEW_X + c] - w[NEW_X + c + 1])
        if first > 0.0 or last > 0.0 or w[STIFFNESS + c] == 0.0:
            continue
        if w[V + c] <= w[V + c + 1] or w[NEW_V + c] >= w[NEW_V + c + 1]:
            continue
        sharpest = 0.0
        if hertz is None:
            # Stages of damped steps are in other rows.
            sharpest = (w[V + c] - w[V + c + 1] - (w[NEW_V + c] - w[NEW_V + c + 1])) / h
        for stage in range(F0, F8 + 1, ROW):
            left = w[stage + c - 1] if c > low else 0.0
            right = w[stage + c] if c < high else 0.0
            sharpest = max(sharpest, abs(left - right))
        if 0.125 * h * h * sharpest > max(-max(first, last), 1e-14 * abs(w[X + c])):
            return True
    return False


@compiled
def part_to_repeat(w, low, high, h, hertz, careful):
    """Fraction with which a step must be repeated; 2 if it may be accepted."""
    if careful and closes_unseen(w, low, high, h, hertz):
        return HALF
    return part_before_release(w, low, high) if hertz is None else 2.0


@compiled
def least_speed(w, i, h):
    """Speed of a bead above which the pulse has reached it."""
    return max(REACHED * w[SCALE + i], (ROUNDED / ROUNDING) * w[NOISE + i] * h)


@compiled
def happens(w, beads, low, high, h, target, kept, last, hertz):
    """Whether an event may be within the step tried; numbers kept begin with contact ``low``."""
    kind, first, second = int(target[KIND]), int(target[PLACE]), int(target[SECOND])
    if first < low or second > high:
        return False
    if kind in (VELOCITY, MAXIMUM):
        falls = w[F8 + first] <= 0.0
        if hertz is not None:
            for stage in range(F2, F8, ROW):
                falls = falls or w[stage + first] <= 0.0
        forward = max(w[V + 1 + first], w[NEW_V + 1 + first])
        least = least_speed(w, first, h) if kind == VELOCITY else 0.0
        return falls and w[F0 + first] > 0.0 and forward > least
    if kind == CLOSING:
        before, after = w[V + first] - w[V + first + 1], w[NEW_V + first] - w[NEW_V + first + 1]
        touching = kept[0, first - low] > 0.0 or last[first - low] > 0.0
        moves = max(abs(w[V + first + 1]), abs(w[NEW_V + first + 1]))
        return touching and before > 0.0 >= after and moves > least_speed(w, first, h)
    if kept[0, first - low] == 0.0 and kept[0, second - low] == 0.0:
        if last[first - low] == 0.0 and last[second - low] == 0.0:
            return False
    rate, _ = event_function(w, beads, GAUGE, first, second, hertz)
    if rate > 0.0:
        return False
    before = 0.0
    for c in (first, second):
        d = w[AT_REST + c] + (w[X + c] - w[X + c + 1])
        closing = w[V + c] - w[V + c + 1]
        before += start_rate(w, c, beads, d, closing, hertz)
        # A force that rises from zero has no rate yet.
        before = 1e-300 if before == 0.0 and d <= 0.0 and last[c - low] > 0.0 else before
    return before > 0.0


@compiled
def start_rate(w, c, beads, d, closing, hertz):
    """Rate of a contact's force at the start of a step."""
    if hertz is None:
        return damped_rate(w, c, beads, X, V, F0)
    if not d > 0.0:
        return 0.0
    p = w[EXPONENT + c]
    return p * w[STIFFNESS + c] * d ** (p - 1.0) * closing


@compiled
def find_events(
    w, events, beads, low, high, h, time, counts, hertz, targets, found, located, candidates, kept,
    last, room,
):  # fmt: skip
    """Look for events in a step; returns the number of those that are still not found."""
    n, remaining = counts[STEPS], 0
    for t in range(len(targets)):
        kind = int(targets[t, KIND])
        if kind >= GAUGE:
            if happens(w, beads, low, high, h, targets[t], kept, last, hertz):
                candidates[counts[CANDIDATES], 0] = t
                candidates[counts[CANDIDATES], 1] = n
                counts[CANDIDATES] += 1
            continue
        if found[t, AT_STEP] >= 0.0:
            continue
        remaining += 1
        if happens(w, beads, low, high, h, targets[t], kept, last, hertz):
            x, v = w[X + 1 : X + 1 + beads], w[V + 1 : V + 1 + beads]
            for c in range(low, high + 1):
                events[AT_REST + c] = w[AT_REST + c]
                if hertz is None:
                    events[RELEASED + c] = w[RELEASED + c]
            load_state(events, beads, low, high, hertz, x, v, room)
            s = locate(events, beads, low, high, h, hertz, targets[t], room, room[len(room) - 1])
            if s <= 1.0:
                found[t, AT_STEP], found[t, FRACTION] = counts[BASE] + n, s
                found[t, AT_TIME] = time + s * h
                keep_event(events, beads, high - low + 1, room, located[t])
                remaining -= 1
    return remaining


@compiled
def keep_event(w, beads, contacts, room, out):
    """Copy the numbers kept in the part of a step before an event, and the state at the event."""
    for row in range(len(room)):
        for c in range(contacts):
            out[row, c] = room[row, c]
    x, v, a = len(room) + EVENT_X, len(room) + EVENT_V, len(room) + EVENT_A
    for i in range(beads):
        out[x, i], out[v, i], out[a, i] = w[NEW_X + 1 + i], w[NEW_V + 1 + i], w[F8 + i]


@entry_point
def advance(
    w, events, beads, clock, counts, until, rtol, most_steps, stop_when_found, hertz, careful,
    resting, targets, found, located, candidates, positions, velocities, lengths, windows,
    kept, room, end,
):  # fmt: skip
    """Take steps until the block is full or the run ends; returns the reason.

    N is the number of beads, S the number of steps in the block and T the number of targets.

    Parameters
    ----------
    w, events : rows of `hertzchain.kernels.adjoint_layout`, those of the run and a second set in
        which events are located
    clock, counts : scalars of the run, with the entries of the layout
    until, rtol, most_steps : end of the run, tolerance, maximum number of steps tried
    stop_when_found : whether to end when all events of beads and contacts are found
    hertz : whether all exponents are 3/2; None with damping
    careful : whether open contacts may close within a step
    resting : whether beads ahead of the front are at rest and not pushed
    targets, found : (T, TARGET) and (T, FOUND); steps are counted from the start of the run
    located : (T, 9 + EVENT_ROWS, N + 1) numbers of the parts of steps before events, and states
    candidates : (C, 2) target and step in the block of maxima of gauges
    positions, velocities, lengths, windows : (S, N), (S, N), (S,), (S, 2) of the block
    kept : (S, 8, N + 1) overlaps at the stages, or as the layout states for damped contacts;
        ``room`` (9, N + 1) is scratch
    end : (N + 1,) overlaps at the end of the last step
    """
    counts[STEPS] = counts[CANDIDATES] = 0
    low, high = counts[LOW], counts[HIGH]
    for c in range(beads + 1):
        kept[0, 0, c] = end[c]
    while True:
        n = counts[STEPS]
        if n == len(lengths):
            return BLOCK_FULL
        if counts[TRIED] >= most_steps:
            return STEP_LIMIT
        h, left = clock[STEP], until - clock[TIME]
        reaches = h >= left
        h = left if reaches else h
        last = kept[n + 1, 0] if n + 1 < len(lengths) else end
        try_step(w, low, high, h, hertz, kept[n], last)
        error = error_of(w, low, high, h, rtol, hertz) / rtol
        counts[TRIED] += 1
        change = SAFETY / math.sqrt(math.sqrt(math.sqrt(error + 1e-30)))
        change = change if change > SHRINKAGE else SHRINKAGE
        part = part_to_repeat(w, low, high, h, hertz, careful) if error <= 1.0 else 0.0
        if part < 1.0:
            clock[STEP], clock[MOST] = h * (part if part > 0.0 else min(change, HALF)), 1.0
            if not clock[STEP] > max(MIN_STEP, 1e-17 * clock[TIME]):
                return STEP_TOO_SMALL
            continue
        remaining = find_events(
            w, events, beads, low, high, h, clock[TIME], counts, hertz, targets, found, located,
            candidates, kept[n], last, room,
        )  # fmt: skip
        for i in range(low, high):
            positions[n, i], velocities[n, i] = w[X + 1 + i], w[V + 1 + i]
        lengths[n], windows[n, 0], windows[n, 1] = h, low, high
        for i in range(low, high):
            w[X + 1 + i], w[V + 1 + i] = w[NEW_X + 1 + i], w[NEW_V + 1 + i]
            w[F0 + i] = w[F8 + i]
        if hertz is None:
            release(w, low, high, kept[n, KEPT_SWITCHES])
        counts[STEPS] = n + 1
        clock[TIME] = until if reaches else clock[TIME] + h
        if not reaches:
            clock[STEP] = h * min(change, clock[MOST])
        clock[MOST] = GROWTH
        if resting:
            while high < beads and w[X + high - REACH + 1] != 0.0:
                high += 1
            counts[HIGH] = high
        if reaches:
            return TIME_REACHED
        if stop_when_found and until == math.inf and remaining == 0:
            return ALL_FOUND
