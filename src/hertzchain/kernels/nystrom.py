r"""Explicit steps of order 8 for chains whose forces depend on positions and time only.

The method is RKN8(6) (`hertzchain.kernels.rkn8`); the forces are those of elastic contacts, walls,
drives and weight.  Stages are rows of ``stages``, as for DOP853, but have no velocities: the start
is in row 0, stages 1 to 7 are in the rows from `FIRST_ROW` on, and the end, which has velocities,
is in row `STEP_STAGES`.

`hertzchain.kernels.rkn8_stages` has the same step for rows at constant distances, so that the
compiler can vectorise a sum over all stages in one loop.  Here the length of the rows varies with
the window, and stages are added in groups.
"""

from __future__ import annotations

import numpy as np

from .compilation import CONTRACTED, compiled, internal
from .contact_law import HERTZ, force, law_of
from .dop853 import STEP_STAGES
from .dop853_step import in_groups
from .driving import MOVING_WALL, NOTHING, PUSH, drive_at, wall_motion
from .error_scale import AT_REST, general_scale, velocity_scale
from .forces import (
    DRIVEN,
    LEFT_IMPULSE,
    LOST,
    PUSHED,
    RIGHT_IMPULSE,
    copy,
    loading_curve,
)
from .limits import ROUNDING
from .nystrom_interpolant import find_coefficients
from .powers import powers
from .rkn8 import B_POSITION, B_VELOCITY, E_VELOCITY, A, C

contracted = internal(**CONTRACTED)

# Number of evaluations of the forces per step, and the row of stage 1.
EVALUATIONS_PER_STEP = 8
FIRST_ROW = STEP_STAGES - EVALUATIONS_PER_STEP + 1
# The estimate is of order 6, and the error of the step of order 8.  With this ratio of the two,
# runs are at least as accurate as those of DOP853 at equal tolerance.
SHARPER = 10.0
# Rows of the table of weights: rows 0 to 6 are those of stages 1 to 7; then follow the positions
# and velocities at the end, and the error of the velocities.  For Python integers, numba would
# compile a further version of `sum_stages` for each.
END_POSITION, END_VELOCITY, VELOCITY_ERROR = np.arange(7, 10)


def _weights():
    """Weights of all sums over stages; columns are the rows of ``stages``."""
    table = np.zeros((VELOCITY_ERROR + 1, STEP_STAGES + 1))
    for row, weights in enumerate((*A, B_POSITION, B_VELOCITY, E_VELOCITY)):
        table[row, 0] = weights[0]
        table[row, FIRST_ROW : FIRST_ROW + len(weights) - 1] = weights[1:]
    return table


TABLE = _weights()
WHICH, WEIGHT, GROUPS = in_groups(TABLE)
TIMES = np.array(C)


@contracted
def sum_stages(row, beads, stages, out):
    """Write the weighted sum of the accelerations at the stages into ``out``, group by group."""
    for group in range(GROUPS[row]):
        which, weight = WHICH[row, group], WEIGHT[row, group]
        a, b, c, d = weight[0], weight[1], weight[2], weight[3]
        p, q = stages[which[0], beads : 2 * beads], stages[which[1], beads : 2 * beads]
        r, s = stages[which[2], beads : 2 * beads], stages[which[3], beads : 2 * beads]
        if group == 0:
            for k in range(beads):
                out[k] = a * p[k] + b * q[k] + c * r[k] + d * s[k]
        else:
            for k in range(beads):
                out[k] = out[k] + (a * p[k] + b * q[k] + c * r[k] + d * s[k])


@contracted
def place(row, part, h, y, beads, stages, out):
    """Write positions after the fraction ``part`` of a step into ``out``."""
    x, v = y[:beads], y[beads : 2 * beads]
    sum_stages(row, beads, stages, out)
    for k in range(beads):
        out[k] = x[k] + h * (part * v[k] + h * out[k])


@compiled
def plain_accelerations(x, setup, scratch, out):
    """Accelerations of the beads of a default chain; ``scratch`` has the shape (4, N)."""
    stiffness, inverse_mass = setup.stiffness, setup.inverse_mass
    contacts = len(stiffness)
    overlap, pushing = scratch[3, :contacts], scratch[2, :contacts]
    for c in range(contacts):
        closed = x[c] - x[c + 1]
        overlap[c] = closed if closed > 0.0 else 0.0
    if setup.exponent == HERTZ:
        for c in range(contacts):
            pushing[c] = stiffness[c] * overlap[c] * np.sqrt(overlap[c])
    else:
        powers(overlap, setup.exponent, pushing, scratch)
        for c in range(contacts):
            pushing[c] *= stiffness[c]
    out[0] = -pushing[0] * inverse_mass[0]
    for k in range(1, contacts):
        out[k] = (pushing[k - 1] - pushing[k]) * inverse_mass[k]
    out[contacts] = pushing[contacts - 1] * inverse_mass[contacts]


@compiled
def find_overlaps(x, gap, wall, overlap):
    """Overlaps of all contacts; ``wall`` is the position of the left wall."""
    beads = len(gap) - 1
    for c in range(1, beads):
        overlap[c] = x[c - 1] - x[c] - gap[c]
    overlap[0] = wall - x[0] - gap[0]
    overlap[beads] = x[beads - 1] - gap[beads]


@compiled
def elastic_forces(overlap, setup, contacts):
    """Write the forces of elastic contacts."""
    pushing = contacts.force
    if setup.law.shared:
        loading_curve(overlap, setup.stiffness, setup.law.exponent, pushing, contacts.powers)
        return
    for c in range(len(pushing)):
        pushing[c] = force(overlap[c], setup.stiffness[c], law_of(c, setup).exponent)


@compiled
def evaluate(time, first, y, setup, contacts, segment, scratch, out):
    """Accelerations and rates of the accumulators at the positions in ``y``.

    ``first`` is the position of bead 1 at the start of the step.  If a force drives bead 1, the
    rate in DRIVEN is F' (x - x(t_0)), the integrand of the second term in `try_step`.
    """
    beads = len(setup.inverse_mass)
    if contacts is None:
        plain_accelerations(y, setup, scratch, out[beads:])
        return
    pushing, outside, inverse_mass = contacts.force, setup.body_force, setup.inverse_mass
    drive = drive_at(time, setup, segment) if setup.drive != NOTHING else (0.0, 0.0, 0.0)
    wall = drive if setup.drive == MOVING_WALL else (0.0, 0.0, 0.0)
    overlap = contacts.scratch[0, : beads + 1]
    find_overlaps(y, setup.gap, wall[0], overlap)
    elastic_forces(overlap, setup, contacts)
    acceleration, rates = out[beads : 2 * beads], out[2 * beads :]
    for k in range(beads):
        acceleration[k] = (pushing[k] - pushing[k + 1] + outside[k]) * inverse_mass[k]
    rates[LOST], rates[PUSHED] = 0.0, 0.0
    rates[DRIVEN] = pushing[0] * wall[1]
    if setup.drive == PUSH:
        acceleration[0] += drive[0] * inverse_mass[0]
        rates[DRIVEN], rates[PUSHED] = drive[1] * (y[0] - first), drive[0]
    rates[LEFT_IMPULSE], rates[RIGHT_IMPULSE] = pushing[0], pushing[beads]


@compiled
def evaluate_at_end(time, y, setup, contacts, segment, scratch, out):
    """The derivative of the state ``y`` at an end of a step."""
    beads = len(setup.inverse_mass)
    evaluate(time, y[0], y, setup, contacts, segment, scratch, out)
    copy(y[beads : 2 * beads], out[:beads])
    if contacts is not None and setup.drive == PUSH:
        out[2 * beads + DRIVEN] = drive_at(time, setup, segment)[0] * y[beads]


@compiled
def try_step(time, y, h, setup, contacts, segment, stages, trial, y_new, scratch):
    """One step of order 8; row 0 of ``stages`` must hold the derivative at its start.

    Because the stages have no velocities, the work of a driving force F is computed as
    F(t_1) (x(t_1) - x(t_0)), minus the integral of F' (x - x(t_0)) over the step.
    """
    beads, first = len(setup.inverse_mass), y[0]
    for stage in range(1, EVALUATIONS_PER_STEP):
        at = time + TIMES[stage - 1] * h
        place(stage - 1, TIMES[stage - 1], h, y, beads, stages, trial)
        row = stages[FIRST_ROW + stage - 1]
        evaluate(at, first, trial, setup, contacts, segment, scratch, row)
    place(END_POSITION, 1.0, h, y, beads, stages, y_new)
    last = stages[STEP_STAGES]
    sum_stages(END_VELOCITY, beads, stages, last)
    for k in range(beads):
        y_new[beads + k] = y[beads + k] + h * last[k]
    if contacts is not None:
        for i in range(2 * beads, len(y)):
            total = 0.0
            for row in range(FIRST_ROW, STEP_STAGES):
                total += TABLE[END_VELOCITY, row] * stages[row, i]
            start = 0.0 if i == 2 * beads + DRIVEN and setup.drive == PUSH else stages[0, i]
            y_new[i] = h * (total + TABLE[END_VELOCITY, 0] * start)
        if setup.drive == PUSH:
            gained = drive_at(time + h, setup, segment)[0] * (y_new[0] - first)
            y_new[2 * beads + DRIVEN] = gained - y_new[2 * beads + DRIVEN]
        for i in range(2 * beads, len(y)):
            y_new[i] += y[i]
    evaluate_at_end(time + h, y_new, setup, contacts, segment, scratch, last)


@compiled
def error_norm(h, stages, scale, rtol, errors):
    """Largest estimated error of a step, in units of the tolerance; NaN if a stage is NaN."""
    beads = len(scale)
    sum_stages(VELOCITY_ERROR, beads, stages, errors)
    for k in range(beads):
        unit = scale[k] if scale[k] > AT_REST else np.inf
        errors[k] = abs(errors[k]) / unit
    return h / (SHARPER * rtol) * largest(errors[:beads])


@compiled
def largest(values):
    """Largest element of an array, which is overwritten; NaN if any element is NaN."""
    n = len(values)
    while n > 1:
        half = (n + 1) // 2
        for i in range(n - half):
            a, b = values[i], values[half + i]
            values[i] = a if (a >= b) | (a != a) else b
        n = half
    return values[0]


@compiled
def begin(time, y, h, setup, contacts, segment, rtol, stages, work, scale):  # noqa: ARG001
    """Compute the derivative at the start of the next step."""
    if contacts is None:
        scratch = work[4:].reshape((4, len(scale)))
        evaluate_at_end(time, y, setup, contacts, segment, scratch, stages[0])
        return
    evaluate_at_end(time, y, setup, contacts, segment, work[4:], stages[0])
    copy(contacts.force, contacts.last_force)


@compiled
def take_step(time, y, h, setup, contacts, segment, rtol, stages, trial, y_new, work, scale):
    """Take one step; returns its error in tolerances (NaN if it failed) and evaluations."""
    speeds = work[3, len(scale) : 2 * len(scale)]
    if contacts is None:
        scratch = work[4:].reshape((4, len(scale)))
        try_step(time, y, h, setup, contacts, segment, stages, trial, y_new, scratch)
        velocity_scale(y, rtol, setup, speeds, scale)
        return error_norm(h, stages, scale, rtol, work[4]), EVALUATIONS_PER_STEP
    try_step(time, y, h, setup, contacts, segment, stages, trial, y_new, work[4:])
    wall_speed = wall_motion(time + h, setup, segment)[1]
    general_scale(
        time, h, y, y_new, wall_speed, setup, contacts, segment, rtol, ROUNDING / SHARPER, speeds,
        scale,
    )  # fmt: skip
    return error_norm(h, stages, scale, rtol, work[4]), EVALUATIONS_PER_STEP


@compiled
def interpolate(time, y, h, y_new, setup, contacts, segment, stages, dense, trial, scratch):
    """Compute the coefficients of the interpolant of a step; returns evaluations."""
    beads = len(setup.inverse_mass)
    # The stages have no velocities, so that this part of their rows is free.
    mean = stages[FIRST_ROW, :beads]
    sum_stages(END_POSITION, beads, stages, mean)
    first, last = stages[0, beads : 2 * beads], stages[STEP_STAGES, beads : 2 * beads]
    find_coefficients(
        time, y, h, y_new, first, last, mean, setup, contacts, segment, dense, trial, scratch
    )
    return 0


@compiled
def forces_within(theta, time, h, state, setup, contacts, segment, scratch):
    """Compute the contact forces at the fraction theta of a step, from the positions there."""
    more = contacts.scratch
    evaluate(time + theta * h, state[0], state, setup, contacts, segment, more, scratch)
