r"""Compiled forces on the beads of a chain: contacts, walls, drives, weight.

The state ``y`` holds positions :math:`x_k`, velocities :math:`v_k` and, unless the chain
is a default chain, accumulators of energy and momentum.  Its derivative is :math:`(v_k, a_k)` with

.. math:: m_k a_k = F_{k-1} - F_k + X_k ,

where :math:`F_c` is the force of contact c and :math:`X_k` the external force on bead k.  Contacts
:math:`c = 1 \dots N - 1` join beads c and c + 1; contacts 0 and N are those with the walls.  At a
free end there is no wall: the contact has stiffness 0, and a constant force that holds the end of a
precompressed chain is part of :math:`X_k`.

A `DefaultChain`, Eq. (4) of the paper, has only the forces :math:`F_c = r_c (x_c - x_{c+1})_+^p`,
and a separate loop; a `GeneralChain` supports all other features.  The force of one contact is in
`hertzchain.kernels.contact_law`; if all contacts have the same law, vectorised loops over contacts
are used instead.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .compilation import compiled, reduced
from .contact_law import (
    LOADED,
    STUCK,
    Law,
    contact_force,
    force,
    has_modes,
    law_of,
)
from .driving import MOVING_WALL, NOTHING, PUSH, drive_at
from .law_kinds import DAMPED, PLASTIC, UNLOADING
from .powers import powers

# Accumulators, after positions and velocities: energy lost in contacts, work and impulse of the
# drive, impulse of the left wall on the chain and of the chain on the right wall.
LOST, DRIVEN, PUSHED, LEFT_IMPULSE, RIGHT_IMPULSE, ACCUMULATORS = range(6)


class DefaultChain(NamedTuple):
    """A chain of Eq. (4) of the paper, which has only beads and their contacts."""

    inverse_mass: Any  # (N,)
    stiffness: Any  # (N - 1,)
    exponent: float


class GeneralChain(NamedTuple):
    """Any other chain: beads, contacts 0..N (walls at both ends), and external forces."""

    inverse_mass: Any  # (N,)
    stiffness: Any  # (N + 1,); 0 without a wall
    exponent: float
    gap: Any  # (N + 1,)
    damping: Any  # (N + 1,): damping constant, or the overlap at yield
    law: Law  # of all contacts; if they differ, its kind is the one with the most checks
    laws: Any  # (N + 1, COLUMNS): the law of each contact, used unless `law` is that of all
    body_force: Any  # (N,): weight along the chain, and forces that hold free ends
    drive: int
    piece_starts: Any  # (pieces,)
    pieces: Any  # (pieces, CUBIC + 2 SINES)


class Contacts(NamedTuple):
    """Memory and forces of the contacts of a `GeneralChain`; `None` for a `DefaultChain`."""

    # If a field is None, numba compiles code without it.  Passing tuples of arrays takes time;
    # loops over contacts therefore extract the arrays first.

    mode: Any  # (N + 1,)
    largest: Any  # (N + 1,): largest overlap so far, if the law depends on it; with implicit steps,
    # the present overlap, which may be smaller than the rounding error of the positions
    force: Any  # (N + 1,)
    last_force: Any  # (N + 1,): at the end of the last step
    scratch: Any  # (3, N + 1)
    powers: Any  # (4, N + 1): scratch of powers
    # Scratch of implicit steps; None if steps are explicit.
    implicit: Any
    # None if forces depend on velocities; selects the method (`hertzchain.kernels.stepping`).
    # Otherwise no contact has modes.
    on_positions: Any


@compiled
def copy(source, target):
    """Copy like ``target[:] = source``, but without a check whether the arrays overlap."""
    for i in range(len(target)):
        target[i] = source[i]


@reduced
def largest_size(values):
    """Largest absolute value; 0 if there are none."""
    found = 0.0
    for i in range(len(values)):
        size = abs(values[i])
        found = size if size > found else found
    return found


@compiled
def plain_derivative(y, inverse_mass, stiffness, exponent, out):
    """Velocities and accelerations of all beads, Eq. (4) of the paper."""
    beads = len(inverse_mass)
    pushed = 0.0
    for k in range(beads - 1):
        pushing = force(y[k] - y[k + 1], stiffness[k], exponent)
        out[k] = y[beads + k]
        out[beads + k] = (pushed - pushing) * inverse_mass[k]
        pushed = pushing
    out[beads - 1] = y[2 * beads - 1]
    out[2 * beads - 1] = pushed * inverse_mass[beads - 1]


@compiled
def overlap_and_closing(c, y, beads, gap, wall):
    """Overlap of contact c and its rate; ``wall`` is the motion of the left wall."""
    left, left_speed = wall[0], wall[1]
    if c > 0:
        left, left_speed = y[c - 1], y[beads + c - 1]
    right, right_speed = 0.0, 0.0
    if c < beads:
        right, right_speed = y[c], y[beads + c]
    return left - right - gap, left_speed - right_speed


@compiled
def force_on(k, drive, setup):
    """External force on bead k (0-based)."""
    if k == 0 and setup.drive == PUSH:
        return setup.body_force[k] + drive
    return setup.body_force[k]


@compiled
def solve_stuck_forces(drive, wall_acceleration, overlap, setup, contacts):
    """Forces that keep the closing speed of stuck contacts at zero, from a tridiagonal system."""
    # The accelerations a_left = (F_{c-1} - F_c + X_left)/m_left and a_right of a stuck contact c
    # are equal; the forces of contacts that are not stuck are known.
    if all_stuck(contacts.mode):
        share_common_force(drive, wall_acceleration, overlap, setup, contacts)
        return
    inverse_mass, mode, pushing = setup.inverse_mass, contacts.mode, contacts.force
    beads = len(inverse_mass)
    factor, value = contacts.scratch[1], contacts.scratch[2]
    for c in range(beads + 1):
        if mode[c] != STUCK:
            continue
        left, right, difference = 0.0, 0.0, 0.0
        if c > 0:
            left = inverse_mass[c - 1]
            difference += left * force_on(c - 1, drive, setup)
            if mode[c - 1] != STUCK:
                difference += left * pushing[c - 1]
        else:
            difference += wall_acceleration
        if c < beads:
            right = inverse_mass[c]
            difference -= right * force_on(c, drive, setup)
            if mode[c + 1] != STUCK:
                difference += right * pushing[c + 1]
        pivot = left + right
        if c > 0 and mode[c - 1] == STUCK:
            pivot -= left * factor[c - 1]
            difference += left * value[c - 1]
        factor[c] = right / pivot
        value[c] = difference / pivot
    for c in range(beads, -1, -1):
        if mode[c] == STUCK:
            pushing[c] = value[c]
            if c < beads and mode[c + 1] == STUCK:
                pushing[c] += factor[c] * pushing[c + 1]


@compiled
def all_stuck(mode):
    """Whether all contacts are stuck, those with two walls included."""
    for c in range(len(mode)):
        if mode[c] != STUCK:
            return False
    return True


@compiled
def share_common_force(drive, wall_acceleration, overlap, setup, contacts):
    """Forces of contacts that are all stuck between two walls.

    At rest, the differences of these forces follow from the external forces on the beads.  The
    force that all have in common is chosen in the middle of the range in which every contact can
    stick or, if a wall begins to move, beyond this range, so that contacts release.
    """
    pushing = contacts.force
    beads, low, high, common = len(setup.inverse_mass), -np.inf, np.inf, 0.0
    for c in range(beads + 1):
        if c > 0:
            common += force_on(c - 1, drive, setup)
        pushing[c] = common
        law = law_of(c, setup)
        loading = force(overlap[c], setup.stiffness[c], law.exponent)
        low = max(low, law.kept * loading - common)
        high = min(high, loading - common)
    middle = 0.5 * (low + high)
    if wall_acceleration != 0.0:
        beyond = abs(low) + abs(high)
        middle += beyond if wall_acceleration > 0.0 else -beyond
    for c in range(beads + 1):
        pushing[c] += middle


@compiled
def overlaps_and_rates(y, gap, wall, overlap, closing):
    """Overlaps of all contacts, and their rates."""
    beads = len(gap) - 1
    position, velocity = y[:beads], y[beads : 2 * beads]
    for c in range(1, beads):
        overlap[c] = position[c - 1] - position[c] - gap[c]
    for c in range(1, beads):
        closing[c] = velocity[c - 1] - velocity[c]
    overlap[0], closing[0] = wall[0] - position[0] - gap[0], wall[1] - velocity[0]
    overlap[beads] = position[beads - 1] - gap[beads]
    closing[beads] = velocity[beads - 1]


# Each of the following loops has one task and no branch, so that the compiler can vectorise it.


@compiled
def loading_curve(overlap, stiffness, exponent, pushing, scratch):
    """Forces k d_+^p of all contacts."""
    if exponent == 1.5:
        for c in range(len(overlap)):
            closed = overlap[c] if overlap[c] > 0.0 else 0.0
            pushing[c] = stiffness[c] * closed * np.sqrt(closed)
        return
    power_of_closed(overlap, exponent, pushing, scratch)
    for c in range(len(overlap)):
        pushing[c] *= stiffness[c]


@compiled
def power_of_closed(overlap, exponent, out, scratch):
    """d_+^exponent of all contacts."""
    closed = scratch[2, : len(overlap)]
    for c in range(len(overlap)):
        closed[c] = overlap[c] if overlap[c] > 0.0 else 0.0
    powers(closed, exponent, out, scratch)


@compiled
def damping_coefficients(overlap, damping, law, weight, scratch):
    """Coefficients of the power of the closing speed: damping * d_+^overlap_power."""
    if law.overlap_power == 0.0:
        copy(damping, weight)
    elif law.overlap_power == 0.25:
        for c in range(len(weight)):
            closed = overlap[c] if overlap[c] > 0.0 else 0.0
            weight[c] = damping[c] * np.sqrt(np.sqrt(closed))
    elif law.overlap_power == 0.5:
        for c in range(len(weight)):
            closed = overlap[c] if overlap[c] > 0.0 else 0.0
            weight[c] = damping[c] * np.sqrt(closed)
    else:
        power_of_closed(overlap, law.overlap_power, weight, scratch)
        for c in range(len(weight)):
            weight[c] *= damping[c]


@compiled
def add_damping(pushing, overlap, closing, damping, mode, law, more, scratch):
    """Add damping forces to the elastic forces; returns the power lost."""
    damping_coefficients(overlap, damping, law, more, scratch)
    if has_modes(law):
        for c in range(len(more)):
            acts = 1.0 if mode[c] == LOADED else 0.0
            pushing[c] *= acts
            more[c] *= acts
    if law.speed_power == 1.0:
        for c in range(len(more)):
            more[c] *= closing[c]
    else:
        speed, power = scratch[2, : len(more)], scratch[3, : len(more)]
        for c in range(len(more)):
            speed[c] = abs(closing[c])
        powers(speed, law.speed_power, power, scratch)
        for c in range(len(more)):
            more[c] *= power[c] if closing[c] > 0.0 else -power[c]
    for c in range(len(more)):
        pushing[c] += more[c]
    return sum_of_products(more, closing)


@compiled
def sum_of_products(a, b):
    """Sum of a * b, computed as four independent sums, which is faster."""
    s, t, u, v = 0.0, 0.0, 0.0, 0.0
    whole = len(a) - len(a) % 4
    for i in range(0, whole, 4):
        s += a[i] * b[i]
        t += a[i + 1] * b[i + 1]
        u += a[i + 2] * b[i + 2]
        v += a[i + 3] * b[i + 3]
    for i in range(whole, len(a)):
        s += a[i] * b[i]
    return (s + t) + (u + v)


@compiled
def reduce_unloading_forces(pushing, mode, law):
    """Reduce the forces of contacts that separate; returns whether any is stuck."""
    stuck = 0
    for c in range(len(pushing)):
        pushing[c] *= 1.0 if mode[c] == LOADED else law.kept
        stuck += 1 if mode[c] == STUCK else 0
    return stuck > 0


@compiled
def power_lost(pushing, closing, mode, law):
    """Power of loading contacts, without the part that unloading will return."""
    s, t = 0.0, 0.0
    for c in range(0, len(pushing) - 1, 2):
        s += pushing[c] * closing[c] if mode[c] == LOADED else 0.0
        t += pushing[c + 1] * closing[c + 1] if mode[c + 1] == LOADED else 0.0
    last = len(pushing) - 1
    if last % 2 == 0 and mode[last] == LOADED:
        s += pushing[last] * closing[last]
    return (1.0 - law.kept) * (s + t)


@compiled
def elastic_overlaps(overlap, mode, largest, kept):
    """Replace overlaps of plastic contacts by those at which the loading curve has their force."""
    for c in range(len(overlap)):
        unloading = (overlap[c] - (1.0 - kept) * largest[c]) / kept
        overlap[c] = overlap[c] if mode[c] == LOADED else unloading


@compiled
def contact_forces(overlap, closing, drive, wall, setup, contacts):
    """Write the forces of all contacts; returns the power lost."""
    law, mode, pushing = setup.law, contacts.mode, contacts.force
    if not law.shared:
        return differing_forces(overlap, closing, drive, wall, setup, contacts)
    if law.kind == PLASTIC:
        elastic_overlaps(overlap, mode, contacts.largest, law.kept)
    loading_curve(overlap, setup.stiffness, law.exponent, pushing, contacts.powers)
    lost = 0.0
    if law.kind == DAMPED:
        more = contacts.scratch[2, : len(mode)]
        lost = add_damping(
            pushing, overlap, closing, setup.damping, mode, law, more, contacts.powers
        )
    elif law.kind == UNLOADING:
        lost = power_lost(pushing, closing, mode, law)
        if reduce_unloading_forces(pushing, mode, law):
            solve_stuck_forces(drive[0], wall[2], overlap, setup, contacts)
    elif law.kind == PLASTIC:
        lost = power_lost(pushing, closing, mode, law)
    return lost


@compiled
def differing_forces(overlap, closing, drive, wall, setup, contacts):
    """Write the forces of contacts with different laws; returns the power lost."""
    lost, stuck = 0.0, False
    for c in range(len(overlap)):
        contacts.force[c], power = contact_force(
            overlap[c], closing[c], contacts.mode[c], contacts.largest[c], setup.stiffness[c],
            setup.damping[c], law_of(c, setup),
        )  # fmt: skip
        lost += power
        stuck = stuck or contacts.mode[c] == STUCK
    if stuck:
        solve_stuck_forces(drive[0], wall[2], overlap, setup, contacts)
    return lost


@compiled
def full_derivative(time, y, setup, contacts, segment, out):
    """Velocities, accelerations and rates of the accumulators."""
    inverse_mass, pushing, outside = setup.inverse_mass, contacts.force, setup.body_force
    beads = len(inverse_mass)
    overlap, closing = contacts.scratch[0, : beads + 1], contacts.scratch[1, : beads + 1]
    drive = drive_at(time, setup, segment) if setup.drive != NOTHING else (0.0, 0.0, 0.0)
    wall = drive if setup.drive == MOVING_WALL else (0.0, 0.0, 0.0)
    overlaps_and_rates(y, setup.gap, wall, overlap, closing)
    lost = contact_forces(overlap, closing, drive, wall, setup, contacts)
    copy(y[beads : 2 * beads], out[:beads])
    acceleration = out[beads : 2 * beads]
    for k in range(beads):
        acceleration[k] = (pushing[k] - pushing[k + 1] + outside[k]) * inverse_mass[k]
    out[2 * beads + LOST] = lost
    out[2 * beads + DRIVEN] = pushing[0] * wall[1]
    out[2 * beads + PUSHED] = 0.0
    if setup.drive == PUSH:
        out[beads] += drive[0] * inverse_mass[0]
        out[2 * beads + DRIVEN] = drive[0] * y[beads]
        out[2 * beads + PUSHED] = drive[0]
    out[2 * beads + LEFT_IMPULSE] = pushing[0]
    out[2 * beads + RIGHT_IMPULSE] = pushing[beads]


@compiled
def derivative(time, y, setup, contacts, segment, out):
    """Velocities and accelerations and, for a general chain, rates of the accumulators."""
    if contacts is None:
        plain_derivative(y, setup.inverse_mass, setup.stiffness, setup.exponent, out)
    else:
        full_derivative(time, y, setup, contacts, segment, out)
