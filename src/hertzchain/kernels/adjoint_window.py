"""Steps of the beads around a leading pulse, stored for the adjoint.

As in `hertzchain.kernels.narrow_window`, only a window of beads is integrated, from some beads
behind the crest to some beads ahead of it.  Their number is a constant of the kernels, so that the
compiler can use vectors; entries after the last bead have neither mass nor stiffness.

Errors of steps are measured in units of the crest's velocity, near the crest and ahead of it,
because motion further behind does not overtake it.  Contacts behind the crest that are about to
open are released (`hertzchain.kernels.adjoint_release`).  A chain whose window cuts off forces
that are not negligible is rejected with a status.
"""

from __future__ import annotations

import math

from .adjoint_forward import MIN_STEP, find_events
from .adjoint_layout import (
    ALL_FOUND,
    AT_REST,
    AT_STEP,
    BLOCK_FULL,
    CUT_OFF,
    F0,
    F8,
    FORCE,
    MOST,
    NEW_V,
    NEW_X,
    PLACE,
    RELEASES,
    SCALE,
    STEP,
    STEP_LIMIT,
    STEP_TOO_SMALL,
    STEPS,
    TIME,
    TRIED,
    USUAL,
    WORK,
    V,
    X,
)
from .adjoint_release import APART, release
from .adjoint_step import compiled, elastic_forces, entry_point, largest, take_step, velocity_error
from .rkn8_step import GROWTH, SAFETY, SHRINKAGE

# Entries of the settings: beads behind the crest, the same if the contact there is open, beads
# ahead of it, beads behind it whose errors count, largest forces cut off at the rear and at the
# front as fractions of the largest force; time before the opening of a contact at which it is
# released, as a fraction of a step; smaller forces, as such a fraction, do not shorten steps.
(BEHIND, OPEN_BEHIND, AHEAD, COUNTED, REAR_LIMIT, FRONT_LIMIT, RELEASE_PART, WEAK) = range(8)
# Number of beads in a window.
WINDOW = 15
# Contacts that are watched for opening.  Before it, steps are at most this fraction of the time
# left, unless they end at this fraction of the time before it at which the contact is released.
WATCHED, APPROACH, CLOSEST = 3, 0.5, 0.95


@compiled
def crest_of(w, at, crest, high):
    """Bead of the next velocity maximum."""
    while crest + 1 < high and w[at + 2 + crest] > w[at + 1 + crest]:
        crest += 1
    return crest


@compiled
def cuts_off(w, low, high, beads, settings):
    """Whether the forces at the ends of the next window, which begins at ``low``, are too large."""
    top = largest(w, FORCE, low, high + 1)
    rear = w[FORCE + low] if low > 0 else 0.0
    front = w[FORCE + high] if high < beads else 0.0
    return rear > settings[REAR_LIMIT] * top or front > settings[FRONT_LIMIT] * top


@compiled
def rear_bead(w, crest, low, settings, targets, found):
    """First bead of the window: behind the crest, and behind the first event that is missing.

    It is -1 if the window would end too close to the crest.
    """
    first = crest
    for t in range(len(targets)):
        if found[t, AT_STEP] < 0.0:
            first = min(first, int(targets[t, PLACE]))
    rear, least = max(low, first - int(settings[BEHIND])), crest + 1 + int(settings[AHEAD]) - WINDOW
    for c in range(first - int(settings[OPEN_BEHIND]), rear, -1):
        if w[FORCE + c] == 0.0:
            return max(c, least)
    if least > first - int(settings[OPEN_BEHIND]):
        return -1
    return max(rear, least)


@compiled
def window_step(w, h, hertz, kept, last):
    """One step of all beads of a window, with which the rows begin; and their errors."""
    take_step(w, 0, WINDOW, h, hertz, kept)
    elastic_forces(w, 0, WINDOW, NEW_X, F8, hertz, last)
    for i in range(WINDOW):
        w[WORK + i] = abs(velocity_error(w, i, F0, F8))


@compiled
def window_forces(w, hertz, kept):
    """Accelerations of all beads of a window."""
    elastic_forces(w, 0, WINDOW, X, F0, hertz, kept)


@compiled
def accept(w):
    """Replace the state at the start of a step by that at its end."""
    for i in range(WINDOW):
        w[X + 1 + i], w[V + 1 + i] = w[NEW_X + 1 + i], w[NEW_V + 1 + i]
        w[F0 + i] = w[F8 + i]


@compiled
def time_to_opening(w, c, horizon):
    """Time until a contact opens, by a parabola; ``inf`` if not within the horizon."""
    d0, d1 = w[AT_REST + c] + (w[X + c] - w[X + c + 1]), w[V + c] - w[V + c + 1]
    if not (d0 > 0.0 and d1 < 0.0 and d0 <= -d1 * horizon):
        return math.inf
    square = d1 * d1 - 2.0 * d0 * (w[F0 + c - 1] - w[F0 + c])
    return 2.0 * d0 / (math.sqrt(square) - d1) if square > 0.0 else math.inf


@compiled
def step_to_openings(w, low, crest, next_event, clock, counts, settings, releases, force):
    """Release contacts that are opening, restore open ones; the next step that the others allow."""
    usual = clock[USUAL]
    step = usual
    for c in range(max(low + 1, crest - WATCHED), crest + 1):
        if w[AT_REST + c] == APART:
            if w[X + c] <= w[X + c + 1]:
                w[AT_REST + c] = 0.0
            continue
        left = time_to_opening(w, c, 4.0 * usual)
        if left == math.inf:
            continue
        if left < settings[RELEASE_PART] * usual and c + 1 < next_event:
            n = counts[RELEASES]
            if n < len(releases) and release(w, c, counts[STEPS] - 1, releases[n]):
                counts[RELEASES] = n + 1
                continue
        if w[FORCE + c] > settings[WEAK] * force and c + 1 < next_event:
            step = min(step, max(APPROACH * left, left - CLOSEST * settings[RELEASE_PART] * usual))
    return step


@compiled
def next_event_of(targets, found):
    """First bead or contact of an event that is missing."""
    first = math.inf
    for t in range(len(targets)):
        if found[t, AT_STEP] < 0.0:
            first = min(first, targets[t, PLACE])
    return first


@entry_point
def follow(
    w, events, beads, clock, counts, rtol, most_steps, settings, hertz, targets, found, located,
    candidates, lengths, windows, kept, releases, room,
):  # fmt: skip
    """Take steps until all events are found, as `hertzchain.kernels.adjoint_forward.advance`.

    The beads must touch.  ``kept`` has space for the contacts of a window only, and for one step
    more than the block; ``releases`` receives the contacts that are released.
    """
    counts[STEPS] = counts[RELEASES] = 0
    low, high, crest = 0, WINDOW, 0
    clock[USUAL] = clock[STEP]
    for c in range(WINDOW + 1):
        kept[0, 0, c] = 0.0
    while counts[STEPS] < len(lengths):
        n, h = counts[STEPS], clock[STEP]
        if counts[TRIED] >= most_steps:
            return STEP_LIMIT
        last = kept[n + 1, 0]
        window_step(w[low:], h, hertz, kept[n], last)
        crest = crest_of(w, NEW_V, max(crest, low), high)
        speed = w[NEW_V + 1 + crest]
        error = (
            h * largest(w, WORK, max(low, crest - int(settings[COUNTED])), high) / (rtol * speed)
        )
        counts[TRIED] += 1
        change = SAFETY / math.sqrt(math.sqrt(math.sqrt(error + 1e-30)))
        change = change if change > SHRINKAGE else SHRINKAGE
        if not error <= 1.0:
            clock[STEP], clock[MOST] = h * min(change, 0.5), 1.0
            clock[USUAL] = clock[STEP]
            if not clock[STEP] > max(MIN_STEP, 1e-17 * clock[TIME]):
                return STEP_TOO_SMALL
            continue
        for i in range(low, high):
            w[SCALE + i] = speed
        remaining = find_events(
            w, events, beads, low, high, h, clock[TIME], counts, hertz, targets, found, located,
            candidates, kept[n], last, room,
        )  # fmt: skip
        accept(w[low:])
        lengths[n], windows[n, 0], windows[n, 1] = h, low, high
        counts[STEPS] = n + 1
        clock[TIME] += h
        # A step that was shortened before an opening does not change the usual one.
        free = h * min(change, clock[MOST])
        clock[USUAL] = free if h >= clock[USUAL] else min(clock[USUAL], h * change)
        clock[MOST] = GROWTH
        if remaining == 0:
            return ALL_FOUND
        before = counts[RELEASES]
        clock[STEP] = step_to_openings(
            w, low, crest, next_event_of(targets, found), clock, counts, settings, releases,
            largest(w, FORCE, low, high + 1),
        )  # fmt: skip
        rear = rear_bead(w, crest, low, settings, targets, found)
        if rear < 0:
            return CUT_OFF
        if rear > low:
            if cuts_off(w, rear, high, beads, settings):
                return CUT_OFF
            low, high = rear, rear + WINDOW
            w[AT_REST + low] = APART
        elif counts[RELEASES] == before:
            continue
        window_forces(w[low:], hertz, last)
    return BLOCK_FULL
