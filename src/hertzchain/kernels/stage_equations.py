"""Solve the equations of the stages of an implicit step for all contact forces.

The unknowns are the contact forces at the stages.  Velocities and positions at the stages are
linear functions of them (`hertzchain.kernels.radau`), and each force has to satisfy its law
(`hertzchain.kernels.stiff_law`).  Each iteration of Newton's method solves a block-tridiagonal
system with blocks (stage, stage), because a contact shares its beads with two other contacts.
"""

from __future__ import annotations

import numpy as np

from .compilation import compiled
from .contact_law import LOADED
from .driving import MOVING_WALL, PUSH, drive_at, wall_motion
from .error_scale import general_scale
from .forces import force_on
from .limits import ROUNDING
from .stiff_law import linearise, overlap_of

# Newton's method ends when an iteration changes velocities by less than this fraction of the
# tolerance.
SOLVED, MAX_ITERATIONS = 0.2, 15


@compiled
def stage_motion(time, h, y, weights, times, setup, contacts, segment, rates):
    """Velocities, accelerations, overlaps and closing speeds at the stages, from the forces."""
    inverse_mass = setup.inverse_mass
    pushing, overlap = contacts.implicit.forces, contacts.implicit.overlaps
    closing = contacts.implicit.closings
    beads, stages = len(inverse_mass), len(weights)
    for i in range(stages):
        push = 0.0
        if setup.drive == PUSH:
            push = drive_at(time + times[i] * h, setup, segment)[0]
        for k in range(beads):
            net = pushing[k, i] - pushing[k + 1, i] + force_on(k, push, setup)
            rates[i, beads + k] = net * inverse_mass[k]
    for i in range(stages):
        for k in range(beads):
            gained = 0.0
            for j in range(stages):
                gained += weights[i, j] * rates[j, beads + k]
            rates[i, k] = y[beads + k] + h * gained
    for i in range(stages):
        wall = wall_motion(time + times[i] * h, setup, segment)
        for c in range(beads + 1):
            left = rates[i, c - 1] if c > 0 else wall[1]
            right = rates[i, c] if c < beads else 0.0
            closing[c, i] = left - right
    at_start = wall_motion(time, setup, segment)
    for c in range(beads + 1):
        first = overlap_of(c, y, at_start, setup, contacts)
        for i in range(stages):
            gained = 0.0
            for j in range(stages):
                gained += weights[i, j] * closing[c, j]
            overlap[c, i] = first + h * gained
    if setup.drive == MOVING_WALL:
        for i in range(stages):
            wall = wall_motion(time + times[i] * h, setup, segment)
            way = 0.0
            for j in range(stages):
                way += weights[i, j] * rates[j, 0]
            overlap[0, i] = wall[0] - (y[0] + h * way) - setup.gap[0]


@compiled
def eliminate(block, stages):
    """Solve a block for the columns to its right, in place, by elimination with row pivoting."""
    columns = 2 * stages + 1
    for column in range(stages):
        pivot = column
        for row in range(column + 1, stages):
            if abs(block[row, column]) > abs(block[pivot, column]):
                pivot = row
        if pivot != column:
            for j in range(column, columns):
                block[column, j], block[pivot, j] = block[pivot, j], block[column, j]
        inverse = 1.0 / block[column, column]
        for j in range(column + 1, columns):
            block[column, j] *= inverse
        for row in range(stages):
            factor = block[row, column]
            if row != column and factor != 0.0:
                for j in range(column + 1, columns):
                    block[row, j] -= factor * block[column, j]


@compiled
def fill_block(c, h, weights, squared, before, inverse_mass, contacts, block):
    """Write the equations of contact c, from which the previous contact is eliminated."""
    own, residual = contacts.implicit.own, contacts.implicit.residual
    by_overlap, by_closing = contacts.implicit.by_overlap, contacts.implicit.by_closing
    beads, stages = len(inverse_mass), len(weights)
    left = inverse_mass[c - 1] if c > 0 else 0.0
    right = inverse_mass[c] if c < beads else 0.0
    for i in range(stages):
        block[i, 2 * stages] = residual[c, i]
        for j in range(stages):
            b = h * (by_closing[c, i] * weights[i, j] + h * by_overlap[c, i] * squared[i, j])
            block[i, stages + j] = -right * b
            block[i, j] = (left + right) * b
        block[i, i] += own[c, i]
    if c == 0:
        return
    for i in range(stages):
        for k in range(stages):
            b = h * (by_closing[c, i] * weights[i, k] + h * by_overlap[c, i] * squared[i, k])
            block[i, 2 * stages] += left * b * residual[c - 1, k]
            for j in range(stages):
                block[i, j] += left * b * before[k, j]


@compiled
def solve_for_change(h, weights, squared, setup, contacts):
    """Solve the linear equations for the changes of all forces, which overwrite the residuals."""
    residual = contacts.implicit.residual
    blocks, block = contacts.implicit.blocks, contacts.implicit.block
    beads, stages = len(setup.inverse_mass), len(weights)
    for c in range(beads + 1):
        if setup.stiffness[c] == 0.0 or contacts.mode[c] != LOADED:
            residual[c], blocks[c] = 0.0, 0.0
            continue
        before = blocks[c - 1 if c > 0 else 0]
        fill_block(c, h, weights, squared, before, setup.inverse_mass, contacts, block)
        eliminate(block, stages)
        for i in range(stages):
            residual[c, i] = block[i, 2 * stages]
            for j in range(stages):
                blocks[c, i, j] = block[i, stages + j]
    for c in range(beads - 1, -1, -1):
        for i in range(stages):
            for j in range(stages):
                residual[c, i] -= blocks[c, i, j] * residual[c + 1, j]


@compiled
def change_forces(step, stages, tolerance, inverse_mass, contacts, scale):
    """Add the changes to the forces; returns the largest change of a velocity, in tolerances."""
    pushing, change = contacts.implicit.forces, contacts.implicit.residual
    beads, worst, total = len(inverse_mass), 0.0, 0.0
    for c in range(beads + 1):
        for i in range(stages):
            pushing[c, i] += change[c, i]
    for k in range(beads):
        for i in range(stages):
            kick = step * abs(change[k, i] - change[k + 1, i]) * inverse_mass[k]
            # Unlike the comparison, the sum propagates NaN.
            total += kick
            if kick > worst * tolerance * scale[k]:
                worst = kick / (tolerance * scale[k])
    return worst + (total - total)


@compiled
def solve_stages(time, h, step, y, weights, squared, times, setup, contacts, segment, rtol, rates,
                 ahead, speeds, scale):  # fmt: skip
    """Improve the forces by Newton's method; returns whether it has converged."""
    # Changes of forces are measured by the changes of velocity that they cause in a full step.
    inverse_mass, beads, stages = setup.inverse_mass, len(setup.inverse_mass), len(weights)
    last = stages - 1
    for _ in range(MAX_ITERATIONS):
        stage_motion(time, h, y, weights, times, setup, contacts, segment, rates)
        for c in range(beads + 1):
            if setup.stiffness[c] == 0.0 or contacts.mode[c] != LOADED:
                continue
            mobility = inverse_mass[c - 1] if c > 0 else 0.0
            mobility += inverse_mass[c] if c < beads else 0.0
            for i in range(stages):
                linearise(c, i, h * weights[i, i] * mobility, setup, contacts)
        solve_for_change(h, weights, squared, setup, contacts)
        for k in range(beads):
            ahead[beads + k] = y[beads + k] + step * rates[last, beads + k]
        wall_speed = wall_motion(time + h, setup, segment)[1]
        general_scale(
            time, step, y, ahead, wall_speed, setup, contacts, segment, rtol, ROUNDING,
            speeds, scale,
        )  # fmt: skip
        worst = change_forces(step, stages, SOLVED * rtol, inverse_mass, contacts, scale)
        if worst <= 1.0:
            stage_motion(time, h, y, weights, times, setup, contacts, segment, rates)
            return True
        if np.isnan(worst):
            return False
    return False
