"""Locate events of one elastic chain by taking a step again with a shorter length.

The end of the shorter step is a state of the discrete integration, so that the adjoint gives exact
derivatives there.  A state on an interpolant would not have them.
"""

from __future__ import annotations

import math

from .adjoint_damped import damped_rate, set_reduced
from .adjoint_layout import (
    AT_REST,
    CLOSING,
    EXPONENT,
    F0,
    F8,
    FORCE,
    INVERSE_MASS,
    KIND,
    MAXIMUM,
    NEW_V,
    NEW_X,
    PLACE,
    SECOND,
    TRIAL,
    VELOCITY,
    V,
    X,
)
from .adjoint_step import compiled, entry_point, forces, try_step
from .elastic_forces import LEAST

# Number of parts of a step that are searched, one after the other, for the first maximum of a
# velocity; limit and tolerance, as a fraction of the step, of the iteration that locates an event.
PARTS, ITERATIONS = 8, 80
CLOSE = 1e-16


@compiled
def accelerations(w, entry, beads):
    """Acceleration, at the end of a step, of an entry of the row of positions; 0 for walls."""
    return w[F8 + entry - 1] if 0 < entry <= beads else 0.0


@compiled
def force_rates(w, c, beads, hertz):
    """First and second derivative of a contact's force with respect to time, at a step's end.

    For damped contacts the second derivative is not computed; 0 is returned instead.
    """
    if hertz is None:
        return damped_rate(w, c, beads, NEW_X, NEW_V, F8), 0.0
    return elastic_rates(w, c, beads)


@compiled
def elastic_rates(w, c, beads):
    """`force_rates` without damping."""
    d = w[AT_REST + c] + (w[NEW_X + c] - w[NEW_X + c + 1])
    if not d > LEAST:
        return 0.0, 0.0
    closing = w[NEW_V + c] - w[NEW_V + c + 1]
    p, force = w[EXPONENT + c], w[FORCE + c]
    slope = p * force / d
    bend = accelerations(w, c, beads) - accelerations(w, c + 1, beads)
    return slope * closing, slope * bend + (p - 1.0) * slope / d * closing * closing


@compiled
def event_function(w, beads, kind, first, second, hertz):
    """The function whose fall through zero is the event, and its rate, at the end of a step."""
    if kind in (VELOCITY, MAXIMUM):
        left, _ = force_rates(w, first, beads, hertz)
        right, _ = force_rates(w, first + 1, beads, hertz)
        return w[F8 + first], (left - right) * w[INVERSE_MASS + first]
    if kind == CLOSING:
        bend = accelerations(w, first, beads) - accelerations(w, first + 1, beads)
        return w[NEW_V + first] - w[NEW_V + first + 1], bend
    rate, bend = force_rates(w, first, beads, hertz)
    if second != first:
        other, more = force_rates(w, second, beads, hertz)
        rate, bend = rate + other, bend + more
    return rate, bend


@compiled
def locate(w, beads, low, high, h, hertz, target, kept, last):
    """Fraction of a step at which an event occurs; 2 if it does not occur.

    On entry, the rows must hold the state and the accelerations at the start of the step; on
    return, the rows of the end of the step hold the state at the event.
    """
    kind, first, second = int(target[KIND]), int(target[PLACE]), int(target[SECOND])
    begin, end = 0.0, 2.0
    for part in range(1 if kind in (VELOCITY, MAXIMUM) else PARTS, PARTS + 1):
        try_step(w, low, high, h * part / PARTS, hertz, kept, last)
        g, rate = event_function(w, beads, kind, first, second, hertz)
        if g <= 0.0:
            end = part / PARTS
            break
        begin = part / PARTS
    if end > 1.0:
        return end
    s = end
    for _ in range(ITERATIONS):
        if g > 0.0:
            begin = s
        else:
            end = s
        new = s - g / (rate * h) if rate != 0.0 else math.nan
        if not begin < new < end:
            new = 0.5 * (begin + end)
        if abs(new - s) < CLOSE or end - begin < CLOSE:
            break
        s = new
        try_step(w, low, high, h * s, hertz, kept, last)
        g, rate = event_function(w, beads, kind, first, second, hertz)
        if g == 0.0:
            break
    return s


@entry_point
def locate_from(w, beads, low, high, h, hertz, target, kept, last, x, v):
    """`locate` in a step that starts from positions and velocities of the beads."""
    load_state(w, beads, low, high, hertz, x, v, kept)
    return locate(w, beads, low, high, h, hertz, target, kept, last)


@compiled
def load_state(w, beads, low, high, hertz, x, v, kept):
    """Load a state into the rows and compute its accelerations; row RELEASED must be set."""
    for i in range(beads):
        w[X + 1 + i] = w[TRIAL + 1 + i] = w[NEW_X + 1 + i] = x[i]
        w[V + 1 + i] = w[NEW_V + 1 + i] = v[i]
        w[F0 + i] = w[F8 + i] = 0.0
    forces(w, low, high, X, F0, hertz, kept[0])
    if hertz is None:
        set_reduced(w, low, high)
