"""Steps of the beads around a leading pulse, stored for the adjoint.

As in `hertzchain.kernels.narrow_window`, only a window of beads is integrated, from some beads
behind the crest to some beads ahead of it.  Errors of steps are measured in units of the crest's
velocity, near the crest and ahead of it, because motion further behind does not overtake it.  A
chain whose window cuts off forces that are not negligible is rejected with a status.
"""

from __future__ import annotations

import math

from .adjoint_forward import MIN_STEP, find_events
from .adjoint_layout import (
    ALL_FOUND,
    AT_STEP,
    BLOCK_FULL,
    CUT_OFF,
    F0,
    F8,
    FORCE,
    HIGH,
    LOW,
    MOST,
    NEW_V,
    NEW_X,
    PLACE,
    SCALE,
    STEP,
    STEP_LIMIT,
    STEP_TOO_SMALL,
    STEPS,
    TIME,
    TRIED,
    V,
    X,
)
from .adjoint_step import compiled, forces, try_step, velocity_error
from .rkn8_step import GROWTH, SAFETY, SHRINKAGE

# Entries of the settings: beads behind the crest, the same if the contact there is open, beads
# ahead of it, beads behind it whose errors count, largest forces cut off at the rear and at the
# front as fractions of the largest force.
BEHIND, OPEN_BEHIND, AHEAD, COUNTED, REAR_LIMIT, FRONT_LIMIT = range(6)


@compiled
def crest_of(w, at, crest, high):
    """Bead of the next velocity maximum."""
    while crest + 1 < high and w[at + 2 + crest] > w[at + 1 + crest]:
        crest += 1
    return crest


@compiled
def window_error(w, first, high, h, speed):
    """Largest error of a step from bead ``first`` on, in units of a speed."""
    top = 0.0
    for i in range(first, high):
        top = max(top, abs(velocity_error(w, i, F0, F8)))
    return abs(h) * top / speed


@compiled
def cuts_off(w, low, high, beads, settings):
    """Whether the forces at the ends of the next window, which begins at ``low``, are too large."""
    largest = 0.0
    for c in range(low, high + 1):
        largest = max(largest, w[FORCE + c])
    rear = w[FORCE + low] if low > 0 else 0.0
    front = w[FORCE + high] if high < beads else 0.0
    return rear > settings[REAR_LIMIT] * largest or front > settings[FRONT_LIMIT] * largest


@compiled
def rear_bead(w, crest, low, settings, targets, found):
    """First bead of the window: behind the crest, and behind the first event that is missing."""
    for t in range(len(targets)):
        if found[t, AT_STEP] < 0.0:
            crest = min(crest, int(targets[t, PLACE]))
    rear = max(low, crest - int(settings[BEHIND]))
    for c in range(crest - int(settings[OPEN_BEHIND]), rear, -1):
        if w[FORCE + c] == 0.0:
            return c
    return rear


@compiled
def accept(w, low, high, beads, x, v):
    """Store the state at the start of a step, and replace it by that at the end."""
    if high < beads:
        x[high] = v[high] = 0.0
    for i in range(low, high):
        x[i], v[i] = w[X + 1 + i], w[V + 1 + i]
        w[X + 1 + i], w[V + 1 + i] = w[NEW_X + 1 + i], w[NEW_V + 1 + i]
        w[F0 + i] = w[F8 + i]


@compiled
def follow(
    w, events, beads, clock, counts, rtol, most_steps, settings, hertz, targets, found, candidates,
    positions, velocities, lengths, windows, kept, room, end,
):  # fmt: skip
    """Take steps until all events are found, as `hertzchain.kernels.adjoint_forward.advance`."""
    counts[STEPS] = 0
    low, high = counts[LOW], counts[HIGH]
    crest = low
    for c in range(low, high + 1):
        kept[0, 0, c] = end[c]
    while counts[STEPS] < len(lengths):
        n, h = counts[STEPS], clock[STEP]
        if counts[TRIED] >= most_steps:
            return STEP_LIMIT
        last = kept[n + 1, 0] if n + 1 < len(lengths) else end
        try_step(w, low, high, h, hertz, kept[n], last)
        crest = crest_of(w, NEW_V, max(crest, low), high)
        speed = w[NEW_V + 1 + crest]
        error = window_error(w, max(low, crest - int(settings[COUNTED])), high, h, speed) / rtol
        counts[TRIED] += 1
        change = SAFETY / math.sqrt(math.sqrt(math.sqrt(error + 1e-30)))
        change = change if change > SHRINKAGE else SHRINKAGE
        if not error <= 1.0:
            clock[STEP], clock[MOST] = h * min(change, 0.5), 1.0
            if not clock[STEP] > max(MIN_STEP, 1e-17 * clock[TIME]):
                return STEP_TOO_SMALL
            continue
        for i in range(low, high):
            w[SCALE + i] = speed
        remaining = find_events(
            w, events, beads, low, high, h, clock[TIME], counts, hertz, targets, found, candidates,
            kept[n], last, room,
        )  # fmt: skip
        accept(w, low, high, beads, positions[n], velocities[n])
        lengths[n], windows[n, 0], windows[n, 1] = h, low, high
        counts[STEPS] = n + 1
        clock[TIME] += h
        clock[STEP] = h * min(change, clock[MOST])
        clock[MOST] = GROWTH
        if remaining == 0:
            return ALL_FOUND
        rear = rear_bead(w, crest, low, settings, targets, found)
        front = max(high, min(beads, crest + 1 + int(settings[AHEAD])))
        if rear > low or front > high:
            if cuts_off(w, rear, high, beads, settings):
                return CUT_OFF
            low, high = counts[LOW], counts[HIGH] = rear, front
            forces(w, low, high, X, F0, hertz, last)
    return BLOCK_FULL
