r"""The law of one contact for implicit steps, with a force that is not determined at rest.

For :math:`\alpha < 1` the damping :math:`f = \gamma |d'|^\alpha\,\mathrm{sgn}\,d'` has a vertical
tangent at d' = 0.  There, d' is treated as a function of f and linearised about the point of its
graph at which :math:`d' + c f` equals that of the iterate, with the compliance c of the contact.
Newton's method then converges equally well for contacts at rest, creeping and sliding, without
regularisation.  A force that may not pull, :math:`F = (k d_+^p + f)_+`, is cut off in the same way.

The speed of a creeping contact may be smaller than the rounding errors of the velocities of its
beads, and a contact may stick as soon as it closes, with an overlap of 1e-40.  If the velocities do
not determine the sign of d', the sign of f is used; overlaps that positions do not resolve are
stored from step to step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .compilation import compiled
from .contact_law import LOADED, damping_weight, force, law_of, signed_power
from .forces import overlap_and_closing
from .radau import BETWEEN, IMPLICIT_STAGES

# Smallest compliance of a contact at rest, relative to that of a free one: if all contacts between
# two walls are at rest, only this determines their common force.
MIN_YIELDING = 1e-10
# Overlaps below this fraction of the positions of the beads are not resolved by the positions.
RESOLVED = 1e-12
# A smaller relative speed, or force in units of momentum per time since the start, is a rounding
# error.
EVEN = 1e-13
# At smaller fractions of a step, the error of an interpolated velocity is only a rounding error.
AT_START = 1e-5
# Largest number of iterations for one contact; a few are sufficient.
MAX_PROJECTIONS = 40


class Implicit(NamedTuple):
    """Scratch of implicit steps, for each contact and stage."""

    forces: Any  # (N + 1, IMPLICIT_STAGES)
    overlaps: Any  # this and all arrays up to ``residual`` follow from the forces
    closings: Any
    # Factors of the changes of force, overlap and closing speed in the law, and its residual.
    own: Any
    by_overlap: Any
    by_closing: Any
    residual: Any
    blocks: Any  # (N + 1, IMPLICIT_STAGES, IMPLICIT_STAGES): after elimination
    block: Any  # (IMPLICIT_STAGES, 2 IMPLICIT_STAGES + 1): that of one contact


def new_implicit(contacts: int) -> Implicit:
    """Create scratch for a number of contacts."""
    forces, overlaps, closings, own, by_overlap, by_closing, residual = np.zeros(
        (7, contacts, IMPLICIT_STAGES)
    )
    return Implicit(
        forces, overlaps, closings, own, by_overlap, by_closing, residual,
        blocks=np.zeros((contacts, IMPLICIT_STAGES, IMPLICIT_STAGES)),
        block=np.zeros((IMPLICIT_STAGES, 2 * IMPLICIT_STAGES + 1)),
    )  # fmt: skip


@compiled
def graph_point(total, compliance, strength, exponent):
    """Closing speed s and force f = strength |s|^exponent for a given s + compliance f."""
    # With s = |total| u^(1/exponent) the equation u^(1/exponent) + ratio u = 1 is convex, so that
    # Newton's method approaches the solution from above without overshooting.
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
    """Whether a force that may not pull is zero, for a given d' + c F."""
    if law.attractive or weight == 0.0:
        return False
    return total < -((spring / weight) ** (1.0 / law.speed_power))


@compiled
def linearise(c, i, compliance, setup, contacts):
    """Write the law of contact c at stage i as own dF - by_overlap dd - by_closing dd' = residual.

    It is linearised about the present forces; dF, dd and dd' are changes from there.
    """
    law, damping, stiffness = law_of(c, setup), setup.damping[c], setup.stiffness[c]
    pushing = contacts.implicit.forces[c, i]
    overlap, closing = contacts.implicit.overlaps[c, i], contacts.implicit.closings[c, i]
    spring = force(overlap, stiffness, law.exponent)
    slope = law.exponent * spring / overlap if overlap > 0.0 else 0.0
    weight = damping * damping_weight(max(overlap, 0.0), law)
    own, residual, steepness = 1.0, 0.0, 0.0
    if cut_off(closing + compliance * pushing, spring, weight, law):
        slope, residual = 0.0, -pushing
    elif law.speed_power < 1.0:
        damped = pushing - spring
        speed, at = graph_point(closing + compliance * damped, compliance, damping, law.speed_power)
        # Derivative of the speed with respect to the force, in units of the compliance.
        yielding = speed / (law.speed_power * at) if at != 0.0 else 0.0
        if damping == 0.0 or yielding > compliance:
            if damping > 0.0:
                steepness = 1.0 / yielding
            residual = at + steepness * (closing - speed) - damped
        else:
            own, steepness = max(yielding / compliance, MIN_YIELDING), 1.0 / compliance
            slope *= own
            residual = (closing - speed) * steepness - own * (damped - at)
    else:
        damped = weight * signed_power(closing, law.speed_power)
        steepness = weight * law.speed_power * abs(closing) ** (law.speed_power - 1.0)
        if overlap > 0.0:
            slope += law.overlap_power * damped / overlap
        # All rows are scaled to the same size, whether stiff or not.
        own = 1.0 / (1.0 + compliance * steepness)
        residual = own * (spring + damped - pushing)
        slope, steepness = own * slope, own * steepness
    contacts.implicit.own[c, i], contacts.implicit.residual[c, i] = own, residual
    contacts.implicit.by_overlap[c, i] = slope
    contacts.implicit.by_closing[c, i] = steepness


@compiled
def size_of(c, y, setup):
    """Size of the positions whose difference is the overlap of contact c."""
    size = abs(setup.gap[c])
    size += abs(y[c - 1]) if c > 0 else 0.0
    return size + abs(y[c]) if c < len(setup.inverse_mass) else size


@compiled
def is_resolved(c, y, overlap, setup):
    """Whether an overlap exceeds the rounding of the positions of its beads."""
    return abs(overlap) > RESOLVED * size_of(c, y, setup)


@compiled
def overlap_of(c, y, wall, setup, contacts):
    """Overlap of contact c in the state y, or that of the last step if it is not resolved."""
    overlap, _ = overlap_and_closing(c, y, len(setup.inverse_mass), setup.gap[c], wall)
    if contacts.mode[c] != LOADED or is_resolved(c, y, overlap, setup):
        return overlap
    return contacts.largest[c]


@compiled
def closes_in(closing, speed, pushing, overlap, stiffness, exponent):
    """Whether a contact closes, from the sign of its speed or else of its damping."""
    if abs(closing) > EVEN * speed:
        return closing > 0.0
    return pushing > force(overlap, stiffness, exponent)


@compiled
def between(c, theta, values):
    """Interpolate a row of scratch of contact c at the fraction theta of an implicit step."""
    total = 0.0
    for i in range(IMPLICIT_STAGES):
        weight = 0.0
        for power in range(IMPLICIT_STAGES - 1, -1, -1):
            weight = weight * theta + BETWEEN[power, i]
        total += weight * values[c, i]
    return total


@compiled
def force_within(c, theta, implicit):
    """Force of contact c at the fraction theta of an implicit step."""
    if implicit is None:
        return 0.0
    return between(c, theta, implicit.forces)


@compiled
def sliding_force_within(c, theta, h, y, wall, setup, contacts, implicit):
    """Force of contact c at the fraction theta of an implicit step, in the interpolated state y.

    In a short step, the error of the interpolated force may be as large as the mass times the
    tolerance of velocities, divided by the step.  Therefore the point on the graph of the law is
    used at which :math:`d' + c f` has its interpolated value: the law determines the force of a
    sliding contact, and the interpolant that of a contact at rest.  With c = theta h / m, both have
    the same error.
    """
    if implicit is None:
        return 0.0
    pushing, law = between(c, theta, implicit.forces), law_of(c, setup)
    if contacts.mode[c] != LOADED or law.speed_power >= 1.0 or setup.damping[c] == 0.0:
        return pushing
    beads = len(setup.inverse_mass)
    overlap, closing = overlap_and_closing(c, y, beads, setup.gap[c], wall)
    overlap = overlap_within(c, theta, y, overlap, setup, implicit)
    spring, damping = force(overlap, setup.stiffness[c], law.exponent), setup.damping[c]
    compliance = setup.inverse_mass[c - 1] if c > 0 else 0.0
    compliance += setup.inverse_mass[c] if c < beads else 0.0
    compliance *= h * max(theta, AT_START)
    if cut_off(closing + compliance * pushing, spring, damping, law):
        return 0.0
    total = closing + compliance * (pushing - spring)
    return spring + graph_point(total, compliance, damping, law.speed_power)[1]


@compiled
def overlap_within(c, theta, y, overlap, setup, implicit):
    """Overlap of contact c at the fraction theta, given y and the overlap that follows from y."""
    if implicit is None:
        return overlap
    if is_resolved(c, y, overlap, setup):
        return overlap
    return between(c, theta, implicit.overlaps)
