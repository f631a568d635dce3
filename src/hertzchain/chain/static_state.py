"""Positions and forces of a chain at rest, before the impact.

In a line of beads, each contact force follows from the previous one; hence no system of equations
has to be solved.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..collision import Array
from ..frozen import Frozen
from ..representation import measure, short
from .contact_groups import loading_overlaps
from .fields import ChainFields
from .static_forces import static_forces


@dataclass(frozen=True, eq=False)
class StaticState(Frozen):
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
    overlaps : ndarray, shape (N + 1,)
        Static overlap of each contact [scaled, or m]; 0 at a free end.
    units : str
        ``"SI"`` or, in scaled variables, ``"scaled"``.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(3).replace(gravity=0.1, right_wall=hc.Wall(stiffness=1.0))
    >>> hc.equilibrium(chain).forces.round(6)
    array([0. , 0.1, 0.2, 0.3])
    """

    positions: Array
    gaps: Array
    forces: Array
    body_forces: Array
    overlaps: Array
    units: str = "scaled"

    def __repr__(self) -> str:
        low, high = (
            measure(each, "N", self.units) for each in (self.forces.min(), self.forces.max())
        )
        forces = f"static forces {low} .. {high}"
        moved = f"largest displacement {measure(np.abs(self.positions).max(), 'm', self.units)}"
        return short("StaticState", f"{len(self.positions)} beads", forces, moved)


def static_state(chain: ChainFields) -> StaticState:
    """Compute the static state from which a chain starts, with read-only arrays."""
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
    found = positions, gaps, forces, body_forces, overlaps
    for values in found:
        values.setflags(write=False)
    return StaticState(*found, units=chain.units)
