r"""The scaling symmetry of chains, and the units in which their motion is the same.

With the mass M of a bead, the largest velocity V and the stiffness k of a contact with exponent
p, the natural units of the motion are :math:`L = (M V^2/k)^{1/(p+1)}` for lengths, :math:`L/V` for
times and :math:`M V^2/L` for forces.  Two chains that are equal in these units have the same traces
in these units.  A change of the stiffness of all contacts, or of the velocity, therefore requires
no simulation, unless the chain has another scale: gravity, precompression, gaps or losses that are
held fixed, or contacts with different exponents.  These cases are found by comparing the chains in
the natural units.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from ..chain.chain import Chain
from ..chain.laws import Loss
from ..chain.scales import Scales
from ..simulation.state import fingerprint

# Numbers that agree in this number of binary digits are regarded as equal.
DIGITS = 35
# Factor that shifts numbers such as 1 away from powers of 2, where rounding would change the
# exponent.
OFF_POWERS = 1.37


@dataclass(frozen=True)
class Units:
    """Units of motion of a chain, in SI.

    ``natural`` is whether they are those of the scaling symmetry, and not those of SI.
    """

    scales: Scales
    time: float
    velocity: float
    force: float
    natural: bool


def units_of(chain: Chain) -> Units:
    """Units of the motion; those of SI if nothing moves at time 0 or a drive moves the chain."""
    velocity = float(np.abs(chain.velocities).max())
    bead = min(chain.strikers, chain.beads - 2)
    mass, stiffness = float(chain.masses[bead]), float(chain.stiffness[bead])
    p = float(chain.contact_exponents[bead + 1])
    radius = float(chain.radii[bead])
    if chain.drive is not None or velocity == 0.0:
        return Units(Scales(radius, mass, 1.0, 1.0, p), 1.0, 1.0, 1.0, natural=False)
    length = (mass * velocity**2 / stiffness) ** (1.0 / (p + 1.0))
    scales = Scales(radius, mass, velocity, length, p)
    return Units(scales, scales.time, velocity, scales.force, natural=True)


def similarity_key(chain: Chain, units: Units) -> bytes:
    """Description of a chain that is the same for chains with the same scaled motion."""
    if not units.natural:
        return fingerprint(chain).encode()
    s, p = units.scales, chain.contact_exponents
    walls = (chain.left_wall, chain.right_wall)
    numbers = [
        chain.masses / s.mass,
        chain.velocities / s.velocity,
        chain.gaps / s.length,
        chain.contact_stiffness * s.length**p / s.force,
        p,
        [0.0 if wall is None else wall.gap / s.length for wall in walls],
        [chain.gravity / s.acceleration, chain.precompression / s.force, chain.strikers],
    ]
    text = [chain.held_by, *(str(wall is None) for wall in walls)]
    for group in chain.contact_groups:
        numbers.append(group.index)
        for law in dict.fromkeys(group.law.resolved(group.contacts)):
            about, values = _law_numbers(law, s)
            text.append(about)
            numbers.append(values)
    whole = OFF_POWERS * np.concatenate([np.asarray(each, float) for each in numbers])
    mantissa, power = np.frexp(whole)
    digits = np.round(np.ldexp(mantissa, DIGITS)).astype(np.int64)
    return digits.tobytes() + power.tobytes() + "|".join(text).encode()


def _law_numbers(law: Loss, scales: Scales) -> tuple[str, list[float]]:
    """Kind of a law, and its parameters in units of the motion."""
    values = []
    words = [law.name]
    about = law.parameters()
    for item in fields(law):
        value = getattr(law, item.name)
        if item.name not in about or value is None:
            continue
        if about[item.name].boolean:
            words.append(str(value))
            continue
        scale = item.metadata.get("scale", "1")
        unit = scale(law) if callable(scale) else scale
        values.append(value / (1.0 if unit == "1" else scales.unit(str(unit))))
    return " ".join(words), values
