"""Titles of figures: the beads of a chain in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..chain.chain import Chain
from ..chain.chain_words import described_strikers
from ..chain.description import (
    OddBead,
    beads_of,
    diameter_in_words,
    law_in_words,
    length_in_words,
    mass_in_words,
    odd_bead,
    shape_in_words,
    sizes_in_words,
    stiffness_in_words,
)
from ..chain.laws.restitution import Restitution
from ..chain.materials import Material
from ..chain.walls import Wall
from ..chain.yield_pressure import YIELD_ASSUMED, YIELD_STATED, assumes_pressure
from ..representation import measure
from .style import literal


def chain_words(chain: Chain, *, strikers: bool = True) -> str:
    """Such as ``20 steel balls, 9 mm to 5 mm, linear taper``; strikers are named, not counted.

    ``strikers`` is whether those of a chain in SI units are named.
    """
    return ", ".join(title_parts(chain, strikers=strikers))


def title_parts(chain: Chain, *, strikers: bool = True) -> list[str]:
    """The parts of these words, which may have commas; the beads of a scaled chain are one part."""
    if chain.units == "SI":
        odd = _odd_bead(chain, "ball")
        materials = list(_materials(_of_balls(chain)).values()) or ["SI"]
        if odd is not None:
            materials = [odd.usual_material or "SI"]
        balls = beads_of(len(chain.radii[chain._balls]), "balls", materials)
        beads = _with_strikers(balls, chain, odd, named=strikers)
    else:
        beads = [_scaled_beads(chain)]
    law = law_in_words(chain.exponents)
    gravity = "under gravity" if chain.gravity else ""
    wall = wall_in_words(chain, chain.right_wall)
    parts = *beads, law, gravity, cap_in_title(chain), wall, loss_in_title(chain)
    return [part for part in parts if part]


def chain_title(chain: Chain) -> str:
    """The same with the precompression, and Y in words, escaped for Matplotlib."""
    words = chain_words(chain).replace(YIELD_ASSUMED, YIELD_STATED)
    return literal(", ".join(filter(None, (words, load_in_title(chain)))))


def load_in_title(chain: Chain) -> str:
    """Such as ``under 20 N`` of a precompressed chain; empty without precompression."""
    if not chain.precompression:
        return ""
    return f"under {measure(chain.precompression, 'N', chain.units)}"


def _odd_bead(chain: Chain, noun: str) -> OddBead | None:
    """The bead that differs from all others, if there is one, with short names of materials."""
    kinds, names = _of_balls(chain), _materials(_of_balls(chain))
    return odd_bead(
        (chain.scatter or chain).radii[chain._balls],
        [names[each.name] for each in kinds],
        chain.masses[chain._balls] if "masses" in chain.given else None,
        noun=noun,
        scaled=chain.scaled,
    )


def _scaled_beads(chain: Chain) -> str:
    """Such as ``20 equal beads``, or ``given masses, 20 beads and 1 striker (mass 5)``."""
    first, number = chain.strikers, len(chain.radii[chain._balls])
    count = beads_of(number, "beads")
    kind, *_ = chain.description.partition(count)
    beads = f"{kind}{count}"
    if kind == "uniform, " and number > 1:
        equal = np.ptp(chain.masses[chain._balls]) == 0.0
        beads = f"{number} equal beads" if equal else f"given masses, {count}"
    elif (odd := _odd_bead(chain, "ball" if first else "bead")) and kind.startswith("uniform"):
        scatter = chain.scatter.words(chain.radii, chain._balls) if chain.scatter else ""
        beads = f"{', '.join(filter(None, (f'{count}, equal{odd.scaled_words}', scatter)))},"
    if not first:
        return beads.removesuffix(",")
    return f"{beads} and {described_strikers(chain)}"


def _with_strikers(beads: str, chain: Chain, odd: OddBead | None, *, named: bool) -> list[str]:
    """The beads, their sizes, and strikers with their size if it is another one."""
    first, radii = chain.strikers, (chain.scatter or chain).radii
    balls = [sizes_in_words(radii[chain._balls])]
    if odd is not None:
        balls = [diameter_in_words(odd.usual_radius), odd.words]
    scatter = chain.scatter.words(chain.radii, chain._balls) if chain.scatter else ""
    balls += filter(None, (shape_in_words(radii[chain._balls]), scatter))
    if not (first and named):
        return [beads, *balls]
    strikers = "a striker" if first == 1 else f"{first} strikers"
    if not chain.strikers_are_spheres:
        # The radius of a striker of a given mass need not be its size.
        if first == 1:
            strikers = f"striker of {mass_in_words(float(chain.masses[0]))}"
        return [f"{beads} of {balls[0]}", *balls[1:], strikers]
    own = [sizes_in_words(radii[:first])]
    if own == balls:
        return [f"{beads} and {strikers}", *balls]
    return [beads, *balls, f"and {strikers}", *own]


def _of_balls(chain: Chain) -> tuple[Material, ...]:
    """Materials of the balls, without those of strikers and a cap."""
    return (chain.materials or ())[chain._balls]


def cap_in_title(chain: Chain) -> str:
    """Such as ``cap 5 g``."""
    if chain.cap is None:
        return ""
    mass = float(chain.masses[-1])
    return f"cap of mass {mass:.4g}" if chain.scaled else f"cap {mass_in_words(mass)}"


def wall_in_words(chain: Chain, wall: Wall | None, end: int = -1) -> str:
    """A wall that is not simply one of the material of the bead at this end of the chain."""
    if wall is None:
        return ""
    kind = ""
    if wall.material is not None and wall.material not in [(chain.materials or (None,))[end]]:
        kind = f"{short_material(wall.material)} wall"
    elif wall.stiffness is not None and chain.units == "SI":
        exponent = float(chain.contact_exponents[end])
        kind = f"wall {stiffness_in_words(wall.stiffness, exponent)}".replace("um", "µm")
    elif wall.stiffness is not None:
        kind = f"wall of stiffness {wall.stiffness:g}"
    gap = ""
    if wall.gap:
        gap = (
            length_in_words(wall.gap).replace("um", "µm")
            if chain.units == "SI"
            else f"{wall.gap:g}"
        )
    parts = [kind or "wall", f"at a distance of {gap}" if gap else ""]
    return " ".join(filter(None, parts)) if kind or gap else ""


def loss_in_title(chain: Chain) -> str:
    """Such as ``restitution 0.95``, the assumed yield pressure, or ``with losses``."""
    if isinstance(chain.loss, Restitution):
        return f"restitution {chain.loss.coefficient:g}"
    if assumes_pressure(chain):
        return YIELD_ASSUMED
    return "" if chain.lossless else "with losses"


def _materials(materials: Sequence[Material]) -> dict[str, str]:
    """Names of materials without their grades, unless two of them differ only by the grade."""
    names = list(dict.fromkeys(each.name for each in materials))
    parts = [name.partition("-") for name in names]
    short = [
        base if any(map(str.isdigit, grade)) else name
        for name, (base, _, grade) in zip(names, parts, strict=True)
    ]
    short = short if len(set(short)) == len(short) else names
    return {name: printed_name(own) for name, own in zip(names, short, strict=True)}


def short_material(material: Material) -> str:
    """The name of a material without its grade."""
    (name,) = _materials((material,)).values()
    return name


def printed_name(material: str) -> str:
    """Name of a material in figures, where PTFE has capital letters."""
    return "PTFE" if material == "ptfe" else material
