r"""The law of one contact for implicit steps: a force that is no function of the speed at rest.

For :math:`\alpha < 1` the damping :math:`f = \gamma |d'|^\alpha\,\mathrm{sgn}\,d'` has a vertical
tangent at d' = 0.  There it is taken as d' as a function of f, about the point of its graph at
which :math:`d' + c f` is that of the iterate, c the compliance of the contact: a contact at rest,
one that creeps and one that slides converge alike, and nothing is regularised.  A force that may
not pull, :math:`F = (k d_+^p + f)_+`, is cut off in the same way.

A contact may creep by less than the rounding of its beads' velocities, or stick from its first
touch on with an overlap of 1e-40.  So that neither is lost, the sign of d' is that of f where the
velocities do not tell, and such an overlap is remembered from step to step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .compilation import compiled
from .contact_law import LOADED, damping_weight, force, law_of, signed_power
from .forces import overlap_and_closing
from .radau import BETWEEN, IMPLICIT_STAGES

# A contact at rest yields by this part of its compliance, at least: between two walls where all
# contacts are at rest, nothing else tells the force that all of them have in common.
MIN_YIELDING = 1e-10
# Overlaps below this part of the positions are no difference of these.
RESOLVED = 1e-12
# A relative speed, or a push in parts of the momentum over the time since the start, that is as
# small as this is rounding.
EVEN = 1e-13
# Iterations for one contact, of which a few are needed.
MAX_PROJECTIONS = 40


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
    return Implicit(
        forces, overlaps, closings, own, by_overlap, by_closing, rest,
        blocks=np.zeros((contacts, IMPLICIT_STAGES, IMPLICIT_STAGES)),
        block=np.zeros((IMPLICIT_STAGES, 2 * IMPLICIT_STAGES + 1)),
    )  # fmt: skip


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
    for _ in range(MAX_PROJECTIONS):
        change = (power + ratio * u - 1.0) / (inverse * power / u + ratio)
        u -= change
        power = u**inverse
        if not change > 1e-15 * u:
            break
    sign = 1.0 if total > 0.0 else -1.0
    return sign * size * power, sign * largest * u


@compiled
def cut_off(total, spring, weight, law):
    """Whether a force that may not pull is none, where d' + c F is given."""
    if law.attractive or weight == 0.0:
        return False
    return total < -((spring / weight) ** (1.0 / law.speed_power))


@compiled
def linearise(c, i, compliance, setup, contacts):
    """The law of contact c at stage i as own dF - by_overlap dd - by_closing dd' = rest."""
    law, damping, stiffness = law_of(c, setup), setup.damping[c], setup.stiffness[c]
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
            own, steepness = max(yielding / compliance, MIN_YIELDING), 1.0 / compliance
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
def closes_in(closing, speed, pushing, overlap, stiffness, exponent):
    """Whether a contact closes in, by the sign of its damping if not by that of its speed."""
    if abs(closing) > EVEN * speed:
        return closing > 0.0
    return pushing > force(overlap, stiffness, exponent)


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
def force_within(c, theta, implicit):
    """Force of contact c at the fraction theta of an implicit step; nothing of an explicit one."""
    if implicit is None:
        return 0.0
    return between(c, theta, implicit.forces)


@compiled
def overlap_within(c, theta, y, overlap, setup, implicit):
    """Overlap of contact c there, where y and the overlap by it are given."""
    if implicit is None:
        return overlap
    if is_resolved(c, y, overlap, setup):
        return overlap
    return between(c, theta, implicit.overlaps)
