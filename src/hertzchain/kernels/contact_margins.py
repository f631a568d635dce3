r"""Margins by which contacts may keep their modes.

The margin of a contact (its overlap, closing speed, force or distance of its force from the bounds
of a stuck contact) is positive as long as its mode is valid, and zero where the mode must change.
"""

from __future__ import annotations

from .compilation import compiled
from .contact_law import (
    LOADED,
    RELEASED,
    STUCK,
    damping_weight,
    force,
    is_plastic,
    law_of,
    signed_power,
)
from .forces import overlap_and_closing
from .law_kinds import DAMPED
from .stiff_law import force_within, overlap_within, size_of

# A force within this fraction of a bound is taken to be at the bound, so that rounding does not
# change the mode of a contact at rest.
EVEN = 1e-13
# Rounding error of an overlap, as a fraction of the positions of its beads.
ROUNDED = 1e-15


@compiled
def must_switch(overlap, closing, stiffness, damping, mode, largest, held, law, still):
    """Whether a contact must leave its mode; relative speeds below ``still`` are taken as zero."""
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
    """`must_switch` for implicit steps; attraction, if excluded, is cut off within the mode."""
    if mode == LOADED:
        return pushing <= 0.0 and overlap < 0.0
    return overlap > ROUNDED * size_of(c, y, setup)


@compiled
def leaves_mode(c, theta, y, wall, setup, contacts, still):
    """Whether contact c must leave its mode at the fraction theta of a step, in the state y."""
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
def pull_free_force(overlap, closing, stiffness, damping, law):
    """Force of a damped contact before attraction is cut off; its overlap if it is open."""
    if overlap <= 0.0 or law.attractive:
        return overlap
    weight = damping * damping_weight(overlap, law)
    return force(overlap, stiffness, law.exponent) + weight * signed_power(closing, law.speed_power)


@compiled
def margin_of(c, y, wall, setup, contacts):
    """Margin of contact c in its mode; the force of a stuck contact must be up to date."""
    law, mode = law_of(c, setup), contacts.mode[c]
    overlap, closing = overlap_and_closing(c, y, len(setup.inverse_mass), setup.gap[c], wall)
    stiffness = setup.stiffness[c]
    if law.kind == DAMPED:
        pushing = pull_free_force(overlap, closing, stiffness, setup.damping[c], law)
        return pushing if mode == LOADED else -pushing
    if mode == STUCK:
        loading = force(overlap, stiffness, law.exponent)
        return min(loading - contacts.force[c], contacts.force[c] - law.kept * loading)
    if mode == RELEASED and is_plastic(law):
        return contacts.largest[c] - overlap
    return closing if mode == LOADED else -closing


@compiled
def vanishes_between(first, slope, last, last_slope):
    """Whether a margin with these values and changes per step at both ends may vanish in a step.

    A convex curve lies above the tangents at its ends.  If these do not meet within the step, the
    margin may vanish.
    """
    if slope >= 0.0 or last_slope <= 0.0:
        return False
    theta = (last - last_slope - first) / (slope - last_slope)
    return theta <= 0.0 or theta >= 1.0 or first + slope * theta <= 0.0
