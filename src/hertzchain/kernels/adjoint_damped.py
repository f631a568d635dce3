r"""Steps of a chain with damped contacts, and their discrete adjoint.

.. math:: F_c = k_c d_c^{p_c} + g_c d_c^{q_c} d_c' ,

which is replaced by zero where it is negative, unless the contact may pull.  The damping force has
an infinite slope where a contact closes if q < 1, and jumps there if q = 0; the derivatives of a
step across such a point would be wrong.  However, the damping force is the rate of change of the
impulse :math:`J_c = g_c d_c^{q_c+1}/(q_c+1)`.  The state therefore consists of the positions and of

.. math::

    u_i = v_i - (J_{i-1} - J_i)/m_i, \qquad
    m_i u_i' = P_{i-1} - P_i, \qquad P_c = F_c - J_c' ,

where P is the elastic force.  The derivatives of the right-hand sides are then continuous, except
for jumps without an impulse if q = 0.  The impulse of a contact is the integral of P plus the
change of J.  Where the force is cut off, :math:`P = -J'` until the end of the step; the contact is
then *released*: its impulse J is removed from u, so that P = F until the contact opens.

The method is DOP853.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from .adjoint_layout import (
    AT_REST,
    BODY,
    BY_BODY,
    BY_DAMPING,
    BY_MASS,
    BY_OVERLAP,
    BY_STIFFNESS,
    DAMPING,
    END_A,
    EXPONENT,
    F0,
    F8,
    FACTOR,
    FORCE,
    IMPULSE,
    INVERSE_MASS,
    KEPT_CLOSINGS,
    KEPT_RELEASED,
    KEPT_SWITCHES,
    LV,
    LX,
    NEW_P,
    NEW_V,
    NEW_X,
    OVERLAP_POWER,
    PULLS,
    PUSH,
    RATE,
    RELEASED,
    ROW,
    SPARE,
    STAGE_A,
    STAGE_V,
    STIFFNESS,
    TRANSFER,
    TRIAL,
    TRIAL_P,
    TRIAL_V,
    WORK,
    ZV,
    ZX,
    P,
    U,
    V,
    X,
)
from .compilation import CONTRACTED, internal
from .dop853 import E3, E5, STEP_STAGES, A, B
from .elastic_forces import LEAST
from .powers import power

# Largest fraction of a step that may follow the release of a contact within the step.
AFTER_RELEASE = 0.01

entry_point = njit(**CONTRACTED)
compiled = internal(**CONTRACTED)
inlined = internal(forceinline=True, **CONTRACTED)

WEIGHTS = np.ascontiguousarray(A[:STEP_STAGES, :STEP_STAGES])
STEP_WEIGHTS, THIRD, FIFTH = np.array(B), np.array(E3), np.array(E5)


@inlined
def overlap_of(w, c, at):
    """Overlap of a contact, 0 if it is open."""
    d = w[AT_REST + c] + (w[at + c] - w[at + c + 1])
    return d if d > LEAST else 0.0


@inlined
def parts_of(w, c, d, closing):
    """Powers d^p and d^q of the overlap, the force, and whether the force acts or is cut off."""
    raised = power(d, w[EXPONENT + c])
    weight = power(d, w[OVERLAP_POWER + c])
    force = w[STIFFNESS + c] * raised + w[DAMPING + c] * weight * closing
    acts = (d > 0.0) & ((force > 0.0) | (w[PULLS + c] > 0.0))
    return raised, weight, force, acts


@inlined
def impulse_of(w, c, d):
    """Impulse J of the damping since a contact closed; 0 if the contact is released."""
    whole = w[DAMPING + c] * d * power(d, w[OVERLAP_POWER + c]) / (w[OVERLAP_POWER + c] + 1.0)
    return (1.0 - w[RELEASED + c]) * whole


@compiled
def damped_forces(w, low, high, at, moving, out, overlaps, closings):
    """Accelerations in row ``out`` at the positions and velocities in two rows."""
    for c in range(low, high + 1):
        d = overlap_of(w, c, at)
        closing = w[moving + c] - w[moving + c + 1]
        overlaps[c], closings[c] = d, closing
        _, _, force, acts = parts_of(w, c, d, closing)
        w[FORCE + c] = force if acts else 0.0
    for i in range(low, high):
        w[out + i] = (w[FORCE + i] - w[FORCE + i + 1]) * w[INVERSE_MASS + i] + w[BODY + i]


@compiled
def rates_of(w, low, high, at, reduced, moving, out, overlaps, closings):
    """Velocities in row ``moving`` and rates of u in row ``out``, from positions and u."""
    for c in range(low, high + 1):
        overlaps[c] = overlap_of(w, c, at)
        w[IMPULSE + c] = impulse_of(w, c, overlaps[c])
    for i in range(low, high):
        change = (w[IMPULSE + i] - w[IMPULSE + i + 1]) * w[INVERSE_MASS + i]
        w[moving + 1 + i] = w[reduced + 1 + i] + change
    for c in range(low, high + 1):
        d, closing = overlaps[c], w[moving + c] - w[moving + c + 1]
        closings[c] = closing
        raised, weight, force, acts = parts_of(w, c, d, closing)
        elastic, taken = w[STIFFNESS + c] * raised, w[DAMPING + c] * weight * closing
        free = w[RELEASED + c] > 0.0
        with_impulse = elastic if acts else -taken
        w[PUSH + c] = (force if acts else 0.0) if free else with_impulse
        w[FORCE + c] = force if acts else 0.0
    for i in range(low, high):
        w[out + i] = (w[PUSH + i] - w[PUSH + i + 1]) * w[INVERSE_MASS + i] + w[BODY + i]


@compiled
def set_reduced(w, low, high):
    """Row P, the u of the state, from positions and velocities."""
    for c in range(low, high + 1):
        w[IMPULSE + c] = impulse_of(w, c, overlap_of(w, c, X))
    for i in range(low, high):
        change = (w[IMPULSE + i] - w[IMPULSE + i + 1]) * w[INVERSE_MASS + i]
        w[P + 1 + i] = w[V + 1 + i] - change


@entry_point
def release(w, low, high, switches):
    """Release contacts whose force is cut off, end the release of others, and update row P."""
    for c in range(low, high + 1):
        d = overlap_of(w, c, X)
        _, _, _, acts = parts_of(w, c, d, w[V + c] - w[V + c + 1])
        free = 1.0 if d > 0.0 and not acts else 0.0
        switches[c] = (free - w[RELEASED + c]) * d
        w[RELEASED + c] = free
    set_reduced(w, low, high)


@compiled
def part_before_release(w, low, high):
    """Fraction of a step after which a contact is released; 2 if none is, or only at its end.

    The rates have a kink there, so that a step across it would rarely satisfy the tolerance.  When
    the contact opens, P has an infinite slope; a step must end between these two times.
    """
    part = 2.0
    for c in range(low, high + 1):
        if w[PULLS + c] > 0.0 or w[RELEASED + c] > 0.0:
            continue
        _, _, first, acts = parts_of(w, c, overlap_of(w, c, X), w[V + c] - w[V + c + 1])
        if not acts:
            continue
        d = overlap_of(w, c, NEW_X)
        _, _, last, _ = parts_of(w, c, d, w[NEW_V + c] - w[NEW_V + c + 1])
        if d == 0.0:
            part = min(part, 0.5)
        elif -last > AFTER_RELEASE * (first - last):
            part = min(part, max(0.1, first / (first - last) * (1.0 + 0.5 * AFTER_RELEASE)))
    return part


@compiled
def add_up(w, low, high, h, at, stages, weights, count, out):
    """Positions or velocities at a stage, or at the end of a step."""
    for i in range(low, high):
        w[WORK + i] = 0.0
    for s in range(count):
        a, stage = weights[s], stages + s * ROW
        if a != 0.0:
            for i in range(low, high):
                w[WORK + i] += a * w[stage + i]
    for i in range(low, high):
        w[out + 1 + i] = w[at + 1 + i] + h * w[WORK + i]


@compiled
def damped_step(w, low, high, h, kept, last):
    """All stages of a step; ``last`` receives the overlaps at its end."""
    for s in range(STEP_STAGES):
        add_up(w, low, high, h, X, STAGE_V, WEIGHTS[s], s, TRIAL)
        add_up(w, low, high, h, P, STAGE_A, WEIGHTS[s], s, TRIAL_P)
        rates_of(w, low, high, TRIAL, TRIAL_P, TRIAL_V, STAGE_A + s * ROW, kept[s],
                 kept[KEPT_CLOSINGS + s])  # fmt: skip
        for i in range(low, high):
            w[STAGE_V + s * ROW + i] = w[TRIAL_V + 1 + i]
        if s == 0:
            for i in range(low, high):
                w[F0 + i] = (w[FORCE + i] - w[FORCE + i + 1]) * w[INVERSE_MASS + i] + w[BODY + i]
    for c in range(low, high + 1):
        kept[KEPT_RELEASED, c], kept[KEPT_SWITCHES, c] = w[RELEASED + c], 0.0
    add_up(w, low, high, h, X, STAGE_V, STEP_WEIGHTS, STEP_STAGES, NEW_X)
    add_up(w, low, high, h, P, STAGE_A, STEP_WEIGHTS, STEP_STAGES, NEW_P)
    rates_of(w, low, high, NEW_X, NEW_P, NEW_V, END_A, last, w[SPARE : SPARE + ROW])
    for i in range(low, high):
        w[F8 + i] = (w[FORCE + i] - w[FORCE + i + 1]) * w[INVERSE_MASS + i] + w[BODY + i]


@inlined
def estimated_error(w, i, stages, at_end):
    """Error estimate of DOP853 for one bead, divided by the step, from the rates at the stages."""
    third, fifth = THIRD[STEP_STAGES] * w[at_end + i], FIFTH[STEP_STAGES] * w[at_end + i]
    for s in range(STEP_STAGES):
        rate = w[stages + s * ROW + i]
        third += THIRD[s] * rate
        fifth += FIFTH[s] * rate
    size = math.sqrt(fifth * fifth + 0.01 * third * third)
    return fifth * fifth / size if size > 0.0 else 0.0


@compiled
def damped_errors(w, low, high, h, scale):
    """Write the error of each bead, in units of its scale, to row WORK.

    Row RATE converts errors of positions to errors of velocities.
    """
    for i in range(low, high):
        change = estimated_error(w, i, STAGE_A, END_A)
        moved = w[RATE + i] * estimated_error(w, i, STAGE_V, NEW_V + 1)
        w[WORK + i] = abs(h) * max(change, moved) / w[scale + i]


@compiled
def damped_rate(w, c, beads, at, moving, accelerations):
    """Rate of a contact's force at a state."""
    d = w[AT_REST + c] + (w[at + c] - w[at + c + 1])
    if not d > LEAST:
        return 0.0
    closing = w[moving + c] - w[moving + c + 1]
    raised, weight, _, acts = parts_of(w, c, d, closing)
    if not acts:
        return 0.0
    damping = w[DAMPING + c] * weight
    slope = w[EXPONENT + c] * w[STIFFNESS + c] * raised / d
    slope += w[OVERLAP_POWER + c] * damping / d * closing
    behind = w[accelerations + c - 1] if c > 0 else 0.0
    ahead = w[accelerations + c] if c < beads else 0.0
    return slope * closing + damping * (behind - ahead)


@compiled
def derive_forces(w, low, high, overlaps, closings, gauge, weight):
    """Compute the derivatives with respect to overlaps and closing speeds from row U.

    They are written to TRANSFER and SPARE, and the forces P to FACTOR.  Contributions are added to
    the derivatives with respect to stiffness and damping.
    """
    w[U + low] = w[U + high + 1] = 0.0
    for c in range(low, high + 1):
        d, closing = overlaps[c], closings[c]
        raised, weighted, force, acts = parts_of(w, c, d, closing)
        inverse = 1.0 / (d if d > 0.0 else 1.0)
        taken = w[DAMPING + c] * weighted
        elastic = w[STIFFNESS + c] * raised
        slope = w[EXPONENT + c] * elastic * inverse
        bend = w[OVERLAP_POWER + c] * taken * inverse * closing
        acting, joined = (1.0 if acts else 0.0), 1.0 - w[RELEASED + c]
        share = w[U + c + 1] - w[U + c] + weight * gauge[c]
        whole = acting * share
        damped = whole - joined * share
        w[TRANSFER + c] = whole * slope + damped * bend
        w[SPARE + c] = damped * taken
        w[FACTOR + c] = acting * force - joined * taken * closing
        w[BY_STIFFNESS + c] += whole * raised
        w[BY_DAMPING + c] += damped * weighted * closing


@compiled
def derive_damped(w, low, high, by_place, by_reduced, overlaps, closings, gauge, weight):
    """Compute the adjoint rows of a stage from row U.

    On entry, row ``by_reduced`` has the derivatives with respect to velocities.
    """
    derive_forces(w, low, high, overlaps, closings, gauge, weight)
    for i in range(low, high):
        w[BY_MASS + i] -= w[U + 1 + i] * (w[FACTOR + i] - w[FACTOR + i + 1])
        w[BY_BODY + i] += w[U + 1 + i]
        w[by_reduced + i] += w[SPARE + i + 1] - w[SPARE + i]
        w[U + 1 + i] = w[by_reduced + i] * w[INVERSE_MASS + i]
    for c in range(low, high + 1):
        d, q = overlaps[c], w[OVERLAP_POWER + c]
        weighted = power(d, q)
        joined = 1.0 - w[RELEASED + c]
        share = joined * (w[U + c + 1] - w[U + c])
        w[IMPULSE + c] = joined * w[DAMPING + c] * d * weighted / (q + 1.0)
        w[TRANSFER + c] += share * w[DAMPING + c] * weighted
        w[BY_DAMPING + c] += share * d * weighted / (q + 1.0)
        w[BY_OVERLAP + c] += w[TRANSFER + c]
    for i in range(low, high):
        w[BY_MASS + i] -= w[U + 1 + i] * (w[IMPULSE + i] - w[IMPULSE + i + 1])
        w[by_place + i] = w[TRANSFER + i + 1] - w[TRANSFER + i]


@compiled
def gather_damped(w, low, high, h, s, state, stages, out):
    """Derivative with respect to the rate of a stage, which enters later stages and the end."""
    for i in range(low, high):
        w[out + i] = STEP_WEIGHTS[s] * w[state + i]
    for later in range(s + 1, STEP_STAGES):
        a, stage = WEIGHTS[later, s], stages + later * ROW
        if a != 0.0:
            for i in range(low, high):
                w[out + i] += a * w[stage + i]
    for i in range(low, high):
        w[out + i] *= h


@compiled
def reverse_switches(w, low, high, switches, gauge, on):
    """Reverse `release`, which removes impulses from u or adds them again."""
    for i in range(low, high):
        w[U + 1 + i] = w[LV + i] * w[INVERSE_MASS + i]
    w[U + low] = w[U + high + 1] = 0.0
    for c in range(low, high + 1):
        if switches[c] == 0.0:
            continue
        d, q, sign = abs(switches[c]), w[OVERLAP_POWER + c], math.copysign(1.0, switches[c])
        weighted = sign * power(d, q)
        share = w[U + c + 1] - w[U + c] + on * gauge[c]
        impulse = w[DAMPING + c] * d * weighted / (q + 1.0)
        by_overlap = share * w[DAMPING + c] * weighted
        w[BY_OVERLAP + c] += by_overlap
        w[BY_DAMPING + c] += share * d * weighted / (q + 1.0)
        if c > low:
            w[LX + c - 1] += by_overlap
            w[BY_MASS + c - 1] += w[U + c] * impulse
        if c < high:
            w[LX + c] -= by_overlap
            w[BY_MASS + c] -= w[U + c + 1] * impulse


@compiled
def reverse_damped(w, low, high, h, kept, gauge, on):
    """`reverse_step` of `hertzchain.kernels.adjoint_reverse` with damping."""
    reverse_switches(w, low, high, kept[KEPT_SWITCHES], gauge, on)
    for c in range(low, high + 1):
        w[RELEASED + c] = kept[KEPT_RELEASED, c]
    for s in range(STEP_STAGES - 1, -1, -1):
        by_place, by_reduced = ZX + s * ROW, ZV + s * ROW
        gather_damped(w, low, high, h, s, LX, ZX, by_reduced)
        gather_damped(w, low, high, h, s, LV, ZV, WORK)
        for i in range(low, high):
            w[U + 1 + i] = w[WORK + i] * w[INVERSE_MASS + i]
        derive_damped(w, low, high, by_place, by_reduced, kept[s], kept[KEPT_CLOSINGS + s], gauge,
                      on * h * STEP_WEIGHTS[s])  # fmt: skip
    for s in range(STEP_STAGES):
        for i in range(low, high):
            w[LX + i] += w[ZX + s * ROW + i]
            w[LV + i] += w[ZV + s * ROW + i]
