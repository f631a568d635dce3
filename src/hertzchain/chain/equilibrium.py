"""Static equilibrium of a chain before the impact."""

from __future__ import annotations

from ..validation.keywords import checked_arguments
from .chain import Chain
from .feature_support import require_chain
from .hertz_warnings import warn_outside_static
from .static_state import StaticState


@checked_arguments("equilibrium")
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

    Warns
    -----
    ModelRangeWarning
        If the static forces exceed a limit of Hertz's law (`hertz_range`).

    Examples
    --------
    A force of 8 on contacts of stiffness 1 gives overlaps of :math:`8^{2/3} = 4`:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(4).replace(precompression=8.0, held_by="force")
    >>> hc.equilibrium(chain).positions.round(9)
    array([12.,  8.,  4.,  0.])
    """
    require_chain("equilibrium", chain, beads=1)
    warn_outside_static(chain)
    return chain.static_state
