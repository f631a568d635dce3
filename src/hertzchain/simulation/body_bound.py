r"""Upper bound of the force that the motion of a chain can still cause on the last body.

The right end is free, and no constant force acts.  Contacts only push, so the momentum of beads 1
to c cannot increase by more than the impulse of the attraction that is left in contact c, and that
of all beads is constant (`hertzchain.simulation.wall_bound` has the notation).  The kinetic energy
is therefore never less than

.. math:: K^- = \sum_k \tfrac12 m_k w_k^2 ,

where :math:`w_k` are the slopes of the greatest convex minorant of the limits of momentum as a
function of the mass of beads 1 to c: the velocities after perfectly plastic collisions of all
beads that approach each other.  The last contact can store no more than

.. math:: E = \sum_k \tfrac12 m_k v_k^2 + \sum_c U(d_c) - K^- ,

and the relative velocity of its two bodies cannot exceed :math:`\sqrt{2 E / \mu}` with their
reduced mass.  A left wall or a piston can only push forward; the minimum is then that of the motion
of all beads as one body, unless all beads already separate.  Under gravity or precompression, there
is no bound.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..chain.chain import Chain
from ..chain.contact_groups import reduced_masses
from ..collision import Array
from ..frozen import once
from ..kernels.law_kinds import DAMPED, UNLOADING
from ..kernels.wall_rule import ROUNDING
from .kernel_input import kernel_chain
from .momentum_limits import attraction_of, minorant


def least_energy(masses: Array, momenta: Array) -> float:
    """Smallest kinetic energy if beads 1 to c have at most momentum c, and all beads the last."""
    # A product that is too large is infinite; a power would raise an error.
    return sum(0.5 * momentum * momentum / mass for mass, momentum in minorant(masses, momenta))


class BodyBound:
    """The last contact of a chain with a free right end."""

    def __init__(self, chain: Chain) -> None:
        equation: Any = kernel_chain(chain)
        self.chain, contact = chain, chain.beads - 1
        group = next(each for each in chain.contact_groups if contact in each.index)
        self.law, self.contact = group.law, group.contacts.only(group.index == contact)
        row = self.law.row(self.contact.exponent)
        self.damping = float(equation.damping[contact]) if row.kind == DAMPED else 0.0
        self.powers = (row.overlap_power, row.speed_power)
        self.reloads = row.kind == UNLOADING
        self.reduced = float(reduced_masses(chain.masses)[contact])
        piston = chain.drive is not None and chain.drive.of == "displacement"
        self.behind = chain.left_wall is not None or piston
        static = chain.static_state
        # Static forces that hold the ends act on, and gravity does, too.
        self.known = not static.body_forces.any() and not static.forces.any()
        self.exists = np.asarray(chain.contact_stiffness) > 0.0
        self.attraction = attraction_of(chain, equation, self.exists)

    def force(self, overlap: float) -> float:
        """Largest force if a contact without a dent has been compressed to an overlap."""
        return float(self.law.loading_force(np.array([max(overlap, 0.0)]), self.contact)[0])

    def later(self, overlaps: Array, stored: Array, velocities: Array) -> float:
        """Bound of any later force of the last contact; infinite if there is none."""
        if not self.known:
            return math.inf
        energy = self._excess(overlaps, stored, velocities)
        if not energy > 0.0:
            return 0.0
        depth = self.law.largest_overlap(np.array([energy]), self.contact)
        speed = math.sqrt(2.0 * energy / self.reduced)
        damping = self.damping * depth ** self.powers[0] * speed ** self.powers[1]
        return float((self.law.loading_force(depth, self.contact) + damping)[0])

    @staticmethod
    def excludes_more(later: float, peak: float) -> bool:
        """Whether this bound of later forces excludes one above the largest so far."""
        return peak > 0.0 and later <= (1.0 + ROUNDING) * peak

    def _excess(self, overlaps: Array, stored: Array, velocities: Array) -> float:
        """Energy that the last contact can take up."""
        masses = self.chain.masses
        opposed = np.concatenate(([0.0], velocities, velocities[-1:]))
        meeting = (overlaps > 0.0) | (opposed[:-1] > opposed[1:])
        if not self.behind:
            meeting[0] = False
        if not meeting[:-1].any():
            return 0.0
        energy = 0.5 * float(masses @ velocities**2) + float(stored[self.exists].sum())
        if self.reloads:
            # The last contact returns to its loading curve without the energy stored in it.
            p, k = self.contact.exponent, float(self.contact.stiffness[0])
            depth = max(float(overlaps[-2]), 0.0)
            energy += k * depth ** (p + 1.0) / (p + 1.0) - float(stored[-2])
        momenta = np.cumsum(masses * velocities)
        if self.behind:
            total = max(float(momenta[-1]), 0.0)
            return energy - 0.5 * total**2 / float(masses.sum())
        momenta[:-1] += self.attraction.impulses(overlaps)[1:-1]
        return energy - least_energy(masses, momenta)


@once
def body_bound(chain: Chain) -> BodyBound:
    """The bound of a chain, which is the same for all its runs."""
    return BodyBound(chain)
