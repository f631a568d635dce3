r"""Contacts of a chain as springs and dampers, for motions that are small about its rest.

A contact of overlap :math:`d_0` under its static force :math:`F_0 > 0` is, for motions much
smaller than :math:`d_0`, a spring and a damper side by side,

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
`VelocityPower` of alpha > 1            0: the loss vanishes faster than the motion
`VelocityPower` of alpha < 1            none: the force rises infinitely fast from rest
`UnloadingRatio`, `WaltonBraun`         none: the force has a kink at rest, however small
                                        the motion
======================================  ====================================================
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import singledispatch

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import check_chain
from hertzchain.chain.equilibrium import equilibrium
from hertzchain.chain.losses import (
    Dashpot,
    Loss,
    Restitution,
    UnloadingRatio,
    VelocityPower,
    Viscoelastic,
    WaltonBraun,
)
from hertzchain.contacts import Array, reduced_mass
from hertzchain.errors import InputError, ModelRangeWarning
from hertzchain.frozen import Frozen


@dataclass(frozen=True, eq=False)
class LinearContacts(Frozen):
    """Masses, and what joins them: contact c lies between beads c and c + 1.

    Contacts are counted with the walls, 0 to N.

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


def linear_contacts(chain: Chain) -> LinearContacts:
    r"""Springs and dampers of a chain about its static equilibrium.

    Parameters
    ----------
    chain : Chain
        A chain that something presses together: precompression, or gravity against a wall.
        Velocities and drive do not matter.

    Returns
    -------
    LinearContacts

    Raises
    ------
    InputError
        If a contact bears no static force, or its loss is not linear however small the motion.

    Warns
    -----
    ModelRangeWarning
        If the loss is a `VelocityPower` with alpha > 1, which small motions do not feel.

    Examples
    --------
    >>> import hertzchain as hc
    >>> held = hc.Chain.uniform(3).replace(precompression=1.0, held_by="force")
    >>> linear_contacts(held.replace(loss=hc.Viscoelastic(0.1))).dampers.round(12)
    array([0.  , 0.15, 0.15, 0.  ])
    """
    check_chain("linear_contacts", chain)
    forces = equilibrium(chain).forces
    left, right = chain.wall_stiffness
    stiffness = np.concatenate(([left], chain.stiffness, [right]))
    _check_pressed(chain, forces)
    # A wall across a gap is not there for motions smaller than the gap.
    touching = (forces > 0.0) & (stiffness > 0.0)
    k, p = stiffness[touching], chain.exponent
    overlaps = (forces[touching] / k) ** (1.0 / p)
    springs, dampers = np.zeros((2, chain.beads + 1))
    springs[touching] = p * forces[touching] / overlaps
    if chain.loss is not None:
        m = chain.masses
        # A wall is as heavy as can be: the reduced mass is the bead's.
        reduced = np.concatenate((m[:1], reduced_mass(m[:-1], m[1:]), m[-1:]))[touching]
        dampers[touching] = _damper(chain.loss, _AtRest(p, k, overlaps, springs[touching], reduced))
    return LinearContacts(chain.masses, springs, dampers)


@dataclass(frozen=True, eq=False)
class _AtRest:
    """Contacts under their static force, each array one number per contact."""

    exponent: float
    stiffness: Array
    overlaps: Array
    springs: Array
    reduced_masses: Array

    def same(self, damping: float) -> Array:
        """One damping constant for all."""
        return np.full(len(self.springs), damping)


def _check_pressed(chain: Chain, forces: Array) -> None:
    """Refuse contacts without a static force: their stiffness at rest is 0 on one side."""
    if chain.strikers:
        raise InputError(
            "strikers fly in and belong to no static equilibrium, about which small motions "
            "could be linear: leave them out"
        )
    walls = chain.left_wall, chain.right_wall
    needed = np.ones(chain.beads + 1, bool)
    needed[[0, -1]] = [wall is not None and wall.gap == 0.0 for wall in walls]
    loose = np.flatnonzero(needed & ~(forces > 0.0))
    if len(loose):
        contact = int(loose[0])
        name = {0: " (left wall)", chain.beads: " (right wall)"}.get(contact, "")
        raise InputError(
            f"contact {contact}{name} bears no static force, so that no motion of it is linear, "
            "however small: give precompression, or gravity towards a wall"
        )


@singledispatch
def _damper(law: Loss, contacts: _AtRest) -> Array:  # noqa: ARG001
    """Damping constants of contacts at rest under a static force."""
    raise InputError(f"it is not known how {law} acts on small motions about a static state")


@_damper.register
def _(law: Viscoelastic, contacts: _AtRest) -> Array:
    return law.time * contacts.springs


@_damper.register
def _(law: Dashpot, contacts: _AtRest) -> Array:
    return contacts.same(law.gamma)


@_damper.register
def _(law: Restitution, contacts: _AtRest) -> Array:
    p = contacts.exponent
    root = np.sqrt(contacts.reduced_masses * contacts.stiffness)
    return np.asarray(law.damping(p) * root * contacts.overlaps ** (0.5 * (p - 1.0)))


@_damper.register
def _(law: VelocityPower, contacts: _AtRest) -> Array:
    if law.alpha == 1.0 or law.gamma == 0.0:
        return contacts.same(law.gamma)
    if law.alpha < 1.0:
        raise InputError(
            f"the force of {law} rises infinitely fast from rest (alpha < 1), so that no motion "
            "is small enough to be linear: use simulate, or loss=None"
        )
    warnings.warn(
        f"{law} vanishes faster than the motion (alpha > 1): small motions are not damped, and "
        "decay rates are 0; real ringing decays the more slowly the smaller it is",
        ModelRangeWarning,
        stacklevel=5,
    )
    return contacts.same(0.0)


@_damper.register
def _(law: UnloadingRatio, contacts: _AtRest) -> Array:
    if law.ratio > 0.0:
        raise InputError(
            f"the force of {law} jumps where a contact turns from closing to opening, so that no "
            "motion is small enough to be linear: use simulate, or loss=None"
        )
    return contacts.same(0.0)


@_damper.register
def _(law: WaltonBraun, contacts: _AtRest) -> Array:
    if law.ratio < 1.0:
        raise InputError(
            f"contacts under {law} close along one curve and open along a steeper one, so that no "
            "motion is small enough to be linear; contacts that were pressed together before "
            f"move along the steeper one: use loss=None and stiffness / {law.ratio:g}**"
            f"{contacts.exponent:g}, of walls too"
        )
    return contacts.same(0.0)
