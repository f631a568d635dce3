"""Events of elastic chains within a step: velocity maxima, largest overlaps, largest forces.

Within a step the motion is interpolated by a Hermite polynomial of degree 7
(`hertzchain.kernels.hermite`).
"""

from __future__ import annotations

from .compilation import OPTIONS, compiled, internal
from .elastic_forces import force_of, force_rate
from .elastic_kinks import kink_motion, touches
from .elastic_layout import (
    AT_REST,
    BODY,
    CROSSED,
    CROSSINGS,
    EXPONENT,
    F0,
    F8,
    FLAG,
    HIGHEST_FALLEN,
    INVERSE_MASS,
    KEPT_MAXIMA,
    LANES,
    LAST_CROSSING,
    LENGTH,
    MAXIMA,
    MAXIMUM_0,
    NEW_V,
    NEW_X,
    NOISE,
    PEAK,
    PEAK_TIME,
    PEAKED,
    PEAKS,
    RECORD_CROSSING,
    RECORD_OVERLAP,
    RECORD_PEAK,
    RECORD_PEAK_TIME,
    RECORD_RESIDENCE,
    REST,
    SCALE,
    SINCE_CROSSING,
    TIME,
    H,
    V,
    X,
)
from .hermite import curvature, hermite, slope, third, value
from .limits import FALL, MIN_HEIGHT, REACHED, ROUNDED, ROUNDING

inlined = internal(forceinline=True, **OPTIONS)

# The pulse has not reached a bead whose speed is less than `REACHED`, or this many tolerances, of
# the speeds nearby; an overlap less than `REACHED` times the positions is ignored.
TOLERANCES = 10.0
# Parts of a step that are searched for the first event; iterations in one part.
PARTS, ITERATIONS = 8, 60
CLOSE = 1e-14
# A force is largest if its rate is less than this fraction of it per step.
FLAT = 1e-12
AT_A_WALL = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@compiled
def motion(w, at, kinks, count):
    """Interpolating polynomial of the position of a bead, without the motion due to kinks."""
    left, right = force_rate(w, at, X, V), force_rate(w, at + LANES, X, V)
    j0 = (left - right) * w[INVERSE_MASS + at]
    left, right = force_rate(w, at, NEW_X, NEW_V), force_rate(w, at + LANES, NEW_X,
                                                                     NEW_V)  # fmt: skip
    j1 = (left - right) * w[INVERSE_MASS + at]
    h, slot = w[H + at], at + LANES
    a0, x1, v1, a1 = w[F0 + at], w[NEW_X + slot], w[NEW_V + slot], w[F8 + at]
    if touches(kinks, count, slot):
        _, _, a, j = kink_motion(kinks, count, slot, 0.0)
        a0, j0 = a0 - a, j0 - j
        x, v, a, j = kink_motion(kinks, count, slot, h)
        x1, v1, a1, j1 = x1 - x, v1 - v, a1 - a, j1 - j
    return hermite(h, w[X + slot], w[V + slot], a0, j0, x1, v1, a1, j1)


@compiled
def motion_of_slot(w, beads, slot, lane, kinks, count):
    """`motion` of an entry of the positions, of which walls are at rest, and its kinks."""
    if slot == 0 or slot == beads + 1:
        return AT_A_WALL, kinks, 0, 0, 0.0
    at = slot * LANES + lane
    p = motion(w, at - LANES, kinks, count)
    return p, kinks, count if touches(kinks, count, at) else 0, at, w[H + at - LANES]


@compiled
def position(path, s):
    """Position of a bead at the fraction s of a step."""
    p, kinks, count, slot, h = path
    if count == 0:
        return value(p, s)
    return value(p, s) + kink_motion(kinks, count, slot, s * h)[0]


@compiled
def velocity(path, s):
    """Velocity of a bead, times the length of the step."""
    p, kinks, count, slot, h = path
    if count == 0:
        return slope(p, s)
    return slope(p, s) + h * kink_motion(kinks, count, slot, s * h)[1]


@compiled
def jerk(path, s):
    """Third derivative of the position by the fraction of the step."""
    p, kinks, count, slot, h = path
    if count == 0:
        return third(p, s)
    return third(p, s) + h * h * h * kink_motion(kinks, count, slot, s * h)[3]


@compiled
def acceleration_at(w, at, s, behind, own, ahead):
    """Acceleration of a bead at the fraction s of a step, from the forces on it."""
    here = position(own, s)
    left = force_of(w, at, w[AT_REST + at] + (position(behind, s) - here))
    right = force_of(w, at + LANES, w[AT_REST + at + LANES] + (here - position(ahead, s)))
    return (left - right) * w[INVERSE_MASS + at] + w[BODY + at]


@compiled
def velocity_maximum(w, at, behind, own, ahead):
    """Fraction of a step at which a bead is first no longer pushed; 2 if none."""
    low, high = 0.0, 2.0
    for part in range(1, PARTS + 1):
        s = part / PARTS
        if acceleration_at(w, at, s, behind, own, ahead) <= 0.0:
            high = s
            break
        low = s
    if high > 1.0:
        return high
    # Where a bead leaves both neighbours, its acceleration vanishes too slowly for Newton's method.
    leaves = w[F8 + at] == 0.0
    s = 0.5 * (low + high)
    for _ in range(ITERATIONS):
        a = acceleration_at(w, at, s, behind, own, ahead)
        if a > 0.0:
            low = s
        else:
            high = s
        # The slope of the acceleration from the polynomial is accurate enough.
        change = a * w[H + at] ** 2 / jerk(own, s)
        # Rounding may place the last iterate on the end of the bracket.
        if high - low < CLOSE or (abs(change) < CLOSE and not leaves):
            break
        s -= change
        if leaves or not low < s < high:
            s = 0.5 * (low + high)
    return s


@compiled
def closing_at(behind, ahead, s):
    """Difference of the velocities of two beads, and its derivative."""
    p, kinks, count, slot, h = behind
    rate, change = slope(p, s), curvature(p, s)
    if count > 0:
        _, v, a, _ = kink_motion(kinks, count, slot, s * h)
        rate, change = rate + h * v, change + h * h * a
    p, kinks, count, slot, h = ahead
    rate, change = rate - slope(p, s), change - curvature(p, s)
    if count > 0:
        _, v, a, _ = kink_motion(kinks, count, slot, s * h)
        rate, change = rate - h * v, change - h * h * a
    return rate, change


@compiled
def rest_within(behind, ahead):
    """Fraction of a step at which two beads first stop approaching; 2 if none."""
    low, high = 0.0, 2.0
    for part in range(1, PARTS + 1):
        s = part / PARTS
        if closing_at(behind, ahead, s)[0] <= 0.0:
            high = s
            break
        low = s
    if high > 1.0:
        return high
    s = 0.5 * (low + high)
    for _ in range(ITERATIONS):
        rate, change = closing_at(behind, ahead, s)
        if rate > 0.0:
            low = s
        else:
            high = s
        if high - low < CLOSE or abs(rate) < CLOSE * abs(change):
            break
        s -= rate / change
        if not low < s < high:
            s = 0.5 * (low + high)
    return s


@inlined
def least_speed(w, at, rtol):
    """Speed of a bead above which the pulse has reached it."""
    least, rounded = max(REACHED, TOLERANCES * rtol) * w[SCALE + at], w[NOISE + at] * w[H + at]
    return max(least, (ROUNDED / ROUNDING) * rounded)


@compiled
def record_peak(w, beads, k, lane, rtol, state, records, kinks, count):
    """Record the first velocity maximum of bead k (from 0), if it is within the step."""
    at = k * LANES + lane
    before, after = w[V + LANES + at], w[NEW_V + LANES + at]
    forward = max(before, after)
    if forward <= least_speed(w, at, rtol):
        return
    own = motion_of_slot(w, beads, k + 1, lane, kinks, count)
    behind = motion_of_slot(w, beads, k, lane, kinks, count)
    ahead = motion_of_slot(w, beads, k + 2, lane, kinks, count)
    s = velocity_maximum(w, at, behind, own, ahead)
    if s > 1.0:
        return
    w[PEAKED + at] = 1.0
    records[RECORD_PEAK_TIME, k] = state[TIME, lane] + s * state[LENGTH, lane]
    # A bead that has left both neighbours keeps the velocity of the step's end.
    left = w[F8 + at] == 0.0 and acceleration_at(w, at, s, behind, own, ahead) == 0.0
    records[RECORD_PEAK, k] = after if left else velocity(own, s) / w[H + at]
    if k > 0:
        state[PEAKS, lane] += 1.0


@compiled
def record_crossing(w, beads, k, lane, rtol, state, records, kinks, count):
    """Record when bead k (from 0) and the next one first have equal velocities."""
    at = k * LANES + lane
    here, there = LANES + at, 2 * LANES + at
    moves = max(abs(w[V + there]), abs(w[NEW_V + there]))
    if moves <= least_speed(w, at + LANES, rtol):
        return
    rest, touching = w[AT_REST + LANES + at], False
    for x in (X, NEW_X):
        sizes = abs(w[x + here]) + abs(w[x + there])
        touching = touching or rest + (w[x + here] - w[x + there]) > REACHED * sizes
    if not touching:
        return
    behind = motion_of_slot(w, beads, k + 1, lane, kinks, count)
    ahead = motion_of_slot(w, beads, k + 2, lane, kinks, count)
    s = rest_within(behind, ahead)
    if s > 1.0:
        return
    after = s * state[LENGTH, lane]
    w[CROSSED + at] = 1.0
    records[RECORD_CROSSING, k] = state[TIME, lane] + after
    records[RECORD_OVERLAP, k] = max(0.0, rest + (position(behind, s) - position(ahead, s)))
    # Counted from the previous crossing, because a difference of two times loses digits.
    if state[LAST_CROSSING, lane] == k - 1:
        records[RECORD_RESIDENCE, k] = state[SINCE_CROSSING, lane] + after
    state[LAST_CROSSING, lane] = k
    state[SINCE_CROSSING, lane] = -after
    state[CROSSINGS, lane] += 1.0


@compiled
def record_events(w, beads, rtol, state, good, which, records, kinks, count):
    """Record the marked events of lanes whose step is accepted."""
    for at in range(beads * LANES):
        mark = w[FLAG + at]
        if mark == 0.0:
            continue
        k, lane = at // LANES, at % LANES
        if good[lane] == 0.0 or which[lane] < 0:
            continue
        own = records[which[lane]]
        if mark == 1.0 or mark == 3.0:
            record_peak(w, beads, k, lane, rtol, state, own, kinks, count)
        if mark >= 2.0:
            record_crossing(w, beads, k, lane, rtol, state, own, kinks, count)


@inlined
def contact_at(w, at, s, behind, ahead):
    """Force of a contact and its rate at the fraction s of a step."""
    overlap = w[AT_REST + at] + (position(behind, s) - position(ahead, s))
    force = force_of(w, at, overlap)
    if not force > 0.0:
        return 0.0, 0.0
    return force, w[EXPONENT + at] * force / overlap * (velocity(behind, s) - velocity(ahead, s))


@compiled
def gauge_at(w, one, two, s, motions):
    """Force of a gauge and its rate at the fraction s of a step, from the motions of its beads."""
    behind, ahead, next_behind, next_ahead = motions
    force, rate = contact_at(w, one, s, behind, ahead)
    if one == two:
        return force, rate
    other, change = contact_at(w, two, s, next_behind, next_ahead)
    return 0.5 * (force + other), 0.5 * (rate + change)


@compiled
def gauge_rate(w, one, two, x, v):
    """Rate of the force of a gauge at one end of a step."""
    return force_rate(w, one, x, v) + force_rate(w, two, x, v)


@compiled
def largest_within(w, beads, lane, first, second, kinks, count):
    """Largest force of a gauge within a step, and the fraction of the step."""
    one, two = first * LANES + lane, second * LANES + lane
    behind = motion_of_slot(w, beads, first, lane, kinks, count)
    ahead = motion_of_slot(w, beads, first + 1, lane, kinks, count)
    motions = behind, ahead, behind, ahead
    if one != two:
        motions = (
            behind,
            ahead,
            motion_of_slot(w, beads, second, lane, kinks, count),
            motion_of_slot(w, beads, second + 1, lane, kinks, count),
        )
    # The largest force at the ends of the parts, and its place; rates there and at both neighbours.
    top, best, before, rate = -1.0, 0, 0.0, 0.0
    rising, falling = 0.0, 0.0
    for part in range(PARTS + 1):
        before = rate
        force, rate = gauge_at(w, one, two, part / PARTS, motions)
        if force > top:
            top, best, rising, falling = force, part, before if part > 0 else rate, rate
        elif part == best + 1:
            falling = rate
    low, high = max(best - 1, 0) / PARTS, min(best + 1, PARTS) / PARTS
    s, side = low if not rising > 0.0 else high, 0
    if rising > 0.0 > falling:
        for _ in range(ITERATIONS):
            # A secant, with the Illinois rule: the rate at an end that remains again is halved.
            s = low + (high - low) * rising / (rising - falling)
            _, rate = gauge_at(w, one, two, s, motions)
            if rate > 0.0:
                low, rising, falling = s, rate, 0.5 * falling if side > 0 else falling
                side = 1
            else:
                high, falling, rising = s, rate, 0.5 * rising if side < 0 else rising
                side = -1
            if high - low < CLOSE or abs(rate) < FLAT * top:
                break
    force, _ = gauge_at(w, one, two, s, motions)
    return force, s


@compiled
def record_largest(w, beads, lane, first, second, start, end, top, state, gauge, kinks, count):
    """Update the largest force of a gauge; ``top`` is the largest at the stages of the step."""
    one, two = first * LANES + lane, second * LANES + lane
    time, h = state[TIME, lane], state[LENGTH, lane]
    turns = top > max(start, end)
    if not turns and end > 0.0:
        turns = gauge_rate(w, one, two, NEW_X, NEW_V) <= 0.0 < gauge_rate(w, one, two, X, V)
    if turns:
        force, s = largest_within(w, beads, lane, first, second, kinks, count)
        if force > gauge[PEAK]:
            gauge[PEAK], gauge[PEAK_TIME] = force, time + s * h
    if end > gauge[PEAK]:
        gauge[PEAK], gauge[PEAK_TIME] = end, time + h


@compiled
def record_fall(end, gauge):
    """Store the largest force so far as a maximum once the force has decreased from it."""
    highest = gauge[PEAK] - gauge[REST]
    if end - gauge[REST] < (1.0 - FALL) * highest and highest > gauge[HIGHEST_FALLEN]:
        gauge[HIGHEST_FALLEN] = highest
        keep_maximum(gauge, highest)


@compiled
def keep_maximum(gauge, highest):
    """Store the largest force as a maximum, and drop maxima that are now too low."""
    kept, count = 0, int(gauge[MAXIMA])
    for i in range(count):
        if gauge[MAXIMUM_0 + 2 * i] - gauge[REST] > MIN_HEIGHT * highest:
            gauge[MAXIMUM_0 + 2 * kept] = gauge[MAXIMUM_0 + 2 * i]
            gauge[MAXIMUM_0 + 2 * kept + 1] = gauge[MAXIMUM_0 + 2 * i + 1]
            kept += 1
    if kept < KEPT_MAXIMA:
        gauge[MAXIMUM_0 + 2 * kept] = gauge[PEAK]
        gauge[MAXIMUM_0 + 2 * kept + 1] = gauge[PEAK_TIME]
        kept += 1
    gauge[MAXIMA] = kept
