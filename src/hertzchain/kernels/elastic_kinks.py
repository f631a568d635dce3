r"""Contacts that open or close within a step, treated by subtraction.

Where a Hertz contact opens or closes, its force has a kink: with the time :math:`q` since the
closing, or until the opening,

.. math:: F = k v^{3/2} q^{3/2} \left[ 1 + \tfrac34 \tfrac{a}{v} q
    + \left( \tfrac14 \tfrac{j}{v} + \tfrac3{32} \tfrac{a^2}{v^2} \right) q^2 + \dots \right] ,

where :math:`v`, :math:`a` and :math:`j` are the derivatives of the overlap at :math:`q = 0` without
this force.  A method of order 8 resolves the kink only by very short steps.  Therefore these three
terms are subtracted from the force, the method integrates the rest, and the motion :math:`S` that
the terms cause is added in closed form.  As the terms depend on time only, this is the same as a
shift of the positions at the stages by the defect :math:`D_s` of the method for them,

.. math:: D_s = h^2 \sum_j a_{sj} P(q_j) - S(c_s h) , \qquad S'' = P .

The method remains of the same order for any values of the coefficients; good values make the rest
smooth.
"""

from __future__ import annotations

import math

from .compilation import CONTRACTED, compiled, internal
from .elastic_forces import closing_of, overlap_of
from .elastic_layout import (
    AT_REST,
    F0,
    FLAG,
    FOUND,
    FOUND_A,
    FOUND_D,
    FOUND_J,
    FOUND_PUSH,
    FOUND_RATE,
    FOUND_REACH,
    FOUND_STIFFNESS,
    FOUND_UNIT,
    GOOD,
    INVERSE_MASS,
    KINK_A,
    KINK_AT,
    KINK_B,
    KINK_ERROR,
    KINK_LEFT,
    KINK_Q,
    KINK_RIGHT,
    KINK_SHIFT,
    KINK_SHIFT_V,
    KINK_SHIFT_X,
    KINK_SIGN,
    KINK_STEP,
    LANES,
    LENGTH,
    LINE,
    MAX_KINKS,
    SCALE,
    STIFFNESS,
    H,
    V,
    X,
)
from .rkn8 import A1, A2, A3, A4, A5, A6, A7, C1, C2, C3, C4, C5, C6
from .rkn8_stages import B0, B2, B3, B4, B5, B6, E0, E2, E3, E4, E5, E6, E7, E8, V0, V2, V3, V4

inlined = internal(forceinline=True, **CONTRACTED)
summing = internal(forceinline=True, **(CONTRACTED | {"fastmath": True}))

# Openings are subtracted if they are less than this part of a step after its end, closings if they
# are less than this part of a step before its start.
NEAR_STEP = 0.4
# The screening of contacts by position, velocity and acceleration allows for this factor.
MARGIN = 1.1
# Kinks whose effect in a step is less than this fraction of the tolerance are ignored; so are
# contacts whose relative velocity changes by more than this factor within the step.
SMALL, GRAZING = 0.1, 4.0
# So are contacts whose relative velocity falls to less than this fraction before the kink.
SLOWED = 0.1


@inlined
def terms(a, b, q):
    """Terms of the force at a time q after closing, or before opening."""
    q = q if q > 0.0 else 0.0
    return q * math.sqrt(q) * (a + q * b)


@inlined
def terms_once(a, b, q):
    """Integral of `terms`."""
    q = q if q > 0.0 else 0.0
    return q * q * math.sqrt(q) * (a / 2.5 + q * (b / 3.5))


@inlined
def terms_twice(a, b, q):
    """Integral of `terms_once`."""
    q = q if q > 0.0 else 0.0
    return q * q * q * math.sqrt(q) * (a / 8.75 + q * (b / 15.75))


@inlined
def terms_rate(a, b, q):
    """Derivative of `terms`."""
    q = q if q > 0.0 else 0.0
    return math.sqrt(q) * (1.5 * a + q * (2.5 * b))


@summing
def screen(w, beads):
    """Mark contacts that may open or close in a step or soon after it; return their number."""
    s = 0.0
    for i in range((beads + 1) * LANES):
        d = w[AT_REST + i] + (w[X + i] - w[X + LANES + i])
        sign = -1.0 if d > 0.0 else 1.0
        rate = sign * (w[V + i] - w[V + LANES + i])
        # Entries before the first bead and after the last one are 0.
        a = sign * (w[F0 - LANES + i] - w[F0 + i])
        h = w[H + i] * (1.0 + NEAR_STEP if d > 0.0 else 1.0)
        reach = h * (MARGIN * rate + 0.5 * h * (a if a > 0.0 else 0.0))
        near = (rate > 0.0) & (abs(d) < reach) & (w[STIFFNESS + i] > 0.0)
        flag = 1.0 if near else 0.0
        w[FLAG + i] = flag
        s += flag
    return s


@inlined
def rate_of(w, at):
    """Rate of the force of a Hertz contact."""
    d = overlap_of(w, at)
    d = d if d > 0.0 else 0.0
    return 1.5 * w[STIFFNESS + at] * math.sqrt(d) * closing_of(w, at)


@inlined
def describe(w, beads, at, kinks, n):
    """Write the motion of a contact that may open or close to entry n of the kinks."""
    h, d = w[H + at], overlap_of(w, at)
    left = w[INVERSE_MASS + at - LANES] if at >= LANES else 0.0
    right = w[INVERSE_MASS + at] if at < beads * LANES else 0.0
    push, unit, d2, d3 = w[STIFFNESS + at] * (left + right), 0.0, 0.0, 0.0
    if left > 0.0:
        unit = w[SCALE + at - LANES]
        d2 += w[F0 + at - LANES]
        d3 += rate_of(w, at - LANES) * left
    if right > 0.0:
        unit = max(unit, w[SCALE + at])
        d2 -= w[F0 + at]
        d3 += rate_of(w, at + LANES) * right
    closed = d if d > 0.0 else 0.0
    sign = -1.0 if d > 0.0 else 1.0
    kinks[FOUND + KINK_AT + n], kinks[FOUND + KINK_SIGN + n] = at, sign
    kinks[FOUND + KINK_STEP + n] = h
    kinks[FOUND + KINK_LEFT + n], kinks[FOUND + KINK_RIGHT + n] = left, right
    kinks[FOUND_D + n], kinks[FOUND_RATE + n] = -sign * d, sign * closing_of(w, at)
    kinks[FOUND_A + n] = sign * (d2 + push * closed * math.sqrt(closed))
    kinks[FOUND_J + n], kinks[FOUND_PUSH + n] = sign * d3, push
    kinks[FOUND_STIFFNESS + n], kinks[FOUND_UNIT + n] = w[STIFFNESS + at], unit
    kinks[FOUND_REACH + n] = h * (1.0 + NEAR_STEP) if d > 0.0 else h


@inlined
def improve(q, end, d, rate, a, j, push):
    """Improve the time q until a distance vanishes, and its rate ``end`` then, by Newton's method.

    ``push`` is the acceleration by the force of the contact, divided by the power 3/2 of the
    overlap.
    """
    root = q * q * math.sqrt(q) * (push * end * math.sqrt(end))
    end = rate + q * (a + 0.5 * j * q) + 0.4 * root
    passed = q * (end - q * (0.5 * a + j * q / 3.0) - root / 8.75)
    return q - (passed - d) / end, end


@inlined
def whole_lines(count):
    """Smallest number of entries that fill cache lines; the compiler needs it to use vectors."""
    return (count + LINE - 1) // LINE * LINE


@compiled
def predict(kinks, count, rtol):
    """Find when contacts open or close; the sign of kinks not worth subtracting becomes 0."""
    for n in range(whole_lines(count)):
        sign, h = kinks[FOUND + KINK_SIGN + n], kinks[FOUND + KINK_STEP + n]
        d, rate, a, j = (
            kinks[FOUND_D + n], kinks[FOUND_RATE + n], kinks[FOUND_A + n], kinks[FOUND_J + n]
        )  # fmt: skip
        push, reach = kinks[FOUND_PUSH + n], kinks[FOUND_REACH + n]
        distance = rate * reach
        effect = push * distance * math.sqrt(distance) * reach
        push = push if sign < 0.0 else 0.0
        q, end = improve(d / rate, rate, d, rate, a, j, push)
        q, end = improve(q, end, d, rate, a, j, push)
        q, end = improve(q, end, d, rate, a, j, push)
        q, end = improve(q, end, d, rate, a, j, push)
        a = a + j * q
        good = (q >= 0.0) & (q < reach) & (end > SLOWED * rate)
        good = good & (abs(a) * (h + q) < GRAZING * end)
        good = good & (effect > SMALL * rtol * kinks[FOUND_UNIT + n])
        kinks[FOUND + KINK_SIGN + n] = sign if good else 0.0
        kinks[FOUND + KINK_Q + n] = -sign * q
        strength = kinks[FOUND_STIFFNESS + n] * end * math.sqrt(end)
        kinks[FOUND + KINK_A + n] = strength
        kinks[FOUND + KINK_B + n] = 0.75 * strength * sign * a / end


@inlined
def node(a, b, q):
    """`terms` and `terms_twice` at a time."""
    q = q if q > 0.0 else 0.0
    root = q * math.sqrt(q)
    return root * (a + q * b), q * q * root * (a / 8.75 + q * (b / 15.75))


@compiled
def set_shifts(kinks, count):
    """Compute the defects of the stages, of the end of the step and of its error."""
    for n in range(whole_lines(count)):
        h, sign, q = kinks[KINK_STEP + n], kinks[KINK_SIGN + n], kinks[KINK_Q + n]
        turn, a, b = sign * h, kinks[KINK_A + n], kinks[KINK_B + n]
        p0, start = node(a, b, q)
        p1, s1 = node(a, b, q + C1 * turn)
        p2, s2 = node(a, b, q + C2 * turn)
        p3, s3 = node(a, b, q + C3 * turn)
        p4, s4 = node(a, b, q + C4 * turn)
        p5, s5 = node(a, b, q + C5 * turn)
        p6, s6 = node(a, b, q + C6 * turn)
        p7, s7 = node(a, b, q + turn)
        once = terms_once(a, b, q)
        rate, hh = once * turn, h * h
        f1 = A1[0] * p0
        f2 = A2[0] * p0 + A2[1] * p1
        f3 = A3[0] * p0 + A3[1] * p1 + A3[2] * p2
        f4 = A4[0] * p0 + A4[1] * p1 + A4[2] * p2 + A4[3] * p3
        f5 = A5[0] * p0 + A5[1] * p1 + A5[2] * p2 + A5[3] * p3 + A5[4] * p4
        f6 = A6[0] * p0 + A6[1] * p1 + A6[2] * p2 + A6[3] * p3 + A6[4] * p4 + A6[5] * p5
        f7 = A7[0] * p0 + A7[1] * p1 + A7[2] * p2 + A7[3] * p3 + A7[4] * p4 + A7[5] * p5
        f7 += A7[6] * p6
        kinks[KINK_SHIFT + 1 * MAX_KINKS + n] = hh * f1 - (s1 - start - C1 * rate)
        kinks[KINK_SHIFT + 2 * MAX_KINKS + n] = hh * f2 - (s2 - start - C2 * rate)
        kinks[KINK_SHIFT + 3 * MAX_KINKS + n] = hh * f3 - (s3 - start - C3 * rate)
        kinks[KINK_SHIFT + 4 * MAX_KINKS + n] = hh * f4 - (s4 - start - C4 * rate)
        kinks[KINK_SHIFT + 5 * MAX_KINKS + n] = hh * f5 - (s5 - start - C5 * rate)
        kinks[KINK_SHIFT + 6 * MAX_KINKS + n] = hh * f6 - (s6 - start - C6 * rate)
        kinks[KINK_SHIFT + 7 * MAX_KINKS + n] = hh * f7 - (s7 - start - rate)
        x = B0 * p0 + B2 * p2 + B3 * p3 + B4 * p4 + B5 * p5 + B6 * p6
        v = V0 * (p0 + p7) + V2 * (p2 + p6) + V3 * (p3 + p5) + V4 * p4
        kinks[KINK_SHIFT_X + n] = hh * x - (s7 - start - rate)
        kinks[KINK_SHIFT_V + n] = h * v - sign * (terms_once(a, b, q + turn) - once)
        error = E0 * p0 + E2 * p2 + E3 * p3 + E4 * p4 + E5 * p5 + E6 * p6
        kinks[KINK_ERROR + n] = error + (E7 + E8) * p7


@inlined
def copy_kink(kinks, n, to):
    """Copy a kink without its defects; both places are entries of row 0."""
    for row in range(0, KINK_SHIFT, MAX_KINKS):
        kinks[row + to] = kinks[row + n]


@compiled
def earlier_kinks(w, which, state, kinks, count):
    """Keep recent closings, whose kinks still matter; return their number."""
    kept = 0
    for n in range(count):
        at = int(kinks[KINK_AT + n])
        lane, since = at % LANES, kinks[KINK_Q + n]
        if which[lane] < 0 or kinks[KINK_SIGN + n] <= 0.0 or since < 0.0:
            continue
        if since > NEAR_STEP * state[LENGTH, lane] or not overlap_of(w, at) > 0.0:
            continue
        copy_kink(kinks, n, kept)
        kinks[KINK_STEP + kept] = state[LENGTH, lane]
        kept += 1
    return kept


@compiled
def keep_found(kinks, found, count, rtol):
    """Keep the kinks worth subtracting of the contacts found; return the number of all kinks."""
    predict(kinks, found, rtol)
    for n in range(found):
        if kinks[FOUND + KINK_SIGN + n] != 0.0 and count < MAX_KINKS:
            copy_kink(kinks, FOUND + n, count)
            count += 1
    return count


@compiled
def find_kinks(w, beads, rtol, which, state, kinks, count):
    """Kinks of the coming step: earlier closings and predicted events; return their number."""
    count, found = earlier_kinks(w, which, state, kinks, count), 0
    if screen(w, beads) > 0.0:
        for at in range((beads + 1) * LANES):
            if w[FLAG + at] > 0.0:
                describe(w, beads, at, kinks, found)
                found += 1
                if found == MAX_KINKS:
                    count, found = keep_found(kinks, found, count, rtol), 0
        count = keep_found(kinks, found, count, rtol)
    set_shifts(kinks, count)
    return count


@compiled
def shift(w, row, kinks, count, entry):
    """Add the defects to the positions at a stage, or to other values at the ends of contacts."""
    for n in range(count):
        at = int(kinks[KINK_AT + n])
        w[row + at] += kinks[KINK_LEFT + n] * kinks[entry + n]
        w[row + LANES + at] -= kinks[KINK_RIGHT + n] * kinks[entry + n]


@compiled
def pass_step(kinks, count, state):
    """Move the times of kinks to the start of the next step."""
    for n in range(count):
        lane = int(kinks[KINK_AT + n]) % LANES
        if state[GOOD, lane] > 0.0:
            kinks[KINK_Q + n] += kinks[KINK_SIGN + n] * state[LENGTH, lane]


@compiled
def drop_kinks(lane, kinks, count):
    """Forget the kinks of a lane."""
    for n in range(count):
        if int(kinks[KINK_AT + n]) % LANES == lane:
            kinks[KINK_SIGN + n] = -1.0


@compiled
def touches(kinks, count, slot):
    """Whether a bead has a contact with a kink."""
    for n in range(count):
        at = int(kinks[KINK_AT + n])
        if at == slot or at == slot - LANES:
            return True
    return False


@compiled
def kink_motion(kinks, count, slot, t):
    """Motion of a bead at a time in a step that the subtracted forces cause, and derivatives."""
    x, v, a, j = 0.0, 0.0, 0.0, 0.0
    for n in range(count):
        at = int(kinks[KINK_AT + n])
        if at == slot:
            mass = -kinks[KINK_LEFT + n]
        elif at == slot - LANES:
            mass = kinks[KINK_RIGHT + n]
        else:
            continue
        sign, start = kinks[KINK_SIGN + n], kinks[KINK_Q + n]
        one, two = kinks[KINK_A + n], kinks[KINK_B + n]
        q, rate = start + sign * t, sign * terms_once(one, two, start)
        x += mass * (terms_twice(one, two, q) - terms_twice(one, two, start) - t * rate)
        v += mass * (sign * terms_once(one, two, q) - rate)
        a += mass * terms(one, two, q)
        j += mass * sign * terms_rate(one, two, q)
    return x, v, a, j


@compiled
def impulse_defect(one, two, lane, kinks, count):
    """Defect of the impulse of a gauge, the mean of two contacts, in a step."""
    s = 0.0
    for n in range(count):
        at = int(kinks[KINK_AT + n])
        if at == one * LANES + lane:
            s += 0.5 * kinks[KINK_SHIFT_V + n]
        if at == two * LANES + lane:
            s += 0.5 * kinks[KINK_SHIFT_V + n]
    return s
