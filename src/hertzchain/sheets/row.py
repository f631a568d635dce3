"""The row of a laboratory sheet in words for students: balls, striker, load cell and sensors."""

from __future__ import annotations

import numpy as np

from ..chain.bead_names import LAST, bead_number, is_load_cell
from ..chain.chain import Chain
from ..chain.description import (
    diameter_in_words,
    length_in_words,
    mass_in_words,
    sizes_in_words,
    stiffness_in_words,
)
from ..chain.walls import Wall
from ..collision import Array
from ..representation import listed
from ..traces.coupling import static_force
from ..traces.places import Place
from .kinds import is_column
from .losses import losses_in_words
from .sheet import WALL, LabSheet


def row_in_words(sheet: LabSheet) -> str:
    """The balls, the striker, the end of the row and the sensors."""
    chain = sheet.chain
    parts = [_balls(chain), _striker(chain), _end(chain), *_conditions(sheet), _sensors(sheet)]
    return " ".join(part for part in parts if part)


def place_in_words(chain: Chain, place: str) -> str:
    """The place of a sensor: ``ball 5``, ``the cap``, ``the wall`` and so on."""
    if place == WALL:
        return "the load cell" if is_load_cell(chain) else "the wall"
    if chain.cap is not None and bead_number(chain, place) == chain.beads:
        return "the cap"
    return "the last ball" if place == LAST else place


def names(sheet: LabSheet) -> list[str]:
    """Names of the sensors in tables, such as ``ball 5`` and ``load cell``."""
    return [place_in_words(sheet.chain, each).removeprefix("the ") for each in sheet.places]


def at_place(chain: Chain, place: str) -> str:
    """``in ball 5``, or ``on the load cell``."""
    return f"{'on' if place == WALL else 'in'} {place_in_words(chain, place)}"


def _kind(chain: Chain) -> str:
    return "column" if is_column(chain) else "row"


def _balls(chain: Chain) -> str:
    """Number, diameter, material and mass of the balls of the row."""
    balls = chain._balls
    radii, masses = chain.radii[balls], chain.masses[balls]
    count = f"The {_kind(chain)} has {len(radii)} ball{'s' * (len(radii) > 1)}"
    if "masses" in chain.given:
        size = f" with {_masses(masses)}"
    elif np.ptp(radii) == 0.0:
        size = f" with a diameter of {diameter_in_words(radii[0])} and {_masses(masses)}"
    else:
        size = f" ({sizes_in_words(radii)}) with {_masses(masses)}"
    return f"{count}{_of_materials(chain, balls)}{size}."


def _masses(masses: Array) -> str:
    least, most = mass_in_words(float(masses.min())), mass_in_words(float(masses.max()))
    return f"a mass of {least}" if least == most else f"masses between {least} and {most}"


def _of_materials(chain: Chain, part: slice) -> str:
    names = list(dict.fromkeys(each.name for each in (chain.materials or ())[part]))
    return f" of {listed(names)}" if names else ""


def _striker(chain: Chain) -> str:
    """The body or bodies that hit the row."""
    count = chain.strikers
    if not count:
        return "Its first ball is the striker."
    own, first = slice(0, count), count
    masses, radii = chain.masses[own], chain.radii[own]
    alike = (
        np.ptp(chain.masses[: first + 1]) == 0.0
        and np.isfinite(chain.face_radii[own]).all()
        and np.ptp(chain.radii[: first + 1]) == 0.0
        and _of_materials(chain, own) == _of_materials(chain, slice(first, first + 1))
    )
    if alike:
        return ("The striker is another ball of this kind." if count == 1
                else f"The strikers are {count} more balls of this kind.")  # fmt: skip
    flat = not np.isfinite(chain.face_radii[own]).all()
    kind = _of_materials(chain, own)
    if count > 1:
        return f"There are {count} strikers{kind} with {_masses(masses)}."
    if flat:
        return f"The striker is a body{kind} with a flat face and {_masses(masses)}."
    diameter = f"a diameter of {diameter_in_words(float(radii[0]))} and "
    shape = "" if "masses" in chain.given or not chain.strikers_are_spheres else diameter
    return f"The striker is a ball{kind} with {shape}{_masses(masses)}."


def _end(chain: Chain) -> str:
    """The load cell, wall or free end behind the row, and its cap."""
    wall, cap = chain.right_wall, ""
    behind = "Below the column" if is_column(chain) else "Behind the row"
    if chain.cap is not None:
        cap = mass_in_words(float(chain.masses[-1]))
    if wall is None:
        return f"The last body is a cap of {cap}." if cap else "The far end of the row is free."
    if is_load_cell(chain):
        facts = [f"a stiffness of {_stiffness(wall, chain)}"] if wall.stiffness is not None else []
        facts += [f"a cap of {cap}"] * bool(cap)
        return f"{behind} is a load cell{f' with {listed(facts)}' if facts else ''}."
    front = f", with a cap of {cap} in front" if cap else ""
    return f"{behind} is {_wall(wall, chain)}{front}."


def _wall(wall: Wall, chain: Chain) -> str:
    if wall.stiffness is not None:
        return f"a wall with a contact stiffness of {_stiffness(wall, chain)}"
    if wall.material is not None:
        return f"a wall of {wall.material.name}"
    last = _of_materials(chain, slice(chain.beads - 1, chain.beads))
    return f"a wall{last}"


def _stiffness(wall: Wall, chain: Chain) -> str:
    """The stiffness with its unit: sheets have SI chains, however the number was given."""
    return stiffness_in_words(float(wall.stiffness or 0.0), float(chain.contact_exponents[-1]))


def _conditions(sheet: LabSheet) -> list[str]:
    """Gaps, static forces, losses and pads that the predictions include."""
    chain = sheet.chain
    inner = chain.contact_exponents[1:-1]
    found = [
        (chain.left_wall is not None, "a wall at the struck end"),
        (bool(chain.gaps.any()), f"gaps of up to {length_in_words(float(chain.gaps.max()))}"
         if len(chain.gaps) else ""),
        (bool((inner == 1.0).any()), "pads"),
        (bool(chain.gravity or chain.precompression > 0.0), "static forces in the contacts"),
        (not chain.lossless, f"losses in the contacts ({losses_in_words(chain)})"),
    ]  # fmt: skip
    words = [text.replace(" um", " µm") for present, text in found if present]
    whose = "The teacher's" if sheet.blank else "The"
    included = [f"{whose} predictions include {listed(words)}."] if words else []
    return [*included, *_static_forces(sheet)]


def _static_forces(sheet: LabSheet) -> list[str]:
    """The static force in each sensor, which AC-coupled sensors do not measure."""
    chain = sheet.chain
    places = [
        Place(each, "right", 0, "force") if each == WALL
        else Place(each, "bead", bead_number(chain, each), "force")
        for each in sheet.places
    ]  # fmt: skip
    forces = [static_force(each, chain) for each in places]
    if not any(forces):
        return []
    found = [f"{force:.3g} N {at_place(chain, place)}"
             for force, place in zip(forces, sheet.places, strict=True)]  # fmt: skip
    return [
        f"The static force is {listed(found)}. A sensor with AC coupling, such as a piezoelectric "
        "one, does not measure it: subtract it from the predicted force."
    ]


def _sensors(sheet: LabSheet) -> str:
    """The places at which forces are measured."""
    chain = sheet.chain
    inside = [place_in_words(chain, place) for place in sheet.places if place != WALL]
    sensors = ""
    if inside:
        verb = "Force sensors are" if len(inside) > 1 else "A force sensor is"
        sensors = f"{verb} in {listed(inside)}"
    if WALL not in sheet.places:
        return f"{sensors}."
    wall = "the force on the wall is measured"
    if is_load_cell(chain):
        wall = f"the load cell measures the force at the end of the {_kind(chain)}"
    return f"{sensors}, and {wall}." if sensors else f"{wall[0].upper()}{wall[1:]}."
