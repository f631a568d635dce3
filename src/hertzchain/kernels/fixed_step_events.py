"""Events and saved times of runs with fixed steps, located on polynomials of degree 5.

The functions do not depend on the splitting method (`hertzchain.kernels.symplectic`).
"""

from __future__ import annotations

from .compilation import CONTRACTED, compiled, internal, reduced
from .events import store_crossing
from .forces import copy
from .hermite import curvature, slope, value
from .leading_pulse import note_leading_pulse, rise_of
from .limits import NEIGHBOURS, REACHED, ROUNDED, SLOW
from .state_layout import (
    CROSSING_TIME,
    FIRST_END,
    FIRST_IMPULSE,
    FRAMES,
    LAST_END,
    LAST_IMPULSE,
    PEAK_TIME,
    PEAK_VELOCITY,
    PEAKS,
    TIME,
    TOUCHES,
    TOUCHING,
    TURNED_BACK,
    WALL_PEAK,
    WALL_PEAK_TIME,
)

BISECTIONS = 48

inlined = internal(forceinline=True, **CONTRACTED)


@inlined
def quintic(h, x0, v0, a0, x1, v1, a1):
    """Coefficients, as those of `hermite`, of the polynomial of degree 5 through both ends."""
    c1, c2 = h * v0, 0.5 * h * h * a0
    x, v, a = x1 - (x0 + c1 + c2), h * v1 - (c1 + 2.0 * c2), h * h * a1 - 2.0 * c2
    c3, c4, c5 = 10.0 * x - 4.0 * v + 0.5 * a, -15.0 * x + 7.0 * v - a, 6.0 * x - 3.0 * v + 0.5 * a
    return x0, c1, c2, c3, c4, c5, 0.0, 0.0


@compiled
def turning_point(c):
    """Fraction of a step at which the first derivative, positive at the start, vanishes."""
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if slope(c, middle) > 0.0 else (low, middle)
    return high


@compiled
def inflection(c):
    """Fraction of a step at which the second derivative, positive at the start, vanishes."""
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if curvature(c, middle) > 0.0 else (low, middle)
    return high


@inlined
def watch_wall(side, time, h, force, given, least, passed, x, v, a, spring, ends, walls):
    """Record the largest force on a wall, the number of touches, and the ends of contacts.

    ``given`` is the impulse on the wall so far, and ``least`` that from which on it is the impulse
    of a first contact.  The position, velocity and acceleration of the adjacent bead are positive
    away from the wall; ``ends`` has these values and the force at the end of the previous step.
    ``passed`` states whether the crest has passed.
    """
    stiffness, closed_by, exponent = spring
    if stiffness > 0.0:
        if force > walls[WALL_PEAK, side]:
            walls[WALL_PEAK, side], walls[WALL_PEAK_TIME, side] = force, time
        if ends[side, 1] < 0.0 and v >= 0.0 and (force > 0.0 or ends[side, 3] > 0.0):
            c = quintic(h, -ends[side, 0], -ends[side, 1], -ends[side, 2], -x, -v, -a)
            s = turning_point(c)
            overlap = closed_by + value(c, s)
            top = stiffness * overlap**exponent if overlap > 0.0 else 0.0
            if top > walls[WALL_PEAK, side]:
                walls[WALL_PEAK, side], walls[WALL_PEAK_TIME, side] = top, time - (1.0 - s) * h
        if force > 0.0 and walls[TOUCHING, side] == 0.0:
            walls[TOUCHES, side] += 1.0
        elif force == 0.0 and walls[TOUCHING, side] > 0.0:
            walls[LAST_END, side], walls[LAST_IMPULSE, side] = time, given
        walls[TOUCHING, side] = 1.0 if force > 0.0 else 0.0
        if force == 0.0 and abs(given) > least and v > 0.0 and walls[FIRST_END, side] == 0.0:
            walls[FIRST_IMPULSE, side], walls[FIRST_END, side] = given, time
        if side == 1 and passed and v > 0.0 and walls[TURNED_BACK, 1] == 0.0:
            walls[TURNED_BACK, 1] = time
        ends[side, 0], ends[side, 1], ends[side, 2], ends[side, 3] = x, v, a, force


@compiled
def save_frames(time, time_new, h, y, springs, rows, counts, frame_times, frames, frame_forces):
    """Save states and forces at the saved times within a step."""
    beads = len(rows.velocities)
    frame = counts[FRAMES]
    while frame < len(frame_times) and frame_times[frame] <= time_new:
        s = min(1.0, (frame_times[frame] - time) / h)
        copy(y, frames[frame])
        for i in range(beads):
            c = polynomial_of(i, h, rows)
            frames[frame, i] = value(c, s)
            frames[frame, beads + i] = slope(c, s) / h
        for c in range(frame_forces.shape[1]):
            x = frames[frame, c - 1] if c > 0 else 0.0
            d = springs.closed_by[c] + (x - (frames[frame, c] if c < beads else 0.0))
            pushing = springs.stiffness[c] * d ** springs.exponents[c] if d > 0.0 else 0.0
            frame_forces[frame, c] = pushing
        frame += 1
    counts[FRAMES] = frame


@compiled
def polynomial_of(i, h, rows):
    """Position of bead i (0-based) within a step, as a polynomial."""
    before = rows.before
    return quintic(
        h, before[0, i + 1], before[1, i + 1], before[2, i + 1], rows.positions[i + 1],
        rows.velocities[i], rows.accelerations[i + 1],
    )  # fmt: skip


@compiled
def moves(k, h, springs, rows):
    """Whether bead k moves within a step, compared with the speeds of the beads around it.

    Static forces cancel except for rounding.
    """
    before, v = rows.before, rows.velocities
    near = 0.0
    for j in range(len(v)):
        near = max(near, SLOW * abs(v[j]))
    for j in range(max(0, k - NEIGHBOURS), min(len(v), k + NEIGHBOURS + 1)):
        near = max(near, abs(v[j]), abs(before[1, j + 1]))
    pushing = (abs(rows.forces[k]) + abs(rows.forces[k + 1])) * springs.inverse_mass[k]
    return max(v[k], before[1, k + 1]) > max(REACHED * near, ROUNDED * h * pushing)


@reduced
def some_peak(times, before, after):
    """Whether the acceleration of a bead without a recorded maximum changes its sign in a step."""
    found = 0
    for k in range(len(times)):
        found += (times[k] == 0.0) & (before[k] > 0.0) & (after[k] <= 0.0)
    return found > 0


@reduced
def some_crossing(times, before, after):
    """Whether velocities of neighbours without a recorded crossing become equal in a step."""
    found = 0
    for k in range(len(after) - 1):
        closing = before[k] > before[k + 1]
        found += (times[k] == 0.0) & closing & (after[k] <= after[k + 1])
    return found > 0


@compiled
def record_events(h, clock, counts, setup, contacts, springs, rows, peaks, crossings):
    """Record first velocity maxima and largest overlaps within a step.

    Most steps have none; a vectorised test for any is faster than a search bead by bead.
    """
    before, v, a = rows.before, rows.velocities, rows.accelerations
    beads = len(v)
    start = 0 if peaks[PEAK_VELOCITY, 0] == 0.0 else 1
    last = beads + 1
    if some_peak(peaks[PEAK_TIME, start:beads], before[2, start + 1 : last], a[start + 1 : last]):
        record_peaks(h, clock, counts, springs, rows, peaks)
    if some_crossing(crossings[CROSSING_TIME], before[1, 1:last], v):
        record_crossings(h, clock, counts, setup, contacts, springs, rows, crossings)


@compiled
def record_peaks(h, clock, counts, springs, rows, peaks):
    """Record first velocity maxima within a step."""
    before, a = rows.before, rows.accelerations
    for k in range(len(rows.velocities)):
        waits = peaks[PEAK_TIME, k] == 0.0 and (k > 0 or peaks[PEAK_VELOCITY, 0] == 0.0)
        if waits and before[2, k + 1] > 0.0 and a[k + 1] <= 0.0 and moves(k, h, springs, rows):
            c = polynomial_of(k, h, rows)
            s = inflection(c)
            peaks[PEAK_TIME, k], peaks[PEAK_VELOCITY, k] = clock[TIME] + s * h, slope(c, s) / h
            counts[PEAKS] += 1 if k > 0 else 0


@compiled
def record_crossings(h, clock, counts, setup, contacts, springs, rows, crossings):
    """Record first largest overlaps within a step."""
    before, v, a = rows.before, rows.velocities, rows.accelerations
    beads = len(v)
    for k in range(beads - 1):
        closing = before[1, k + 1] - before[1, k + 2]
        if crossings[CROSSING_TIME, k] != 0.0 or closing <= 0.0 or v[k] > v[k + 1]:
            continue
        c = quintic(
            h, before[0, k + 1] - before[0, k + 2], closing, before[2, k + 1] - before[2, k + 2],
            rows.positions[k + 1] - rows.positions[k + 2], v[k] - v[k + 1], a[k + 1] - a[k + 2],
        )  # fmt: skip
        s = turning_point(c)
        overlap = springs.closed_by[k + 1] + value(c, s)
        if overlap <= 0.0 or not (moves(k, h, springs, rows) or moves(k + 1, h, springs, rows)):
            continue
        store_crossing(k, s * h, overlap, clock, counts, crossings)
        rise = rise_of(overlap, k, setup, contacts)
        state = rows.state
        for i in range(beads):
            state[beads + i] = slope(polynomial_of(i, h, rows), s) / h
        note_leading_pulse(
            k, rise, 0, clock[TIME], counts, state, state, springs.inverse_mass, crossings
        )
