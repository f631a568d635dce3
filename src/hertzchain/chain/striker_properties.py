"""Properties of strikers and caps that do not follow from their radii and materials."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np

from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError
from ..validation.keywords import checked_fields
from ..validation.numbers import number
from ..validation.objects import check_bool, check_list, check_type
from .boundary_checks import check_units
from .cap import Cap
from .materials import Materials, contact_modulus, sphere_stiffness
from .parts import Part
from .scales import scale


@checked_fields
@dataclass(frozen=True, eq=False)
class StrikerProperties(Part):
    """Mass, face and contact of a striker, if they are not those of a sphere of its material.

    `Chain.struck_by` creates them.

    Attributes
    ----------
    mass : float or None
        Mass [scaled, or kg]; that of a sphere of the striker's radius if `None`.
    flat : bool
        Whether its face is flat.  Its radius then has no effect on its contacts.
    stiffness : float or None
        Stiffness of its contact with the next bead [scaled, or N/m^p]; that of Hertz's law if
        `None`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Chain.uniform(20).struck_by(mass=4.0, radius=1.0).striker_properties
    (StrikerProperties(mass=4.0, flat=False, stiffness=None),)
    """

    mass: float | None = field(default=None, metadata=scale("mass"))
    flat: bool = False
    stiffness: float | None = field(default=None, metadata=scale("stiffness"))

    def __post_init__(self) -> None:
        super().__post_init__()
        check_bool("flat", self.flat)
        for name, unit in (("mass", "kg"), ("stiffness", "N/m**1.5")):
            if (value := getattr(self, name)) is not None:
                checked = number(f"{name} of a striker", value, unit=unit, above=0.0)
                object.__setattr__(self, name, checked)


UNKNOWN_STIFFNESS: Final = (
    "the stiffness of the contacts of strikers or of a cap cannot be computed from radii and "
    "materials for this chain; give stiffness"
)
SPHERE: Final = StrikerProperties()
Given = tuple[StrikerProperties, ...]
Bodies = Mapping[int, StrikerProperties | Cap]


def checked_properties(given: Iterable[StrikerProperties], strikers: int, *, scaled: bool,
                       exponent: float, all_given: Iterable[str]) -> Given:  # fmt: skip
    """Properties of all strikers, without those that are given for all beads; () for spheres."""
    found = tuple(check_list("striker_properties", given, "StrikerProperties"))
    for each in found:
        check_type("an item of striker_properties", each, StrikerProperties)
        if each.with_units:
            check_units("a striker", each, scaled=scaled, exponent=exponent)
    if found and len(found) != strikers:
        raise InputError(
            f"striker_properties has one item for each striker, got {len(found)} for {strikers} "
            f"striker{'s' * (strikers != 1)}; give both, or use struck_by"
        )
    found = tuple(
        StrikerProperties(
            None if "masses" in all_given else each.mass, each.flat,
            None if "stiffness" in all_given else each.stiffness,
        )
        for each in found
    )  # fmt: skip
    return () if all(each == SPHERE for each in found) else found


def bodies_with(strikers: Given, cap: Cap | None, beads: int) -> Bodies:
    """Properties of strikers and cap, by the indices of their beads."""
    found: dict[int, StrikerProperties | Cap] = dict(enumerate(strikers))
    return found if cap is None else found | {beads - 1: cap}


def masses_with(bodies: Bodies, masses: Array) -> Array:
    """Masses of spheres with the given ones of strikers and cap."""
    found = masses.copy()
    for k, each in bodies.items():
        if each.mass is not None:
            found[k] = each.mass
    return found


def stiffness_with(
    bodies: Bodies, stiffness: Array, radii: Array, materials: Materials, exponents: Array,
    *, scaled: bool,
) -> Array:  # fmt: skip
    """Stiffness of contacts of spheres with that of contacts which bodies give or make flat."""
    found, faces = stiffness.copy(), face_radii(bodies, radii)
    for bead, each in bodies.items():
        k = _contact_of(bead, len(found))
        if each.stiffness is not None:
            found[k] = each.stiffness
        elif np.isinf(faces[k : k + 2]).any():
            kinds = None if scaled or materials is None else materials[k : k + 2]
            p = float(exponents[k] if len(exponents) > 1 else exponents[0])
            found[k] = face_stiffness(float(faces[k]), float(faces[k + 1]), kinds, p, k + 1)
    return found


def without_given(bodies: Bodies, exponents: Array, contacts: int) -> Array:
    """Exponents of the contacts whose stiffness no body gives."""
    given = {_contact_of(bead, contacts) for bead, each in bodies.items()
             if each.stiffness is not None}  # fmt: skip
    listed = exponents if len(exponents) == contacts else np.repeat(exponents, contacts or 1)
    return np.delete(listed, [*given])


def _contact_of(bead: int, contacts: int) -> int:
    """Index of the contact of a striker with the next bead, or of a cap with the last ball."""
    return min(bead, contacts - 1)


def face_stiffness(
    one: float, other: float, materials: Materials, exponent: float, contact: int
) -> float:
    """Hertz stiffness of the contact of two faces, one of which is flat; scaled without materials.

    The stiffness of scaled contacts is for beads and strikers of one material.
    """
    if math.isinf(min(one, other)):
        raise InputError(
            f"the flat faces of beads {contact} and {contact + 1} touch, so that the stiffness of "
            f"contact {contact} cannot be computed from radii and materials; give stiffness, or a "
            "radius instead of one flat face"
        )
    if exponent != HERTZ_EXPONENT:
        raise InputError(UNKNOWN_STIFFNESS)
    if materials is None:
        return math.sqrt(2.0 * min(one, other))
    return float(sphere_stiffness(one, other, contact_modulus(*materials)))


def face_radii(bodies: Bodies, radii: Array) -> Array:
    """Radii of curvature at the contacts of the beads: infinite for flat bodies."""
    found = radii.copy()
    found[[k for k, each in bodies.items() if each.flat]] = math.inf
    return found


def following(
    bodies: Bodies, field: Literal["masses", "stiffness"], count: int, *, all_given: bool
) -> Array:
    """Whether the masses of beads, or the stiffness of contacts, follow from radii."""
    name = "mass" if field == "masses" else "stiffness"
    found = np.full(count, not all_given)
    found[
        [_contact_of(k, count) for k, each in bodies.items() if getattr(each, name) is not None]
    ] = False
    return found
