"""The cap of a load cell between the last ball and the right wall.

`with_cap` is a method of `hertzchain.Chain`.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, TypeVar

import numpy as np

from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError
from ..units import unit_of_stiffness
from ..validation.keywords import checked_arguments
from ..validation.numbers import has_unit, number
from .cap import Cap
from .fields import ChainFields
from .input_checks import checked_beads, checked_wall_exponent, warn_heavy_cap, warn_soft
from .materials import Material, MaterialLike
from .materials import material as material_named
from .per_contact import usual_exponent
from .pieces import cut
from .striker_properties import UNKNOWN_STIFFNESS, face_stiffness

C = TypeVar("C", bound=ChainFields)
CELL = "such as right_wall=Wall('5 kN/mm', exponent=1)"


@checked_arguments("with_cap")
def with_cap(
    self: C,
    mass: float | None = None,
    *,
    frequency: float | None = None,
    material: MaterialLike | None = None,
    stiffness: float | None = None,
    exponent: float | None = None,
) -> C:
    r"""Return the chain with a cap behind its last ball, such as that of a load cell.

    The cap is a flat body of given mass and becomes the last bead.  Its contact with the last ball
    is that of a sphere on a flat face, or a linear spring of given stiffness if there is a pad
    between them (``exponent=1``).  The right wall of the chain is then the wall behind the
    cap: the spring of the load cell.  Masses and contacts of all other beads still follow from
    their radii if they did.  Exponents and losses that are listed by contact are repeated for the
    contact with the cap.  A law of loss that is given for all contacts is that of a pad, too;
    only `ElasticPlastic` does not apply to it.  If the chain has a cap, the new one replaces it
    and its contact.

    Walls push, but do not pull: the cap rests on its spring and can leave it after the first peak,
    whereas a cap that is bolted to its cell continues to oscillate.  The first peak is the same.

    Parameters
    ----------
    mass : float, optional
        Mass of the cap [scaled, or kg].
    frequency : float, optional
        Resonance frequency f of the cap on the linear right wall of stiffness K, instead of its
        mass :math:`m = K/(2\pi f)^2` [scaled, or Hz].
    material : str or Material, optional
        Material of the cap's surface, in a chain with materials.  The default is that of the
        last ball.
    stiffness : float, optional
        Stiffness of the contact of ball and cap [scaled, or N/m^p].  The default is that of
        Hertz's law.  A unit is allowed only if p is 3/2 or 1.
    exponent : float, optional
        Exponent p >= 1 of this contact, with a stiffness; 1 for a pad between the last ball and the
        cap.  The default is that of the contact in front of it, or 3/2 if that is a linear spring.

    Returns
    -------
    Chain
        Its last bead is the cap, described by ``chain.cap``.

    Raises
    ------
    InputError
        If a value is out of range, the right wall has the stiffness of a Hertz contact, or the
        stiffness of the cap's contact cannot be computed.

    Warns
    -----
    InputWarning
        If the unit of a mass or stiffness that is a plain number is probably wrong.

    Examples
    --------
    >>> import hertzchain as hc
    >>> balls = hc.Chain.from_materials(diameters="10 mm", materials="brass", beads=10)
    >>> cell = balls.replace(right_wall=hc.Wall("5 kN/mm", exponent=1))
    >>> cell.with_cap("5 g", material="steel-304").description
    '10 brass beads, diameter 10 mm, and a cap (5 g, steel-304), right wall of 5 kN/mm'
    >>> f"{1e3 * cell.with_cap(frequency='5 kHz').cap.mass:.2f} g"
    '5.07 g'

    A pad between the last ball and the cap:

    >>> padded = cell.with_cap("5 g", stiffness="1 kN/mm", exponent=1)
    >>> padded.contact_exponents[-3:]
    array([1.5, 1. , 1. ])
    """
    if self.cap is not None:
        self = self.replace(cap=None, **cut(self, 0, self.beads - 1))
    checked_beads(self.beads + 1)
    if (mass is None) == (frequency is None):
        raise InputError(
            "a cap needs its mass, such as '5 g', or its resonance frequency on the right wall, "
            f"such as '5 kHz': {'neither was' if mass is None else 'both were'} given"
        )
    if frequency is not None:
        mass = _resonant_mass(self, frequency)
    heavy = number("mass of a cap", mass, unit=self._unit("kg"), above=0.0)
    if self.units == "SI" and frequency is None:
        warn_heavy_cap(mass, heavy, self.masses)
    own = None if self.materials is None else self.materials[-1]
    if material is not None:
        if own is None:
            raise InputError("material requires a chain with materials; use Chain.from_materials")
        own = material_named(material)
    new = _exponents_with(self, exponent)
    if stiffness is not None:
        p = new.get("exponent", self.contact_exponents[1:-1])
        unit = self._unit(unit_of_stiffness(p[-1]) if len(p) else self._stiffness_unit)
        plain = not has_unit(stiffness)
        stiffness = number("stiffness of the contact of a cap", stiffness, unit=unit, above=0.0)
        if self.units == "SI" and plain and len(p):
            warn_soft("the stiffness of the contact of the cap", stiffness, float(p[-1]))
    new |= {name: np.append(getattr(self, name), 0.0)
            for name in ("velocities", "gaps") if name in self.given}  # fmt: skip
    if own is not None and self.materials is not None:
        new["materials"] = (*self.materials, own)
    if "masses" in self.given:
        new["masses"] = np.append(self.masses, heavy)
    if "stiffness" in self.given:
        new["stiffness"] = _listed_stiffness(self, stiffness, own)
    if isinstance(self.loss, tuple):
        new["loss"] = (*self.loss, self.loss[-1])
    # The radius of the cap follows from its mass.
    radii = np.append(self.radii, self.radii[-1])
    if self.scatter is not None:
        new["scatter"] = self.scatter.with_radii(np.append(self.scatter.radii, self.radii[-1]))
    return self.replace(radii=radii, cap=Cap(heavy, stiffness), **new)


def _exponents_with(chain: ChainFields, given: float | None) -> dict[str, Any]:
    """The exponents of a chain with that of the contact of its cap, if these change."""
    listed = isinstance(chain.exponent, np.ndarray)
    if given is None and not listed:
        return {}
    inner = chain.contact_exponents[1:-1]
    if given is None:
        return {"exponent": np.append(inner, usual_exponent(inner[::-1].tolist()))}
    p = checked_wall_exponent(given, "exponent of the contact of a cap")
    new: dict[str, Any] = {"exponent": np.append(inner, p)}
    inner = new["exponent"].tolist()
    for name, end, order in (("left_wall", 0, inner), ("right_wall", -1, inner[::-1])):
        wall, own = getattr(chain, name), float(chain.contact_exponents[end])
        # A wall without an exponent has that of the contact next to it.
        if wall is not None and wall.exponent is None and usual_exponent(order) != own:
            new[name] = dataclasses.replace(wall, exponent=own)
    return new


def _resonant_mass(chain: ChainFields, frequency: float) -> float:
    """Mass of a cap with this resonance frequency on the linear right wall."""
    wall = chain.right_wall
    if wall is None or wall.stiffness is None or chain.contact_exponents[-1] != 1.0:
        kind = "no right wall" if wall is None else f"right_wall={wall}"
        raise InputError(
            f"the frequency of a cap requires a linear right wall, {CELL}, but the chain has "
            f"{kind}; set the wall before the cap, or give the mass"
        )
    f = number("frequency of a cap", frequency, unit=chain._unit("Hz"), above=0.0)
    return wall.stiffness / (2.0 * math.pi * f) ** 2


def _listed_stiffness(chain: ChainFields, given: float | None, own: Material | None) -> Array:
    """Stiffness of all contacts, with that of the cap, in a chain that lists it."""
    if given is None:
        if own is None or chain.materials is None or chain.contact_exponents[-2] != HERTZ_EXPONENT:
            raise InputError(UNKNOWN_STIFFNESS)
        ball, pair = float(chain.face_radii[-1]), (chain.materials[-1], own)
        given = face_stiffness(ball, math.inf, pair, HERTZ_EXPONENT, chain.beads)
    return np.append(chain.stiffness, given)
