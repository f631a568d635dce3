r"""Upper bounds of the force that the motion of a chain can still cause on a wall.

**Proof.**  Let the end of the chain opposite to the right wall be free, and let no constant force
push the beads towards the wall.  Contacts only push, so the momentum of beads 1 to c cannot
increase by more than :math:`J_c`, the impulse of the attraction that is left in contact c:

.. math::

    \sum_{k \le c} m_k v_k(t') \le P_c = J_c + \sum_{k \le c} m_k v_k(t)
    \quad (c = 1, \dots, N,\ t' \ge t) .

When the force on the wall has a maximum, :math:`v_N \ge 0`, so that beads 1 to N - 1 have at most
the momentum :math:`\min(P_{N-1}, P_N)`.  Under these conditions the kinetic energy is at least

.. math:: K^- = \sum_{k < N} \tfrac12 m_k w_k^2 ,

where :math:`w_k \le 0` are the negative slopes of the greatest convex minorant of the limits of
momentum as a function of the mass of beads 1 to c, from (0, 0) on.  Without attraction, they are
the negative velocities after perfectly plastic collisions of all beads that approach each other.
The contact with the wall can therefore store no more than

.. math:: E = \sum_k \tfrac12 m_k v_k^2 + \sum_c U(d_c) - K^- ,

and the force on the wall cannot have a maximum above

.. math:: B = k_w \left( \frac{(p+1)\,E}{k_w} \right)^{p/(p+1)}

at any later time.  With gravity that pulls all beads away from the wall, this holds in the falling
frame.  :math:`J_c = g\,d^{a+1}/(a+1)` if the damping force of a closed contact is
:math:`g\,d^a d'` and may pull; a contact with another attraction sets no limit.

**Estimate.**  If the other end is held, by a wall, a piston or a force, or if gravity acts towards
the wall, all motion can return.  The energy that moves towards the right wall now, counted from
the state of rest, is

.. math::

    E^+ = \sum_{v_k > 0} \tfrac12 m_k v_k^2
        + \sum_{v_k + v_{k+1} > 0} \left[ U(d) - U(d_0) - F_0\,(d - d_0) \right] .

The second sum is over the contacts that move forward (including the contact with the wall while it
is compressed) and, under gravity, over every open contact, because it includes the energy of the
beads that will fall.  :math:`d_0` and :math:`F_0` are overlap and force at rest.  Since :math:`U`
is convex, the force on the wall cannot exceed

.. math:: B^+ = k_w \left[ d_0 + \left( \frac{(p+1)\,E^+}{k_w} \right)^{1/(p+1)} \right]^p

until some of the backward motion is reversed or some of the energy in other contacts is released.

Laws with damping add the damping force of the deepest and fastest impact to both bounds; plastic
laws use the overlap at which the contact would return the energy, since reloading a dent requires
less energy.  For the left wall, the chain is mirrored.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..chain.chain import Chain
from ..chain.contact_groups import loading_overlaps
from ..collision import Array
from ..frozen import once
from ..kernels.law_kinds import DAMPED, UNLOADING
from .kernel_input import kernel_chain
from .momentum_limits import Attraction, attraction_of, minorant
from .rebounds import has_rebounded, may_rebound

if TYPE_CHECKING:
    from ..kernels.forces import GeneralChain

LEFT, RIGHT = 0, 1


@dataclass(frozen=True)
class Approach:
    """Motion that can reach a wall: its momentum, its energy, and the bound of the force."""

    momentum: float
    energy: float
    bound: float


# Of a peak on a wall to which beads can return.
LATER_IMPACTS: Final = "the beads can return to the wall, and a later impact may be stronger"


def motion_can_escape(chain: Chain, side: int) -> bool:
    """Whether the beads can leave a wall permanently, and nothing pushes them towards it."""
    other, towards = (chain.left_wall, 1.0) if side == RIGHT else (chain.right_wall, -1.0)
    piston = side == RIGHT and chain.drive is not None and chain.drive.of == "displacement"
    held = other is not None or piston or chain.precompression > 0.0
    return not held and towards * chain.gravity <= 0.0


def locked_energy(masses: Array, momenta: Array) -> float:
    """Smallest kinetic energy if the first c beads have at most momentum ``momenta[c - 1]``.

    The positive direction is that towards the wall; infinite entries set no limit.
    """
    # A product that is too large is infinite; a power would raise an error.
    return sum(
        0.5 * momentum * momentum / mass
        for mass, momentum in minorant(masses, momenta) if momentum < 0.0
    )  # fmt: skip


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
        self.reloads = row.kind == UNLOADING
        self.can_escape = motion_can_escape(chain, side)
        pull = attraction_of(chain, equation, self.contacts)
        self.attraction = Attraction(self._wall_last(pull.strength), self._wall_last(pull.powers))

        self.forces = self._forces_at_rest()
        forces = self._wall_last(self.forces)
        overlaps, stored = loading_overlaps(groups, forces), np.zeros(chain.beads + 1)
        for each in groups:
            at = each.index
            stored[at] = each.law.stored_energy(overlaps[at], forces[at], each.contacts)
        self.overlaps = self._wall_last(overlaps)
        self.stored = self._wall_last(np.where(self.contacts, stored, 0.0))
        self.may_rebound = may_rebound(chain, self.towards, held=bool(self.exists[0]))

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
        """Motion towards the wall now, from overlaps, stored energies and velocities."""
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

    def reach(self, overlaps: Array, stored: Array, velocities: Array) -> Approach:
        """Motion that can ever reach the wall, or that moves towards it if none can escape."""
        approach = self.approach(overlaps, stored, velocities)
        if not self.can_escape:
            return approach
        overlaps, stored = self._wall_last(overlaps), self._wall_last(stored)
        velocity = self.towards * self._wall_last(velocities)
        # With a nonlinear attraction, a contact that is open now may pull later.
        momenta = np.cumsum(self.masses * velocity) + self.attraction.impulses(overlaps)[1:]
        # The last bead does not recede from the wall while the force on it reaches a maximum.
        momenta[-2] = momenta[-2:].min()
        energy = 0.5 * float(self.masses @ velocity**2) + float(stored[self.exists].sum())
        if self.reloads:
            # The contact with the wall returns to its loading curve without that energy.
            energy += self._loading_energy(float(overlaps[-1])) - float(stored[-1])
        energy = max(0.0, energy - locked_energy(self.masses[:-1], momenta[:-1]))
        return Approach(approach.momentum, energy, self._bound(energy))

    def rebounded(self, overlaps: Array, stored: Array, velocities: Array) -> bool:
        """Whether the first beads have rebounded from the row, and the others are slow."""
        if not self.may_rebound:
            return False
        overlaps, stored = self._wall_last(overlaps), self._wall_last(stored)
        velocity = self.towards * self._wall_last(velocities)
        return has_rebounded(self.masses, velocity, overlaps, stored, self.forces, self.exists)

    def _loading_energy(self, overlap: float) -> float:
        """Energy that the contact with the wall takes up when it is loaded to an overlap."""
        p, k = self.wall.exponent, float(self.wall.stiffness[0])
        return k * max(overlap, 0.0) ** (p + 1.0) / (p + 1.0)

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
