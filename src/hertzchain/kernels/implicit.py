r"""One implicit step, for contacts whose damping is too stiff for explicit ones.

Under :math:`\gamma |d'|^\alpha` with :math:`\alpha < 1` two beads that hardly move against each
other are held together by a force that is no smooth function of their speed, and under a
strong dashpot they creep; explicit steps would have to follow the relaxation of both.  Here
the unknowns are the contact forces at the stages, F: velocities and positions at the stages
are linear in them (`hertzchain.kernels.radau`), and each has to satisfy the law

.. math:: F = k d_+^p + f, \qquad f = \gamma\, d_+^q\, |d'|^\alpha\, \mathrm{sgn}\, d' .

Newton's method solves for all contacts at once, a system of blocks (stage, stage) on three
diagonals.  For :math:`\alpha < 1` the law has a vertical tangent at d' = 0.  There it is
taken as d' as a function of f, about the point of its graph at which :math:`d' + c f` is
that of the iterate, c the compliance of the contact: a contact at rest, one that creeps and one
that slides converge alike, and nothing is regularised.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hertzchain.kernels.dop853 import STEP_STAGES
from hertzchain.kernels.forces import (
    DRIVEN,
    LEFT_IMPULSE,
    LOADED,
    LOST,
    MOVING_WALL,
    PUSH,
    PUSHED,
    RIGHT_IMPULSE,
    copy,
    damping_weight,
    drive_at,
    force,
    force_on,
    overlap_and_closing,
    signed_power,
    wall_motion,
)
from hertzchain.kernels.options import compiled
from hertzchain.kernels.radau import (
    BEFORE_LAST,
    BETWEEN,
    IMPLICIT_STAGES,
    LAST,
    NODES,
    ONE_STAGE,
    SQUARED,
    TO_DENSE,
    WEIGHTS,
)
from hertzchain.kernels.step import bench_scale

TIMES = np.array(NODES)
END = np.ones(1)
# A step's tolerance is at least this: rounding of the velocities is amplified by what is stiff.
FINEST = 1e-11
# Energies are known this many times less precisely than speeds.
ENERGY = 100.0
# Newton's method ends when a step changes velocities by less than this part of the tolerance.
SOLVED, MOST_ITERATIONS = 0.2, 15
# A contact at rest yields by this part of its compliance, at least: between two walls where all
# contacts are at rest, nothing else tells the force that all of them have in common.
LEAST_YIELDING = 1e-10
# Overlaps below this part of the positions are no difference of these.
RESOLVED = 1e-12
# Part of a step after which the forces that a state has are those that hold its contacts.
SETTLING = 1e-3
# A push this small, in parts of the momentum over the time since the start, is none.
EVEN = 1e-13
# Weights of the accelerations at the nodes that give the one at the start.
AT_START = SETTLING ** np.arange(IMPLICIT_STAGES) @ BETWEEN
# Iterations for one contact, of which a few are needed.
MOST_PROJECTIONS = 40


class Implicit(NamedTuple):
    """Scratch of implicit steps, of every contact and stage."""

    forces: Any  # (N + 1, IMPLICIT_STAGES)
    overlaps: Any  # as all up to ``rest``: what follows from the forces
    closings: Any
    # What multiplies the changes of force, overlap and closing speed in the law, and its remainder.
    own: Any
    by_overlap: Any
    by_closing: Any
    rest: Any
    blocks: Any  # (N + 1, IMPLICIT_STAGES, IMPLICIT_STAGES): what elimination leaves of them
    block: Any  # (IMPLICIT_STAGES, 2 IMPLICIT_STAGES + 1): that of one contact


def new_implicit(contacts: int) -> Implicit:
    """Scratch for so many contacts."""
    forces, overlaps, closings, own, by_overlap, by_closing, rest = np.zeros(
        (7, contacts, IMPLICIT_STAGES)
    )
    blocks = np.zeros((contacts, IMPLICIT_STAGES, IMPLICIT_STAGES))
    block = np.zeros((IMPLICIT_STAGES, 2 * IMPLICIT_STAGES + 1))
    return Implicit(forces, overlaps, closings, own, by_overlap, by_closing, rest, blocks, block)


@compiled
def graph_point(total, compliance, strength, exponent):
    """The closing speed s and force f = strength |s|^exponent for which s + compliance f is given.

    With s = |total| u^(1/exponent) the equation u^(1/exponent) + ratio u = 1 is convex: from
    above, Newton's method approaches the solution without overshooting.
    """
    size = abs(total)
    if size == 0.0:
        return 0.0, 0.0
    if strength == 0.0:
        return total, 0.0
    largest = strength * size**exponent
    ratio, inverse = compliance * largest / size, 1.0 / exponent
    u = 1.0 if ratio < 1.0 else 1.0 / ratio
    power = u**inverse
    for _ in range(MOST_PROJECTIONS):
        change = (power + ratio * u - 1.0) / (inverse * power / u + ratio)
        u -= change
        power = u**inverse
        if not change > 1e-15 * u:
            break
    sign = 1.0 if total > 0.0 else -1.0
    return sign * size * power, sign * largest * u


@compiled
def size_of(c, y, setup):
    """What the overlap of contact c is a difference of."""
    size = abs(setup.gap[c])
    size += abs(y[c - 1]) if c > 0 else 0.0
    return size + abs(y[c]) if c < len(setup.inverse_mass) else size


@compiled
def is_resolved(c, y, overlap, setup):
    """Whether an overlap is more than rounding may make of the places of its beads."""
    return abs(overlap) > RESOLVED * size_of(c, y, setup)


@compiled
def overlap_of(c, y, wall, setup, contacts):
    """Overlap of contact c where y is given.

    Beads that stick together at their first touch may have an overlap of 1e-40: what it was
    at the end of the step before is remembered.
    """
    overlap, _ = overlap_and_closing(c, y, len(setup.inverse_mass), setup.gap[c], wall)
    if contacts.mode[c] != LOADED or is_resolved(c, y, overlap, setup):
        return overlap
    return contacts.largest[c]


@compiled
def stage_motion(time, h, y, weights, times, setup, contacts, segment, rates):
    """Velocities and accelerations at the stages, overlaps and closing speeds, by the forces."""
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
def cut_off(total, spring, weight, law):
    """Whether a force that may not pull is none, where d' + c F is given."""
    if law.attractive or weight == 0.0:
        return False
    return total < -((spring / weight) ** (1.0 / law.speed_power))


@compiled
def linearise(c, i, compliance, setup, contacts):
    """The law of contact c at stage i as own dF - by_overlap dd - by_closing dd' = rest."""
    law, damping, stiffness = setup.law, setup.damping[c], setup.stiffness[c]
    pushing = contacts.implicit.forces[c, i]
    overlap, closing = contacts.implicit.overlaps[c, i], contacts.implicit.closings[c, i]
    spring = force(overlap, stiffness, law.exponent)
    slope = law.exponent * spring / overlap if overlap > 0.0 else 0.0
    weight = damping * damping_weight(max(overlap, 0.0), law)
    own, rest, steepness = 1.0, 0.0, 0.0
    if cut_off(closing + compliance * pushing, spring, weight, law):
        slope, rest = 0.0, -pushing
    elif law.speed_power < 1.0:
        damped = pushing - spring
        speed, at = graph_point(closing + compliance * damped, compliance, damping, law.speed_power)
        # How much the speed grows with the force, and how much it would by the compliance.
        yielding = speed / (law.speed_power * at) if at != 0.0 else 0.0
        if damping == 0.0 or yielding > compliance:
            if damping > 0.0:
                steepness = 1.0 / yielding
            rest = at + steepness * (closing - speed) - damped
        else:
            own, steepness = max(yielding / compliance, LEAST_YIELDING), 1.0 / compliance
            slope *= own
            rest = (closing - speed) * steepness - own * (damped - at)
    else:
        damped = weight * signed_power(closing, law.speed_power)
        steepness = weight * law.speed_power * abs(closing) ** (law.speed_power - 1.0)
        if overlap > 0.0:
            slope += law.overlap_power * damped / overlap
        # Stiff or not, all rows are of one size.
        own = 1.0 / (1.0 + compliance * steepness)
        rest = own * (spring + damped - pushing)
        slope, steepness = own * slope, own * steepness
    contacts.implicit.own[c, i], contacts.implicit.rest[c, i] = own, rest
    contacts.implicit.by_overlap[c, i] = slope
    contacts.implicit.by_closing[c, i] = steepness


@compiled
def eliminate(block, stages):
    """Solve a block for the columns to its right, in place, with pivots from its columns."""
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
    """The equations of contact c, those of the one before it eliminated.

    ``before`` is that contact's block, by which its change of force follows from this one's.
    """
    own, rest = contacts.implicit.own, contacts.implicit.rest
    by_overlap, by_closing = contacts.implicit.by_overlap, contacts.implicit.by_closing
    beads, stages = len(inverse_mass), len(weights)
    left = inverse_mass[c - 1] if c > 0 else 0.0
    right = inverse_mass[c] if c < beads else 0.0
    for i in range(stages):
        block[i, 2 * stages] = rest[c, i]
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
            block[i, 2 * stages] += left * b * rest[c - 1, k]
            for j in range(stages):
                block[i, j] += left * b * before[k, j]


@compiled
def solve_for_change(h, weights, squared, setup, contacts):
    """Changes of all forces that satisfy the linear equations, written over what was left."""
    rest = contacts.implicit.rest
    blocks, block = contacts.implicit.blocks, contacts.implicit.block
    beads, stages = len(setup.inverse_mass), len(weights)
    for c in range(beads + 1):
        if setup.stiffness[c] == 0.0 or contacts.mode[c] != LOADED:
            rest[c], blocks[c] = 0.0, 0.0
            continue
        before = blocks[c - 1 if c > 0 else 0]
        fill_block(c, h, weights, squared, before, setup.inverse_mass, contacts, block)
        eliminate(block, stages)
        for i in range(stages):
            rest[c, i] = block[i, 2 * stages]
            for j in range(stages):
                blocks[c, i, j] = block[i, stages + j]
    for c in range(beads - 1, -1, -1):
        for i in range(stages):
            for j in range(stages):
                rest[c, i] -= blocks[c, i, j] * rest[c + 1, j]


@compiled
def change_forces(step, stages, tolerance, inverse_mass, contacts, scale):
    """Add the changes to the forces; the largest change of a velocity in a step, in tolerances."""
    pushing, change = contacts.implicit.forces, contacts.implicit.rest
    beads, worst, total = len(inverse_mass), 0.0, 0.0
    for c in range(beads + 1):
        for i in range(stages):
            pushing[c, i] += change[c, i]
    for k in range(beads):
        for i in range(stages):
            kick = step * abs(change[k, i] - change[k + 1, i]) * inverse_mass[k]
            # Keeps what is not a number.
            total += kick
            if kick > worst * tolerance * scale[k]:
                worst = kick / (tolerance * scale[k])
    return worst + (total - total)


@compiled
def solve_stages(time, h, step, y, weights, squared, times, setup, contacts, segment, rtol, rates,
                 ahead, speeds, scale):  # fmt: skip
    """Newton's method from the forces that are there; returns whether it has converged.

    Changes are measured by the velocities that they make within a whole ``step``.
    """
    inverse_mass, beads, stages = setup.inverse_mass, len(setup.inverse_mass), len(weights)
    last = stages - 1
    for _ in range(MOST_ITERATIONS):
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
        bench_scale(step, y, ahead, wall_speed, setup, contacts, rtol, speeds, scale)
        worst = change_forces(step, stages, SOLVED * rtol, inverse_mass, contacts, scale)
        if worst <= 1.0:
            stage_motion(time, h, y, weights, times, setup, contacts, segment, rates)
            return True
        if np.isnan(worst):
            return False
    return False


@compiled
def ledger_rates(i, time, setup, contacts, segment, rates):
    """Rates of the ledger at stage i."""
    beads, law = len(setup.inverse_mass), setup.law
    pushing, overlap = contacts.implicit.forces, contacts.implicit.overlaps
    closing, ledger = contacts.implicit.closings, rates[2 * beads :]
    lost = 0.0
    for c in range(beads + 1):
        if setup.stiffness[c] > 0.0 and contacts.mode[c] == LOADED:
            spring = force(overlap[c, i], setup.stiffness[c], law.exponent)
            lost += (pushing[c, i] - spring) * closing[c, i]
    ledger[LOST] = lost
    ledger[DRIVEN] = pushing[0, i] * wall_motion(time, setup, segment)[1]
    ledger[PUSHED] = 0.0
    if setup.drive == PUSH:
        drive = drive_at(time, setup, segment)[0]
        ledger[DRIVEN], ledger[PUSHED] = drive * rates[0], drive
    ledger[LEFT_IMPULSE], ledger[RIGHT_IMPULSE] = pushing[0, i], pushing[beads, i]


@compiled
def resolve_overlaps(time, h, y, setup, contacts, segment):
    """Overlaps lost in the rounding of positions, from the speeds that go with the forces."""
    law, beads = setup.law, len(setup.inverse_mass)
    pushing, overlap = contacts.implicit.forces, contacts.implicit.overlaps
    wall = wall_motion(time, setup, segment)
    for c in range(beads + 1):
        if contacts.mode[c] != LOADED or setup.damping[c] == 0.0 or law.overlap_power > 0.0:
            continue
        if is_resolved(c, y, overlap[c, IMPLICIT_STAGES - 1], setup):
            continue
        first = overlap_of(c, y, wall, setup, contacts)
        for i in range(IMPLICIT_STAGES):
            gained = 0.0
            for j in range(IMPLICIT_STAGES):
                damped = pushing[c, j] - force(overlap[c, j], setup.stiffness[c], law.exponent)
                speed = signed_power(damped / setup.damping[c], 1.0 / law.speed_power)
                gained += WEIGHTS[i, j] * speed
            contacts.implicit.rest[c, i] = first + h * gained
        for i in range(IMPLICIT_STAGES):
            overlap[c, i] = contacts.implicit.rest[c, i]


@compiled
def remember_overlaps(contacts):
    """Keep the overlaps at the end of the step, from which the next one begins.

    Beads that push each other touch: what is negative then is below the tolerance of the step.
    """
    for c in range(len(contacts.mode)):
        if contacts.mode[c] == LOADED:
            overlap = contacts.implicit.overlaps[c, IMPLICIT_STAGES - 1]
            pushed = contacts.implicit.forces[c, IMPLICIT_STAGES - 1] > 0.0
            contacts.largest[c] = max(overlap, 0.0) if pushed else overlap


@compiled
def forget_rounding(time, setup, contacts, rates):
    """Pushes that would not change a velocity in all the time that has passed are none.

    Where contacts stick, beads come to move alike, and the signs of what is left are those of
    rounding.
    """
    inverse_mass, law, beads = setup.inverse_mass, setup.law, len(setup.inverse_mass)
    pushing, overlap = contacts.implicit.forces, contacts.implicit.overlaps
    closing = contacts.implicit.closings
    for i in range(IMPLICIT_STAGES):
        for k in range(beads):
            least = EVEN * abs(rates[i, k])
            if rates[i, beads + k] * time < least:
                rates[i, beads + k] = min(0.0, rates[i, beads + k])
            still = contacts.mode[k] == LOADED and abs(closing[k, i]) < least
            if setup.stiffness[k] > 0.0 and still:
                spring = force(overlap[k, i], setup.stiffness[k], law.exponent)
                if abs(pushing[k, i] - spring) * inverse_mass[k] * time < least:
                    pushing[k, i] = spring


@compiled
def settle(time, y, h, setup, contacts, segment, rtol, stages, ahead, speeds, scale):
    """The forces and the derivative that a state has, by a very short implicit step.

    The speed at which a contact creeps may be less than the rounding of the beads' velocities, so
    that the law does not tell its force.  Depends on the state alone, so that a run that is
    resumed from it takes the same steps.
    """
    beads, law, rtol = len(setup.inverse_mass), setup.law, max(rtol, FINEST)
    pushing, wall = contacts.implicit.forces, wall_motion(time, setup, segment)
    for c in range(beads + 1):
        overlap = overlap_of(c, y, wall, setup, contacts)
        acts = contacts.mode[c] == LOADED and setup.stiffness[c] > 0.0
        spring = force(overlap, setup.stiffness[c], law.exponent)
        pushing[c, 0] = spring if acts else 0.0
        contacts.last_force[c] = pushing[c, 0]
    solved = solve_stages(time, SETTLING * h, h, y, ONE_STAGE, ONE_STAGE, END, setup, contacts,
                          segment, rtol, stages[1:2], ahead, speeds, scale)  # fmt: skip
    for c in range(beads + 1):
        contacts.force[c] = contacts.last_force[c] = pushing[c, 0]
    for k in range(beads):
        stages[0, k] = y[beads + k]
        stages[0, beads + k] = stages[1, beads + k]
    copy(stages[0, :beads], stages[1, :beads])
    ledger_rates(0, time, setup, contacts, segment, stages[1])
    copy(stages[1, 2 * beads :], stages[0, 2 * beads :])
    return solved


@compiled
def try_implicit_step(time, y, h, setup, contacts, segment, rtol, stages, y_new, speeds, scale):
    """One implicit step; returns whether its equations could be solved."""
    rtol = max(rtol, FINEST)
    beads, rates = len(setup.inverse_mass), stages[1 : IMPLICIT_STAGES + 1]
    if not settle(time, y, h, setup, contacts, segment, rtol, stages, y_new, speeds, scale):
        return False
    pushing = contacts.implicit.forces
    for c in range(beads + 1):
        for i in range(IMPLICIT_STAGES):
            pushing[c, i] = contacts.force[c]
    if not solve_stages(time, h, h, y, WEIGHTS, SQUARED, TIMES, setup, contacts, segment, rtol,
                        rates, y_new, speeds, scale):  # fmt: skip
        return False
    for i in range(IMPLICIT_STAGES):
        ledger_rates(i, time + TIMES[i] * h, setup, contacts, segment, rates[i])
    for i in range(len(y)):
        gained = 0.0
        for j in range(IMPLICIT_STAGES):
            gained += WEIGHTS[IMPLICIT_STAGES - 1, j] * rates[j, i]
        y_new[i] = y[i] + h * gained
    for c in range(beads + 1):
        contacts.force[c] = pushing[c, IMPLICIT_STAGES - 1]
    resolve_overlaps(time, h, y, setup, contacts, segment)
    forget_rounding(time + h, setup, contacts, rates)
    # Whoever looks through the stages of an explicit step finds the end in those that are left.
    for row in range(IMPLICIT_STAGES + 1, STEP_STAGES + 1):
        copy(stages[IMPLICIT_STAGES], stages[row])
    return True


@compiled
def error_of_ledger(h, stages, setup, rtol):
    """How well the energy lost is known, in tolerances of energy.

    Where a force is cut off beads may fly freely, and only what is lost needs shorter steps.
    """
    beads, last, kinetic = len(setup.inverse_mass), 0.0, 0.0
    for k in range(beads):
        speed = max(abs(stages[IMPLICIT_STAGES, k]), setup.law.slowest)
        kinetic += 0.5 * speed * speed / setup.inverse_mass[k]
    for i in range(IMPLICIT_STAGES):
        last += LAST[i] * stages[i + 1, 2 * beads + LOST]
    return h * abs(last) / (ENERGY * rtol * kinetic) if kinetic > 0.0 else 0.0


@compiled
def implicit_error(h, stages, setup, scale, rtol):
    """Estimated error of an implicit step, in tolerances.

    The next Legendre coefficient of the accelerations, from the last two: as small beside the
    last as this is beside the one before.  Between the start and the first node a force may have
    bent unseen: there, the interpolant must lead back to the acceleration at the start.
    """
    beads, rtol = len(scale), max(rtol, FINEST)
    worst, worst_before, bent = error_of_ledger(h, stages, setup, rtol), 0.0, 0.0
    for k in range(beads):
        if scale[k] == 0.0:
            continue
        last, before, first = 0.0, 0.0, -stages[0, beads + k]
        for i in range(IMPLICIT_STAGES):
            last += LAST[i] * stages[i + 1, beads + k]
            before += BEFORE_LAST[i] * stages[i + 1, beads + k]
            first += AT_START[i] * stages[i + 1, beads + k]
        unit = h / (rtol * scale[k])
        worst, worst_before = max(worst, abs(last) * unit), max(worst_before, abs(before) * unit)
        # No acceleration at the start is known better than its equations were solved.
        if SETTLING * abs(first) * unit > SOLVED:
            bent = max(bent, 0.5 * NODES[0] * abs(first) * unit)
    if worst_before > worst:
        worst *= worst / worst_before
    return max(worst, bent)


@compiled
def first_rest(k, beads, stages):
    """When in the step bead k is first no longer pushed; 2 if at no stage."""
    for i in range(IMPLICIT_STAGES):
        if stages[i + 1, beads + k] <= 0.0:
            return NODES[i]
    return 2.0


@compiled
def closes_in(closing, speed, pushing, overlap, stiffness, exponent):
    """Whether a contact closes in, by the sign of its damping if not by that of its speed."""
    if abs(closing) > EVEN * speed:
        return closing > 0.0
    return pushing > force(overlap, stiffness, exponent)


@compiled
def closes_throughout(c, setup, contacts, stages):
    """Whether contact c closes in at all stages."""
    beads, scratch = len(setup.inverse_mass), contacts.implicit
    for i in range(IMPLICIT_STAGES):
        speed = abs(stages[i + 1, c]) if c < beads else 0.0
        if not closes_in(
            scratch.closings[c, i], speed, scratch.forces[c, i], scratch.overlaps[c, i],
            setup.stiffness[c], setup.law.exponent,
        ):  # fmt: skip
            return False
    return True


@compiled
def implicit_coefficients(h, stages, dense):
    """The interpolant of an implicit step, as that of an explicit one."""
    for row in range(len(dense)):
        for i in range(dense.shape[1]):
            total = 0.0
            for j in range(IMPLICIT_STAGES):
                total += TO_DENSE[row, j] * stages[j + 1, i]
            dense[row, i] = h * total


@compiled
def between(c, theta, values):
    """A row of scratch of contact c at the fraction theta of an implicit step."""
    total = 0.0
    for i in range(IMPLICIT_STAGES):
        weight = 0.0
        for power in range(IMPLICIT_STAGES - 1, -1, -1):
            weight = weight * theta + BETWEEN[power, i]
        total += weight * values[c, i]
    return total


@compiled
def force_within(c, theta, contacts):
    """Force of contact c at the fraction theta of an implicit step."""
    return between(c, theta, contacts.implicit.forces)


@compiled
def overlap_within(c, theta, y, overlap, setup, contacts):
    """Overlap of contact c there, where y and the overlap by it are given."""
    if is_resolved(c, y, overlap, setup):
        return overlap
    return between(c, theta, contacts.implicit.overlaps)
