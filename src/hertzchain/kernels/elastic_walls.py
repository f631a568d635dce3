"""Criteria for the completeness of the largest force on the right wall, for elastic contacts.

These are the compiled criteria of `hertzchain.simulation.wall_watch`;
`hertzchain.simulation.wall_bound` has the equations of the bounds.
"""

from __future__ import annotations

import math

from . import wall_rule
from .compilation import compiled
from .elastic_forces import closing_of, force_of, overlap_of
from .elastic_layout import (
    BODY,
    BOUNDED,
    DUE,
    EXPONENT,
    FORCE,
    IMPACT_IMPULSE,
    INVERSE_MASS,
    LANES,
    LAST_END,
    LAST_IMPULSE,
    NEAR,
    RECORD_CROSSING,
    RECORD_PEAK_TIME,
    SINCE,
    STATIC_FORCE,
    STATIC_OVERLAP,
    STEP,
    STIFFNESS,
    TIME,
    TRANSIT,
    WATCH_START,
    WORK,
    V,
)
from .wall_rule import CHECKS, HELD, REST, ROUNDING

longest_watch, has_released = compiled(wall_rule.longest_watch), compiled(wall_rule.has_released)
time_between_checks = compiled(wall_rule.time_between_checks)


@compiled
def bound_of(w, beads, lane, chain):
    """Largest force on the right wall that the motion towards it can still cause."""
    energy, behind = 0.0, 0.0
    for c in range(beads + 1):
        at = c * LANES + lane
        ahead = w[V + LANES + at] if c < beads else 0.0
        if c < beads and ahead > 0.0:
            energy += 0.5 * ahead * ahead / w[INVERSE_MASS + at]
        if w[STIFFNESS + at] > 0.0:
            d, static = overlap_of(w, at), chain[STATIC_FORCE, c]
            if behind + ahead > 0.0 or (d < 0.0 and static > 0.0):
                p, rest = w[EXPONENT + at], chain[STATIC_OVERLAP, c]
                stored = force_of(w, at, d) * d - force_of(w, at, rest) * rest
                energy += max(0.0, stored / (p + 1.0) - static * (d - rest))
        behind = ahead
    at = beads * LANES + lane
    p, k = w[EXPONENT + at], w[STIFFNESS + at]
    depth = ((p + 1.0) * energy / k) ** (1.0 / (p + 1.0)) + chain[STATIC_OVERLAP, beads]
    return k * depth**p


@compiled
def may_rebound(w, lane, chain):
    """Whether nothing but gravity pushes beads towards the wall, and the other end is free."""
    fall = w[BODY + lane] / w[INVERSE_MASS + lane]
    carried = chain[STATIC_FORCE, 1]
    return fall > 0.0 and w[STIFFNESS + lane] == 0.0 and carried <= (1.0 + ROUNDING) * fall


@compiled
def has_rebounded(w, beads, lane, chain):
    """`hertzchain.simulation.rebounds`: the first beads fly away, and the others are slow."""
    if not may_rebound(w, lane, chain):
        return False
    count, flying, total, rest = 0, True, 0.0, 0.0
    for k in range(1, beads + 1):
        bead, at = (k - 1) * LANES + lane, k * LANES + lane
        d, v = overlap_of(w, at), w[V + at]
        flying = flying and v < 0.0 and d <= 0.0
        if flying:
            count = k
        there = w[STIFFNESS + at] > 0.0
        apart = max(0.0, -d) if there else 0.0
        stored = force_of(w, at, d) * d / (w[EXPONENT + at] + 1.0) if there and d > 0.0 else 0.0
        kinetic = 0.5 * v * v / w[INVERSE_MASS + bead]
        total += kinetic + stored + chain[STATIC_FORCE, k] * apart
        if not flying:
            weight = max(0.0, chain[STATIC_FORCE, k] - chain[STATIC_FORCE, count])
            rest += stored + weight * apart + (kinetic if v > 0.0 else 0.0)
    return count > 0 and rest <= (1.0 + ROUNDING) * REST * total


@compiled
def total_energy(w, beads, lane):
    """Kinetic energy of the beads and energy of the contacts."""
    energy = 0.0
    for c in range(beads + 1):
        at = c * LANES + lane
        if c < beads:
            energy += 0.5 * w[V + LANES + at] ** 2 / w[INVERSE_MASS + at]
        d = overlap_of(w, at)
        if w[STIFFNESS + at] > 0.0 and d > 0.0:
            energy += force_of(w, at, d) * d / (w[EXPONENT + at] + 1.0)
    return energy


@compiled
def energy_to_exceed(w, at, peak):
    """Energy of a contact whose force exceeds a peak."""
    p, k = w[EXPONENT + at], w[STIFFNESS + at]
    return k / (p + 1.0) * ((1.0 + ROUNDING) * peak / k) ** ((p + 1.0) / p)


@compiled
def energy_left(w, beads, lane, energy, impulse):
    """Largest energy of the last bead at the wall, after at least an impulse of the wall."""
    last = (beads - 1) * LANES + lane
    momentum = w[V + LANES + last] / w[INVERSE_MASS + last] - impulse
    return energy - locked_energy(w, beads, lane, min(0.0, momentum))


@compiled
def cannot_be_exceeded(w, beads, lane, peak):
    """Whether it is proven that no later force on the wall exceeds a peak."""
    enough = energy_to_exceed(w, beads * LANES + lane, peak)
    return energy_left(w, beads, lane, total_energy(w, beads, lane), 0.0) <= enough


@compiled
def is_largest(w, beads, lane, peak):
    """`cannot_be_exceeded` without constant forces, by a sharper bound.

    A larger force requires an impulse of the wall before, which the last bead passes on to the
    others; some of their energy then cannot reach the wall.
    """
    at = beads * LANES + lane
    energy, enough = total_energy(w, beads, lane), energy_to_exceed(w, at, peak)
    most = energy_left(w, beads, lane, energy, 0.0)
    if most <= enough:
        return True
    d = max(0.0, overlap_of(w, at))
    stored = force_of(w, at, d) * d / (w[EXPONENT + at] + 1.0)
    # Speeds of the last bead are at most those of the energy that is not in the contact.
    impulse = math.sqrt(max(0.0, most - stored)) - math.sqrt(most - enough)
    impulse *= math.sqrt(2.0 / w[INVERSE_MASS + at - LANES])
    return energy_left(w, beads, lane, energy, impulse) <= enough


@compiled
def locked_energy(w, beads, lane, pushed):
    """Smallest kinetic energy of beads 1 to N - 1, to which ``pushed`` is transferred."""
    locked = 0.0
    for at in range(lane, end_of_groups(w, beads - 1, lane, pushed), LANES):
        if w[NEAR + at] < 0.0:
            locked += 0.5 * w[NEAR + at] ** 2 / w[WORK + at]
    return locked


@compiled
def end_of_groups(w, count, lane, pushed):
    """Group the first beads, to the last of which ``pushed`` is transferred.

    Beads move together in groups whose velocities increase from left to right; the masses and
    momenta of the groups are in rows WORK and NEAR, up to the entry that is returned.
    """
    groups = lane
    for k in range(count):
        at = k * LANES + lane
        mass = 1.0 / w[INVERSE_MASS + at]
        momentum = w[V + LANES + at] * mass + (pushed if k == count - 1 else 0.0)
        while groups > lane:
            before, own = w[WORK + groups - LANES], w[NEAR + groups - LANES]
            if momentum * before > own * mass:
                break
            mass, momentum, groups = mass + before, momentum + own, groups - LANES
        w[WORK + groups], w[NEAR + groups] = mass, momentum
        groups += LANES
    return groups


@compiled
def nothing_can_happen(w, beads, lane):
    """Whether no contact is closed or closing and no constant force acts."""
    for k in range(beads):
        if w[BODY + k * LANES + lane] != 0.0:
            return False
    for c in range(beads + 1):
        at = c * LANES + lane
        if w[STIFFNESS + at] > 0.0 and (overlap_of(w, at) > 0.0 or closing_of(w, at) > 0.0):
            return False
    return True


@compiled
def set_due(lane, state, checks):
    """Set the next check to the first one after the next step."""
    watched = state[TIME, lane] - state[WATCH_START, lane]
    spacing = time_between_checks(watched, state[TRANSIT, lane], checks)
    # After free flight the predicted step may be longer than many transits.
    state[STEP, lane] = min(state[STEP, lane], spacing)
    time = state[TIME, lane] + state[STEP, lane]
    number = max(0.0, (time - state[WATCH_START, lane]) // spacing) + 1.0
    state[DUE, lane] = state[WATCH_START, lane] + number * spacing


@compiled
def start_watch(w, beads, lane, state, records):
    """Watch the wall from the end of the first transit on."""
    transit = 0.0
    for k in range(beads):
        transit = max(transit, records[RECORD_PEAK_TIME, k], records[RECORD_CROSSING, k])
    flight, last = 0.0, beads * LANES + lane
    if w[STIFFNESS + last] > 0.0 and w[V + last] > 0.0:
        flight = max(0.0, -overlap_of(w, last)) / w[V + last]
    state[WATCH_START, lane], state[TRANSIT, lane] = transit + flight, transit
    set_due(lane, state, CHECKS)


@compiled
def note(lane, state, time, impulse):
    """Record that the impact has ended, unless this is already recorded."""
    if state[SINCE, lane] == 0.0:
        state[SINCE, lane], state[IMPACT_IMPULSE, lane] = time, impulse
    if state[BOUNDED, lane] == 0.0:
        state[BOUNDED, lane] = state[TIME, lane]


@compiled
def forget(lane, state):
    """Forget the end of an impact, because the force may exceed its peak."""
    state[BOUNDED, lane] = state[SINCE, lane] = state[IMPACT_IMPULSE, lane] = 0.0


@compiled
def restart(lane, state, peak_time):
    """Forget the end of an impact that a larger force has followed."""
    if peak_time > state[BOUNDED, lane]:
        forget(lane, state)


@compiled
def close(lane, state, impulse):
    """Record that nothing more can happen, so that the peak is complete."""
    state[WATCH_START, lane] = state[TIME, lane]
    state[TRANSIT, lane] = 0.0
    note(lane, state, state[TIME, lane], impulse)


@compiled
def check_wall(w, beads, lane, chain, state, peak, impulse):
    """Compare the bound with the largest force so far."""
    set_due(lane, state, CHECKS)
    if nothing_can_happen(w, beads, lane):
        close(lane, state, impulse)
    elif peak == 0.0 or not is_over(w, beads, lane, chain, state, peak):
        forget(lane, state)
    else:
        note_if_released(w, beads, lane, chain, state, peak, impulse)


@compiled
def is_over(w, beads, lane, chain, state, peak):
    """Whether the present motion towards the wall is not expected to exceed a peak."""
    if bound_of(w, beads, lane, chain) <= (1.0 + ROUNDING) * peak:
        return True
    return has_rebounded(w, beads, lane, chain) or (
        may_rebound(w, lane, chain) and held(lane, state)
    )


@compiled
def note_if_released(w, beads, lane, chain, state, peak, impulse):
    """Note the end of the impact if the wall has been released since the bound is low enough."""
    if state[BOUNDED, lane] == 0.0:
        state[BOUNDED, lane] = state[TIME, lane]
    force, static = w[FORCE + beads * LANES + lane], chain[STATIC_FORCE, beads]
    if state[LAST_END, lane] > state[BOUNDED, lane]:
        note(lane, state, state[LAST_END, lane], state[LAST_IMPULSE, lane])
    elif has_released(force, static, peak):
        note(lane, state, state[TIME, lane], impulse)


@compiled
def note_end(w, beads, lane, chain, state, peak, impulse):
    """Record at the end of the run that the impact has ended after the last check."""
    if peak == 0.0 or state[TRANSIT, lane] == 0.0:
        return
    if is_over(w, beads, lane, chain, state, peak):
        note_if_released(w, beads, lane, chain, state, peak, impulse)


@compiled
def complete(w, beads, lane, chain, can_escape, state, peak):
    """Whether the largest force so far is complete."""
    if can_escape:
        return peak > 0.0 and cannot_be_exceeded(w, beads, lane, peak)
    if not held(lane, state):
        return False
    low = bound_of(w, beads, lane, chain) <= (1.0 + ROUNDING) * peak
    return low or may_rebound(w, lane, chain)


@compiled
def held(lane, state):
    """Whether half a transit has passed since the end of the impact."""
    since = state[SINCE, lane]
    return since > 0.0 and state[TIME, lane] - since >= HELD * state[TRANSIT, lane]


@compiled
def expired(lane, state, rebounds, can_escape):
    """Whether the longest run has ended, and half a transit since the end of the impact."""
    last = state[WATCH_START, lane] + longest_watch(state[TRANSIT, lane], rebounds, can_escape)
    late = state[TIME, lane] >= last
    return late and (state[SINCE, lane] == 0.0 or held(lane, state))
