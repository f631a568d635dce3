r"""Changes of the modes of contacts, between two steps.

The modes (`hertzchain.kernels.contact_law`) are constant within a step, so that the forces are
smooth.  The step ends where a contact must leave its mode (`hertzchain.kernels.mode_search`).  This
module determines the mode that follows, and whether a contact may have closed and opened again
within a step without being detected.
"""

from __future__ import annotations

import numpy as np

from .compilation import compiled
from .contact_law import (
    LOADED,
    RELEASED,
    STUCK,
    force,
    has_modes,
    is_plastic,
    law_of,
    potential,
)
from .contact_margins import leaves_mode, must_switch
from .dop853 import STEP_STAGES
from .driving import MOVING_WALL, reach_of_wall, wall_motion
from .forces import LOST, derivative, overlap_and_closing
from .law_kinds import DAMPED, UNLOADING

# Relative speeds below this fraction of the largest speed so far are taken to be zero, so that
# rounding does not change the mode of a contact at rest.
MIN_RELATIVE_SPEED = 1e-14
# Largest relative speed at which the last contact of a stack of stuck contacts may stick, in units
# of the speed that is taken to be zero.
SETTLED = 1e4
# Overlaps up to this fraction of the displacement of a wall may remain undetected, because a wall
# may come to rest where it just touches a bead.
UNSEEN = 1e-10
# Argument ``first`` of `switch` if no contact is given.  For the literal -1, numba would compile
# another version.
ANY = np.int64(-1)
# Number of contacts that are compared without a branch.
GROUP = 64


@compiled
def first_modes(y, setup, contacts):
    """Set the first mode of each contact.

    Beads that touch at rest are in contact and loading, because the next force on them is a push.
    Beads that separate from the start do not attract each other.
    """
    beads, wall = len(setup.inverse_mass), wall_motion(0.0, setup, 0)
    mode, largest = contacts.mode, contacts.largest
    for c in range(beads + 1):
        law, stiffness, damping = law_of(c, setup), setup.stiffness[c], setup.damping[c]
        overlap, closing = overlap_and_closing(c, y, beads, setup.gap[c], wall)
        largest[c] = overlap if law.implicit else max(overlap, 0.0)
        separates = closing < 0.0
        if law.kind == DAMPED:
            leaves = must_switch(
                overlap, closing, stiffness, damping, LOADED, largest[c], 0.0, law, 0.0
            )
            if law.implicit and overlap > 0.0:
                # Implicit steps cut off a pull without a change of the mode.
                leaves = False
            separates = (overlap == 0.0 and separates) or leaves
            separates = separates and has_modes(law)
        mode[c] = RELEASED if separates else LOADED
        if law.kind == DAMPED and separates:
            y[2 * beads + LOST] += potential(overlap, stiffness, damping, LOADED, largest[c], law)


@compiled
def sharpest_turn(c, beads, stages, row):
    """Largest relative acceleration of the two beads of contact c, at stages from ``row`` on."""
    left = stages[0, beads + c - 1] if c > 0 else 0.0
    sharpest = abs(left - stages[0, beads + c]) if c < beads else abs(left)
    for j in range(row, STEP_STAGES + 1):
        left = stages[j, beads + c - 1] if c > 0 else 0.0
        right = stages[j, beads + c] if c < beads else 0.0
        sharpest = max(sharpest, abs(left - right))
    return sharpest


@compiled
def all_closed(y, gap, stiffness):
    """Whether all contacts are closed; the left wall is at rest."""
    beads = len(gap) - 1
    for start in range(1, beads, GROUP):
        opened = 0
        for c in range(start, min(start + GROUP, beads)):
            opened += 1 if y[c - 1] - y[c] - gap[c] <= 0.0 else 0
        if opened > 0:
            return False
    first, last = -y[0] - gap[0], y[beads - 1] - gap[beads]
    return (first > 0.0 or stiffness[0] == 0.0) and (last > 0.0 or stiffness[beads] == 0.0)


@compiled
def may_close_unseen(time, h, y, y_new, stages, row, scale, setup, segment, rtol):
    """Whether a contact, open at both ends of a step, may have been closed in between.

    If the relative acceleration is at most a, the distance of the beads within the step is at least
    the smaller of their distances at its ends, minus a h^2/8.
    """
    beads, drive = len(setup.inverse_mass), setup.drive
    if drive != MOVING_WALL and all_closed(y, setup.gap, setup.stiffness):
        return False
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
            unseen = max(unseen, UNSEEN * way)
        if sharpest == 0.0 and (closing <= 0.0 or still_closing >= 0.0):
            continue
        sharpest += sharpest_turn(c, beads, stages, row)
        if 0.125 * h * h * sharpest > max(-max(first, last), unseen):
            return True
    return False


@compiled
def next_mode(c, overlap, time, y, setup, contacts, segment, scratch):
    """Next mode of contact c, which sticks if both of its forces would reverse its motion."""
    law, mode = law_of(c, setup), contacts.mode[c]
    if law.kind != UNLOADING:
        return RELEASED if mode == LOADED else LOADED
    loading = force(overlap, setup.stiffness[c], law.exponent)
    if mode == STUCK:
        # The force is at one of its bounds, and rounding may have put it on either side.
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
def close_stack(time, y, still, setup, contacts, segment, scratch):
    """Let the last contact between two walls stick if all others do and the forces allow it.

    The beads of this contact can no longer move; rounding would decide between loading and
    unloading.
    """
    beads, mode, last = len(setup.inverse_mass), contacts.mode, -1
    for c in range(beads + 1):
        if setup.stiffness[c] == 0.0 or (mode[c] != STUCK and last >= 0):
            return
        if mode[c] != STUCK:
            last = c
    if last < 0 or law_of(last, setup).kind != UNLOADING:
        return
    wall, before = wall_motion(time, setup, segment), mode[last]
    overlap, closing = overlap_and_closing(last, y, beads, setup.gap[last], wall)
    if overlap <= 0.0 or abs(closing) > SETTLED * still or wall[2] != 0.0:
        return
    mode[last] = STUCK
    derivative(time, y, setup, contacts, segment, scratch)
    for c in range(beads + 1):
        overlap, _ = overlap_and_closing(c, y, beads, setup.gap[c], wall)
        loading = force(overlap, setup.stiffness[c], law_of(c, setup).exponent)
        if not law_of(c, setup).kept * loading < contacts.force[c] < loading:
            mode[last] = before
            return


@compiled
def equalise_velocities(c, wall_speed, y, inverse_mass, mode):
    """Give one velocity to the beads joined by contact c, now stuck, and adjacent stuck contacts.

    Their remaining relative motion would be mistaken for separation or approach when the contacts
    release.
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
def forget_unloading(y, wall, setup, contacts, on_positions):
    """Set the mode of open contacts to loading, the mode in which they will close."""
    if on_positions is not None or setup.law.kind != UNLOADING:
        return
    beads, mode = len(setup.inverse_mass), contacts.mode
    for c in range(beads + 1):
        if mode[c] == RELEASED and law_of(c, setup).kind == UNLOADING:
            overlap, _ = overlap_and_closing(c, y, beads, setup.gap[c], wall)
            if overlap < 0.0:
                mode[c] = LOADED


@compiled
def switch(first, time, y, setup, contacts, segment, still, scratch, on_positions):
    """Change the mode of contact ``first``, and of all others that must change at this time.

    A contact that changes its mode alters the forces that stuck contacts on both sides must carry.
    ``on_positions`` is that of `hertzchain.kernels.mode_search.first_switch`.
    """
    if on_positions is not None:
        return
    changed = switch_once(first, time, y, setup, contacts, segment, still, scratch)
    for _ in range(len(setup.inverse_mass) + 1):
        if not changed or setup.law.kind != UNLOADING:
            return
        changed = switch_once(ANY, time, y, setup, contacts, segment, still, scratch)


@compiled
def switch_once(first, time, y, setup, contacts, segment, still, scratch):
    """Check each contact once, from left to right; returns whether any changed its mode.

    If ``first`` is negative, only contacts that may stick are checked: rounding would make others
    leave the mode that they have just entered.
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
        # The energy that a contact still stores when its force is cut off is lost.
        y[2 * beads + LOST] += before - after
        if mode[c] == STUCK:
            close_stack(time, y, still, setup, contacts, segment, scratch)
            equalise_velocities(c, wall[1], y, setup.inverse_mass, mode)
        derivative(time, y, setup, contacts, segment, scratch)
    return changed


@compiled
def follow_wall(time, y, setup, contacts, segment, still, scratch, on_positions):
    """Set the mode of the contact with the left wall after a jump of the wall's velocity."""
    if on_positions is not None or setup.law.kind != UNLOADING:
        return
    wall = wall_motion(time, setup, segment)
    _, closing = overlap_and_closing(0, y, len(setup.inverse_mass), setup.gap[0], wall)
    if law_of(0, setup).kind == UNLOADING and abs(closing) > still:
        contacts.mode[0] = LOADED if closing > 0.0 else RELEASED
        derivative(time, y, setup, contacts, segment, scratch)
        switch(ANY, time, y, setup, contacts, segment, still, scratch, on_positions)
