r"""Whether the forces of a chain are a power of the speed of the impact.

If all contacts have forces :math:`F = k d^{3/2}` and there is no other scale of force or length, a
solution of the equations of motion can be scaled: forces are proportional to :math:`v^{6/5}`, and
times to :math:`v^{-1/5}`.  This includes losses with constant coefficients of restitution, such as
`Restitution`, whose damping force :math:`c\sqrt{\mu k}\,d^{1/4} d'` is proportional to
:math:`v^{1/5}\,v`.
"""

from __future__ import annotations

from ..chain.chain import Chain
from ..chain.hertz_ratios import linear_springs, scale_free_loss, springs_of

EXPONENT_OF_FORCES = 6.0 / 5.0


def other_scales(chain: Chain) -> list[str]:
    """Parts of a chain because of which forces are no power of the speed, in words."""
    linear, springs = linear_springs(chain), springs_of(chain)
    found = []
    if linear[-1]:
        found.append("the wall or load cell behind the row is a linear spring")
    if linear[:-1].any():
        found.append("a contact between two bodies is a linear spring, such as a pad")
    if (springs & ~linear).any():
        found.append("contacts have another exponent than 3/2")
    if chain.gaps.any():
        found.append("there are gaps between the balls")
    if chain.gravity or chain.precompression > 0.0:
        found.append("a static force acts on the contacts")
    if not chain.lossless and not scale_free_loss(chain):
        found.append("contacts lose energy by a law with a scale of time or speed")
    return found
