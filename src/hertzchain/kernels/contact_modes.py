r"""When a contact leaves its mode: the moment is found, and the step ends there.

What the modes are stands in `hertzchain.kernels.forces`.  They are kept within a step, so that the
forces are smooth; here is which contact must leave its mode first, when, and into which, and
whether one may have closed and opened again within a step, unseen.
"""

from __future__ import annotations

from .compilation import compiled
from .contact_law import (
    LOADED,
    RELEASED,
    STUCK,
    damping_weight,
    force,
    has_modes,
    is_plastic,
    law_of,
    potential,
    signed_power,
)
from .dop853 import STEP_STAGES
from .dop853_interpolant import state_within, value
from .driving import MOVING_WALL, reach_of_wall, wall_motion
from .events import BISECTIONS, PARTS
from .forces import LOST, derivative, overlap_and_closing
from .law_kinds import DAMPED, UNLOADING
from .stepping import interpolate
from .stiff_law import force_within, overlap_within, size_of

# What counts as no relative motion, in parts of the fastest motion so far: a contact at rest
# must not change its mode for rounding.
MIN_RELATIVE_SPEED = 1e-14
# A force within this part of a bound is on it: a contact at rest must not change its mode
# for rounding.
EVEN = 1e-13
# An overlap of this part of a wall's way may go unseen: a wall may rest where a bead touches it.
UNSEEN = 1e-10
# Part of the beads' positions that rounding makes an overlap of.
ROUNDED = 1e-15


@compiled
def must_switch(overlap, closing, stiffness, damping, mode, largest, held, law, still):
    """Whether a contact has to leave its mode; relative speeds below ``still`` are none."""
    if law.kind == DAMPED:
        pulls = False
        if not law.attractive and overlap > 0.0:
            pushing = force(overlap, stiffness, law.exponent)
            weight = damping_weight(overlap, law)
            pulls = pushing + damping * weight * signed_power(closing, law.speed_power) < 0.0
        return overlap < 0.0 or pulls if mode == LOADED else overlap > 0.0 and not pulls
    if overlap <= 0.0 and mode != STUCK:
        return False
    if mode == LOADED:
        return closing < -still
    if is_plastic(law):
        return overlap > largest and closing > still
    if mode == RELEASED:
        return closing > still
    loading = force(overlap, stiffness, law.exponent)
    return held > (1.0 + EVEN) * loading or held < (1.0 - EVEN) * law.kept * loading


@compiled
def implicit_must_switch(c, y, overlap, pushing, setup, mode):
    """The same where steps are implicit: a force that may not pull is cut off within the mode."""
    if mode == LOADED:
        return pushing <= 0.0 and overlap < 0.0
    return overlap > ROUNDED * size_of(c, y, setup)


@compiled
def leaves_mode(c, theta, y, wall, setup, contacts, still):
    """Whether contact c has to leave its mode at the fraction theta of a step, where y is given."""
    beads = len(setup.inverse_mass)
    overlap, closing = overlap_and_closing(c, y, beads, setup.gap[c], wall)
    if setup.law.implicit:
        pushing = force_within(c, theta, contacts.implicit)
        if contacts.mode[c] == LOADED:
            overlap = overlap_within(c, theta, y, overlap, setup, contacts.implicit)
        return implicit_must_switch(c, y, overlap, pushing, setup, contacts.mode[c])
    return must_switch(overlap, closing, setup.stiffness[c], setup.damping[c], contacts.mode[c],
                       contacts.largest[c], contacts.force[c], law_of(c, setup), still)  # fmt: skip


@compiled
def first_modes(y, setup, contacts):
    """Touching counts as closed and rest as loading: what comes next is a push.

    Beads that part from the start on do not hold each other.
    """
    beads, wall = len(setup.inverse_mass), wall_motion(0.0, setup, 0)
    mode, largest = contacts.mode, contacts.largest
    for c in range(beads + 1):
        law, stiffness, damping = law_of(c, setup), setup.stiffness[c], setup.damping[c]
        overlap, closing = overlap_and_closing(c, y, beads, setup.gap[c], wall)
        largest[c] = overlap if law.implicit else max(overlap, 0.0)
        parts = closing < 0.0
        if law.kind == DAMPED:
            parts = (overlap == 0.0 and parts) or must_switch(
                overlap, closing, stiffness, damping, LOADED, largest[c], 0.0, law, 0.0
            )
            parts = parts and has_modes(law)
        mode[c] = RELEASED if parts else LOADED
        if law.kind == DAMPED and parts:
            y[2 * beads + LOST] += potential(overlap, stiffness, damping, LOADED, largest[c], law)


@compiled
def sharpest_turn(c, beads, stages):
    """Largest relative acceleration of the two beads of contact c at the stages of a step."""
    sharpest = 0.0
    for j in range(STEP_STAGES + 1):
        left = stages[j, beads + c - 1] if c > 0 else 0.0
        right = stages[j, beads + c] if c < beads else 0.0
        sharpest = max(sharpest, abs(left - right))
    return sharpest


@compiled
def may_close_unseen(time, h, y, y_new, stages, scale, setup, segment, rtol):
    """Whether a contact, open at both ends of a step, may have been closed in between.

    With relative accelerations of at most a, beads come no nearer to each other than at the ends
    but for a h^2/8.
    """
    beads, drive = len(setup.inverse_mass), setup.drive
    before, after = wall_motion(time, setup, segment), wall_motion(time + h, setup, segment)
    for c in range(beads + 1):
        if setup.stiffness[c] == 0.0:
            continue
        first, closing = overlap_and_closing(c, y, beads, setup.gap[c], before)
        last, still_closing = overlap_and_closing(c, y_new, beads, setup.gap[c], after)
        if first > 0.0 or last > 0.0:
            continue
        sharpest, unseen = 0.0, rtol * h * scale[min(c, beads - 1)]
        if c == 0 and drive == MOVING_WALL:
            way, sharpest = reach_of_wall(time + h, setup, segment)
            unseen = UNSEEN * way
        elif closing <= 0.0 or still_closing >= 0.0:
            continue
        sharpest += sharpest_turn(c, beads, stages)
        if 0.125 * h * h * sharpest > max(-max(first, last), unseen):
            return True
    return False


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
def may_switch(c, y, y_new, stages, setup, contacts, walls, still):
    """Whether contact c, by what the stages of a step say, must leave its mode within it.

    ``walls`` is the motion of the left wall at both ends of the step.
    """
    law, mode, gap = law_of(c, setup), contacts.mode[c], setup.gap[c]
    beads = len(setup.inverse_mass)
    remembers = law.kind == UNLOADING or is_plastic(law)
    if remembers and mode != STUCK:
        # Open at both ends: there is no force whose mode could matter.
        overlap, _ = overlap_and_closing(c, y_new, beads, gap, walls[1])
        before, _ = overlap_and_closing(c, y, beads, gap, walls[0])
        if overlap <= 0.0 and before <= 0.0:
            return False
    if leaves_mode(c, 1.0, y_new, walls[1], setup, contacts, still):
        return True
    if remembers and mode == LOADED:
        return turned(c, beads, walls[1][1], 1.0, stages, still)
    if law.kind == UNLOADING and mode == RELEASED:
        return turned(c, beads, walls[1][1], -1.0, stages, still)
    if is_plastic(law) and mode == RELEASED:
        # It may go beyond its largest overlap and come back.
        _, closing = overlap_and_closing(c, y, beads, gap, walls[0])
        return closing > still and turned(c, beads, walls[1][1], 1.0, stages, still)
    return False


@compiled
def closing_until(c, time, y, h, dense, setup, segment, still):
    """Fraction of the step until which contact c, closing at its start, closes."""
    beads, low, high = len(setup.inverse_mass), 0.0, 2.0
    for part in range(1, PARTS + BISECTIONS + 1):
        if high > 1.0 and part > PARTS:
            return 1.0
        theta = part / PARTS if high > 1.0 else 0.5 * (low + high)
        left = wall_motion(time + theta * h, setup, segment)[1]
        if c > 0:
            left = value(beads + c - 1, theta, y, dense)
        right = value(beads + c, theta, y, dense) if c < beads else 0.0
        if left - right > still:
            low = theta
        else:
            high = theta
    return low


@compiled
def switch_within(c, time, y, h, dense, setup, contacts, segment, still, trial, scratch):
    """Where in the step contact c first must leave its mode; 2 if nowhere."""
    beads, mode = len(setup.inverse_mass), contacts.mode[c]
    # A stuck contact's force depends on all beads, that of another one on its own two.
    first, last = max(c - 1, 0), min(c + 1, beads)
    low, high, found, end = 0.0, 0.0, False, 1.0
    if is_plastic(law_of(c, setup)) and mode == RELEASED:
        end = closing_until(c, time, y, h, dense, setup, segment, still)
    for part in range(1, PARTS + BISECTIONS + 1):
        if found:
            theta = 0.5 * (low + high)
        elif part > PARTS:
            return 2.0
        else:
            theta = end * part / PARTS
        if mode == STUCK:
            state_within(theta, y, dense, trial)
            derivative(time + theta * h, trial, setup, contacts, segment, scratch)
        for k in range(first, last):
            trial[k] = value(k, theta, y, dense)
            trial[beads + k] = value(beads + k, theta, y, dense)
        wall = wall_motion(time + theta * h, setup, segment)
        if leaves_mode(c, theta, trial, wall, setup, contacts, still):
            high, found = theta, True
        else:
            low = theta
    return high


@compiled
def first_switch(time, y, h, y_new, stages, dense, setup, contacts, segment, still, trial, scratch):
    """The first contact that must leave its mode within the step, and where; -1 if none.

    Tells, too, whether it has completed the stages and found the coefficients in ``dense``.
    """
    beads = len(setup.inverse_mass)
    walls = wall_motion(time, setup, segment), wall_motion(time + h, setup, segment)
    first, earliest, dense_is_found = -1, 2.0, False
    for c in range(beads + 1):
        if setup.stiffness[c] == 0.0 or not has_modes(law_of(c, setup)):
            continue
        if not may_switch(c, y, y_new, stages, setup, contacts, walls, still):
            continue
        if not dense_is_found:
            interpolate(time, y, h, y_new, setup, contacts, segment, stages, dense, trial)
            dense_is_found = True
        theta = switch_within(c, time, y, h, dense, setup, contacts, segment, still, trial, scratch)
        if setup.law.kind == UNLOADING:
            # The forces of stuck contacts were overwritten.
            derivative(time + h, y_new, setup, contacts, segment, scratch)
        if first < 0 or theta < earliest:
            first, earliest = c, theta
    return first if earliest <= 1.0 else -1, earliest, dense_is_found


@compiled
def next_mode(c, overlap, time, y, setup, contacts, segment, scratch):
    """The mode that follows.  A contact whose two forces both drive it back is stuck."""
    law, mode = law_of(c, setup), contacts.mode[c]
    if law.kind != UNLOADING:
        return RELEASED if mode == LOADED else LOADED
    loading = force(overlap, setup.stiffness[c], law.exponent)
    if mode == STUCK:
        # It is at one of the bounds: rounding may have put it on either side of that.
        middle = 0.5 * (1.0 + law.kept) * loading
        return LOADED if contacts.force[c] > middle else RELEASED
    contacts.mode[c] = STUCK
    derivative(time, y, setup, contacts, segment, scratch)
    contacts.mode[c] = mode
    held = contacts.force[c]
    if overlap > 0.0 and law.kept * loading < held < loading:
        return STUCK
    return RELEASED if mode == LOADED else LOADED


@compiled
def equalise_velocities(c, wall_speed, y, inverse_mass, mode):
    """Give the beads that contact c, now stuck, and stuck ones beside it join one velocity.

    What little they still moved apart would count as parting or closing when they come loose.
    """
    beads = len(inverse_mass)
    first, last = c, c
    while first > 0 and mode[first - 1] == STUCK:
        first -= 1
    while last < beads and mode[last + 1] == STUCK:
        last += 1
    mass, momentum = 0.0, 0.0
    for k in range(max(first - 1, 0), min(last + 1, beads)):
        mass += 1.0 / inverse_mass[k]
        momentum += y[beads + k] / inverse_mass[k]
    velocity = momentum / mass
    if first == 0:
        velocity = wall_speed
    elif last == beads:
        velocity = 0.0
    for k in range(max(first - 1, 0), min(last + 1, beads)):
        y[beads + k] = velocity


@compiled
def forget_unloading(y, wall, setup, contacts):
    """An open contact will load when it closes."""
    beads, mode = len(setup.inverse_mass), contacts.mode
    for c in range(beads + 1):
        if mode[c] == RELEASED and law_of(c, setup).kind == UNLOADING:
            overlap, _ = overlap_and_closing(c, y, beads, setup.gap[c], wall)
            if overlap < 0.0:
                mode[c] = LOADED


@compiled
def switch(first, time, y, setup, contacts, segment, still, scratch):
    """Give contact ``first`` its next mode, and all others that must change at this moment.

    A contact that changes alters the forces that stuck contacts on both sides of it have to bear.
    """
    changed = switch_once(first, time, y, setup, contacts, segment, still, scratch)
    for _ in range(len(setup.inverse_mass) + 1):
        if not changed or setup.law.kind != UNLOADING:
            return
        changed = switch_once(-1, time, y, setup, contacts, segment, still, scratch)


@compiled
def switch_once(first, time, y, setup, contacts, segment, still, scratch):
    """Look at each contact once, from the left on; returns whether any changed its mode.

    Without a ``first`` one only those that may stick together are looked at: rounding would have
    others leave the mode that they have just been given.
    """
    stiffness, damping, gap = setup.stiffness, setup.damping, setup.gap
    mode, largest = contacts.mode, contacts.largest
    beads, changed = len(setup.inverse_mass), False
    wall = wall_motion(time, setup, segment)
    for c in range(beads + 1):
        law = law_of(c, setup)
        if stiffness[c] == 0.0 or not has_modes(law):
            continue
        if first < 0 and law.kind != UNLOADING:
            continue
        if c != first and not leaves_mode(c, 1.0, y, wall, setup, contacts, still):
            continue
        changed = True
        overlap, _ = overlap_and_closing(c, y, beads, gap[c], wall)
        if is_plastic(law) and mode[c] == LOADED:
            largest[c] = max(largest[c], overlap)
        before = potential(overlap, stiffness[c], damping[c], mode[c], largest[c], law)
        if law.implicit:
            largest[c] = overlap
        mode[c] = next_mode(c, overlap, time, y, setup, contacts, segment, scratch)
        after = potential(overlap, stiffness[c], damping[c], mode[c], largest[c], law)
        # What a contact still stores when its force is cut off comes to nothing.
        y[2 * beads + LOST] += before - after
        if mode[c] == STUCK:
            equalise_velocities(c, wall[1], y, setup.inverse_mass, mode)
        derivative(time, y, setup, contacts, segment, scratch)
    return changed


@compiled
def follow_wall(time, y, setup, contacts, segment, still, scratch):
    """Give the contact with the left wall its mode where the wall's speed has jumped."""
    wall = wall_motion(time, setup, segment)
    _, closing = overlap_and_closing(0, y, len(setup.inverse_mass), setup.gap[0], wall)
    if law_of(0, setup).kind == UNLOADING and abs(closing) > still:
        contacts.mode[0] = LOADED if closing > 0.0 else RELEASED
        derivative(time, y, setup, contacts, segment, scratch)
        switch(-1, time, y, setup, contacts, segment, still, scratch)
