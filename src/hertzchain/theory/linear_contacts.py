r"""Represent contacts by springs and dampers, for small motions about static equilibrium.

For motions much smaller than the static overlap :math:`d_0`, a contact under a static force
:math:`F_0 > 0` acts as a spring and a damper in parallel,

.. math::

    F - F_0 \approx K\,(d - d_0) + C\,d', \qquad
    K = \frac{\partial F}{\partial d} = p\,k\,d_0^{\,p-1}, \qquad
    C = \frac{\partial F}{\partial d'}\bigg|_{d'=0} ,

======================================  ====================================================
law                                     damper C
======================================  ====================================================
`Viscoelastic`                          :math:`A K`
`Dashpot`, `VelocityPower` of alpha 1   :math:`\gamma`
`Restitution`                           :math:`c\sqrt{\mu k}\;d_0^{(p-1)/2}`
`VelocityPower` of alpha > 1            0: the damping is of higher order in the speed
`VelocityPower` of alpha < 1            none: the force rises infinitely fast from rest
`UnloadingRatio`, `WaltonBraun`,        none: the force is not differentiable at rest
`ElasticPlastic` beyond yield
======================================  ====================================================
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..chain.chain import Chain
from ..chain.feature_support import require_chain
from ..chain.laws.base import ContactsAtRest
from ..collision import Array
from ..errors import InputError
from ..frozen import Frozen
from ..representation import counted, short


@dataclass(frozen=True, eq=False)
class LinearContacts(Frozen):
    """Masses, springs and dampers of a linearised chain.

    Contact c joins beads c and c + 1; contacts 0 and N are those with the walls.

    Attributes
    ----------
    masses : ndarray, shape (N,)
        Masses of the beads [scaled, or kg].
    springs : ndarray, shape (N + 1,)
        Spring constants K [scaled, or N/m]; 0 at a free end.
    dampers : ndarray, shape (N + 1,)
        Damping constants C [scaled, or kg/s].
    """

    masses: Array
    springs: Array
    dampers: Array

    def __repr__(self) -> str:
        shown = [f"{each:.4g}" for each in np.sort(self.springs[self.springs > 0.0])]
        springs = " to ".join(dict.fromkeys((*shown[:1], *shown[-1:]))) or "none"
        dampers = f"dampers up to {self.dampers.max():.4g}" if self.dampers.any() else "no dampers"
        return short(
            "LinearContacts", counted(len(self.masses), "bead"), f"springs {springs}", dampers
        )


def linear_contacts(chain: Chain) -> LinearContacts:
    r"""Springs and dampers of a chain about its static equilibrium."""
    require_chain("linear_contacts", chain)
    forces = chain.static_state.forces
    _check_pressed(chain, forces)
    springs, dampers = np.zeros((2, chain.beads + 1))
    for group in chain.contact_groups:
        # A wall behind a gap has no effect on motions smaller than the gap.
        touching = (forces[group.index] > 0.0) & (group.contacts.stiffness > 0.0)
        if not touching.any():
            continue
        index, contacts = group.index[touching], group.contacts.only(touching)
        overlap = group.law.loading_overlap(forces[index], contacts)
        springs[index] = contacts.exponent * forces[index] / overlap
        at_rest = ContactsAtRest(**vars(contacts), overlap=overlap, spring=springs[index])
        dampers[index] = group.law.damper(at_rest)
    return LinearContacts(chain.masses, springs, dampers)


def _check_pressed(chain: Chain, forces: Array) -> None:
    """Reject contacts without static force: the force is not differentiable at zero overlap."""
    if chain.strikers:
        raise InputError(
            "strikers are not part of a static equilibrium about which the motion could be "
            "linearised; remove them from the chain"
        )
    walls = chain.left_wall, chain.right_wall
    needed = np.ones(chain.beads + 1, bool)
    needed[[0, -1]] = [wall is not None and wall.gap == 0.0 for wall in walls]
    loose = np.flatnonzero(needed & ~(forces > 0.0))
    if len(loose):
        contact = int(loose[0])
        name = {0: " (left wall)", chain.beads: " (right wall)"}.get(contact, "")
        raise InputError(
            f"contact {contact}{name} carries no static force, and its motion cannot be "
            "linearised; give precompression, or gravity towards a wall"
        )
