r"""Steps of a chain with damped contacts, and their discrete adjoint.

.. math:: F_c = k_c d_c^{p_c} + g_c d_c^{q_c} d_c' ,

which is not negative unless a contact may pull; q > 0, so that no force jumps.  The method is
DOP853.  For each stage, overlaps and closing speeds of all contacts are kept, in this order.
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
    EXPONENT,
    F0,
    F8,
    FACTOR,
    FORCE,
    INVERSE_MASS,
    LV,
    LX,
    NEW_V,
    NEW_X,
    OVERLAP_POWER,
    PULLS,
    ROW,
    SPARE,
    STAGE_A,
    STAGE_V,
    STIFFNESS,
    TRANSFER,
    TRIAL,
    TRIAL_V,
    WORK,
    ZV,
    ZX,
    U,
    V,
    X,
)
from .compilation import CONTRACTED
from .dop853 import E3, E5, STEP_STAGES, A, B
from .elastic_forces import LEAST
from .powers import power

compiled = njit(**CONTRACTED)
inlined = njit(forceinline=True, **CONTRACTED)

WEIGHTS = np.ascontiguousarray(A[:STEP_STAGES, :STEP_STAGES])
STEP_WEIGHTS, THIRD, FIFTH = np.array(B), np.array(E3), np.array(E5)


@inlined
def parts_of(w, c, d, closing):
    """Elastic power, power of the damping, and whether the contact pushes."""
    raised = power(d, w[EXPONENT + c])
    weight = power(d, w[OVERLAP_POWER + c])
    force = w[STIFFNESS + c] * raised + w[DAMPING + c] * weight * closing
    acts = (d > 0.0) & ((force > 0.0) | (w[PULLS + c] > 0.0))
    return raised, weight, force, acts


@compiled
def damped_forces(w, low, high, at, moving, out, overlaps, closings):
    """Accelerations in row ``out`` at the positions and velocities in two rows."""
    for c in range(low, high + 1):
        d = w[AT_REST + c] + (w[at + c] - w[at + c + 1])
        d = d if d > LEAST else 0.0
        closing = w[moving + c] - w[moving + c + 1]
        overlaps[c], closings[c] = d, closing
        _, _, force, acts = parts_of(w, c, d, closing)
        w[FORCE + c] = force if acts else 0.0
    for i in range(low, high):
        w[out + i] = (w[FORCE + i] - w[FORCE + i + 1]) * w[INVERSE_MASS + i] + w[BODY + i]


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
    damped_forces(w, low, high, X, V, STAGE_A, kept[0], kept[STEP_STAGES])
    for i in range(low, high):
        w[STAGE_V + i], w[F0 + i] = w[V + 1 + i], w[STAGE_A + i]
    for s in range(1, STEP_STAGES):
        add_up(w, low, high, h, X, STAGE_V, WEIGHTS[s], s, TRIAL)
        add_up(w, low, high, h, V, STAGE_A, WEIGHTS[s], s, TRIAL_V)
        for i in range(low, high):
            w[STAGE_V + s * ROW + i] = w[TRIAL_V + 1 + i]
        damped_forces(w, low, high, TRIAL, TRIAL_V, STAGE_A + s * ROW, kept[s],
                      kept[STEP_STAGES + s])  # fmt: skip
    add_up(w, low, high, h, X, STAGE_V, STEP_WEIGHTS, STEP_STAGES, NEW_X)
    add_up(w, low, high, h, V, STAGE_A, STEP_WEIGHTS, STEP_STAGES, NEW_V)
    damped_forces(w, low, high, NEW_X, NEW_V, F8, last, w[SPARE : SPARE + ROW])


@compiled
def damped_errors(w, low, high, h, scale):
    """Error of each bead in units of its scale, in the row WORK."""
    for i in range(low, high):
        third = THIRD[STEP_STAGES] * w[F8 + i]
        fifth = FIFTH[STEP_STAGES] * w[F8 + i]
        for s in range(STEP_STAGES):
            a = w[STAGE_A + s * ROW + i]
            third += THIRD[s] * a
            fifth += FIFTH[s] * a
        size = math.sqrt(fifth * fifth + 0.01 * third * third)
        w[WORK + i] = abs(h) * fifth * fifth / (size * w[scale + i]) if size > 0.0 else 0.0


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
def derive_damped(w, low, high, by_place, by_speed, overlaps, closings, gauge, weight):
    """The rows of a stage from the row U, as `hertzchain.kernels.adjoint_reverse.derive`.

    ``by_speed`` already has the derivatives through the positions.
    """
    w[U + low] = w[U + high + 1] = 0.0
    for c in range(low, high + 1):
        d, closing = overlaps[c], closings[c]
        raised, weighted, force, acts = parts_of(w, c, d, closing)
        share = w[U + c + 1] - w[U + c] + weight * gauge[c]
        share = share if acts else 0.0
        inverse = 1.0 / (d if d > 0.0 else 1.0)
        damping = w[DAMPING + c] * weighted
        slope = w[EXPONENT + c] * w[STIFFNESS + c] * raised * inverse
        slope += w[OVERLAP_POWER + c] * damping * inverse * closing
        w[TRANSFER + c], w[SPARE + c] = share * slope, share * damping
        w[FACTOR + c] = force if acts else 0.0
        w[BY_OVERLAP + c] += share * slope
        w[BY_STIFFNESS + c] += share * raised
        w[BY_DAMPING + c] += share * weighted * closing
    for i in range(low, high):
        w[by_place + i] = w[TRANSFER + i + 1] - w[TRANSFER + i]
        w[by_speed + i] += w[SPARE + i + 1] - w[SPARE + i]
        w[BY_MASS + i] -= w[U + 1 + i] * (w[FACTOR + i] - w[FACTOR + i + 1])
        w[BY_BODY + i] += w[U + 1 + i]


@compiled
def gather_damped(w, low, high, h, s, state, stages, out):
    """Derivative by a stage's rate: through the end of the step and all later stages."""
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
def reverse_damped(w, low, high, h, kept, gauge, on):
    """Derivatives by the state at the start of a step from those by the state at its end."""
    for s in range(STEP_STAGES - 1, -1, -1):
        by_place, by_speed = ZX + s * ROW, ZV + s * ROW
        gather_damped(w, low, high, h, s, LX, ZX, by_speed)
        gather_damped(w, low, high, h, s, LV, ZV, WORK)
        for i in range(low, high):
            w[U + 1 + i] = w[WORK + i] * w[INVERSE_MASS + i]
        derive_damped(w, low, high, by_place, by_speed, kept[s], kept[STEP_STAGES + s], gauge,
                      on * h * STEP_WEIGHTS[s])  # fmt: skip
    for s in range(STEP_STAGES):
        for i in range(low, high):
            w[LX + i] += w[ZX + s * ROW + i]
            w[LV + i] += w[ZV + s * ROW + i]
