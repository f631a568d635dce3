r"""The largest force that the motion towards a wall can still make there.

The energy that moves towards the right wall, counted from the state of rest, is

.. math::

    E^+ = \sum_{v_k > 0} \tfrac12 m_k v_k^2
        + \sum_{v_k + v_{k+1} > 0} \left[ U(d) - U(d_0) - F_0\,(d - d_0) \right] .

The second sum is over the contacts that move forward (the wall's own among them while it is
pressed in) and, under gravity, over every open contact: it holds the energy of the beads that
will fall.  :math:`d_0` and :math:`F_0` are overlap and force at rest.  Since :math:`U` is convex,
the force on the wall cannot exceed

.. math:: B = k_w \left[ d_0 + \left( \frac{(p+1)\,E^+}{k_w} \right)^{1/(p+1)} \right]^p

until some of the motion backwards is reversed.  Laws with damping add the damping force of the
deepest and fastest impact; with `WaltonBraun`, :math:`E^+` is divided by the ratio of its
stiffnesses, since a dent takes less energy to be loaded again.  For the left wall everything is
mirrored.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.chain.equilibrium import equilibrium
from hertzchain.contacts import Array
from hertzchain.simulation.budget import overlaps_of, stored_energy

if TYPE_CHECKING:
    from hertzchain.kernels.forces import Bench

LEFT, RIGHT = 0, 1


@dataclass(frozen=True)
class Approach:
    """Motion towards a wall: its momentum and energy, and the bound of the force."""

    momentum: float
    energy: float
    bound: float


class Target:
    """A wall of a chain, and the chain as seen from it: mirrored for the left wall."""

    def __init__(self, chain: Chain, side: int, equation: Bench) -> None:
        from hertzchain.kernels.forces import ELASTIC, PLASTIC

        self.chain, self.side, self.p = chain, side, chain.exponent
        self.towards = 1.0 if side == RIGHT else -1.0
        law, stiffness = equation.law, self._seen(equation.stiffness)
        self.contacts = equation.stiffness > 0.0
        self.masses, self.exists = self._seen(chain.masses), stiffness > 0.0
        self.stiffness, self.damping = float(stiffness[-1]), float(self._seen(equation.damping)[-1])
        self.powers = (float(law.overlap_power), float(law.speed_power))
        self.softening = law.kept if law.kind == PLASTIC else 1.0

        self.forces = self._forces_at_rest()
        bearing = np.where(self.exists, stiffness, 1.0)
        self.overlaps = np.asarray((self.forces / bearing) ** (1.0 / self.p))
        kept = 1.0 if law.kind == ELASTIC else law.kept
        self.stored = kept * self.forces * self.overlaps / (self.p + 1.0)

    def _seen(self, values: Array) -> Array:
        return values if self.side == RIGHT else values[::-1]

    def _forces_at_rest(self) -> Array:
        """Forces if all contacts were closed: each bears the one before and the bead between."""
        static = equilibrium(self.chain)
        pushes = self.towards * self._seen(static.body_forces)
        first = float(self._seen(static.forces)[0]) if self.exists[0] else 0.0
        forces = first + np.concatenate(([0.0], np.cumsum(pushes)))
        rounding = 1e-12 * float(np.abs(pushes).sum())
        return np.where(self.exists & (forces > rounding), forces, 0.0)

    def approach(self, time: float, positions: Array, velocities: Array, forces: Array) -> Approach:
        """The motion towards the wall.

        Parameters
        ----------
        time : float
            Time [scaled, or s].
        positions, velocities : ndarray, shape (N,)
            Of the beads [scaled, or m and m/s].
        forces : ndarray, shape (N + 1,)
            In the contacts, counted with the walls [scaled, or N].

        Returns
        -------
        Approach

        Examples
        --------
        A bead of energy 1/2 in front of a wall of stiffness 1:

        >>> from hertzchain.chain.walls import Wall
        >>> from hertzchain.simulation.equations import equation_of
        >>> chain = Chain.uniform(2).replace(right_wall=Wall(stiffness=1.0))
        >>> wall, none = Target(chain, RIGHT, equation_of(chain)), np.zeros(2)
        >>> wall.approach(0.0, none, np.array([0.0, 1.0]), np.zeros(3)).bound == 1.25**0.6
        True
        """
        at = np.array([time]), positions[np.newaxis]
        overlaps = self._seen(overlaps_of(self.chain, *at)[0])
        stored = self._seen(stored_energy(self.chain, *at, forces[np.newaxis])[0])
        velocity = self.towards * self._seen(velocities)
        padded = np.concatenate(([0.0], velocity, [0.0]))
        will_fall = (overlaps < 0.0) & (self.forces > 0.0)
        moving = self.exists & ((padded[:-1] + padded[1:] > 0.0) | will_fall)
        available = stored - self.stored - self.forces * (overlaps - self.overlaps)
        forward = np.maximum(velocity, 0.0)
        energy = 0.5 * float(self.masses @ forward**2)
        energy += float(np.maximum(available[moving], 0.0).sum())
        return Approach(float(self.masses @ forward), energy, self._bound(energy))

    def _bound(self, energy: float) -> float:
        """Largest force on the wall that an energy can make."""
        p = self.p
        depth = ((p + 1.0) * energy / (self.softening * self.stiffness)) ** (1.0 / (p + 1.0))
        depth += float(self.overlaps[-1])
        speed = math.sqrt(2.0 * energy / float(self.masses[-1]))
        damping = self.damping * depth ** self.powers[0] * speed ** self.powers[1]
        return float(self.stiffness * depth**p + damping)
