"""Strikers: beads, pistons or several of either that fly in from the left.

`struck_by` is a method of `hertzchain.Chain`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from hertzchain.chain.materials import Material, MaterialLike, contact_modulus, sphere_stiffness
from hertzchain.chain.materials import material as material_named
from hertzchain.chain.sizes import checked_beads
from hertzchain.checks import number, whole_number
from hertzchain.contacts import HERTZ_EXPONENT, hertz_stiffness
from hertzchain.errors import InputError

if TYPE_CHECKING:
    from hertzchain.chain.chain import Chain


def struck_by(
    self: Chain,
    *,
    velocity: float = 1.0,
    radius: float | None = None,
    mass: float | None = None,
    material: MaterialLike | None = None,
    stiffness: float | None = None,
    count: int = 1,
    gap: float = 0.0,
) -> Chain:
    """The same chain, at rest, with strikers in front that fly in.

    Can be repeated: later strikers stand in front of earlier ones.  What is not given is
    as of the chain's first bead.

    Parameters
    ----------
    velocity : float
        Velocity of the strikers [scaled, or m/s].
    radius : float, optional
        Radius of a striker [scaled, or m]; if a mass is given, that of a sphere of this
        mass.  Infinite for a flat face, such as a piston's, which needs a mass.
    mass : float, optional
        Mass of a striker [scaled, or kg]; that of a sphere if not given.
    material : str or Material, optional
        Material of the strikers, in a chain of materials.
    stiffness : float, optional
        Stiffness of all new contacts [scaled, or N/m^p]; Hertz' if not given.
    count : int
        Number of equal strikers, which touch each other.
    gap : float
        Distance between the last of them and the chain [scaled, or m].

    Returns
    -------
    Chain
        Its first beads are the strikers; ``chain.strikers`` says how many.

    Raises
    ------
    InputError
        For a value out of its range, or a stiffness that does not follow from the rest.

    Examples
    --------
    A striker of four times the mass:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(20).struck_by(mass=4.0, radius=1.0)
    >>> chain.masses[:3], chain.velocities[:3]
    (array([4., 1., 1.]), array([1., 0., 0.]))

    A piston of 50 g with a flat steel face on a chain of brass balls:

    >>> balls = hc.Chain.from_materials(5e-3, "brass", beads=20)
    >>> import math
    >>> piston = balls.struck_by(mass=0.05, radius=math.inf, material="steel-304")
    >>> round(float(piston.stiffness[0] / piston.stiffness[1]), 3)
    1.833
    """
    count = whole_number("count of strikers", count, least=1)
    checked_beads(self.beads + count)
    own, radius, mass, drawn = _striker(self, radius, mass, material)
    speed = number("velocity of the strikers", velocity, unit=self._unit("m/s"))
    distance = number("gap", gap, unit=self._unit("m"), least=0.0)
    moving = self.strikers > 0 or "velocities" in self.features
    behind = self.velocities if moving else np.zeros(self.beads)
    new: dict[str, Any] = {
        "radii": np.concatenate((np.full(count, drawn), self.radii)),
        "velocities": np.concatenate((np.full(count, speed), behind)),
        "gaps": np.concatenate((np.zeros(count - 1), [distance], self.gaps)),
        "strikers": self.strikers + count,
    }
    if own is not None and self.materials is not None:
        new["materials"] = (own,) * count + self.materials
    if mass is not None or "masses" in self.given:
        heavy = _sphere_mass(self, drawn, own) if mass is None else mass
        new["masses"] = np.concatenate((np.full(count, heavy), self.masses))
    if stiffness is not None or "stiffness" in self.given or math.isinf(radius):
        between = 0.0 if count == 1 else _striker_contact(self, stiffness, radius, own, None)
        last = _striker_contact(self, stiffness, radius, own, 0)
        contacts = [*[between] * (count - 1), last]
        new["stiffness"] = np.concatenate((contacts, self.stiffness))
    return self.replace(**new)


def _striker(
    chain: Chain, radius: float | None, mass: float | None, material: MaterialLike | None
) -> tuple[Material | None, float, float | None, float]:
    """Material, radius of the face, mass unless a sphere's, and radius to draw."""
    own = None if chain.materials is None else chain.materials[chain.strikers]
    if material is not None:
        if own is None:
            raise InputError("material has a meaning in a chain of materials only")
        own = material_named(material)
    if mass is not None:
        mass = number("mass of a striker", mass, unit=chain._unit("kg"), above=0.0)
    elif radius is None:
        radius = float(chain.radii[chain.strikers])
    sphere = 0.0 if mass is None else float(np.cbrt(mass / _sphere_mass(chain, 1.0, own)))
    if radius is None:
        return own, sphere, None, sphere
    if isinstance(radius, float) and radius == math.inf:
        if mass is None:
            raise InputError("a flat striker needs a mass: no sphere says what it weighs")
        return own, math.inf, mass, sphere
    radius = number("radius of a striker", radius, unit=chain._unit("m"), above=0.0)
    return own, radius, mass, radius


def _sphere_mass(chain: Chain, radius: float, own: Material | None) -> float:
    """Mass of a sphere of a material, or of the density of the first bead."""
    if own is not None:
        return 4.0 / 3.0 * math.pi * own.density * radius**3
    first = chain.strikers
    return float(chain.masses[first] * (radius / chain.radii[first]) ** 3)


def _striker_contact(
    chain: Chain, given: float | None, radius: float, own: Material | None, bead: int | None
) -> float:
    """Stiffness of a striker's contact with a bead, or with another such striker."""
    if given is not None:
        unit = chain._unit(f"N/m**{chain.exponent}")
        return number("stiffness of the new contacts", given, unit=unit, above=0.0)
    other_radius = radius if bead is None else float(chain.radii[bead])
    hertz = chain.exponent == HERTZ_EXPONENT and "stiffness" not in chain.given
    if (
        math.isinf(other_radius)
        or (chain.units == "SI" and own is None)
        or not (hertz or (own is not None and chain.exponent == HERTZ_EXPONENT))
    ):
        raise InputError(
            "the stiffness of the strikers' contacts does not follow from sizes and "
            "materials here: give stiffness"
        )
    if own is not None and chain.materials is not None:
        other = own if bead is None else chain.materials[bead]
        return float(sphere_stiffness(radius, other_radius, contact_modulus(own, other)))
    if math.isinf(radius):
        return math.sqrt(2.0 * other_radius)
    return float(hertz_stiffness(radius, other_radius))
