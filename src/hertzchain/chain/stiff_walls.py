"""Walls of a given linear stiffness that are too stiff to replace the contact of a ball."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from ..representation import measure
from .bead_names import bead_label, walls_of
from .chain import Chain
from .hertz_ratios import linear_springs, with_walls
from .materials import contact_moduli
from .walls import material_of_wall

# Deflection of a spring, over the overlap of a Hertz contact under the same force, from which the
# contact can be left out.  At this ratio, both in series are about a tenth softer.
MUCH_LARGER: Final = 10.0
# Mass of a light cap, as a part of that of the ball.
LIGHT: Final = 0.02
# In the reasons of points of sweeps, which are counted by these words.
TOO_STIFF: Final = "wall is too stiff to replace the Hertz contact of a ball"


def stiff_walls(chain: Chain, overlaps: ArrayLike) -> dict[str, tuple[float, float]]:
    """Deflection and Hertz overlap [m] of the walls whose spring is too stiff, by their side.

    The overlap is that of the ball and a wall of its own material, unless the wall has one, under
    the largest force of the spring.  A cap has a contact in front of its spring.
    """
    if chain.units != "SI" or chain.materials is None:
        return {}
    found: dict[str, tuple[float, float]] = {}
    springs = linear_springs(chain)
    largest = with_walls(chain, overlaps)
    for side in walls_of(chain):
        ball, contact = (0, 0) if side == "left" else (chain.beads - 1, chain.beads)
        radius, deflection = float(chain.radii[ball]), float(largest[contact])
        of_cap = chain.cap is not None and side == "right"
        if of_cap or not (springs[contact] and deflection > 0.0 and np.isfinite(radius)):
            continue
        bead = chain.materials[ball]
        wall = material_of_wall(chain.left_wall if side == "left" else chain.right_wall, bead)
        (modulus,) = contact_moduli([bead, wall])
        force = chain.contact_stiffness[contact] * deflection
        overlap = float(np.cbrt(0.75 * force / (modulus * np.sqrt(radius))) ** 2)
        if deflection < MUCH_LARGER * overlap:
            found[side] = deflection, overlap
    return found


def stiff_wall_notes(chain: Chain, overlaps: ArrayLike) -> tuple[str, ...]:
    """A sentence for each wall whose spring is too stiff to replace the contact of a ball."""
    notes = []
    for side, (deflection, overlap) in stiff_walls(chain, overlaps).items():
        ball = 0 if side == "left" else chain.beads - 1
        name = bead_label(chain, ball + 1)
        relation = "not much larger than" if deflection > overlap else "less than"
        spring, contact = (measure(each, "m", "SI", 2) for each in (deflection, overlap))
        notes.append(
            f"the spring of the {side} wall replaces the Hertz contact of {name}, but its "
            f"deflection of {spring} is {relation} the overlap of this contact under the "
            f"same force, {contact}; with both in series, the force differs: {_advice(chain, side)}"
        )
    return tuple(notes)


def stiff_wall_reasons(chain: Chain, overlaps: ArrayLike) -> list[str]:
    """A short clause for each wall whose spring is too stiff, for tables of many chains."""
    found = stiff_walls(chain, overlaps)
    return [f"the spring of the {side} {TOO_STIFF}: {_advice(chain, side, short=True)}"
            for side in found]  # fmt: skip


def _advice(chain: Chain, side: str, *, short: bool = False) -> str:
    """The change that corrects the force, with the name of the method unless the text is short."""
    if side == "left":
        return "use Wall() or the material of the wall if it is stiffer than the contact"
    mass = 1e3 * float(f"{LIGHT * chain.masses[chain.beads - 1]:.1g}")
    return f"add a light cap of {mass:g} g" if short else f"add a light cap: with_cap('{mass:g} g')"
