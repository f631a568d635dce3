r"""The whole chain, every bead, by an adaptive Runge-Kutta method of order 8.

`advance` takes steps of DOP853 (`hertzchain.kernels.dop853`) and looks between
them for what the eye would pick from the curves: the first maximum of each
bead's velocity and the largest overlap of each contact.  Both are found on the
method's interpolant of order 7 by bisection, not among the steps.

Contacts open and close with a force that is not smooth (a power 3/2 of time), and
so does the strike begin; there the error estimate shortens the steps by itself.
Where a law's force jumps, has a memory or is cut off, each contact is in a *mode*
(`hertzchain.kernels.forces`) that is kept within a step: the first moment at which one
must change is located on the interpolant, and the step ends there.
"""

from __future__ import annotations

import numpy as np

from hertzchain.kernels.dop853 import E3, E5, STAGES, STEP_STAGES, A, B, D
from hertzchain.kernels.forces import (
    DAMPED,
    LEDGER,
    LEFT_IMPULSE,
    LOADED,
    LOST,
    NOTHING,
    PLASTIC,
    RELEASED,
    RIGHT_IMPULSE,
    STUCK,
    UNLOADING,
    compiled,
    derivative,
    force,
    has_modes,
    must_switch,
    next_mode,
    overlap_and_closing,
    potential,
    wall_motion,
)
from hertzchain.kernels.forces import DRIVEN as DRIVEN
from hertzchain.kernels.forces import PUSHED as PUSHED
from hertzchain.kernels.forces import Plain as Plain

# What `advance` returns.
RUNNING, PULSE_LEFT, TIME_REACHED, FRAMES_FULL, STEP_TOO_SMALL, PULSE_LOST, LAST_STEP = range(7)

# Meaning of the entries of `clock` and `counts`, the parts of the state that are no arrays.
TIME, STEP, SINCE_CROSSING, FASTEST = 0, 1, 2, 3
INITIAL_ENERGY, INITIAL_MOMENTUM, ENERGY_UNIT, MOMENTUM_UNIT = range(4, 8)
ENERGY_DRIFT, MOMENTUM_DRIFT, CLOCK_SIZE = 8, 9, 10
STEPS, EVALUATIONS, FRAMES, PEAKS, CROSSINGS, LAST_CROSSING, FROZEN, SEGMENT, SWITCHES = range(9)
COUNTS_SIZE = 9
# Rows of `peaks`, of `crossings` and of `walls`.
PEAK_TIME, PEAK_VELOCITY = 0, 1
CROSSING_TIME, OVERLAP, RESIDENCE = 0, 1, 2
WALL_PEAK_TIME, WALL_PEAK, FIRST_IMPULSE, FIRST_END, WALL_ROWS = range(5)
# Peak time of a striker, which has its velocity from the start on.
FROM_THE_START = -1.0
# A bead slower than this, in parts of the speeds around it, is not reached yet: rounding
# ahead of the pulse could look like a maximum.
REACHED = 1e-11
# Beads to either side that set the scale of a bead's error, and the part of the fastest
# bead in contact that sets it where all of them are slow: the debris behind a pulse.
NEIGHBOURS = 3
SLOW = 1e-4
# Beads slower than this have not been reached: numbers that underflow ahead of the front.
AT_REST = 1e-290
# Part of a force that is lost to rounding, with what the error estimate makes of it.
ROUNDING = 5e-15
SMALLEST_STEP = 1e-280
# A run that waits this long for the pulse to leave waits for ever.
ENDLESS = 1e300
BISECTIONS = 48
# Parts of a step that are searched for the first event: a light bead may turn twice in one.
PARTS = 8
# Steps too short for the clock to notice, in a row, after which the run is given up.
MOST_FROZEN = 100_000
# What counts as no relative motion, in parts of the fastest motion so far: a contact at rest
# must not change its mode for rounding.
STILL = 1e-14
# When in a step its stages are.
C = A.sum(axis=1)


@compiled
def add_stages(y, h, weights, stages, count, out):
    """Write y + h * sum over the first stages of weight * stage into ``out``."""
    out[:] = y
    for j in range(count):
        if weights[j] != 0.0:
            factor = h * weights[j]
            for i in range(len(y)):
                out[i] += factor * stages[j, i]


@compiled
def try_step(time, y, h, setup, contacts, segment, stages, trial, y_new):
    """One step of order 8; stage 0 must hold the derivative at its start."""
    for s in range(1, STEP_STAGES):
        add_stages(y, h, A[s], stages, s, trial)
        derivative(time + C[s] * h, trial, setup, contacts, segment, stages[s])
    add_stages(y, h, B, stages, STEP_STAGES, y_new)
    derivative(time + h, y_new, setup, contacts, segment, stages[STEP_STAGES])


@compiled
def complete_stages(time, y, h, setup, contacts, segment, stages, trial):
    """The three further stages that the interpolant needs."""
    for s in range(STEP_STAGES + 1, STAGES):
        add_stages(y, h, A[s], stages, s, trial)
        derivative(time + C[s] * h, trial, setup, contacts, segment, stages[s])


@compiled
def velocity_scale(y, scale):
    """The speeds in which the beads' errors are measured.

    A bead's is the largest within a few beads, or a small part of that of the fastest
    bead in contact: beads that have lost contact move exactly, however fast they are.
    """
    beads = len(scale)
    fastest = 0.0
    for k in range(beads - 1):
        if y[k] > y[k + 1]:
            fastest = max(fastest, abs(y[beads + k]), abs(y[beads + k + 1]))
    for k in range(beads):
        largest = SLOW * fastest
        for j in range(max(k - NEIGHBOURS, 0), min(k + NEIGHBOURS + 1, beads)):
            largest = max(largest, abs(y[beads + j]))
        scale[k] = largest


@compiled
def bench_scale(h, y, wall_speed, setup, contacts, rtol, scale):
    """The same at the end of a step, as on a bench much begins at rest.

    There are gaps, the left wall may move and set beads in motion, and where contacts bear
    static forces no velocity is known better than these are rounded.
    """
    beads = len(scale)
    # Those at its start: a step that is far too long ends with any force.
    pushing, inverse_mass = contacts.last_force, setup.inverse_mass
    fastest = 0.0
    for c in range(beads + 1):
        if pushing[c] != 0.0:
            for k in range(max(c - 1, 0), min(c + 1, beads)):
                fastest = max(fastest, abs(y[beads + k]))
    for k in range(beads):
        rounding = ROUNDING * (abs(pushing[k]) + abs(pushing[k + 1])) * inverse_mass[k] * h / rtol
        largest = max(SLOW * fastest, rounding)
        if k < NEIGHBOURS:
            largest = max(largest, abs(wall_speed))
        for j in range(max(k - NEIGHBOURS, 0), min(k + NEIGHBOURS + 1, beads)):
            largest = max(largest, abs(y[beads + j]))
        scale[k] = largest


@compiled
def error_norm(h, stages, scale, rtol, errors):
    """Largest estimated error of a step, in tolerances; not a number if a stage is none.

    Positions count as the velocity error that would cause them within the step.
    """
    beads = len(scale)
    worst5 = 0.0
    worst3 = 0.0
    errors[:] = 0.0
    for j in range(STEP_STAGES + 1):
        # The method leaves stages 1 to 4 out of both estimates.
        if E5[j] != 0.0 or E3[j] != 0.0:
            for i in range(2 * beads):
                errors[0, i] += E5[j] * stages[j, i]
                errors[1, i] += E3[j] * stages[j, i]
    for k in range(beads):
        if scale[k] < AT_REST:
            continue
        for i in (k, beads + k):
            error5, error3 = errors[0, i], errors[1, i]
            unit = rtol * scale[k] if i < beads else rtol * scale[k] / h
            # Written so that what is not a number is kept: max() would lose it.
            if not abs(error5) / unit <= worst5:
                worst5 = abs(error5) / unit
            if not abs(error3) / unit <= worst3:
                worst3 = abs(error3) / unit
    if worst5 == 0.0:
        return 0.0
    return worst5 * worst5 / np.sqrt(worst5 * worst5 + 0.01 * worst3 * worst3)


@compiled
def interpolate(i, theta, h, y, y_new, stages):
    """Component i of the state at the fraction theta of a completed step."""
    change = y_new[i] - y[i]
    value = 0.0
    for row in range(3, -1, -1):
        coefficient = 0.0
        for j in range(STAGES):
            coefficient += D[row, j] * stages[j, i]
        value = (value + h * coefficient) * (theta if row % 2 == 1 else 1.0 - theta)
    value = (value + 2.0 * change - h * (stages[STEP_STAGES, i] + stages[0, i])) * theta
    value = (value + h * stages[0, i] - change) * (1.0 - theta)
    return y[i] + (value + change) * theta


@compiled
def slope(i, theta, h, y, y_new, stages):
    """Rate of change of component i at the fraction theta of a completed step."""
    change = y_new[i] - y[i]
    value = 0.0
    rate = 0.0
    for row in range(6, -1, -1):
        if row > 2:
            coefficient = 0.0
            for j in range(STAGES):
                coefficient += D[row - 3, j] * stages[j, i]
            coefficient *= h
        elif row == 2:
            coefficient = 2.0 * change - h * (stages[STEP_STAGES, i] + stages[0, i])
        elif row == 1:
            coefficient = h * stages[0, i] - change
        else:
            coefficient = change
        value += coefficient
        if row % 2 == 0:
            value, rate = value * theta, rate * theta + value
        else:
            value, rate = value * (1.0 - theta), rate * (1.0 - theta) - value
    return rate / h


@compiled
def acceleration_within(k, theta, h, y, y_new, stages, setup, contacts):
    """Acceleration of bead k, or net force on it, at the fraction theta of a completed step."""
    if contacts is not None:
        return slope(len(setup.inverse_mass) + k, theta, h, y, y_new, stages)
    here = interpolate(k, theta, h, y, y_new, stages)
    net = 0.0
    if k > 0:
        left = interpolate(k - 1, theta, h, y, y_new, stages)
        net += force(left - here, setup.stiffness[k - 1], setup.exponent)
    if k < len(setup.inverse_mass) - 1:
        right = interpolate(k + 1, theta, h, y, y_new, stages)
        net -= force(here - right, setup.stiffness[k], setup.exponent)
    return net


@compiled
def peak_within(k, h, y, y_new, stages, setup, contacts):
    """Where in the step the net force on bead k first stops being positive; 2 if nowhere."""
    low = 0.0
    for part in range(1, PARTS + 1):
        high = part / PARTS
        if acceleration_within(k, high, h, y, y_new, stages, setup, contacts) <= 0.0:
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                a = acceleration_within(k, middle, h, y, y_new, stages, setup, contacts)
                low, high = (middle, high) if a > 0.0 else (low, middle)
            return high
        low = high
    return 2.0


@compiled
def crossing_within(c, beads, h, y, y_new, stages):
    """Where in the step beads c and c + 1 (0-based) first have equal velocities; 2 if nowhere."""
    left = beads + c
    low = 0.0
    for part in range(1, PARTS + 1):
        high = part / PARTS
        ahead = interpolate(left + 1, high, h, y, y_new, stages)
        if interpolate(left, high, h, y, y_new, stages) <= ahead:
            for _ in range(BISECTIONS):
                middle = 0.5 * (low + high)
                ahead = interpolate(left + 1, middle, h, y, y_new, stages)
                closing = interpolate(left, middle, h, y, y_new, stages) > ahead
                low, high = (middle, high) if closing else (low, middle)
            return high
        low = high
    return 2.0


@compiled
def may_peak(k, beads, stages):
    """Whether some stage of the step finds bead k, pushed at its start, no longer pushed."""
    i = beads + k
    if stages[0, i] <= 0.0:
        return False
    for j in range(1, STEP_STAGES + 1):
        if stages[j, i] <= 0.0:
            return True
    return False


@compiled
def may_cross(c, stages):
    """Whether some stage finds beads c and c + 1, closing at its start, at equal speed."""
    if stages[0, c] <= stages[0, c + 1]:
        return False
    for j in range(1, STEP_STAGES + 1):
        if stages[j, c] <= stages[j, c + 1]:
            return True
    return False


@compiled
def record_peaks(h, time, y, y_new, stages, setup, contacts, expected, peaks):
    """First maxima of velocity within the step, of the beads where one is expected."""
    beads = len(setup.inverse_mass)
    found = 0
    for k in range(1, beads):
        if not expected[k]:
            continue
        theta = peak_within(k, h, y, y_new, stages, setup, contacts)
        if theta > 1.0:
            continue
        peaks[PEAK_TIME, k] = time + theta * h
        # A bead that has left both neighbours for good flies on at the step's last velocity.
        flies = stages[STEP_STAGES, beads + k] == 0.0 and (
            acceleration_within(k, theta, h, y, y_new, stages, setup, contacts) == 0.0
        )
        velocity = interpolate(beads + k, theta, h, y, y_new, stages)
        peaks[PEAK_VELOCITY, k] = y_new[beads + k] if flies else velocity
        found += 1
    return found


@compiled
def record_jumps(time, y, stages, scale, peaks):
    """First maxima of velocity where an acceleration jumped down, between two steps."""
    beads = len(scale)
    found = 0
    for k in range(1, beads):
        i = beads + k
        jumped = stages[STEP_STAGES, i] > 0.0 and stages[0, i] <= 0.0
        if jumped and peaks[PEAK_TIME, k] == 0.0 and y[i] > REACHED * scale[k]:
            peaks[PEAK_TIME, k] = time
            peaks[PEAK_VELOCITY, k] = y[i]
            found += 1
    return found


@compiled
def record_crossings(h, clock, counts, y, y_new, stages, setup, contacts, expected, crossings):
    """First moments of equal neighbour velocities within the step: largest overlaps.

    The residence is counted from the crossing before, since the difference of two times
    loses its digits where the pulse becomes much faster than it was.
    """
    for c in range(crossings.shape[1]):
        if not expected[c]:
            continue
        theta = crossing_within(c, crossings.shape[1] + 1, h, y, y_new, stages)
        if theta > 1.0:
            continue
        crossings[CROSSING_TIME, c] = clock[TIME] + theta * h
        behind = interpolate(c, theta, h, y, y_new, stages)
        overlap = behind - interpolate(c + 1, theta, h, y, y_new, stages)
        if contacts is not None:
            overlap -= setup.gap[c + 1]
        crossings[OVERLAP, c] = overlap
        if counts[LAST_CROSSING] == c - 1:
            crossings[RESIDENCE, c] = clock[SINCE_CROSSING] + theta * h
        counts[LAST_CROSSING] = c
        counts[CROSSINGS] += 1
        clock[SINCE_CROSSING] = -theta * h


@compiled
def expect_events(y_new, stages, scale, contacts, peaks, crossings, expected):
    """Mark the beads and contacts whose first peak or crossing may lie within the step."""
    beads = len(scale)
    anything = False
    for k in range(1, beads):
        reached = y_new[beads + k] > REACHED * scale[k]
        peak = reached and peaks[PEAK_TIME, k] == 0.0 and may_peak(k, beads, stages)
        waiting = crossings[CROSSING_TIME, k - 1] == 0.0
        if contacts is not None:
            # Before a wall a bead may have turned round.
            reached = abs(y_new[beads + k]) > REACHED * scale[k]
        crossing = reached and waiting and may_cross(k - 1, stages)
        expected[0, k] = peak
        expected[1, k - 1] = crossing
        anything = anything or peak or crossing
    return anything


@compiled
def nothing_can_happen(y, setup, contacts):
    """Whether no beads touch and none approach: from here on all fly freely."""
    beads = len(setup.inverse_mass)
    if contacts is None:
        for k in range(beads - 1):
            if y[k] > y[k + 1] or y[beads + k] > y[beads + k + 1]:
                return False
        return True
    if setup.drive != NOTHING or setup.body_force.any():
        return False
    for c in range(beads + 1):
        if setup.stiffness[c] > 0.0:
            overlap, closing = overlap_and_closing(c, y, beads, setup.gap[c], (0.0, 0.0, 0.0))
            if overlap > 0.0 or closing > 0.0:
                return False
    return True


@compiled
def switch_within(c, time, y, h, y_new, stages, setup, contacts, segment, still, trial, scratch):
    """Where in the step contact c first must leave its mode; 2 if nowhere."""
    beads, law, gap = len(setup.inverse_mass), setup.law, setup.gap[c]
    stiffness, damping = setup.stiffness[c], setup.damping[c]
    mode, largest, force_of = contacts.mode[c], contacts.largest[c], contacts.force
    # A stuck contact's force depends on all beads, that of another one on its own two.
    stuck = mode == STUCK
    first, last = (0, beads) if stuck else (max(c - 1, 0), min(c + 1, beads))
    low, high, found = 0.0, 0.0, False
    for part in range(1, PARTS + BISECTIONS + 1):
        if found:
            theta = 0.5 * (low + high)
        elif part > PARTS:
            return 2.0
        else:
            theta = part / PARTS
        for k in range(first, last):
            trial[k] = interpolate(k, theta, h, y, y_new, stages)
            trial[beads + k] = interpolate(beads + k, theta, h, y, y_new, stages)
        if stuck:
            derivative(time + theta * h, trial, setup, contacts, segment, scratch)
        wall = wall_motion(time + theta * h, setup, segment)
        overlap, closing = overlap_and_closing(c, trial, beads, gap, wall)
        if must_switch(
            overlap, closing, stiffness, damping, mode, largest, force_of[c], law, still
        ):
            high, found = theta, True
        else:
            low = theta
    return high


@compiled
def turned(c, beads, wall_speed, sign, stages, still):
    """Whether some stage of the step finds contact c opening (sign 1) or closing (-1)."""
    for j in range(1, STEP_STAGES):
        left = stages[j, c - 1] if c > 0 else wall_speed
        right = stages[j, c] if c < beads else 0.0
        if sign * (left - right) < -still:
            return True
    return False


@compiled
def first_switch(time, y, h, y_new, stages, setup, contacts, segment, still, trial, scratch):
    """The first contact that must leave its mode within the step, and where; -1 if none."""
    stiffness, gap, damping, law = setup.stiffness, setup.gap, setup.damping, setup.law
    mode, largest, held = contacts.mode, contacts.largest, contacts.force
    beads = len(setup.inverse_mass)
    wall = wall_motion(time + h, setup, segment)
    by_speed = law.kind == UNLOADING or law.kind == PLASTIC
    first, earliest = -1, 2.0
    for c in range(beads + 1):
        if stiffness[c] == 0.0:
            continue
        overlap, closing = overlap_and_closing(c, y_new, beads, gap[c], wall)
        may = must_switch(
            overlap, closing, stiffness[c], damping[c], mode[c], largest[c], held[c], law, still
        )
        if not may and by_speed and mode[c] == LOADED:
            may = turned(c, beads, wall[1], 1.0, stages, still)
        if not may and law.kind == UNLOADING and mode[c] == RELEASED:
            may = turned(c, beads, wall[1], -1.0, stages, still)
        if not may:
            continue
        if first < 0:
            complete_stages(time, y, h, setup, contacts, segment, stages, trial)
        theta = switch_within(
            c, time, y, h, y_new, stages, setup, contacts, segment, still, trial, scratch
        )
        # The forces of stuck contacts were overwritten.
        derivative(time + h, y_new, setup, contacts, segment, scratch)
        if first < 0 or theta < earliest:
            first, earliest = c, theta
    return first if earliest <= 1.0 else -1, earliest


@compiled
def switch(first, time, y, setup, contacts, segment, still, scratch):
    """Give contact ``first`` its next mode, and all others that must change at this moment."""
    stiffness, gap, damping, law = setup.stiffness, setup.gap, setup.damping, setup.law
    mode, largest, held = contacts.mode, contacts.largest, contacts.force
    beads = len(setup.inverse_mass)
    wall = wall_motion(time, setup, segment)
    for c in range(beads + 1):
        if stiffness[c] == 0.0:
            continue
        overlap, closing = overlap_and_closing(c, y, beads, gap[c], wall)
        if c != first and not must_switch(
            overlap, closing, stiffness[c], damping[c], mode[c], largest[c], held[c], law, still
        ):
            continue
        if law.kind == PLASTIC and mode[c] == LOADED:
            largest[c] = max(largest[c], overlap)
        before = potential(overlap, stiffness[c], mode[c], largest[c], law)
        mode[c] = next_mode(c, overlap, time, y, setup, contacts, segment, scratch)
        after = potential(overlap, stiffness[c], mode[c], largest[c], law)
        # What a contact still stores when its force is cut off comes to nothing.
        y[2 * beads + LOST] += before - after
        derivative(time, y, setup, contacts, segment, scratch)


@compiled
def record_walls(time, h, y, y_new, stages, walls):
    """Largest force on each wall, and the impulse until the first contact with it ends."""
    ledger = len(y) - LEDGER
    for side in range(2):
        i = ledger + LEFT_IMPULSE + side
        largest = 0.0
        for j in range(STEP_STAGES + 1):
            largest = max(largest, stages[j, i])
        # In a step cut very short the slope has lost its digits, and the stages are the peak.
        sharp = 1e-15 * abs(y_new[i]) < 1e-12 * h * largest
        if largest > walls[WALL_PEAK, side] and not sharp:
            walls[WALL_PEAK, side] = largest
            walls[WALL_PEAK_TIME, side] = time + h
        elif largest > walls[WALL_PEAK, side]:
            low, high = 0.0, 1.0
            for _ in range(BISECTIONS):
                one, two = (2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0
                if slope(i, one, h, y, y_new, stages) < slope(i, two, h, y, y_new, stages):
                    low = one
                else:
                    high = two
            top = slope(i, 0.5 * (low + high), h, y, y_new, stages)
            if top > walls[WALL_PEAK, side]:
                walls[WALL_PEAK, side] = top
                walls[WALL_PEAK_TIME, side] = time + 0.5 * (low + high) * h
        ended = y_new[i] != 0.0 and stages[STEP_STAGES, i] == 0.0
        if ended and walls[FIRST_END, side] == 0.0:
            walls[FIRST_IMPULSE, side] = y_new[i]
            walls[FIRST_END, side] = time + h


@compiled
def wall_pushed(stages):
    """Whether some stage of the step finds a wall pushed."""
    ledger = stages.shape[1] - LEDGER
    for j in range(STEP_STAGES + 1):
        if stages[j, ledger + LEFT_IMPULSE] != 0.0 or stages[j, ledger + RIGHT_IMPULSE] != 0.0:
            return True
    return False


@compiled
def in_motion(y, inverse_mass):
    """Kinetic energy, momentum, and the sum of the beads' absolute momenta."""
    beads = len(inverse_mass)
    kinetic = 0.0
    momentum = 0.0
    absolute = 0.0
    for k in range(beads):
        p = y[beads + k] / inverse_mass[k]
        momentum += p
        absolute += abs(p)
        kinetic += 0.5 * p * y[beads + k]
    return kinetic, momentum, absolute


@compiled
def plain_potential(y, stiffness, exponent):
    """Energy stored in the contacts of a plain chain."""
    stored = 0.0
    for k in range(len(stiffness)):
        overlap = y[k] - y[k + 1]
        stored += force(overlap, stiffness[k], exponent) * overlap / (exponent + 1.0)
    return stored


@compiled
def not_in_motion(time, y, setup, contacts, segment):
    """Energy stored less what came from outside, and momentum less what came from outside."""
    outside, stiffness, gap, law = setup.body_force, setup.stiffness, setup.gap, setup.law
    mode, largest = contacts.mode, contacts.largest
    beads = len(outside)
    wall = wall_motion(time, setup, segment)
    ledger = y[2 * beads :]
    energy = ledger[LOST] - ledger[DRIVEN]
    momentum = ledger[RIGHT_IMPULSE] - ledger[LEFT_IMPULSE] - ledger[PUSHED]
    for c in range(beads + 1):
        if stiffness[c] > 0.0:
            overlap, _ = overlap_and_closing(c, y, beads, gap[c], wall)
            energy += potential(overlap, stiffness[c], mode[c], largest[c], law)
    for k in range(beads):
        energy -= outside[k] * y[k]
        momentum -= outside[k] * time
    return energy, momentum


@compiled
def first_modes(y, setup, contacts):
    """Touching counts as closed and rest as loading: what comes next is a push."""
    wall = wall_motion(0.0, setup, 0)
    for c in range(len(setup.stiffness)):
        overlap, closing = overlap_and_closing(c, y, len(setup.inverse_mass), setup.gap[c], wall)
        contacts.largest[c] = max(overlap, 0.0)
        loaded = overlap >= 0.0 if setup.law.kind == DAMPED else closing >= 0.0
        contacts.mode[c] = LOADED if loaded else RELEASED


@compiled
def start(y, clock, counts, setup, contacts, first_step):
    """Clock at zero, contacts in their first modes, and what drift is measured from."""
    clock[:] = 0.0
    counts[:] = 0
    counts[LAST_CROSSING] = -1
    clock[STEP] = first_step
    if contacts is not None:
        first_modes(y, setup, contacts)
    note_drift(y, clock, setup, contacts, 0, True)


@compiled
def note_drift(y, clock, setup, contacts, segment, first):
    """Keep the largest departure from conservation, and what to compare it with.

    Energy is compared with the largest kinetic energy, momentum with the largest sum of
    absolute momenta: in a backward taper the pulse gains momenta of thousands, against as
    much thrown back, and one is their difference.
    """
    beads = len(setup.inverse_mass)
    kinetic, momentum, absolute = in_motion(y, setup.inverse_mass)
    if contacts is None:
        stored = plain_potential(y, setup.stiffness, setup.exponent)
    else:
        stored, given = not_in_motion(clock[TIME], y, setup, contacts, segment)
        momentum += given
        for k in range(beads):
            clock[FASTEST] = max(clock[FASTEST], abs(y[beads + k]))
    energy = kinetic + stored
    if first:
        clock[INITIAL_ENERGY], clock[INITIAL_MOMENTUM] = energy, momentum
    clock[ENERGY_UNIT] = max(clock[ENERGY_UNIT], kinetic)
    clock[MOMENTUM_UNIT] = max(clock[MOMENTUM_UNIT], absolute)
    clock[ENERGY_DRIFT] = max(clock[ENERGY_DRIFT], abs(energy - clock[INITIAL_ENERGY]))
    clock[MOMENTUM_DRIFT] = max(clock[MOMENTUM_DRIFT], abs(momentum - clock[INITIAL_MOMENTUM]))


@compiled
def save_frames(time, time_new, h, y, y_new, stages, setup, contacts, segment,
                counts, frame_times, frames, frame_forces, trial, scratch):  # fmt: skip
    """States, and forces where they are asked for, at the saved times within the step."""
    frame = counts[FRAMES]
    while frame < len(frame_times) and frame_times[frame] <= time_new:
        theta = min(1.0, (frame_times[frame] - time) / h)
        for i in range(len(y)):
            frames[frame, i] = interpolate(i, theta, h, y, y_new, stages)
        if contacts is not None:
            trial[:] = frames[frame]
            derivative(time + theta * h, trial, setup, contacts, segment, scratch)
            frame_forces[frame] = contacts.force
        frame += 1
    counts[FRAMES] = frame


@compiled
def advance(
    y, clock, counts, setup, contacts, until, stop_when_left, rtol, budget, pause,
    frame_times, growing, frames, frame_forces, peaks, crossings, walls, stages, work, expected,
):  # fmt: skip
    """Take up to ``budget`` steps and say why it stopped.

    Everything that changes is in the arrays, so a run goes on where it stopped.

    Parameters
    ----------
    y : (2N,) or (2N + LEDGER,) state; ``clock`` (CLOCK_SIZE,) and ``counts`` (COUNTS_SIZE,)
    setup, contacts : what acts on the beads, and what contacts remember
    until : time not to step past; ``stop_when_left`` ends the run once all is recorded
    rtol : tolerated error of a step, in units of the speeds around each bead
    pause : come back before the step that ``until`` cuts short: the state that a longer
        run would go on from
    frame_times, frames : (F,) times to save at, and the (F, len(y)) states saved; with
        ``growing`` the caller is asked for later times before a step would pass the last
    frame_forces : (F, N + 1) contact forces saved; nothing with a plain chain
    peaks, crossings : (2, N), (3, N - 1): time and velocity; time, overlap and residence;
        0 = not yet
    walls : (WALL_ROWS, 2) of the left and the right wall; 0 = not yet
    stages, work, expected : (STAGES, len(y)), (6, len(y)), (2, N) scratch
    """
    beads = len(setup.inverse_mass)
    trial, y_new, scratch, scale = work[0], work[1], work[2], work[3, :beads]
    derivative(clock[TIME], y, setup, contacts, counts[SEGMENT], stages[0])
    if contacts is not None:
        contacts.last_force[:] = contacts.force
    for _ in range(budget):
        time, h = clock[TIME], clock[STEP]
        segment = counts[SEGMENT]
        piece_end = np.inf
        if contacts is not None and segment + 1 < len(setup.piece_starts):
            piece_end = setup.piece_starts[segment + 1]
        stop = min(np.inf if stop_when_left else until, piece_end)
        cut = time + h >= stop
        last_step = cut and not stop_when_left and stop == until
        if last_step and pause:
            return LAST_STEP
        if cut:
            h = stop - time
        if stop_when_left and not time + h < ENDLESS:
            return PULSE_LOST
        if growing and time + h >= frame_times[-1]:
            return FRAMES_FULL
        try_step(time, y, h, setup, contacts, segment, stages, trial, y_new)
        if contacts is None:
            velocity_scale(y, scale)
        else:
            wall_speed = wall_motion(time + h, setup, segment)[1]
            bench_scale(h, y_new, wall_speed, setup, contacts, rtol, scale)
        counts[EVALUATIONS] += STEP_STAGES
        error = error_norm(h, stages, scale, rtol, work[4:])
        change = 10.0 if error == 0.0 else min(10.0, max(0.2, 0.9 * error**-0.125))
        if not error <= 1.0:
            clock[STEP] = h * (change if error > 1.0 else 0.2)
            if not clock[STEP] > SMALLEST_STEP:
                return STEP_TOO_SMALL
            continue
        if stop_when_left and error == 0.0 and nothing_can_happen(y, setup, contacts):
            return PULSE_LOST
        if contacts is not None:
            contacts.last_force[:] = contacts.force

        switching = -1
        still = STILL * clock[FASTEST]
        if contacts is not None and has_modes(setup.law):
            switching, theta = first_switch(
                time, y, h, y_new, stages, setup, contacts, segment, still, trial, scratch
            )
            if switching >= 0 and theta < 1.0:
                h *= theta
                cut = last_step = False
                try_step(time, y, h, setup, contacts, segment, stages, trial, y_new)
                counts[EVALUATIONS] += STEP_STAGES
        time_new = stop if cut else time + h
        frame = counts[FRAMES]
        save = frame < len(frame_times) and frame_times[frame] <= time_new
        event = expect_events(y_new, stages, scale, contacts, peaks, crossings, expected)
        walled = contacts is not None and wall_pushed(stages)
        if save or event or walled:
            complete_stages(time, y, h, setup, contacts, segment, stages, trial)
            counts[EVALUATIONS] += STAGES - STEP_STAGES - 1
        if event:
            counts[PEAKS] += record_peaks(
                h, time, y, y_new, stages, setup, contacts, expected[0], peaks
            )
            record_crossings(
                h, clock, counts, y, y_new, stages, setup, contacts, expected[1], crossings
            )
        if walled:
            record_walls(time, h, y, y_new, stages, walls)
        if save:
            save_frames(time, time_new, h, y, y_new, stages, setup, contacts, segment,
                        counts, frame_times, frames, frame_forces, trial, scratch)  # fmt: skip

        y[:] = y_new
        stages[0] = stages[STEP_STAGES]
        clock[TIME] = time_new
        clock[SINCE_CROSSING] += h
        counts[FROZEN] = counts[FROZEN] + 1 if time_new == time else 0
        if counts[FROZEN] > MOST_FROZEN:
            return STEP_TOO_SMALL
        if not cut and switching < 0:
            clock[STEP] = h * change
        counts[STEPS] += 1
        if contacts is not None and switching >= 0:
            switch(switching, time_new, y, setup, contacts, segment, still, scratch)
            counts[SWITCHES] += 1
        if cut and stop == piece_end:
            counts[SEGMENT] += 1
        if switching >= 0 or cut:
            derivative(time_new, y, setup, contacts, counts[SEGMENT], stages[0])
            if contacts is not None:
                contacts.last_force[:] = contacts.force
            counts[PEAKS] += record_jumps(time_new, y, stages, scale, peaks)
        note_drift(y, clock, setup, contacts, counts[SEGMENT], False)
        left = counts[PEAKS] == beads - 1 and counts[CROSSINGS] == beads - 1
        if stop_when_left and left:
            return PULSE_LEFT
        if last_step:
            return TIME_REACHED
    return RUNNING
