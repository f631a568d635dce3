"""Strikers: beads or pistons that hit the chain from the left.

`struck_by` is a method of `hertzchain.Chain`.
"""

from __future__ import annotations

import itertools
import math
from numbers import Real
from typing import Any, Final, TypeVar

import numpy as np

from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError, InputWarning, warn_user
from ..representation import measure
from ..units import STANDARD_GRAVITY, unit_of_stiffness
from ..validation.json_types import FLAT_FACES
from ..validation.keywords import checked_arguments
from ..validation.numbers import number, plain_magnitude, whole_number
from .fields import ChainFields
from .input_checks import GAP_HINT, MAX_GAP, MAX_VELOCITY, checked_beads
from .materials import Material, MaterialLike
from .materials import material as material_named
from .per_contact import LINEAR, usual_exponent
from .striker_properties import SPHERE, UNKNOWN_STIFFNESS, StrikerProperties, face_stiffness

# Mass of a striker over that of the heaviest bead, and in kg, from which the unit is probably
# wrong: grams given as kg are a thousand times too heavy, but so are small hammers on small balls.
HEAVY, HEAVY_KG = 1000.0, 1.0
# The same of a sphere whose mass has no unit.
HEAVY_SPHERE = 100.0
# Largest height to fall from [m].
MAX_FALL: Final = 1e6
C = TypeVar("C", bound=ChainFields)


@checked_arguments("struck_by")
def struck_by(
    self: C,
    *,
    velocity: float | None = None,
    height: float | None = None,
    energy: float | None = None,
    radius: float | None = None,
    diameter: float | None = None,
    mass: float | None = None,
    material: MaterialLike | None = None,
    stiffness: float | None = None,
    count: int = 1,
    gap: float = 0.0,
) -> C:
    r"""Return the chain at rest, to be hit by strikers from the left.

    The impact on the first bead is then omitted, with a warning if its velocity was given, such as
    ``velocity`` of `Chain.from_materials`.
    The method can be called repeatedly; later strikers are placed to the left of earlier
    ones.  Properties that are not given are those of the chain's first bead.  Masses and contacts
    of the other beads still follow from their radii if they did.

    Parameters
    ----------
    velocity : float, optional
        Velocity of the strikers [scaled, or m/s]; 1 by default.
    height : float, optional
        Height h from which the strikers fall [m], instead of their velocity
        :math:`v = \sqrt{2gh}` with g = 9.80665 m/s^2, whatever the gravity of the chain, in an SI
        chain.  It may also be that of a pendulum.
    energy : float, optional
        Kinetic energy E of each striker [J], instead of its velocity :math:`v = \sqrt{2E/m}`, in
        an SI chain.
    radius : float, optional
        Radius of a striker [scaled, or m].  If only a mass is given, the default is the
        radius of a sphere of this mass.  An infinite radius, or ``"flat"``, is a flat face,
        such as that of a piston; it requires a mass.
    diameter : float, optional
        Diameter of a striker, instead of its radius [scaled, or m].
    mass : float, optional
        Mass of a striker [scaled, or kg].  The default is that of a sphere.
    material : str or Material, optional
        Material of the strikers, in a chain with materials.
    stiffness : float, optional
        Stiffness of all new contacts [scaled, or N/m^p].  The default is that of Hertz's law.
    count : int
        Number of equal strikers, which touch each other.
    gap : float
        Distance between the last striker and the chain [scaled, or m].

    Returns
    -------
    Chain
        Its first beads are the strikers; ``chain.strikers`` is their number.

    Raises
    ------
    InputError
        If a value is out of range, or the stiffness cannot be computed from the other
        arguments.

    Warns
    -----
    InputWarning
        If the chain has a given velocity of its first bead, which is omitted, or if a striker is
        so heavy that the unit of its mass or radius is probably wrong.

    Examples
    --------
    A striker with four times the mass of a bead:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(20).struck_by(mass=4.0, radius=1.0)
    >>> chain.masses[:3], chain.velocities[:3]
    (array([4., 1., 1.]), array([1., 0., 0.]))

    A ball that falls from 5 mm:

    >>> row = hc.Chain.from_materials(diameters="10 mm", materials="brass", beads=5)
    >>> row.struck_by(height="5 mm").velocities[0].round(4)
    np.float64(0.3132)

    A hammer of 300 g with an impact energy of 2 J:

    >>> hammer = row.struck_by(mass="300 g", radius="flat", energy="2 J")
    >>> hammer.velocities[0].round(3)
    np.float64(3.651)

    A 50 g piston with a flat steel face hits a chain of brass balls:

    >>> balls = hc.Chain.from_materials(5e-3, "brass", beads=20)
    >>> import math
    >>> piston = balls.struck_by(mass=0.05, radius=math.inf, material="steel-304")
    >>> round(float(piston.stiffness[0] / piston.stiffness[1]), 3)
    1.833
    """
    count = whole_number("count of strikers", count, least=1)
    checked_beads(self.beads + count)
    if diameter is not None:
        if radius is not None:
            raise InputError("a striker has a radius or a diameter, not both: omit one")
        radius = _half(diameter, self._unit("m"))
    plain = mass if isinstance(mass, Real) else 0.0
    own, radius, mass, drawn = _striker(self, radius, mass, material)
    heavy = _sphere_mass(self, drawn, own) if mass is None else mass
    speed = _speed(self, velocity, height, energy, heavy)
    distance = number("gap", gap, unit=self._unit("m"), least=0.0, most=MAX_GAP, hint=GAP_HINT)
    _warn_heavy(self, drawn, mass, plain=0.0 if math.isinf(radius) else plain)
    behind = _velocities_without_impact(self)
    new: dict[str, Any] = {
        "radii": np.concatenate((np.full(count, drawn), self.radii)),
        "velocities": np.concatenate((np.full(count, speed), behind)),
        "gaps": np.concatenate((np.zeros(count - 1), [distance], self.gaps)),
        "strikers": self.strikers + count,
    }
    if self.scatter is not None:
        new["scatter"] = self.scatter.behind(count, drawn, self.radii[self.strikers :])
    if own is not None and self.materials is not None:
        new["materials"] = (own,) * count + self.materials
    if stiffness is not None:
        unit = self._unit(unit_of_stiffness(_exponent(self)))
        stiffness = number("stiffness of the new contacts", stiffness, unit=unit, above=0.0)
    if "masses" in self.given:
        new["masses"] = np.concatenate((np.full(count, heavy), self.masses))
    if "stiffness" in self.given:
        new["stiffness"] = _listed_stiffness(self, stiffness, radius, own, count)
    earlier = self.striker_properties or (SPHERE,) * self.strikers
    properties = StrikerProperties(mass, math.isinf(radius), stiffness)
    new["striker_properties"] = (properties,) * count + earlier
    return self.replace(**new, **_like_the_first(self, count))


def _warn_heavy(chain: ChainFields, drawn: float, mass: float | None, *, plain: Any) -> None:
    """Warn about a mass that is probably in another unit; ``plain`` is that typed for a sphere."""
    # A sphere has the mass of its radius, which is then not given.
    with np.errstate(over="ignore"):
        times = (drawn / chain.radii.max()) ** 3 if mass is None else mass / chain.masses.max()
    if chain.units != "SI":
        return
    if times > HEAVY and times * chain.masses.max() >= HEAVY_KG:
        warn_user(
            f"the striker has {times:,.0f} times the mass of the heaviest bead; masses are in kg, "
            "and radii in m, so check the unit",
            InputWarning,
        )
    elif plain > HEAVY_KG and times > HEAVY_SPHERE:
        warn_user(
            f"the striker has {times:,.0f} times the mass of the heaviest bead, and a mass of "
            f"{plain:g} without a unit is in kg; if grams are meant, write mass='{plain:g} g', "
            f"otherwise mass='{plain:g} kg'",
            InputWarning,
        )


def _exponent(chain: ChainFields) -> float:
    """Exponent of the contacts of further strikers."""
    inner = chain.contact_exponents[1:-1].tolist()
    return usual_exponent(inner) if inner else float(chain.contact_exponents[0])


def _like_the_first(chain: ChainFields, count: int) -> dict[str, Any]:
    """Listed exponents and losses, which begin with those of strikers: those of the first."""
    listed: dict[str, Any] = {}
    # A pad behind the only bead is not one in front of it.
    if isinstance(chain.exponent, np.ndarray) or chain.exponent == LINEAR:
        inner = chain.contact_exponents[1:-1]
        listed["exponent"] = np.concatenate(([_exponent(chain)] * count, inner))
    if isinstance(chain.loss, tuple):
        listed["loss"] = (chain.loss[0],) * count + chain.loss
    return listed


def _velocities_without_impact(chain: ChainFields) -> Array:
    """Velocities of the beads; those of a chain of which only bead 1 moves are omitted."""
    if chain.strikers > 0 or "velocities" in chain.features:
        return chain.velocities
    if "velocities" in chain.given and chain.velocities[0] != 0.0:
        warn_user(
            "struck_by omits the velocity of bead 1, "
            f"{measure(float(chain.velocities[0]), 'm/s', chain.units)}, because strikers hit a "
            "chain at rest; give the velocity of the impact only to struck_by",
            InputWarning,
        )
    return np.zeros(chain.beads)


def _striker(
    chain: ChainFields, radius: float | None, mass: float | None, material: MaterialLike | None
) -> tuple[Material | None, float, float | None, float]:
    """Material, radius of the face, mass unless that of a sphere, and radius for figures."""
    own = None if chain.materials is None else chain.materials[chain.strikers]
    if material is not None:
        if own is None:
            raise InputError("material requires a chain with materials; use Chain.from_materials")
        own = material_named(material)
    if mass is not None:
        mass = number("mass of a striker", mass, unit=chain._unit("kg"), above=0.0)
    elif radius is None:
        radius = float(chain.radii[chain.strikers])
    sphere = 0.0 if mass is None else float(np.cbrt(mass / _sphere_mass(chain, 1.0, own)))
    if radius is None:
        return own, sphere, None, sphere
    unit = chain._unit("m")
    radius = _infinite_if_flat(radius)
    plain = plain_magnitude("radius of a striker", radius, unit)
    if isinstance(plain, float) and plain == math.inf:
        if mass is None:
            raise InputError("a flat striker (radius = 'flat') has no default mass; give mass")
        return own, math.inf, mass, sphere
    radius = number("radius of a striker", radius, unit=unit, above=0.0)
    return own, radius, mass, radius


def _infinite_if_flat(size: float | None) -> float | None:
    """Infinity instead of the text of a flat face."""
    return math.inf if isinstance(size, str) and size in FLAT_FACES else size


def _speed(
    chain: ChainFields, velocity: float | None, height: float | None, energy: float | None,
    mass: float,
) -> float:  # fmt: skip
    """Velocity of strikers, also from the height from which they fall, or from their energy."""
    given = {"velocity": velocity, "height": height, "energy": energy}
    names = [name for name, value in given.items() if value is not None]
    if len(names) > 1:
        one, other = (f"{name} to fall from" if name == "height" else name for name in names[:2])
        article = "an" if other == "energy" else "a"
        raise InputError(f"strikers have a {one} or {article} {other}, not both: omit one")
    if height is None and energy is None:
        return number("velocity of the strikers", 1.0 if velocity is None else velocity,
                      unit=chain._unit("m/s"), least=0.0, most=MAX_VELOCITY,
                      hint="positive velocities are towards the chain")  # fmt: skip
    if chain.scaled:
        raise InputError(
            f"{names[0]} requires a chain in SI units; give the velocity of the strikers"
        )
    if height is not None:
        return speed_of_fall("height of the strikers", height)
    return speed_of_energy("energy of the strikers", energy, mass)


def speed_of_fall(what: str, height: object) -> float:
    """Speed [m/s] after a fall from a height at rest."""
    fall = number(what, height, unit="m", least=0.0, most=MAX_FALL)
    return math.sqrt(2.0 * STANDARD_GRAVITY * fall)


def speed_of_energy(what: str, energy: object, mass: float) -> float:
    """Speed [m/s] of a body with this kinetic energy and mass [kg]."""
    most = 0.5 * mass * MAX_VELOCITY**2
    return math.sqrt(2.0 * number(what, energy, unit="J", least=0.0, most=most) / mass)


def _half(diameter: float, unit: str) -> float:
    """Radius of a striker; a flat face has an infinite one."""
    size = _infinite_if_flat(diameter)
    plain = plain_magnitude("diameter of a striker", size, unit)
    if isinstance(plain, float) and plain == math.inf:
        return math.inf
    return 0.5 * number("diameter of a striker", size, unit=unit, above=0.0)


def _sphere_mass(chain: ChainFields, radius: float, own: Material | None) -> float:
    """Mass of a sphere of a material, by default with the density of the first bead."""
    # An infinite mass is rejected afterwards.
    with np.errstate(over="ignore"):
        cube = np.float64(radius) ** 3
        if own is not None:
            return float(4.0 / 3.0 * math.pi * own.density * cube)
        first = chain.strikers
        return float(chain.masses[first] / chain.radii[first] ** 3 * cube)


def _listed_stiffness(
    chain: ChainFields, given: float | None, radius: float, own: Material | None, count: int
) -> Array:
    """Stiffness of all contacts, behind strikers, in a chain that lists it."""
    if given is not None:
        return np.concatenate(([given] * count, chain.stiffness))
    if own is None or chain.materials is None or _exponent(chain) != HERTZ_EXPONENT:
        raise InputError(UNKNOWN_STIFFNESS)
    bodies = [(radius, own)] * count + [(float(chain.face_radii[0]), chain.materials[0])]
    new = [
        face_stiffness(one, other, (kind, next_kind), HERTZ_EXPONENT, k)
        for k, ((one, kind), (other, next_kind)) in enumerate(itertools.pairwise(bodies), start=1)
    ]
    return np.concatenate((new, chain.stiffness))
