r"""Upper bound of the force that the motion towards a wall can still cause.

The energy that moves towards the right wall, counted from the state of rest, is

.. math::

    E^+ = \sum_{v_k > 0} \tfrac12 m_k v_k^2
        + \sum_{v_k + v_{k+1} > 0} \left[ U(d) - U(d_0) - F_0\,(d - d_0) \right] .

The second sum is over the contacts that move forward (including the contact with the wall while it
is compressed) and, under gravity, over every open contact, because it includes the energy of the
beads that will fall.  :math:`d_0` and :math:`F_0` are overlap and force at rest.  Since :math:`U`
is convex, the force on the wall cannot exceed

.. math:: B = k_w \left[ d_0 + \left( \frac{(p+1)\,E^+}{k_w} \right)^{1/(p+1)} \right]^p

until some of the backward motion is reversed.  Laws with damping add the damping force of the
deepest and fastest impact; plastic laws use the overlap at which the contact would return
:math:`E^+`, since reloading a dent requires less energy.  For the left wall, the chain is
mirrored.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..chain.chain import Chain
from ..chain.contact_groups import loading_overlaps
from ..collision import Array
from ..frozen import once
from ..kernels.law_kinds import DAMPED
from .kernel_input import kernel_chain

if TYPE_CHECKING:
    from ..kernels.forces import GeneralChain

LEFT, RIGHT = 0, 1


@dataclass(frozen=True)
class Approach:
    """Motion towards a wall: its momentum, its energy, and the bound of the force."""

    momentum: float
    energy: float
    bound: float


class Target:
    """A wall of a chain, with the chain mirrored for the left wall."""

    def __init__(self, chain: Chain, side: int, equation: GeneralChain) -> None:
        self.chain, self.side = chain, side
        self.towards = 1.0 if side == RIGHT else -1.0
        self.contacts = equation.stiffness > 0.0
        self.masses, self.exists = self._wall_last(chain.masses), self._wall_last(self.contacts)
        contact = chain.beads if side == RIGHT else 0
        groups = chain.contact_groups
        group = next(each for each in groups if contact in each.index)
        self.law, self.wall = group.law, group.contacts.only(group.index == contact)
        row = self.law.row(self.wall.exponent)
        self.damping = float(equation.damping[contact]) if row.kind == DAMPED else 0.0
        self.powers = (row.overlap_power, row.speed_power)

        self.forces = self._forces_at_rest()
        forces = self._wall_last(self.forces)
        overlaps, stored = loading_overlaps(groups, forces), np.zeros(chain.beads + 1)
        for each in groups:
            at = each.index
            stored[at] = each.law.stored_energy(overlaps[at], forces[at], each.contacts)
        self.overlaps = self._wall_last(overlaps)
        self.stored = self._wall_last(np.where(self.contacts, stored, 0.0))

    def _wall_last(self, values: Array) -> Array:
        """Order values, with those at the wall last."""
        return values if self.side == RIGHT else values[::-1]

    def _forces_at_rest(self) -> Array:
        """Forces at rest if all contacts are closed: each carries the beads beyond it."""
        static = self.chain.static_state
        pushes = self.towards * self._wall_last(static.body_forces)
        first = float(self._wall_last(static.forces)[0]) if self.exists[0] else 0.0
        forces = first + np.concatenate(([0.0], np.cumsum(pushes)))
        rounding = 1e-12 * float(np.abs(pushes).sum())
        return np.where(self.exists & (forces > rounding), forces, 0.0)

    def approach(self, overlaps: Array, stored: Array, velocities: Array) -> Approach:
        """Motion towards the wall, from overlaps, energies stored in contacts and velocities."""
        overlaps, stored = self._wall_last(overlaps), self._wall_last(stored)
        velocity = self.towards * self._wall_last(velocities)
        padded = np.concatenate(([0.0], velocity, [0.0]))
        will_fall = (overlaps < 0.0) & (self.forces > 0.0)
        moving = self.exists & ((padded[:-1] + padded[1:] > 0.0) | will_fall)
        available = stored - self.stored - self.forces * (overlaps - self.overlaps)
        forward = np.maximum(velocity, 0.0)
        energy = 0.5 * float(self.masses @ forward**2)
        energy += float(np.maximum(available[moving], 0.0).sum())
        return Approach(float(self.masses @ forward), energy, self._bound(energy))

    def _bound(self, energy: float) -> float:
        """Largest force on the wall that this energy can cause."""
        depth = self.law.largest_overlap(np.array([energy]), self.wall) + self.overlaps[-1]
        speed = math.sqrt(2.0 * energy / float(self.masses[-1]))
        damping = self.damping * depth ** self.powers[0] * speed ** self.powers[1]
        return float((self.law.loading_force(depth, self.wall) + damping)[0])


@once
def wall_targets(chain: Chain) -> tuple[Target, ...]:
    """The walls of a chain, the left one first."""
    equation: Any = kernel_chain(chain)
    sides = [side for side, stiffness in enumerate(chain.wall_stiffness) if stiffness > 0.0]
    return tuple(Target(chain, side, equation) for side in sides)
