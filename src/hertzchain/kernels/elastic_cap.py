"""End of an elastic chain with a cap behind the row: proof that no larger force on it follows.

The bound is that of `hertzchain.simulation.body_bound` without attraction and constant forces.
"""

from __future__ import annotations

from .compilation import compiled
from .elastic_forces import closing_of, force_of, overlap_of
from .elastic_layout import (
    EXPONENT,
    INVERSE_MASS,
    LANES,
    NEAR,
    PULSE_LEFT,
    RECORD_CROSSING,
    RECORD_PEAK_TIME,
    STEPS,
    STIFFNESS,
    TIME,
    TRANSIT_LIMIT,
    WORK,
    V,
)
from .elastic_walls import end_of_groups
from .wall_rule import ROUNDING

# Steps between two attempts of the proof.
STEPS_PER_PROOF = 16


@compiled
def ending_on_cap(w, beads, lane, state, peak, records, longest, lone):
    """Reason for a chain to end whose pulse has left; 0 if a larger force may follow.

    ``lone`` is whether all beads may be in free flight, in which steps are long.
    """
    if not lone and state[STEPS, lane] % STEPS_PER_PROOF != 0.0:
        return 0
    if peak > 0.0 and bound_on_cap(w, beads, lane) <= (1.0 + ROUNDING) * peak:
        return PULSE_LEFT
    transit = 0.0
    for k in range(beads):
        transit = max(transit, records[RECORD_PEAK_TIME, k], records[RECORD_CROSSING, k])
    return TRANSIT_LIMIT if state[TIME, lane] >= longest * transit else 0


@compiled
def bound_on_cap(w, beads, lane):
    """Bound of any later force of the last contact; 0 if there is none."""
    behind, meeting = w[STIFFNESS + lane] > 0.0, False
    kinetic, stored, momentum, total = 0.0, 0.0, 0.0, 0.0
    for k in range(beads):
        at = k * LANES + lane
        d, speed, mass = overlap_of(w, at), w[V + LANES + at], 1.0 / w[INVERSE_MASS + at]
        kinetic += 0.5 * mass * speed * speed
        momentum, total = momentum + mass * speed, total + mass
        if k > 0 or behind:
            meeting = meeting or d > 0.0 or closing_of(w, at) > 0.0
            stored += force_of(w, at, d) * max(d, 0.0) / (w[EXPONENT + at] + 1.0)
    if not meeting:
        return 0.0
    energy = kinetic + stored
    if behind:
        energy -= 0.5 * max(momentum, 0.0) ** 2 / total
    else:
        for at in range(lane, end_of_groups(w, beads, lane, 0.0), LANES):
            energy -= 0.5 * w[NEAR + at] ** 2 / w[WORK + at]
    if not energy > 0.0:
        return 0.0
    last = (beads - 1) * LANES + lane
    p = w[EXPONENT + last]
    depth = ((p + 1.0) * energy / w[STIFFNESS + last]) ** (1.0 / (p + 1.0))
    return force_of(w, last, depth)
