r"""Release of a contact that is about to open, and its adjoint.

The force of an opening contact ends like a power p of time, where steps lose their order and
derivatives even more of it.  A contact c that opens after a short time :math:`\sigma` is therefore
removed, and the bead ahead of it, of mass m, receives the rest of its push in closed form.  With
the overlap extrapolated as a cubic in time, and

.. math::

    I = \int_0^\sigma F\,dt, \qquad T = \int_0^\sigma F t\,dt, \qquad
    Q = \int_0^\sigma F t^2/2\,dt,

the velocity of this bead changes by :math:`I/m` and its position by :math:`-T/m`, so that both are
exact from the time on at which the contact opens.  Until then the bead is displaced by
:math:`-\int_t^\sigma F(s)(s - t)\,ds/m`, which changes the impulse of the next contact, of slope
:math:`\kappa`, by :math:`\kappa Q/m`; this impulse is restored.

As a function of :math:`u = 1 - t/\sigma` the overlap is :math:`D u (1 + e_1 u + e_2 u^2)`, and its
powers are series in u.
"""

from __future__ import annotations

import math

from .adjoint_layout import (
    AT_RELEASE,
    AT_REST,
    BY_BODY,
    BY_MASS,
    BY_OVERLAP,
    BY_STIFFNESS,
    EXPONENT,
    INVERSE_MASS,
    LV,
    LX,
    RELEASED_CLOSINGS,
    RELEASED_CONTACT,
    RELEASED_OVERLAPS,
    STIFFNESS,
    V,
    X,
)
from .adjoint_step import compiled
from .elastic_forces import LEAST

# Overlap of a contact that is released.
APART = -1e30
TERMS, ITERATIONS = 6, 5
# Speed at which a contact must open, relative to its present one.
STEADY = 0.3


@compiled
def contact_terms(w, c, d, closing):
    """Force of a contact, its slope, and its rate."""
    if not d > LEAST:
        return 0.0, 0.0, 0.0
    p = w[EXPONENT + c]
    force = w[STIFFNESS + c] * d**p
    slope = p * force / d
    return force, slope, slope * closing


@compiled
def overlap_derivatives(w, given):
    """Second and third derivative of the overlap by time."""
    c = int(given[RELEASED_CONTACT])
    behind, ahead = w[INVERSE_MASS + c - 1], w[INVERSE_MASS + c]
    d2 = d3 = 0.0
    for j in range(3):
        weight = -(behind + ahead) if j == 1 else (behind if j == 0 else ahead)
        force, _, rate = contact_terms(
            w, c - 1 + j, given[RELEASED_OVERLAPS + j], given[RELEASED_CLOSINGS + j]
        )
        d2 += weight * force
        d3 += weight * rate
    return d2, d3


@compiled
def opening_of(d0, d1, d2, d3):
    """Time until an overlap vanishes, its rate then, and the coefficients of its series."""
    square = d1 * d1 - 2.0 * d0 * d2
    left = 2.0 * d0 / (math.sqrt(max(square, 0.0)) - d1)
    for _ in range(ITERATIONS):
        gap = d0 + left * (d1 + left * (d2 / 2.0 + left * d3 / 6.0))
        left -= gap / (d1 + left * (d2 + left * d3 / 2.0))
    opening = -(d1 + left * (d2 + left * d3 / 2.0))
    e1 = (d2 + left * d3) / (2.0 * opening) * left
    e2 = -d3 / (6.0 * opening) * left * left
    return left, opening, e1, e2


@compiled
def moment(p, e1, e2, order):
    r"""The integral of :math:`(u (1 + e_1 u + e_2 u^2))^p (1 - u)^j/j!` from 0 to 1."""
    total, before, term = 0.0, 0.0, 1.0
    for n in range(TERMS):
        weight = 1.0
        for j in range(order + 1):
            weight *= p + n + 1.0 + j
        total += term / weight
        after = ((p - n) * e1 * term + (2.0 * p - n + 1.0) * e2 * before) / (n + 1.0)
        before, term = term, after
    return total


@compiled
def release(w, c, n, out):
    """Release contact c after step n, if it opens steadily; returns whether it has been."""
    out[AT_RELEASE], out[RELEASED_CONTACT] = n, c
    for j in range(3):
        k = c - 1 + j
        out[RELEASED_OVERLAPS + j] = w[AT_REST + k] + (w[X + k] - w[X + k + 1])
        out[RELEASED_CLOSINGS + j] = w[V + k] - w[V + k + 1]
    d2, d3 = overlap_derivatives(w, out)
    d0, d1 = out[RELEASED_OVERLAPS + 1], out[RELEASED_CLOSINGS + 1]
    left, opening, e1, e2 = opening_of(d0, d1, d2, d3)
    if not (opening > -STEADY * d1 and left > 0.0):
        return False
    p, m = w[EXPONENT + c], w[INVERSE_MASS + c]
    scale = w[STIFFNESS + c] * (opening * left) ** p * left
    push = scale * moment(p, e1, e2, 0)
    first = scale * left * moment(p, e1, e2, 1)
    second = scale * left * left * moment(p, e1, e2, 2)
    _, slope, _ = contact_terms(w, c + 1, out[RELEASED_OVERLAPS + 2], 0.0)
    back = slope * second * m
    w[X + c + 1] -= first * m
    w[V + c + 1] += (push - back) * m
    w[V + c + 2] += back * w[INVERSE_MASS + c + 1]
    w[AT_REST + c] = APART
    return True


@compiled
def reverse_release(w, given):
    """Derivatives by the state before a release, from those by the state after it."""
    c = int(given[RELEASED_CONTACT])
    p, k = w[EXPONENT + c], w[STIFFNESS + c]
    behind, m, ahead = w[INVERSE_MASS + c - 1], w[INVERSE_MASS + c], w[INVERSE_MASS + c + 1]
    d2, d3 = overlap_derivatives(w, given)
    d0, d1 = given[RELEASED_OVERLAPS + 1], given[RELEASED_CLOSINGS + 1]
    left, opening, e1, e2 = opening_of(d0, d1, d2, d3)
    depth = opening * left
    scale = k * depth**p * left
    push = scale * moment(p, e1, e2, 0)
    first = scale * left * moment(p, e1, e2, 1)
    second = scale * left * left * moment(p, e1, e2, 2)
    _, slope, _ = contact_terms(w, c + 1, given[RELEASED_OVERLAPS + 2], 0.0)
    # The quantity changes by a I - b T + g Q.
    a, b = w[LV + c] * m, w[LX + c] * m
    per_slope = (w[LV + c + 1] * ahead - a) * m
    g = slope * per_slope
    w[BY_STIFFNESS + c] += (a * push - b * first + g * second) / k
    w[BY_MASS + c] += b * first - a * push - slope * second * (per_slope - a * m)
    w[BY_MASS + c + 1] -= slope * second * w[LV + c + 1] * ahead * m
    m0, m1 = moment(p - 1.0, e1, e2, 0), moment(p - 1.0, e1, e2, 1)
    m2, m3 = moment(p - 1.0, e1, e2, 2), moment(p - 1.0, e1, e2, 3)
    m4, m5 = moment(p - 1.0, e1, e2, 4), moment(p - 1.0, e1, e2, 5)
    scale, once, twice = p * k * depth ** (p - 1.0) * left, b * left, g * left * left
    by_d0 = scale * (a * m0 - once * m1 + twice * m2)
    by_d1 = scale * left * (a * m1 - 2.0 * once * m2 + 3.0 * twice * m3)
    by_d2 = scale * left**2 * (a * m2 - 3.0 * once * m3 + 6.0 * twice * m4)
    by_d3 = scale * left**3 * (a * m3 - 4.0 * once * m4 + 10.0 * twice * m5)
    w[BY_BODY + c - 1] += by_d2 * behind
    w[BY_BODY + c] -= by_d2 * m
    for j in range(3):
        at, d = c - 1 + j, given[RELEASED_OVERLAPS + j]
        closing = given[RELEASED_CLOSINGS + j]
        force, slope, rate = contact_terms(w, at, d, closing)
        weight = -(behind + m) if j == 1 else (behind if j == 0 else m)
        by_overlap = by_closing = 0.0
        if force > 0.0:
            bend = (w[EXPONENT + at] - 1.0) * slope / d
            by_overlap = weight * (by_d2 * slope + by_d3 * bend * closing)
            by_closing = weight * by_d3 * slope
            own = weight * (by_d2 * force + by_d3 * rate)
            if j == 2:
                by_overlap += per_slope * second * bend
                own += per_slope * second * slope
            w[BY_STIFFNESS + at] += own / w[STIFFNESS + at]
            # The forces accelerate the bead behind by one mass, the bead ahead by the other.
            pull = by_d2 * force + by_d3 * rate
            if j < 2:
                w[BY_MASS + c - 1] += (pull if j == 1 else -pull) * behind
            if j > 0:
                w[BY_MASS + c] += (pull if j == 1 else -pull) * m
        if j == 1:
            by_overlap += by_d0
            by_closing += by_d1
        w[BY_OVERLAP + at] += by_overlap
        if at > 0:
            w[LX + at - 1] += by_overlap
            w[LV + at - 1] += by_closing
        w[LX + at] -= by_overlap
        w[LV + at] -= by_closing
