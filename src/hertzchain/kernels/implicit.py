r"""One implicit step, for contacts whose damping is too stiff for explicit ones.

With a damping force :math:`\gamma |d'|^\alpha`, :math:`\alpha < 1`, two beads with a small relative
speed are held together by a force that is not a smooth function of this speed.  With a strong
dashpot they creep.  Explicit steps would have to resolve the fast relaxation in either case.  An
implicit step solves for the forces at its stages (`hertzchain.kernels.stage_equations`), and its
length is limited only by the slow motion.
"""

from __future__ import annotations

import numpy as np

from .compilation import compiled
from .contact_law import LOADED, force, law_of, signed_power
from .dop853 import STEP_STAGES
from .driving import PUSH, drive_at, wall_motion
from .error_scale import general_scale
from .forces import DRIVEN, LEFT_IMPULSE, LOST, PUSHED, RIGHT_IMPULSE, copy
from .limits import ROUNDING
from .radau import (
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
from .stage_equations import SOLVED, solve_stages
from .stiff_law import EVEN, closes_in, is_resolved, overlap_of, sliding_force_within

TIMES = np.array(NODES)
END = np.ones(1)
# Lower bound of the tolerance, because stiff contacts amplify rounding errors of velocities.
FINEST = 1e-11
# Relative tolerance of energies, in units of that of speeds.
ENERGY = 10.0
# Length of the very short step that determines the forces of a state, as a fraction of a step.
SETTLING = 1e-3
# Weights of the accelerations at the nodes in the interpolated acceleration at the start.
AT_START = SETTLING ** np.arange(IMPLICIT_STAGES) @ BETWEEN


@compiled
def accumulator_rates(i, time, setup, contacts, segment, rates):
    """Rates of the accumulators at stage i."""
    beads = len(setup.inverse_mass)
    pushing, overlap = contacts.implicit.forces, contacts.implicit.overlaps
    closing, accumulators = contacts.implicit.closings, rates[2 * beads :]
    lost = 0.0
    for c in range(beads + 1):
        if setup.stiffness[c] > 0.0 and contacts.mode[c] == LOADED:
            spring = force(overlap[c, i], setup.stiffness[c], law_of(c, setup).exponent)
            lost += (pushing[c, i] - spring) * closing[c, i]
    accumulators[LOST] = lost
    accumulators[DRIVEN] = pushing[0, i] * wall_motion(time, setup, segment)[1]
    accumulators[PUSHED] = 0.0
    if setup.drive == PUSH:
        drive = drive_at(time, setup, segment)[0]
        accumulators[DRIVEN], accumulators[PUSHED] = drive * rates[0], drive
    accumulators[LEFT_IMPULSE], accumulators[RIGHT_IMPULSE] = pushing[0, i], pushing[beads, i]


@compiled
def resolve_overlaps(time, h, y, setup, contacts, segment):
    """Integrate overlaps smaller than the rounding of positions, from the speeds of the forces."""
    beads, speed = len(setup.inverse_mass), contacts.implicit.residual
    pushing, overlap = contacts.implicit.forces, contacts.implicit.overlaps
    wall = wall_motion(time, setup, segment)
    for c in range(beads + 1):
        law = law_of(c, setup)
        if contacts.mode[c] != LOADED or setup.damping[c] == 0.0 or law.overlap_power > 0.0:
            continue
        if is_resolved(c, y, overlap[c, IMPLICIT_STAGES - 1], setup):
            continue
        first = overlap_of(c, y, wall, setup, contacts)
        for i in range(IMPLICIT_STAGES):
            damped = pushing[c, i] - force(overlap[c, i], setup.stiffness[c], law.exponent)
            speed[c, i] = signed_power(damped / setup.damping[c], 1.0 / law.speed_power)
        for i in range(IMPLICIT_STAGES):
            gained = 0.0
            for j in range(IMPLICIT_STAGES):
                gained += WEIGHTS[i, j] * speed[c, j]
            overlap[c, i] = first + h * gained


@compiled
def remember_overlaps(contacts, implicit):
    """Store the overlaps at the end of the step, from which the next one begins.

    Beads that push each other touch: a negative overlap is then an error within the tolerance.
    """
    if implicit is None:
        return
    for c in range(len(contacts.mode)):
        if contacts.mode[c] == LOADED:
            overlap = implicit.overlaps[c, IMPLICIT_STAGES - 1]
            pushed = implicit.forces[c, IMPLICIT_STAGES - 1] > 0.0
            contacts.largest[c] = max(overlap, 0.0) if pushed else overlap


@compiled
def forget_rounding(time, setup, contacts, rates):
    """Remove net forces too small to change a velocity in the whole time that has passed.

    The beads of contacts that stick acquire the same velocity, and the signs of the remaining
    forces are then those of rounding errors.
    """
    inverse_mass, beads = setup.inverse_mass, len(setup.inverse_mass)
    pushing, overlap = contacts.implicit.forces, contacts.implicit.overlaps
    closing = contacts.implicit.closings
    for i in range(IMPLICIT_STAGES):
        for k in range(beads):
            least = EVEN * abs(rates[i, k])
            if rates[i, beads + k] * time < least:
                rates[i, beads + k] = min(0.0, rates[i, beads + k])
            still = contacts.mode[k] == LOADED and abs(closing[k, i]) < least
            if setup.stiffness[k] > 0.0 and still:
                exponent = law_of(k, setup).exponent
                spring = force(overlap[k, i], setup.stiffness[k], exponent)
                if abs(pushing[k, i] - spring) * inverse_mass[k] * time < least:
                    pushing[k, i] = spring


@compiled
def settle(time, y, h, setup, contacts, implicit, segment, rtol, stages, ahead, speeds, scale):
    """Determine the forces and the derivative of a state by a very short implicit step.

    The speed at which a contact creeps may be less than the rounding error of the velocities; its
    force then cannot be computed from the law.  The result depends only on the state, so that a
    resumed run takes the same steps.
    """
    if implicit is None:
        return False
    beads, rtol = len(setup.inverse_mass), max(rtol, FINEST)
    pushing, wall = implicit.forces, wall_motion(time, setup, segment)
    for c in range(beads + 1):
        overlap = overlap_of(c, y, wall, setup, contacts)
        acts = contacts.mode[c] == LOADED and setup.stiffness[c] > 0.0
        spring = force(overlap, setup.stiffness[c], law_of(c, setup).exponent)
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
    accumulator_rates(0, time, setup, contacts, segment, stages[1])
    copy(stages[1, 2 * beads :], stages[0, 2 * beads :])
    return solved


@compiled
def try_implicit_step(
    time, y, h, setup, contacts, implicit, segment, rtol, stages, y_new, speeds, scale
):
    """One implicit step; returns whether its equations could be solved."""
    if implicit is None:
        return False
    rtol = max(rtol, FINEST)
    beads, rates = len(setup.inverse_mass), stages[1 : IMPLICIT_STAGES + 1]
    if not settle(
        time, y, h, setup, contacts, implicit, segment, rtol, stages, y_new, speeds, scale
    ):
        return False
    pushing = implicit.forces
    for c in range(beads + 1):
        for i in range(IMPLICIT_STAGES):
            pushing[c, i] = contacts.force[c]
    if not solve_stages(time, h, h, y, WEIGHTS, SQUARED, TIMES, setup, contacts, segment, rtol,
                        rates, y_new, speeds, scale):  # fmt: skip
        return False
    for i in range(IMPLICIT_STAGES):
        accumulator_rates(i, time + TIMES[i] * h, setup, contacts, segment, rates[i])
    for i in range(len(y)):
        gained = 0.0
        for j in range(IMPLICIT_STAGES):
            gained += WEIGHTS[IMPLICIT_STAGES - 1, j] * rates[j, i]
        y_new[i] = y[i] + h * gained
    for c in range(beads + 1):
        contacts.force[c] = pushing[c, IMPLICIT_STAGES - 1]
    resolve_overlaps(time, h, y, setup, contacts, segment)
    forget_rounding(time + h, setup, contacts, rates)
    # Functions that search all stages of an explicit step find the last one in the unused rows.
    for row in range(IMPLICIT_STAGES + 1, STEP_STAGES + 1):
        copy(stages[IMPLICIT_STAGES], stages[row])
    return True


@compiled
def error_of_losses(h, stages, setup, rtol):
    """Estimated error of the energy lost, in tolerances of energy.

    After a force is cut off, beads may be in free flight, and only the energy lost requires shorter
    steps.
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

    The estimate is the next Legendre coefficient of the accelerations, extrapolated geometrically
    from the last two.  A force may have changed abruptly between the start and the first node;
    therefore the interpolant must also reproduce the acceleration at the start.
    """
    beads, rtol = len(scale), max(rtol, FINEST)
    worst, worst_before, bent = error_of_losses(h, stages, setup, rtol), 0.0, 0.0
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
        # The acceleration at the start is only as accurate as the solution of its equations.
        if SETTLING * abs(first) * unit > SOLVED:
            bent = max(bent, 0.5 * NODES[0] * abs(first) * unit)
    if worst_before > worst:
        worst *= worst / worst_before
    return max(worst, bent)


@compiled
def first_rest(k, beads, stages):
    """Time, as a fraction of the step, of the first stage without a push on bead k; 2 if none."""
    for i in range(IMPLICIT_STAGES):
        if stages[i + 1, beads + k] <= 0.0:
            return NODES[i]
    return 2.0


@compiled
def closes_throughout(c, setup, implicit, stages):
    """Whether the beads of contact c approach each other at all stages."""
    if implicit is None:
        return True
    pushing, overlap = implicit.forces, implicit.overlaps
    closing, beads = implicit.closings, len(setup.inverse_mass)
    for i in range(IMPLICIT_STAGES):
        speed = abs(stages[i + 1, c]) if c < beads else 0.0
        if not closes_in(closing[c, i], speed, pushing[c, i], overlap[c, i], setup.stiffness[c],
                         law_of(c, setup).exponent):  # fmt: skip
            return False
    return True


@compiled
def implicit_coefficients(h, stages, dense):
    """Coefficients of the interpolant of an implicit step, in the form of an explicit one."""
    for row in range(len(dense)):
        for i in range(dense.shape[1]):
            total = 0.0
            for j in range(IMPLICIT_STAGES):
                total += TO_DENSE[row, j] * stages[j + 1, i]
            dense[row, i] = h * total


@compiled
def begin(time, y, h, setup, contacts, segment, rtol, stages, work, scale):
    """Compute the derivative at the start of the next step."""
    speeds = work[3, len(scale) : 2 * len(scale)]
    settle(
        time, y, h, setup, contacts, contacts.implicit, segment, rtol, stages, work[0], speeds,
        scale,
    )  # fmt: skip


@compiled
def take_step(time, y, h, setup, contacts, segment, rtol, stages, trial, y_new, work, scale):  # noqa: ARG001
    """Take one step; returns its error in tolerances (NaN if it failed) and evaluations."""
    speeds = work[3, len(scale) : 2 * len(scale)]
    wall_speed = wall_motion(time + h, setup, segment)[1]
    if not try_implicit_step(
        time, y, h, setup, contacts, contacts.implicit, segment, rtol, stages, y_new, speeds, scale
    ):
        return np.nan, IMPLICIT_STAGES
    general_scale(
        time, h, y, y_new, wall_speed, setup, contacts, segment, rtol, ROUNDING, speeds, scale
    )
    return implicit_error(h, stages, setup, scale, rtol), IMPLICIT_STAGES


@compiled
def interpolate(time, y, h, y_new, setup, contacts, segment, stages, dense, trial, scratch):  # noqa: ARG001
    """Compute the coefficients of the interpolant of a step; returns evaluations."""
    implicit_coefficients(h, stages, dense)
    return 0


@compiled
def forces_within(theta, time, h, state, setup, contacts, segment, scratch):  # noqa: ARG001
    """Compute the contact forces at the fraction theta of a step, from the state there."""
    wall = wall_motion(time + theta * h, setup, segment)
    for c in range(len(contacts.force)):
        contacts.force[c] = sliding_force_within(
            c, theta, h, state, wall, setup, contacts, contacts.implicit
        )
