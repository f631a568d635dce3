r"""One step of order 8 for all beads of a chain, and its estimated error.

The method is DOP853 (`hertzchain.kernels.dop853`), the forces are those of
`hertzchain.kernels.forces`.  Stage j of a step is row j of ``stages``, in the order of the
state: velocities, accelerations, rates of the ledger.
"""

from __future__ import annotations

import numpy as np

from .active_beads import unresolved_speed
from .compilation import compiled
from .dop853 import E3, E5, STAGES, STEP_STAGES, A
from .driving import PUSH, drive_at
from .forces import derivative

# Beads to either side that set the scale of a bead's error, and the part of the fastest
# bead in contact that sets it where all of them are slow: the debris behind a pulse.
NEIGHBOURS = 3
SLOW = 1e-4
# The same part if the steps resolve no motion in any contact, in unresolved speeds.
FAINT = 100.0
# Beads slower than this have not been reached: numbers that underflow ahead of the front.
AT_REST = 1e-290
# Part of a force that is lost to rounding, with what the error estimate makes of it.
ROUNDING = 5e-15
# When in a step its stages are.
C = A.sum(axis=1)
# Stages that are added in one go, each sum of stages as rows of so many: read once, written once.
GROUP_SIZE = 4


def _in_groups(rows):
    """Of each row of weights the places and values that are not zero, in groups."""
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


# Row s: what is added up before stage s.
WHICH, WEIGHT, GROUPS = _in_groups(A)


@compiled
def add_stages(y, h, row, stages, out):
    """Write y + h * sum over stages of weight * stage into ``out``, a group at a time."""
    for group in range(GROUPS[row]):
        which, weight = WHICH[row, group], WEIGHT[row, group]
        a, b, c, d = h * weight[0], h * weight[1], h * weight[2], h * weight[3]
        p, q, r, s = stages[which[0]], stages[which[1]], stages[which[2]], stages[which[3]]
        # Two loops, since the compiler wants to see that they write where nothing is read.
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
    # The last stage is at the step's end: its weights are the method's.
    add_stages(y, h, STEP_STAGES, stages, y_new)
    derivative(time + h, y_new, setup, contacts, segment, stages[STEP_STAGES])


@compiled
def complete_stages(time, y, h, setup, contacts, segment, stages, trial):
    """The three further stages that the interpolant needs."""
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
    """The speeds in which the beads' errors are measured.

    A bead's is the largest within a few beads, or a small part of that of the fastest
    bead in contact: beads that have lost contact move exactly, however fast they are.  What is
    left of a pulse that has gone is not followed more exactly than it is known.
    """
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
    """The same at both ends of a step, as on a bench much begins at rest, or is brought to it.

    There are gaps, the left wall may move and set beads in motion, and where contacts bear
    static forces no velocity is known better than these are rounded.  A force that begins at a
    late time is not known better than the time is.
    """
    beads = len(scale)
    for k in range(beads):
        speeds[k] = max(abs(y[beads + k]), abs(y_new[beads + k]))
    # Those at its start: a step that is far too long ends with any force.
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
        rate = drive_at(time + h, setup, segment)[1]
        scale[0] = max(scale[0], abs(rate) * (time + h) * inverse_mass[0] * rounded)
    for k in range(min(NEIGHBOURS, beads)):
        scale[k] = max(scale[k], abs(wall_speed), scale[0] if setup.drive == PUSH else 0.0)
    fastest_nearby(speeds, scale)


@compiled
def estimate(weights, stages, out):
    """Sum over the stages of weight * stage; the method leaves stages 1 to 4 out."""
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
    """Largest estimated error of a step, in tolerances; not a number if a stage is none.

    Positions count as the velocity error that would cause them within the step.
    """
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
        # Keeps what is not a number: max() may lose it.
        total += position5[k] + velocity5[k]
    if np.isnan(total):
        return np.nan
    if worst5 == 0.0:
        return 0.0
    return worst5 * worst5 / np.sqrt(worst5 * worst5 + 0.01 * worst3 * worst3)
