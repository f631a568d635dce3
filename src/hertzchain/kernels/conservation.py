"""Drift of the total energy and momentum of a run, updated after each step."""

from __future__ import annotations

import numpy as np

from .compilation import compiled, reduced
from .contact_law import HERTZ, force, law_of, potential
from .driving import wall_motion
from .forces import (
    DRIVEN,
    LEFT_IMPULSE,
    LOST,
    PUSHED,
    RIGHT_IMPULSE,
    largest_size,
    overlap_and_closing,
)
from .state_layout import (
    ENERGY_DRIFT,
    ENERGY_UNIT,
    FASTEST,
    INITIAL_ENERGY,
    INITIAL_MOMENTUM,
    MOMENTUM_DRIFT,
    MOMENTUM_UNIT,
    TIME,
)


@reduced
def kinetic(velocities, inverse_mass, others):
    """Kinetic energy, momentum and sum of absolute momenta, added to those in ``others``."""
    kinetic, momentum, absolute = others
    for k in range(len(inverse_mass)):
        p = velocities[k] / inverse_mass[k]
        momentum += p
        absolute += abs(p)
        kinetic += 0.5 * p * velocities[k]
    return kinetic, momentum, absolute


@reduced
def plain_potential(y, stiffness, exponent):
    """Energy stored in the contacts of a default chain."""
    stored = 0.0
    if exponent == HERTZ:
        for k in range(len(stiffness)):
            overlap = y[k] - y[k + 1]
            overlap = overlap if overlap > 0.0 else 0.0
            stored += stiffness[k] * overlap * overlap * np.sqrt(overlap)
        return stored / (exponent + 1.0)
    for k in range(len(stiffness)):
        overlap = y[k] - y[k + 1]
        stored += force(overlap, stiffness[k], exponent) * overlap / (exponent + 1.0)
    return stored


@reduced
def hertz_potential(y, wall, stiffness, gap):
    """Energy stored in the elastic Hertz contacts of a general chain."""
    beads = len(gap) - 1
    first, last = wall - y[0] - gap[0], y[beads - 1] - gap[beads]
    first, last = max(first, 0.0), max(last, 0.0)
    stored = stiffness[0] * first * first * np.sqrt(first)
    stored += stiffness[beads] * last * last * np.sqrt(last)
    for c in range(1, beads):
        overlap = y[c - 1] - y[c] - gap[c]
        overlap = overlap if overlap > 0.0 else 0.0
        stored += stiffness[c] * overlap * overlap * np.sqrt(overlap)
    return stored / (HERTZ + 1.0)


@reduced
def weight_work(y, outside):
    """Work of constant forces on the beads, and the sum of these forces."""
    work, total = 0.0, 0.0
    for k in range(len(outside)):
        work += outside[k] * y[k]
        total += outside[k]
    return work, total


@compiled
def stored_minus_supplied(time, y, setup, contacts, segment):
    """Energy in contacts and momentum of walls, minus energy and momentum from outside.

    The energy in contacts includes the energy that they have lost.
    """
    outside = setup.body_force
    beads = len(outside)
    wall = wall_motion(time, setup, segment)
    accumulators = y[2 * beads :]
    energy = accumulators[LOST] - accumulators[DRIVEN]
    momentum = accumulators[RIGHT_IMPULSE] - accumulators[LEFT_IMPULSE] - accumulators[PUSHED]
    energy += energy_in_contacts(y, wall, setup, contacts)
    work, weight = weight_work(y, outside)
    return energy - work, momentum - weight * time


@compiled
def energy_in_contacts(y, wall, setup, contacts):
    """Energy stored in all contacts."""
    beads, stiffness, gap = len(setup.inverse_mass), setup.stiffness, setup.gap
    energy = 0.0
    if contacts.on_positions is not None:
        if setup.law.shared and setup.law.exponent == HERTZ:
            return hertz_potential(y, wall[0], stiffness, gap)
        for c in range(beads + 1):
            overlap, _ = overlap_and_closing(c, y, beads, gap[c], wall)
            exponent = law_of(c, setup).exponent
            energy += force(overlap, stiffness[c], exponent) * overlap / (exponent + 1.0)
        return energy
    for c in range(beads + 1):
        if stiffness[c] > 0.0:
            overlap, _ = overlap_and_closing(c, y, beads, gap[c], wall)
            if overlap > 0.0:
                energy += potential(
                    overlap, stiffness[c], setup.damping[c], contacts.mode[c], contacts.largest[c],
                    law_of(c, setup),
                )  # fmt: skip
    return energy


@compiled
def larger(known, value):
    """The larger of two numbers; NaN, which `max` would drop, if one of them is."""
    return known if value <= known or known != known else value


@compiled
def update_drift(y, clock, setup, contacts, segment, flying, first):
    """Update the largest drifts and their units.

    ``flying`` has the sums of `kinetic` for the beads behind the window; ``first`` states whether
    this is the start of the run.
    """
    # The unit of the momentum is the largest sum of absolute momenta: in a backward taper, the
    # pulse and the beads behind it have opposite momenta in the thousands, whose sum is one.
    beads = len(setup.inverse_mass)
    velocities = y[beads : 2 * beads]
    kinetic_energy, momentum, absolute = kinetic(velocities, setup.inverse_mass, flying)
    if contacts is None:
        stored = plain_potential(y, setup.stiffness, setup.exponent)
    else:
        stored, given = stored_minus_supplied(clock[TIME], y, setup, contacts, segment)
        momentum += given
        clock[FASTEST] = max(clock[FASTEST], largest_size(velocities))
    energy = kinetic_energy + stored
    if first:
        clock[INITIAL_ENERGY], clock[INITIAL_MOMENTUM] = energy, momentum
    clock[ENERGY_UNIT] = max(clock[ENERGY_UNIT], kinetic_energy)
    clock[MOMENTUM_UNIT] = max(clock[MOMENTUM_UNIT], absolute)
    lost, pushed = energy - clock[INITIAL_ENERGY], momentum - clock[INITIAL_MOMENTUM]
    clock[ENERGY_DRIFT] = larger(clock[ENERGY_DRIFT], abs(lost))
    clock[MOMENTUM_DRIFT] = larger(clock[MOMENTUM_DRIFT], abs(pushed))
