"""Static equilibrium of a chain before the impact.

In a line of beads, each contact force follows from the previous one, so that no system of equations
has to be solved.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..collision import Array
from ..representation import short
from .chain import Chain
from .contact_groups import loading_overlaps
from .feature_support import require_chain
from .static_forces import static_forces


@dataclass(frozen=True, eq=False)
class StaticState:
    r"""Positions, gaps and constant forces of a chain at time 0.

    Contact numbers include the walls: contact 0 joins the left wall and bead 1, contact N
    joins bead N and the right wall.  The overlap of contact c is

    .. math:: d_c = x_c - x_{c+1} - g_c , \qquad x_0 = x_{N+1} = 0 .

    Attributes
    ----------
    positions : ndarray, shape (N,)
        Displacements :math:`x_k` from the positions at which the unloaded beads touch
        [scaled, or m].  The right end stays in place if it has a wall, or if neither end
        has one; otherwise the left end does.
    gaps : ndarray, shape (N + 1,)
        Distances :math:`g_c` in the formula [scaled, or m].  The gap is negative for a wall
        that was moved inwards to hold the chain.
    forces : ndarray, shape (N + 1,)
        Static force of each contact [scaled, or N]; at a free end, the constant force on
        it.
    body_forces : ndarray, shape (N,)
        Constant force on each bead [scaled, or N]: the component of its weight along the
        chain, and the force that holds a free end.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(3).replace(gravity=0.1, right_wall=hc.Wall(stiffness=1.0))
    >>> equilibrium(chain).forces.round(6)
    array([0. , 0.1, 0.2, 0.3])
    """

    positions: Array
    gaps: Array
    forces: Array
    body_forces: Array

    def __repr__(self) -> str:
        forces = f"static forces {self.forces.min():.4g} .. {self.forces.max():.4g}"
        moved = f"largest displacement {np.abs(self.positions).max():.4g}"
        return short("StaticState", f"{len(self.positions)} beads", forces, moved)


def equilibrium(chain: Chain) -> StaticState:
    r"""Compute the static state from which a chain starts.

    The contact with the smallest force carries the precompression :math:`F_0`.  From there
    the force grows by the weight of each bead, and the overlaps are

    .. math:: d_c = (F_c/k_c)^{1/p} .

    Parameters
    ----------
    chain : Chain
        Any chain.  Without precompression, and without a wall on which the chain rests
        under gravity, or if there are gaps, all forces are 0.

    Examples
    --------
    A force of 8 on contacts of stiffness 1 gives overlaps of :math:`8^{2/3} = 4`:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(4).replace(precompression=8.0, held_by="force")
    >>> equilibrium(chain).positions.round(9)
    array([12.,  8.,  4.,  0.])
    """
    require_chain("equilibrium", chain)
    forces = static_forces(chain.loads)
    overlaps = np.zeros(len(forces))
    if forces.any():
        overlaps = loading_overlaps(chain.contact_groups, forces)

    # Each position follows from the next bead's; strikers touch the chain without overlap.
    behind = overlaps[1:-1].copy()
    behind[: chain.strikers] = 0.0
    positions = np.append(np.cumsum(behind[::-1])[::-1], 0.0)
    if chain.right_wall is not None:
        positions += overlaps[-1]
    elif chain.left_wall is not None:
        positions -= positions[0] + overlaps[0]

    gaps = np.concatenate(([0.0], chain.gaps, [0.0]))
    if chain.left_wall is not None:
        gaps[0] = chain.left_wall.gap - positions[0] - overlaps[0]
    if chain.right_wall is not None:
        gaps[-1] = chain.right_wall.gap + positions[-1] - overlaps[-1]
    body_forces = chain.masses * chain.gravity
    if chain.precompression > 0.0:
        if chain.left_wall is None:
            body_forces[chain.strikers] += forces[chain.strikers]
        if chain.right_wall is None:
            body_forces[-1] -= forces[-1]
    return StaticState(positions, gaps, forces, body_forces)
