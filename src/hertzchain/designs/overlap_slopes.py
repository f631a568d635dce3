r"""Exact derivatives of the largest overlap / radius of a chain.

With the force :math:`F` of a contact of radius :math:`R` and modulus :math:`E^*`,

.. math:: d/R = \left(\frac{3F}{4E^*}\right)^{2/3} R^{-4/3} .

The force has an exact gradient if the largest overlap is that of the leading pulse, or that at the
right wall.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.contact_groups import effective_radii
from ..chain.hertz_range import hertz_range
from ..collision import Array
from ..derivatives.gradient import gradients
from ..errors import SimulationError
from ..simulation.simulate_many import tabulate_runs

# Relative difference of two values of the same force, at the tolerances of gradients.
SAME: Final = 1e-4
# Part of the limit below which derivatives are not needed.
FAR: Final = 0.5


def overlap_ratio_and_slopes(
    chain: Chain, fields: tuple[str, ...], limit: float, rtol: float, until: float | None
) -> tuple[float, dict[str, Array]]:
    """Largest overlap / radius and its derivatives, which are 0 far below a limit.

    Raise `SimulationError` if there are no exact derivatives.
    """
    table = tabulate_runs([chain], keep=["largest_overlap"], rtol=rtol, until=until)
    if table.reasons:
        raise SimulationError(table.reasons[0])
    overlaps = table._overlaps[0, : chain.beads + 1]
    ratios = np.nan_to_num(hertz_range(chain, overlaps).overlap_ratio)
    k = int(ratios.argmax())
    value, slopes = float(ratios[k]), {each: np.zeros(len(getattr(chain, each))) for each in fields}
    if value < FAR * limit:
        return value, slopes
    force = chain.contact_stiffness[k] * overlaps[k] ** chain.contact_exponents[k]
    if not 0 < k < chain.beads and not (k == chain.beads and chain.right_wall is not None):
        raise SimulationError("the force on the left wall has no exact gradient here")
    name = "wall_force.peak" if k == chain.beads else f"pulse.peak_force@{k}"
    (found,) = gradients(chain, [name], to=fields, rtol=rtol, until=until)
    if not abs(found.value - force) <= SAME * force:
        raise SimulationError("the largest overlap is not that of the leading pulse")
    for field in fields:
        slopes[field] += 2.0 / 3.0 * value / force * found[field]
    if "radii" in fields:
        radius = effective_radii(chain.face_radii)[k]
        for bead in (k - 1, k):
            if 0 <= bead < chain.beads:
                curvature = 1.0 / chain.face_radii[bead]
                slopes["radii"][bead] -= 4.0 / 3.0 * value * radius * curvature**2
    return value, slopes
