"""Balance of energy and momentum of a run, evaluated after each step."""

from __future__ import annotations

from .compilation import compiled
from .contact_law import force, law_of, potential
from .driving import wall_motion
from .forces import DRIVEN, LEFT_IMPULSE, LOST, PUSHED, RIGHT_IMPULSE, overlap_and_closing
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


@compiled
def kinetic(velocities, inverse_mass, others):
    """Kinetic energy, momentum, and the sum of absolute momenta, with those of ``others``."""
    kinetic, momentum, absolute = others
    for k in range(len(inverse_mass)):
        p = velocities[k] / inverse_mass[k]
        momentum += p
        absolute += abs(p)
        kinetic += 0.5 * p * velocities[k]
    return kinetic, momentum, absolute


@compiled
def plain_potential(y, stiffness, exponent):
    """Energy stored in the contacts of a default chain."""
    stored = 0.0
    for k in range(len(stiffness)):
        overlap = y[k] - y[k + 1]
        stored += force(overlap, stiffness[k], exponent) * overlap / (exponent + 1.0)
    return stored


@compiled
def stored_minus_supplied(time, y, setup, contacts, segment):
    """Stored energy and momentum of the chain, minus energy and momentum supplied from outside."""
    outside, stiffness, gap = setup.body_force, setup.stiffness, setup.gap
    damping, mode, largest = setup.damping, contacts.mode, contacts.largest
    beads = len(outside)
    wall = wall_motion(time, setup, segment)
    ledger = y[2 * beads :]
    energy = ledger[LOST] - ledger[DRIVEN]
    momentum = ledger[RIGHT_IMPULSE] - ledger[LEFT_IMPULSE] - ledger[PUSHED]
    for c in range(beads + 1):
        if stiffness[c] > 0.0:
            overlap, _ = overlap_and_closing(c, y, beads, gap[c], wall)
            if overlap > 0.0:
                energy += potential(
                    overlap, stiffness[c], damping[c], mode[c], largest[c], law_of(c, setup)
                )
    for k in range(beads):
        energy -= outside[k] * y[k]
        momentum -= outside[k] * time
    return energy, momentum


@compiled
def update_drift(y, clock, setup, contacts, segment, flying, first):
    """Update the largest drifts and their units; ``flying`` are sums of beads behind the window."""
    # The unit of the momentum is the largest sum of absolute momenta: in a backward taper, the
    # pulse and the beads behind it have opposite momenta of thousands, and their sum is one.
    beads = len(setup.inverse_mass)
    velocities = y[beads : 2 * beads]
    kinetic_energy, momentum, absolute = kinetic(velocities, setup.inverse_mass, flying)
    if contacts is None:
        stored = plain_potential(y, setup.stiffness, setup.exponent)
    else:
        stored, given = stored_minus_supplied(clock[TIME], y, setup, contacts, segment)
        momentum += given
        fastest = clock[FASTEST]
        for k in range(beads):
            fastest = max(fastest, abs(velocities[k]))
        clock[FASTEST] = fastest
    energy = kinetic_energy + stored
    if first:
        clock[INITIAL_ENERGY], clock[INITIAL_MOMENTUM] = energy, momentum
    clock[ENERGY_UNIT] = max(clock[ENERGY_UNIT], kinetic_energy)
    clock[MOMENTUM_UNIT] = max(clock[MOMENTUM_UNIT], absolute)
    clock[ENERGY_DRIFT] = max(clock[ENERGY_DRIFT], abs(energy - clock[INITIAL_ENERGY]))
    clock[MOMENTUM_DRIFT] = max(clock[MOMENTUM_DRIFT], abs(momentum - clock[INITIAL_MOMENTUM]))
