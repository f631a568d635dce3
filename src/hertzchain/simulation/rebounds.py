r"""The end of an impact under gravity: beads have rebounded, and the rest of the row is slow.

Under gravity towards a wall, beads that have been thrown off the row fall back onto it.  This is
another impact, which does not belong to the one that threw them off.  Let beads 1 to c move away
from the wall and contacts 1 to c be open.  The row has *rebounded* if the remaining beads have at
most a fraction `REST` of the energy of the motion,

.. math::

    \sum_{k > c,\,v_k > 0} \tfrac12 m_k v_k^2
        + \sum_{k > c} \left[ U(d_k) + (F_k - F_c)\,\max(0, -d_k) \right]
    \le \text{REST} \left\{ \sum_k \tfrac12 m_k v_k^2
        + \sum_k \left[ U(d_k) + F_k\,\max(0, -d_k) \right] \right\} ,

where :math:`F_k` is the weight of beads 1 to k, with which an open contact will close.  The bound
of `hertzchain.simulation.wall_bound` is then needlessly large: it puts the energy of the rattling
beads, and of the fall of those thrown off, into the contact with the wall, which is often much
stiffer than the contacts between the beads.
"""

from __future__ import annotations

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..kernels.wall_rule import REST, ROUNDING


def may_rebound(chain: Chain, towards: float, *, held: bool) -> bool:
    """Whether nothing but gravity pushes beads towards a wall, and the other end is not held."""
    falls = towards * chain.gravity > 0.0
    return falls and chain.drive is None and chain.precompression == 0.0 and not held


def has_rebounded(
    masses: Array, velocities: Array, overlaps: Array, stored: Array, weights: Array, exists: Array
) -> bool:
    """Whether the first beads fly away and the others have little energy; the wall is last.

    Overlaps, energies, weights and ``exists`` are those of contacts 0 to N.
    """
    away = (velocities < 0.0) & (overlaps[1:] <= 0.0)
    count = len(away) if away.all() else int(np.argmin(away))
    if not count:
        return False
    kinetic = 0.5 * masses * velocities**2
    open_by = np.where(exists, np.maximum(-overlaps, 0.0), 0.0)
    stored = np.where(exists, stored, 0.0)
    total = kinetic.sum() + stored.sum() + weights @ open_by
    beyond = slice(count + 1, None)
    own = np.maximum(weights[beyond] - weights[count], 0.0)
    forward = velocities[count:] > 0.0
    rest = kinetic[count:][forward].sum() + stored[beyond].sum() + own @ open_by[beyond]
    return bool(rest <= (1.0 + ROUNDING) * REST * total)
