"""A chain at rest: what its contacts bear before anything moves.

In a row each force follows from the one before it, so nothing needs to be solved for but
the overlaps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.chain.coverage import check_chain
from hertzchain.chain.holding import static_forces, static_overlaps
from hertzchain.contacts import Array


@dataclass(frozen=True, eq=False)
class StaticState:
    r"""Where the beads are at time 0, and which forces act on them all the time.

    Contacts are counted with the walls: contact 0 is that of the left wall and bead 1,
    contact N that of bead N and the right wall.  The overlap of contact c is

    .. math:: d_c = x_c - x_{c+1} - g_c , \qquad x_0 = x_{N+1} = 0 .

    Attributes
    ----------
    positions : ndarray, shape (N,)
        Displacements :math:`x_k` from where the unloaded beads touch [scaled, or m]; of
        the two ends, the right one stays in place if it has a wall or neither has.
    gaps : ndarray, shape (N + 1,)
        Distances :math:`g_c` in the formula; negative for a wall that was moved in to hold
        the chain [scaled, or m].
    forces : ndarray, shape (N + 1,)
        Static force of each contact [scaled, or N]; that of a free end is the constant
        force on it.
    body_forces : ndarray, shape (N,)
        Constant force on each bead: its weight along the chain and what holds a free end
        [scaled, or N].

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


def equilibrium(chain: Chain) -> StaticState:
    r"""The static state from which a chain starts.

    From the contact that bears least, with the chain's precompression :math:`F_0`, forces
    grow by the weight of each bead, and

    .. math:: d_c = (F_c/k_c)^{1/p} .

    Parameters
    ----------
    chain : Chain
        Any chain.  If nothing holds it, as without precompression and wall to stand on,
        or if there are gaps, beads are where they are put and forces are 0.

    Returns
    -------
    StaticState

    Examples
    --------
    A force of 8 on contacts of stiffness 1: overlaps are :math:`8^{2/3} = 4`.

    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(4).replace(precompression=8.0, held_by="force")
    >>> equilibrium(chain).positions.round(9)
    array([12.,  8.,  4.,  0.])
    """
    check_chain("equilibrium", chain)
    forces = static_forces(chain)
    overlaps = static_overlaps(chain, forces)

    # Each bead from the one after it; strikers just meet the chain, but for their gaps.
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
