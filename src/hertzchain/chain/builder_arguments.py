"""Arguments of the builders of `hertzchain.Chain`: sizes and materials of all beads."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from ..collision import Array
from ..errors import InputError, InputWarning, warn_user
from ..validation.keywords import check_keywords
from ..validation.numbers import FRACTION, number, real_numbers
from ..validation.objects import check_list
from .fields import ChainFields
from .input_checks import checked_beads, checked_sizes
from .materials import Material, MaterialLike

# Fields that builders pass on to a chain, those of a taper, and those of a dimer of a mass ratio.
OTHER_FIELDS: Final = tuple(
    item.name for item in dataclasses.fields(ChainFields)
    if item.init
    and item.name not in ("radii", "units", "materials", "scatter", "striker_properties", "cap")
)  # fmt: skip
TAPER_FIELDS: Final = tuple(name for name in OTHER_FIELDS if not name.startswith("taper"))
DIMER_FIELDS: Final = tuple(
    name for name in OTHER_FIELDS if name not in ("masses", "stiffness", "taper")
)


def radii_of_beads(radii: Any, diameters: Any, beads: int | None, materials: int | None) -> Array:
    """Radii [m] from radii or diameters; the number of equal ones is that of the materials."""
    if diameters is None:
        given = checked_sizes("radius", radii)
    else:
        given = 0.5 * checked_sizes("diameter", diameters)
    if given.ndim > 0:
        if beads is not None and checked_beads(beads) != len(given):
            one, several = ("radius", "radii") if diameters is None else ("diameter", "diameters")
            there = f"is 1 {one}" if len(given) == 1 else f"are {len(given)} {several}"
            raise InputError(f"beads = {beads}, but there {there}: omit beads")
        return given
    count = materials if beads is None else beads
    if count is None:
        raise InputError(
            "one radius or diameter and one material for all beads need their number: give beads"
        )
    return np.full(checked_beads(count), given)


def two_sizes(
    mass_ratio: float | None, radii: ArrayLike | None, diameters: ArrayLike | None
) -> Array:
    """Radii of the two kinds of beads of a dimer."""
    sizes = {"mass_ratio": mass_ratio, "radii": radii, "diameters": diameters}
    if len(given := [name for name, value in sizes.items() if value is not None]) > 1:
        raise InputError(f"give only one of {' and '.join(given)} for a dimer")
    if not given:
        raise InputError(
            "Chain.dimer needs a mass ratio, two radii or two diameters, such as "
            "Chain.dimer(diameters=['10 mm', '6 mm'], materials='steel-52100', beads=40)"
        )
    if diameters is not None:
        found = 0.5 * checked_sizes("diameter", diameters)
    else:
        assert radii is not None
        found = checked_sizes("radius", radii)
    if found.shape not in ((), (2,)):
        raise InputError(
            f"a dimer has two sizes, or one number for both, got a list of {found.size}; "
            "Chain.periodic repeats any cell"
        )
    return np.resize(found, 2)


def repeated_sizes(cell: Any, diameters: Any, cells: int) -> Array:
    """Radii of the beads of a repeated cell, from the radii or diameters of its beads."""
    if (cell is None) == (diameters is None):
        raise InputError(
            "a cell needs either radii or diameters, such as Chain.periodic(diameters=['10 mm', "
            "'6 mm'], cells=20, materials='steel-52100')"
        )
    if diameters is None:
        one = real_numbers("radius", cell, "bead", unit="m")
    else:
        one = 0.5 * checked_sizes("diameter", diameters)
    checked_beads(cells * one.size)
    return np.tile(np.atleast_1d(one), cells)


def repeated_materials(
    materials: MaterialLike | Sequence[MaterialLike], size: int, beads: int
) -> MaterialLike | Sequence[MaterialLike]:
    """Materials of all beads, from those of a cell."""
    if isinstance(materials, str | Material):
        return materials
    kinds = check_list("materials of the cell", materials, "names")
    if len(kinds) != size:
        raise InputError(
            f"the cell has {size} beads, but {len(kinds)} materials; give one for each bead"
        )
    return (kinds * beads)[:beads]


def materials_in_turn(
    materials: Material | Sequence[Material], beads: int | None
) -> Material | Sequence[Material]:
    """Materials of all beads, which repeat in turn if there are fewer."""
    if beads is None or isinstance(materials, Material):
        return materials
    if not 0 < len(materials) < checked_beads(beads):
        return materials
    found = [materials[i % len(materials)] for i in range(beads)]
    if 2 * len(materials) > beads:
        warn_user(
            f"there are {len(materials)} materials for {beads} beads, which repeat in turn: bead "
            f"{beads} is of {found[-1].name}; give one for each bead if this is not meant",
            InputWarning,
        )
    return found


def velocities(beads: int, velocity: float | str, fields: Mapping[str, Any]) -> Array:
    """Velocities of all beads, of which only the first one moves."""
    if fields.get("velocities") is not None:
        raise InputError("give only one of velocity (of bead 1) and velocities (of all)")
    found = np.zeros(beads)
    found[:1] = number("velocity", velocity, unit="m/s")
    return found


def dimer_masses(mass_ratio: float, beads: int, materials: Any, fields: Mapping[str, Any]) -> Array:
    """Scaled masses of a dimer of a mass ratio, which has no materials."""
    ratio = number("mass ratio of a dimer", mass_ratio, unit=FRACTION, above=0.0)
    if materials is not None:
        raise InputError(
            "a dimer of a mass ratio is a scaled chain without materials: omit them, or give two "
            "radii or diameters instead of the mass ratio"
        )
    check_keywords("Chain.dimer of a mass ratio", fields, DIMER_FIELDS)
    return np.where(np.arange(beads) % 2, ratio, 1.0)
