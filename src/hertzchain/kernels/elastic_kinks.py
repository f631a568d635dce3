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
    LANES,
    LENGTH,
    MOST_KINKS,
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
# The screening of contacts by position and velocity allows for this factor in the time.
MARGIN = 2.0
# Kinks whose effect in a step is less than this fraction of the tolerance are ignored; so are
# contacts whose relative velocity changes by more than this factor within the step.
SMALL, GRAZING = 0.1, 4.0
NEWTON = 6
# Kinks are located to this fraction of a step.
CLOSE = 1e-5


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
        rate = w[V + i] - w[V + LANES + i]
        changes = ((d <= 0.0) & (rate > 0.0)) | ((d > 0.0) & (rate < 0.0))
        near = abs(d) < MARGIN * w[H + i] * abs(rate)
        flag = 1.0 if changes & near & (w[STIFFNESS + i] > 0.0) else 0.0
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
def time_of_closing(d, d1, d2, d3, h):
    """Time until an overlap vanishes that grows from a negative value; infinity if unclear."""
    q = -d / d1
    for _ in range(NEWTON):
        rate = d1 + q * (d2 + 0.5 * q * d3)
        if not rate > 0.2 * d1:
            return math.inf
        change = (d + q * (d1 + q * (0.5 * d2 + q * d3 / 6.0))) / rate
        q -= change
        if abs(change) < CLOSE * h:
            break
    return q


@inlined
def time_of_opening(d, d1, a, j, push, h):
    """Time until an overlap vanishes, and its rate then, with accelerations by other forces.

    ``push`` is the acceleration of the overlap by the force of the contact, divided by the power
    3/2 of the overlap.
    """
    rate, q = -d1, -d / d1
    for _ in range(NEWTON):
        root = q * q * math.sqrt(q) * (push * rate * math.sqrt(rate))
        rate = -d1 - q * (a + 0.5 * j * q) + 0.4 * root
        if not rate > -0.05 * d1:
            return math.inf, rate
        old = q
        q = d / (rate + q * (0.5 * a + j * q / 3.0) - root / 8.75)
        if not q > 0.0:
            return math.inf, rate
        if abs(q - old) < CLOSE * h:
            break
    return q, rate


@compiled
def predict(w, beads, at, h, rtol, kink):
    """Find when a contact opens or closes; return whether the kink is worth subtracting."""
    left = w[INVERSE_MASS + at - LANES] if at >= LANES else 0.0
    right = w[INVERSE_MASS + at] if at < beads * LANES else 0.0
    d, d1, push = overlap_of(w, at), closing_of(w, at), w[STIFFNESS + at] * (left + right)
    unit = max(w[SCALE + at - LANES] if left > 0.0 else 0.0, w[SCALE + at] if right > 0.0 else 0.0)
    reach = h if d <= 0.0 else h * (1.0 + NEAR_STEP)
    distance = abs(d1) * reach
    if push * distance * math.sqrt(distance) * reach < SMALL * rtol * unit:
        return False
    own = rate_of(w, at)
    d2, d3 = 0.0, 0.0
    if left > 0.0:
        d2 += w[F0 + at - LANES]
        d3 += (rate_of(w, at - LANES) - own) * left
    if right > 0.0:
        d2 -= w[F0 + at]
        d3 -= (own - rate_of(w, at + LANES)) * right
    if d <= 0.0:
        q = time_of_closing(d, d1, d2, d3, h)
        sign, rate, a = 1.0, d1 + q * (d2 + 0.5 * q * d3), d2 + q * d3
    else:
        j = d3 + (left + right) * own
        d2 += push * d * math.sqrt(d)
        q, rate = time_of_opening(d, d1, d2, j, push, h)
        sign, a = -1.0, d2 + j * q
    if not 0.0 <= q < reach or abs(a) * (h + q) > GRAZING * rate:
        return False
    kink[KINK_AT], kink[KINK_SIGN], kink[KINK_Q] = at, sign, -sign * q
    kink[KINK_A] = w[STIFFNESS + at] * rate * math.sqrt(rate)
    kink[KINK_B] = 0.75 * kink[KINK_A] * a / rate
    kink[KINK_LEFT], kink[KINK_RIGHT] = left, right
    return True


@inlined
def node(a, b, q):
    """`terms` and `terms_twice` at a time."""
    q = q if q > 0.0 else 0.0
    root = q * math.sqrt(q)
    return root * (a + q * b), q * q * root * (a / 8.75 + q * (b / 15.75))


@compiled
def set_shifts(kink, h):
    """Compute the defects of the stages, of the end of the step and of its error."""
    q, turn, a, b = kink[KINK_Q], kink[KINK_SIGN] * h, kink[KINK_A], kink[KINK_B]
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
    f7 = A7[0] * p0 + A7[1] * p1 + A7[2] * p2 + A7[3] * p3 + A7[4] * p4 + A7[5] * p5 + A7[6] * p6
    kink[KINK_SHIFT + 1] = hh * f1 - (s1 - start - C1 * rate)
    kink[KINK_SHIFT + 2] = hh * f2 - (s2 - start - C2 * rate)
    kink[KINK_SHIFT + 3] = hh * f3 - (s3 - start - C3 * rate)
    kink[KINK_SHIFT + 4] = hh * f4 - (s4 - start - C4 * rate)
    kink[KINK_SHIFT + 5] = hh * f5 - (s5 - start - C5 * rate)
    kink[KINK_SHIFT + 6] = hh * f6 - (s6 - start - C6 * rate)
    kink[KINK_SHIFT + 7] = hh * f7 - (s7 - start - rate)
    x = B0 * p0 + B2 * p2 + B3 * p3 + B4 * p4 + B5 * p5 + B6 * p6
    v = V0 * (p0 + p7) + V2 * (p2 + p6) + V3 * (p3 + p5) + V4 * p4
    kink[KINK_SHIFT_X] = hh * x - (s7 - start - rate)
    kink[KINK_SHIFT_V] = h * v - kink[KINK_SIGN] * (terms_once(a, b, q + turn) - once)
    error = E0 * p0 + E2 * p2 + E3 * p3 + E4 * p4 + E5 * p5 + E6 * p6
    kink[KINK_ERROR] = error + (E7 + E8) * p7


@compiled
def find_kinks(w, beads, rtol, which, state, kinks, count):
    """Kinks of the coming step: earlier closings and predicted events; return their number."""
    kept = 0
    for n in range(count):
        kink = kinks[n]
        at = int(kink[KINK_AT])
        lane = at % LANES
        since = kink[KINK_Q]
        if which[lane] < 0 or kink[KINK_SIGN] < 0.0 or since < 0.0:
            continue
        if since > NEAR_STEP * state[LENGTH, lane] or not overlap_of(w, at) > 0.0:
            continue
        if kept < n:
            for row in range(KINK_SHIFT):
                kinks[kept, row] = kink[row]
        kept += 1
    if screen(w, beads) > 0.0:
        for c in range(beads + 1):
            marks = 0.0
            for lane in range(LANES):
                marks += w[FLAG + c * LANES + lane]
            if marks == 0.0:
                continue
            for lane in range(LANES):
                at = c * LANES + lane
                if w[FLAG + at] > 0.0 and kept < MOST_KINKS:
                    if predict(w, beads, at, state[LENGTH, lane], rtol, kinks[kept]):
                        kept += 1
    for n in range(kept):
        set_shifts(kinks[n], state[LENGTH, int(kinks[n, KINK_AT]) % LANES])
    return kept


@compiled
def shift(w, row, kinks, count, entry):
    """Add the defects to the positions at a stage, or to other values at the ends of contacts."""
    for n in range(count):
        at = int(kinks[n, KINK_AT])
        w[row + at] += kinks[n, KINK_LEFT] * kinks[n, entry]
        w[row + LANES + at] -= kinks[n, KINK_RIGHT] * kinks[n, entry]


@compiled
def pass_step(kinks, count, state):
    """Move the times of kinks to the start of the next step."""
    for n in range(count):
        lane = int(kinks[n, KINK_AT]) % LANES
        if state[GOOD, lane] > 0.0:
            kinks[n, KINK_Q] += kinks[n, KINK_SIGN] * state[LENGTH, lane]


@compiled
def drop_kinks(lane, kinks, count):
    """Forget the kinks of a lane."""
    for n in range(count):
        if int(kinks[n, KINK_AT]) % LANES == lane:
            kinks[n, KINK_SIGN] = -1.0


@compiled
def touches(kinks, count, slot):
    """Whether a bead has a contact with a kink."""
    for n in range(count):
        at = int(kinks[n, KINK_AT])
        if at == slot or at == slot - LANES:
            return True
    return False


@compiled
def kink_motion(kinks, count, slot, t):
    """Motion of a bead at a time in a step that the subtracted forces cause, and derivatives."""
    x, v, a, j = 0.0, 0.0, 0.0, 0.0
    for n in range(count):
        kink = kinks[n]
        at = int(kink[KINK_AT])
        if at == slot:
            mass = -kink[KINK_LEFT]
        elif at == slot - LANES:
            mass = kink[KINK_RIGHT]
        else:
            continue
        sign, start, one, two = kink[KINK_SIGN], kink[KINK_Q], kink[KINK_A], kink[KINK_B]
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
        at = int(kinks[n, KINK_AT])
        if at == one * LANES + lane:
            s += 0.5 * kinks[n, KINK_SHIFT_V]
        if at == two * LANES + lane:
            s += 0.5 * kinks[n, KINK_SHIFT_V]
    return s
