r"""Contacts of bodies other than spheres: exponent and stiffness from geometry and material.

A shape gives :math:`F = k\,d^{\,p}` of two bodies with the effective modulus :math:`E^*`;
`Chain.with_contacts` puts shapes at contacts of a chain of materials.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Final, TypeAlias, TypeVar

import numpy as np

from ..errors import InputError, short_repr
from ..validation.keywords import checked_arguments, checked_fields, checked_methods
from ..validation.numbers import contact_number, has_unit, number
from .description import stiffness_in_words
from .fields import ChainFields
from .input_checks import warn_soft
from .materials import contact_modulus
from .walls import material_of_wall

C = TypeVar("C", bound=ChainFields)

# Relative difference of curvatures below which an ellipse of contact is a circle: the stiffness
# differs by its square.
ROUND: Final = 1e-7
# Smallest angle at which cylinders cross [degrees]: parallel ones touch along a line.
MIN_ANGLE: Final = 1.0


@checked_methods
@checked_fields
@dataclass(frozen=True)
class CrossedCylinders:
    r"""Two cylinders whose axes cross at an angle: a Hertz contact on an ellipse, p = 3/2.

    With the principal relative curvatures A and B, axes a and b of the ellipse, :math:`q = b/a`,
    and complete elliptic integrals of the parameter :math:`1 - q^2`,

    .. math::

        A + B = \tfrac12\left(\tfrac1{R_1} + \tfrac1{R_2}\right), \quad
        (B - A)^2 = \tfrac14\left(\tfrac1{R_1^2} + \tfrac1{R_2^2}
            + \tfrac{2\cos 2\omega}{R_1 R_2}\right), \quad
        \frac BA = \frac{E/q^2 - K}{K - E}, \\
        k = \tfrac43 E^* \sqrt{R_e}\,F_2^{-3/2}, \quad R_e = \frac1{2\sqrt{AB}}, \quad
        F_2 = \frac{2 K \sqrt q}{\pi F_1}, \quad
        F_1^3 = \frac{4 q^{3/2}}{\pi (1 - q^2)} \sqrt{(E/q^2 - K)(K - E)} .

    K. L. Johnson, *Contact Mechanics*, Cambridge 1985, Secs. 4.1 and 4.2,
    doi:10.1017/CBO9781139171731.  Equal cylinders that cross at right angles are like a sphere of
    their radius on a plane.

    Attributes
    ----------
    radius : float or None
        Radius of one cylinder [m]; that of the bead if `None`.
    other_radius : float or None
        Radius of the other [m]; that of the other bead or, if ``radius`` is given, the same.
    angle : float
        Angle between the axes, 1 to 90 [degrees].

    Examples
    --------
    Cylinders of 5 mm radius, at right angles and at 30 degrees:

    >>> import hertzchain as hc
    >>> crossed = hc.CrossedCylinders(5e-3), hc.CrossedCylinders(5e-3, angle=30.0)
    >>> [round(each.stiffness(100e9) / 1e9, 3) for each in crossed]
    [9.428, 15.231]
    """

    radius: float | None = None
    other_radius: float | None = None
    angle: float = 90.0

    exponent: ClassVar[float] = 1.5

    def __post_init__(self) -> None:
        for name in ("radius", "other_radius"):
            value = getattr(self, name)
            if value is not None:
                checked = number(f"{name} of crossed cylinders", value, unit="m", above=0.0)
                object.__setattr__(self, name, checked)
        if self.radius is None and self.other_radius is not None:
            raise InputError("crossed cylinders with an other_radius need a radius: give both")
        angle = number("angle of crossed cylinders", self.angle, least=MIN_ANGLE, most=90.0,
                       hint="in degrees; parallel cylinders touch along a line")  # fmt: skip
        object.__setattr__(self, "angle", angle)

    def stiffness(self, modulus: float) -> float:
        """Stiffness k of F = k d^(3/2) [N/m^1.5].

        Parameters
        ----------
        modulus : float
            Effective modulus, of `hertzchain.chain.materials.contact_modulus` [Pa].

        Raises
        ------
        InputError
            If no radius is known, or a number is out of its range.

        Examples
        --------
        >>> import hertzchain as hc
        >>> round(hc.CrossedCylinders(5e-3).stiffness(100e9) / 1e9, 3)
        9.428
        """
        modulus = number("effective modulus", modulus, unit="Pa", above=0.0)
        if self.radius is None:
            raise InputError(
                "crossed cylinders need a radius where they are not at a contact of two beads, "
                "which have radii: give CrossedCylinders(radius)"
            )
        other = self.radius if self.other_radius is None else self.other_radius
        radius, softer = _ellipse(self.radius, other, math.radians(self.angle))
        return 4.0 / 3.0 * modulus * math.sqrt(radius) / softer**1.5

    def _between(self, radius: float, other_radius: float) -> CrossedCylinders:
        """Insert the radii of two beads if there are none."""
        if self.radius is not None:
            return self
        if math.isinf(max(radius, other_radius)):
            raise InputError("a flat striker or cap is not a cylinder with a radius: give "
                             "CrossedCylinders(radius), or other contacts only")  # fmt: skip
        return dataclasses.replace(self, radius=radius, other_radius=other_radius)


@checked_methods
@checked_fields
@dataclass(frozen=True)
class Cone:
    r"""The tip of a cone on a plane, p = 2.

    .. math:: k = \frac2\pi E^* \tan\theta

    I. N. Sneddon, Int. J. Eng. Sci. 3, 47 (1965), doi:10.1016/0020-7225(65)90019-4, for blunt
    cones: the side makes the angle :math:`90° - \theta` with the plane, which is taken as small.

    Attributes
    ----------
    half_angle : float
        Angle :math:`\theta` between axis and side, above 0 and below 90 [degrees].

    Examples
    --------
    >>> import hertzchain as hc
    >>> round(hc.Cone(70.3).stiffness(100e9) / 1e9, 2)
    177.8
    """

    half_angle: float

    exponent: ClassVar[float] = 2.0

    def __post_init__(self) -> None:
        angle = number("half angle of a cone", self.half_angle, above=0.0, below=90.0,
                       hint="in degrees, between axis and side")  # fmt: skip
        object.__setattr__(self, "half_angle", angle)

    def stiffness(self, modulus: float) -> float:
        """Stiffness k of F = k d^2 [N/m^2].

        Parameters
        ----------
        modulus : float
            Effective modulus, of `hertzchain.chain.materials.contact_modulus` [Pa].

        Raises
        ------
        InputError
            If the modulus is not positive.

        Examples
        --------
        >>> import hertzchain as hc
        >>> round(hc.Cone(45.0).stiffness(100e9) / 1e9, 2)
        63.66
        """
        modulus = number("effective modulus", modulus, unit="Pa", above=0.0)
        return 2.0 / math.pi * modulus * math.tan(math.radians(self.half_angle))

    def _between(self, radius: float, other_radius: float) -> Cone:  # noqa: ARG002
        return self


@checked_methods
@checked_fields
@dataclass(frozen=True)
class Pad:
    r"""An elastic pad between two beads, a linear spring :math:`F = k\,d`, p = 1.

    Attributes
    ----------
    stiffness : float
        Stiffness k > 0 [N/m].

    Examples
    --------
    The other contacts remain those of spheres:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.from_materials(5e-3, "steel-316", beads=4)
    >>> hc.Pad("1 kN/mm")
    Pad(stiffness = 1 kN/mm)
    >>> chain.with_contacts({2: hc.Pad("1 kN/mm")}).exponent
    array([1.5, 1. , 1.5])
    """

    stiffness: float

    exponent: ClassVar[float] = 1.0

    def __post_init__(self) -> None:
        value = number("stiffness of a pad", self.stiffness, unit="N/m", above=0.0)
        if not has_unit(self.stiffness):
            warn_soft("the stiffness of the pad", value, self.exponent)
        object.__setattr__(self, "stiffness", value)

    def __repr__(self) -> str:
        return f"Pad(stiffness = {stiffness_in_words(self.stiffness, self.exponent)})"

    def _between(self, radius: float, other_radius: float) -> Pad:  # noqa: ARG002
        return self


Shape: TypeAlias = CrossedCylinders | Cone | Pad


def _stiffness(shape: Shape, modulus: float) -> float:
    """Stiffness of a shape; that of a pad does not depend on the materials of the beads."""
    return shape.stiffness if isinstance(shape, Pad) else shape.stiffness(modulus)


def _ellipse(one: float, other: float, angle: float) -> tuple[float, float]:
    """Effective radius, and the factor by which an ellipse of contact lets bodies approach."""
    from scipy.optimize import brentq
    from scipy.special import ellipe, ellipkm1

    total = 0.5 * (1.0 / one + 1.0 / other)
    squared = one**-2.0 + other**-2.0 + 2.0 * math.cos(2.0 * angle) / (one * other)
    apart = 0.5 * math.sqrt(max(squared, 0.0))
    small, large = 0.5 * (total - apart), 0.5 * (total + apart)
    radius = 0.5 / math.sqrt(small * large)
    if apart < ROUND * total:
        return radius, 1.0

    def differences(q: float) -> tuple[float, float, float]:
        k, e = float(ellipkm1(q * q)), float(ellipe(1.0 - q * q))
        return k, e / (q * q) - k, k - e

    def excess(q: float) -> float:
        _, over, under = differences(q)
        return math.log(over / under) - math.log(large / small)

    q = brentq(excess, 1e-8, 1.0 - 1e-9, xtol=1e-15, rtol=1e-14)
    k, over, under = differences(q)
    first = (4.0 * q**1.5 / (math.pi * (1.0 - q * q)) * math.sqrt(over * under)) ** (1.0 / 3.0)
    return radius, 2.0 * k * math.sqrt(q) / (math.pi * first)


@checked_arguments("with_contacts")
def with_contacts(self: C, shapes: Shape | Mapping[int, Shape]) -> C:
    """The same chain with contacts of bodies other than spheres, or with pads.

    Exponents and stiffness follow from the shapes and the materials of both bodies; masses, radii
    and the other contacts are unchanged.

    Parameters
    ----------
    shapes : CrossedCylinders, Cone, Pad or mapping from int to them
        Shape of all contacts of two beads; or of contacts by their number, 1 to N - 1, and 0 or N
        of a wall.

    Raises
    ------
    InputError
        If the chain has no materials, or there is no such contact.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.from_materials(5e-3, "steel-316", beads=4)
    >>> chain.with_contacts(hc.CrossedCylinders()).stiffness / chain.stiffness
    array([1.41421356, 1.41421356, 1.41421356])
    >>> chain.with_contacts({2: hc.Cone(80.0)}).exponent
    array([1.5, 2. , 1.5])
    """
    if self.units != "SI" or self.materials is None:
        raise InputError(
            "the stiffness of shapes follows from materials: make the chain by "
            "Chain.from_materials, or give stiffness and exponent"
        )
    last = self.beads
    given = shapes if isinstance(shapes, Mapping) else dict.fromkeys(range(1, last), shapes)
    stiffness, exponents = self.stiffness.copy(), self.contact_exponents[1:-1].copy()
    walls = {0: ("left_wall", 0), last: ("right_wall", -1)}
    changes: dict[str, Any] = {}
    for contact, shape in given.items():
        c = contact_number(contact, last, "number of a contact")
        if not isinstance(shape, Shape):
            raise InputError(
                f"the shape of contact {c} must be a CrossedCylinders, Cone or Pad, got "
                f"{short_repr(shape)}"
            )
        if c not in walls:
            modulus = contact_modulus(*self.materials[c - 1 : c + 1])
            own = shape._between(*self.face_radii[c - 1 : c + 1].tolist())
            stiffness[c - 1], exponents[c - 1] = _stiffness(own, modulus), shape.exponent
            continue
        name, bead = walls[c]
        wall = getattr(self, name)
        if wall is None:
            raise InputError(f"contact {c} has no shape: the chain has no {name}")
        solid = self.materials[bead]
        modulus = contact_modulus(solid, material_of_wall(wall, solid))
        changes[name] = dataclasses.replace(
            wall, stiffness=_stiffness(shape, modulus), exponent=shape.exponent
        )
    if np.any(self.stiffness != stiffness) or np.any(self.contact_exponents[1:-1] != exponents):
        changes |= {"stiffness": stiffness, "exponent": exponents}
    return self.replace(**changes)
