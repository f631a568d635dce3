"""The cap of a load cell: a flat last body whose mass is given."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ..collision import Array
from ..errors import InputError
from ..validation.keywords import checked_fields
from ..validation.numbers import number
from ..validation.objects import check_type
from .boundary_checks import check_units
from .description import mass_in_words
from .mass_and_stiffness import sphere_masses
from .materials import Materials
from .parts import Part
from .scales import scale


@checked_fields
@dataclass(frozen=True, eq=False)
class Cap(Part):
    """Mass and contact of a flat last body, such as the cap of a load cell.

    `Chain.with_cap` creates it.  Its material is the last one in ``Chain.materials``.  Its entry in
    ``Chain.radii`` is the radius of a sphere of its mass, which has no effect.

    Attributes
    ----------
    mass : float or None
        Mass [scaled, or kg].  In a chain of given masses it is the last of them, and can be
        omitted.
    stiffness : float or None
        Stiffness of its contact with the last ball [scaled, or N/m^p]; that of Hertz's law for a
        sphere on a flat face if `None`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.Chain.uniform(20).with_cap(4.0).cap
    Cap(mass = 4)
    >>> hc.Chain.from_materials("5 mm", "brass", beads=9).with_cap("5 g").cap
    Cap(mass = 5 g)
    """

    mass: float | None = field(default=None, metadata=scale("mass"))
    stiffness: float | None = field(default=None, metadata=scale("stiffness"))

    flat: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, unit in (("mass", "kg"), ("stiffness", "N/m**1.5")):
            if (value := getattr(self, name)) is not None:
                checked = number(f"{name} of a cap", value, unit=unit, above=0.0)
                object.__setattr__(self, name, checked)

    def __repr__(self) -> str:
        real = "mass" in self.with_units
        parts = []
        if self.mass is not None:
            parts.append(f"mass = {mass_in_words(self.mass) if real else f'{self.mass:.4g}'}")
        if self.stiffness is not None:
            unit = " N/m^p" if real or "stiffness" in self.with_units else ""
            parts.append(f"stiffness = {self.stiffness:.4g}{unit}")
        return f"Cap({', '.join(parts)})"


def cap_of_chain(cap: Cap, mass: float, *, scaled: bool) -> Cap:
    """The cap with its mass, which is in SI units unless the chain is scaled."""
    found = Cap(mass, cap.stiffness)
    if not scaled:
        object.__setattr__(found, "with_units", frozenset({"mass"}))
    return found


def checked_cap(
    cap: Cap | None, balls: int, *, scaled: bool, exponent: float, all_given: Iterable[str]
) -> Cap | None:
    """The cap behind a number of balls, without a stiffness that is given for all contacts."""
    if cap is None:
        return None
    check_type("cap", cap, Cap, "use Chain.with_cap")
    if balls < 1:
        raise InputError("a cap requires a ball in front of it, but the chain has no other beads")
    if cap.with_units:
        check_units("a cap", cap, scaled=scaled, exponent=exponent)
    if cap.mass is None and "masses" not in all_given:
        raise InputError("a cap has no default mass; give mass")
    return Cap(cap.mass, None if "stiffness" in all_given else cap.stiffness)


def with_radius_of_cap(radii: Array, masses: Array, materials: Materials, *, scaled: bool) -> Array:
    """Radii with that of a sphere of the cap's mass, for figures; by default as dense as a ball."""
    if scaled or materials is None:
        unit = masses[-2] / radii[-2] ** 3
    else:
        (unit,) = sphere_masses(np.ones(1), materials[-1:], scaled=False)
    return np.append(radii[:-1], np.cbrt(masses[-1] / unit))
