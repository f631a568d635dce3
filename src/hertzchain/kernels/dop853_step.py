r"""Explicit steps of order 8 for chains whose forces depend on velocities.

The method is DOP853 (`hertzchain.kernels.dop853`), the forces are those of
`hertzchain.kernels.forces`.  Stage j of a step is row j of ``stages``, in the order of the
state: velocities, accelerations, rates of the accumulators.
"""

from __future__ import annotations

import numpy as np

from .compilation import compiled
from .dop853 import E3, E5, STAGES, STEP_STAGES, A, D
from .driving import wall_motion
from .error_scale import AT_REST, general_scale
from .forces import copy, derivative
from .interpolant import COEFFICIENTS
from .limits import ROUNDING

# Times of the stages, as fractions of the step.
C = A.sum(axis=1)
# Number of stages that are added in one pass over the arrays.
GROUP_SIZE = 4


def in_groups(rows):
    """Indices and values of the nonzero weights of each row, in groups, and number of groups."""
    longest = max(np.count_nonzero(row) for row in rows)
    groups = -(-longest // GROUP_SIZE)
    which = np.zeros((len(rows), groups, GROUP_SIZE), np.int64)
    weight = np.zeros((len(rows), groups, GROUP_SIZE))
    count = np.zeros(len(rows), np.int64)
    for s, row in enumerate(rows):
        places = np.flatnonzero(row)
        count[s] = -(-len(places) // GROUP_SIZE)
        which[s].flat[: len(places)] = places
        weight[s].flat[: len(places)] = row[places]
    return which, weight, count


# Row s: stages that are added before stage s.
WHICH, WEIGHT, GROUPS = in_groups(A)


@compiled
def add_stages(y, h, row, stages, out):
    """Write y + h * sum over stages of weight * stage into ``out``, a group at a time."""
    for group in range(GROUPS[row]):
        which, weight = WHICH[row, group], WEIGHT[row, group]
        a, b, c, d = h * weight[0], h * weight[1], h * weight[2], h * weight[3]
        p, q, r, s = stages[which[0]], stages[which[1]], stages[which[2]], stages[which[3]]
        # In two separate loops, the compiler recognises that outputs and inputs do not overlap.
        if group == 0:
            for i in range(len(out)):
                out[i] = y[i] + a * p[i] + b * q[i] + c * r[i] + d * s[i]
        else:
            for i in range(len(out)):
                out[i] = out[i] + a * p[i] + b * q[i] + c * r[i] + d * s[i]


@compiled
def try_step(time, y, h, setup, contacts, segment, stages, trial, y_new):
    """One step of order 8; stage 0 must hold the derivative at its start."""
    for s in range(1, STEP_STAGES):
        add_stages(y, h, s, stages, trial)
        derivative(time + C[s] * h, trial, setup, contacts, segment, stages[s])
    # The last stage is at the end of the step, with the weights of the method.
    add_stages(y, h, STEP_STAGES, stages, y_new)
    derivative(time + h, y_new, setup, contacts, segment, stages[STEP_STAGES])


@compiled
def complete_stages(time, y, h, setup, contacts, segment, stages, trial):
    """Compute the three further stages of the interpolant."""
    for s in range(STEP_STAGES + 1, STAGES):
        add_stages(y, h, s, stages, trial)
        derivative(time + C[s] * h, trial, setup, contacts, segment, stages[s])


@compiled
def estimate(weights, stages, out):
    """Write the sum over the stages of weight * stage; the weights of stages 1 to 4 are zero."""
    w0, w5, w6, w7 = weights[0], weights[5], weights[6], weights[7]
    s0, s5, s6, s7 = stages[0], stages[5], stages[6], stages[7]
    for i in range(len(out)):
        out[i] = w0 * s0[i] + w5 * s5[i] + w6 * s6[i] + w7 * s7[i]
    w8, w9, w10, w11 = weights[8], weights[9], weights[10], weights[11]
    s8, s9, s10, s11 = stages[8], stages[9], stages[10], stages[11]
    for i in range(len(out)):
        out[i] = out[i] + w8 * s8[i] + w9 * s9[i] + w10 * s10[i] + w11 * s11[i]


@compiled
def error_norm(h, stages, scale, rtol, errors):
    """Largest estimated error of a step, in units of the tolerance; NaN if a stage is NaN."""
    # The error of a position is measured by the constant error of velocity that would cause it
    # within the step.
    beads = len(scale)
    estimate(E5, stages, errors[0])
    estimate(E3, stages, errors[1])
    position5, velocity5 = errors[0, :beads], errors[0, beads : 2 * beads]
    position3, velocity3 = errors[1, :beads], errors[1, beads : 2 * beads]
    worst5, worst3, total = 0.0, 0.0, 0.0
    for k in range(beads):
        if scale[k] < AT_REST:
            continue
        unit = 1.0 / (rtol * scale[k])
        error5 = max(abs(position5[k]), h * abs(velocity5[k])) * unit
        error3 = max(abs(position3[k]), h * abs(velocity3[k])) * unit
        worst5, worst3 = max(error5, worst5), max(error3, worst3)
        # Unlike max(), this keeps NaN.
        total += position5[k] + velocity5[k]
    if np.isnan(total):
        return np.nan
    if worst5 == 0.0:
        return 0.0
    return worst5 * worst5 / np.sqrt(worst5 * worst5 + 0.01 * worst3 * worst3)


@compiled
def find_coefficients(h, y, y_new, stages, dense):
    """Interpolant of a step with all its stages: coefficients of shape (COEFFICIENTS, len(y))."""
    first, last = stages[0], stages[STEP_STAGES]
    for i in range(len(y)):
        dense[0, i] = y_new[i] - y[i]
    for i in range(len(y)):
        dense[1, i] = h * first[i] - dense[0, i]
    for i in range(len(y)):
        dense[2, i] = 2.0 * dense[0, i] - h * (last[i] + first[i])
    for row in range(3, COEFFICIENTS):
        weights, out = D[row - 3], dense[row]
        # The interpolant does not use stages 1 to 4.
        w0, w1, w2, w3 = h * weights[0], h * weights[5], h * weights[6], h * weights[7]
        s1, s2, s3 = stages[5], stages[6], stages[7]
        for i in range(len(y)):
            out[i] = w0 * first[i] + w1 * s1[i] + w2 * s2[i] + w3 * s3[i]
        for j in (8, 12):
            w0, w1, w2, w3 = weights[j], weights[j + 1], weights[j + 2], weights[j + 3]
            add_four(out, h * w0, h * w1, h * w2, h * w3, stages, j)


@compiled
def add_four(out, a, b, c, d, stages, j):
    """Add a multiple of each of four stages, from stage j on."""
    p, q, r, s = stages[j], stages[j + 1], stages[j + 2], stages[j + 3]
    for i in range(len(out)):
        out[i] = out[i] + a * p[i] + b * q[i] + c * r[i] + d * s[i]


@compiled
def begin(time, y, h, setup, contacts, segment, rtol, stages, work, scale):  # noqa: ARG001
    """Compute the derivative at the start of the next step."""
    derivative(time, y, setup, contacts, segment, stages[0])
    copy(contacts.force, contacts.last_force)


@compiled
def take_step(time, y, h, setup, contacts, segment, rtol, stages, trial, y_new, work, scale):
    """Take one step; returns its error in tolerances (NaN if it failed) and evaluations."""
    speeds = work[3, len(scale) : 2 * len(scale)]
    wall_speed = wall_motion(time + h, setup, segment)[1]
    try_step(time, y, h, setup, contacts, segment, stages, trial, y_new)
    general_scale(
        time, h, y, y_new, wall_speed, setup, contacts, segment, rtol, ROUNDING, speeds, scale
    )
    return error_norm(h, stages, scale, rtol, work[4:]), STEP_STAGES


@compiled
def interpolate(time, y, h, y_new, setup, contacts, segment, stages, dense, trial, scratch):  # noqa: ARG001
    """Compute the coefficients of the interpolant of a step; returns evaluations."""
    complete_stages(time, y, h, setup, contacts, segment, stages, trial)
    find_coefficients(h, y, y_new, stages, dense)
    return STAGES - STEP_STAGES - 1


@compiled
def forces_within(theta, time, h, state, setup, contacts, segment, scratch):
    """Compute the contact forces at the fraction theta of a step, from the state there."""
    derivative(time + theta * h, state, setup, contacts, segment, scratch)
