r"""Compiled force and stored energy of one contact, and the table of laws.

If the force of a law is discontinuous, has a memory or is cut off, each contact is in a *mode*,
which `hertzchain.kernels.contact_modes` keeps constant within a step:

=============  ========================  =================  =======================
law            `LOADED`                  `RELEASED`         `STUCK`
=============  ========================  =================  =======================
`DAMPED`       the law acts              no force
`UNLOADING`    approaching               separating         d' = 0, with a force
                                                            between the other two
`PLASTIC`,     beyond the largest        below the largest
`YIELDING`     overlap so far            overlap so far
=============  ========================  =================  =======================

A new kind of law is a branch of `contact_force` and, if its stored energy differs, of `potential`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .compilation import compiled
from .law_kinds import DAMPED, ELASTIC, PLASTIC, UNLOADING, YIELDING

RELEASED, LOADED, STUCK = range(3)
HERTZ = 1.5


class Law(NamedTuple):
    """Numbers of a law, and of the steps of a chain."""

    kind: int
    exponent: float
    # DAMPED: k d^p + damping d^overlap_power |d'|^speed_power sgn d'.
    overlap_power: float
    speed_power: float
    # Part of the energy that is returned: 1 - w of UNLOADING, e^2 of PLASTIC.
    kept: float
    attractive: bool
    # Whether steps are implicit, because explicit ones would be too short.
    implicit: bool
    # Lower bound of the unit in which errors of velocities are measured, for chains at rest.
    slowest: float
    # Whether all contacts have this law, so that loops over contacts can be vectorised.
    shared: bool


# Columns of a table of laws, which has one row per contact: the fields of a law.
KIND, EXPONENT, OVERLAP_POWER, SPEED_POWER, KEPT, ATTRACTIVE, COLUMNS = range(7)


@compiled
def law_of(c, setup):
    """Law of contact c: `setup.law`, unless the contacts have different laws."""
    law, laws = setup.law, setup.laws
    if law.shared:
        return law
    return Law(
        int(laws[c, KIND]), laws[c, EXPONENT], laws[c, OVERLAP_POWER], laws[c, SPEED_POWER],
        laws[c, KEPT], laws[c, ATTRACTIVE] != 0.0, law.implicit, law.slowest, False,
    )  # fmt: skip


@compiled
def force(overlap, stiffness, exponent):
    """Contact force k d^p of a positive overlap; d^1.5 by a square root is 40 times faster."""
    if overlap <= 0.0:
        return 0.0
    if exponent == 1.5:
        return stiffness * overlap * np.sqrt(overlap)
    return stiffness * overlap**exponent


@compiled
def has_modes(law):
    """Whether the force is discontinuous or depends on more than overlap and closing speed."""
    if law.kind == DAMPED:
        return law.overlap_power == 0.0 or not law.attractive
    return law.kind != ELASTIC


@compiled
def is_plastic(law):
    """Whether the contact remembers its largest overlap."""
    return law.kind == PLASTIC or law.kind == YIELDING


@compiled
def damping_weight(overlap, law):
    """d^overlap_power of an overlap that is not negative."""
    if law.overlap_power == 0.0:
        return 1.0
    if law.overlap_power == 0.25:
        return np.sqrt(np.sqrt(overlap))
    if law.overlap_power == 0.5:
        return np.sqrt(overlap)
    return overlap**law.overlap_power


@compiled
def signed_power(closing, exponent):
    """|d'|^exponent with the sign of d'."""
    if exponent == 1.0:
        return closing
    return np.sign(closing) * abs(closing) ** exponent


@compiled
def elastic_overlap(overlap, mode, largest, law):
    """Overlap at which the loading curve has the force of a plastic contact."""
    if mode == LOADED:
        return overlap
    return (overlap - (1.0 - law.kept) * largest) / law.kept


@compiled
def loading_force(overlap, stiffness, damping, law):
    """Force at an overlap reached slowly for the first time; see `contact_force`."""
    if law.kind == YIELDING and overlap > damping:
        return stiffness * np.sqrt(damping) * (1.5 * overlap - 0.5 * damping)
    return force(overlap, stiffness, law.exponent)


@compiled
def rebound(overlap, largest, stiffness, damping, law):
    """Overlap and stiffness of the Hertz contact along which an elastic-plastic one unloads."""
    if largest <= damping or stiffness == 0.0:
        return overlap, stiffness
    peak = loading_force(largest, stiffness, damping, law)
    root = np.sqrt(largest)
    steeper = stiffness * np.sqrt(stiffness * largest * root / peak)
    return overlap - largest + peak / (stiffness * root), steeper


@compiled
def power_of_yield(overlap, closing, stiffness, damping, law):
    """Power lost in plastic loading, d (W - U)/dt: work W done minus energy U stored."""
    # At a free end, the stiffness and the overlap at yield are 0.
    if overlap <= damping or stiffness == 0.0:
        return 0.0
    slope = 1.5 * stiffness * np.sqrt(damping)
    pushing = loading_force(overlap, stiffness, damping, law)
    stored = 0.4 * pushing * (2.0 * slope * overlap - 0.5 * pushing)
    return (pushing - stored / (stiffness * overlap * np.sqrt(overlap))) * closing


@compiled
def contact_force(overlap, closing, mode, largest, stiffness, damping, law):
    """Force and power loss of a contact; for YIELDING, ``damping`` is the overlap at yield."""
    if law.kind == DAMPED:
        if has_modes(law) and mode != LOADED:
            return 0.0, 0.0
        weight = damping * damping_weight(max(overlap, 0.0), law)
        damped = weight * signed_power(closing, law.speed_power)
        return force(overlap, stiffness, law.exponent) + damped, damped * closing
    if law.kind == YIELDING:
        if mode == LOADED:
            pushing = loading_force(overlap, stiffness, damping, law)
            return pushing, power_of_yield(overlap, closing, stiffness, damping, law)
        elastic, steeper = rebound(overlap, largest, stiffness, damping, law)
        return force(elastic, steeper, HERTZ), 0.0
    if law.kind == PLASTIC:
        overlap = elastic_overlap(overlap, mode, largest, law)
    curve = force(overlap, stiffness, law.exponent)
    if law.kind == ELASTIC:
        return curve, 0.0
    if mode == LOADED:
        return curve, (1.0 - law.kept) * curve * closing
    return law.kept * curve if law.kind == UNLOADING else curve, 0.0


@compiled
def potential(overlap, stiffness, damping, mode, largest, law):
    """Energy stored in a contact: the energy that it can return."""
    kept = 1.0
    if law.kind == DAMPED and has_modes(law) and mode == RELEASED:
        return 0.0
    if law.kind == YIELDING:
        furthest = max(overlap, 0.0) if mode == LOADED else largest
        overlap, stiffness = rebound(overlap, furthest, stiffness, damping, law)
    if law.kind == PLASTIC:
        overlap = elastic_overlap(overlap, mode, largest, law)
        kept = law.kept
    if law.kind == UNLOADING:
        kept = law.kept
    curve = force(overlap, stiffness, law.exponent)
    return kept * curve * max(overlap, 0.0) / (law.exponent + 1.0)
