r"""One step of order 8 for all beads of a chain, and its estimated error.

The method is DOP853 (`hertzchain.kernels.dop853`), the forces are those of
`hertzchain.kernels.forces`.  Stage j of a step is row j of ``stages``, in the order of the
state: velocities, accelerations, rates of the accumulators.
"""

from __future__ import annotations

import numpy as np

from .active_beads import unresolved_speed
from .compilation import compiled
from .dop853 import E3, E5, STAGES, STEP_STAGES, A
from .driving import PUSH, drive_at, rounding_of_drive
from .forces import derivative

# Number of beads on either side that set the unit of the error of a bead, and the part of the speed
# of the fastest bead in contact that sets it if all of them are slow, as behind a pulse.
NEIGHBOURS = 3
SLOW = 1e-4
# The same part if the steps resolve no motion in any contact, in unresolved speeds.
FAINT = 100.0
# Slower beads have not been reached: ahead of the front, numbers underflow.
AT_REST = 1e-290
# Relative rounding error of a force, as amplified by the error estimate.
ROUNDING = 5e-15
# Times of the stages, in parts of the step.
C = A.sum(axis=1)
# Number of stages that are added in one pass over the arrays.
GROUP_SIZE = 4


def _in_groups(rows):
    """Places and values of the weights other than zero, in groups, for each row."""
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
WHICH, WEIGHT, GROUPS = _in_groups(A)


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
def fastest_nearby(speeds, scale):
    """Raise each bead's scale to the largest speed within a few beads."""
    beads = len(scale)
    for k in range(beads):
        scale[k] = max(scale[k], speeds[k])
    for shift in range(1, NEIGHBOURS + 1):
        for k in range(beads - shift):
            scale[k] = max(scale[k], speeds[k + shift])
        for k in range(shift, beads):
            scale[k] = max(scale[k], speeds[k - shift])


@compiled
def velocity_scale(y, rtol, setup, speeds, scale):
    """Units of the errors of the velocities of beads."""
    # The unit is the largest speed within a few beads, or a small part of that of the fastest bead
    # in contact: the motion of beads without contact is exact at any speed.  Motion that remains
    # behind a pulse is not integrated more accurately than it is known.
    beads = len(scale)
    velocities = y[beads : 2 * beads]
    for k in range(beads):
        speeds[k] = abs(velocities[k])
    fastest = 0.0
    for k in range(beads - 1):
        if y[k] > y[k + 1]:
            fastest = max(fastest, speeds[k], speeds[k + 1])
    scale[:] = max(SLOW * fastest, FAINT * unresolved_speed(y, beads, rtol, setup, None))
    fastest_nearby(speeds, scale)


@compiled
def general_scale(time, h, y, y_new, wall_speed, setup, contacts, segment, rtol, speeds, scale):
    """Units of errors for both ends of a step of a general chain."""
    # Beads may start from or come to rest within a step, because of gaps or a moving left wall.
    # The accuracy of velocities is limited by the rounding of static forces, and that of a force
    # that begins at a late time by the rounding of the time.
    beads = len(scale)
    for k in range(beads):
        speeds[k] = max(abs(y[beads + k]), abs(y_new[beads + k]))
    # The forces are those at the start: a step that is far too long ends with arbitrary forces.
    pushing, inverse_mass = contacts.last_force, setup.inverse_mass
    fastest = 0.0
    for k in range(beads):
        if pushing[k] != 0.0 or pushing[k + 1] != 0.0:
            fastest = max(fastest, speeds[k])
    rounded = ROUNDING * h / rtol
    least = max(SLOW * fastest, FAINT * unresolved_speed(y, beads, rtol, setup, contacts))
    for k in range(beads):
        rounding = (abs(pushing[k]) + abs(pushing[k + 1])) * inverse_mass[k] * rounded
        scale[k] = max(least, rounding, setup.law.slowest)
    if setup.drive == PUSH:
        unknown = abs(drive_at(time + h, setup, segment)[1]) * (time + h)
        unknown = max(unknown, rounding_of_drive(time, setup, segment))
        scale[0] = max(scale[0], unknown * inverse_mass[0] * rounded)
    for k in range(min(NEIGHBOURS, beads)):
        scale[k] = max(scale[k], abs(wall_speed), scale[0] if setup.drive == PUSH else 0.0)
    fastest_nearby(speeds, scale)


@compiled
def estimate(weights, stages, out):
    """Sum over the stages of weight * stage; the weights of stages 1 to 4 are zero."""
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
    # Errors of positions are expressed as the error of a velocity that causes them within the step.
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
