"""Check that walls, drive and precompression of a chain are consistent."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final, Literal, get_args

import numpy as np

from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError, short_repr
from .contact_groups import ContactGroup
from .drives import Drive
from .input_checks import warn_soft
from .laws import Loss
from .laws.own_laws import checked_strength
from .parts import Part
from .static_forces import Loads
from .walls import Wall

HeldBy = Literal["walls", "force"]
HELD_BY: Final[tuple[HeldBy, ...]] = get_args(HeldBy)
_WALLS: Final = (
    "Wall() has the material of the bead next to it, Wall.of('brass') another one, and "
    "Wall.rigid() is rigid"
)
# Parts of a chain: name, type, allowed values and an example for messages.
PARTS: Final = (
    ("left_wall", Wall, "a Wall", _WALLS),
    ("right_wall", Wall, "a Wall", _WALLS),
    ("drive", Drive, "a SineBurst, a StepDrive, a TableDrive",
     "for example, StepDrive(100.0) is a force of 100 on bead 1"),
)  # fmt: skip


def check_part(name: str, part: object, *, scaled: bool, exponent: float) -> None:
    """Check the type of a wall or drive, and the units of its numbers."""
    kind, allowed, advice = next(row[1:] for row in PARTS if row[0] == name)
    if not isinstance(part, kind):
        raise InputError(f"{name} must be {allowed} or None, got {short_repr(part)}; {advice}")
    if isinstance(part, Part) and part.with_units:
        check_units(name, part, scaled=scaled, exponent=exponent)
    if isinstance(part, Wall) and part.loss is not None and part.loss.with_units:
        check_units(f"loss of {name}", part.loss, scaled=scaled, exponent=exponent)


def check_laws(laws: Iterable[Loss], groups: Sequence[ContactGroup], *, scaled: bool) -> None:
    """Check the units of the laws of a chain, and that each law supports its contacts."""
    for law in laws:
        if law.with_units:
            check_units("loss", law, scaled=scaled, exponent=HERTZ_EXPONENT)
    for group in groups:
        strength = checked_strength(group.law, group.contacts)
        if np.isinf(strength[group.contacts.stiffness > 0.0]).any():
            raise InputError(
                f"{group.law} with the stiffness of these contacts gives an infinite force; check "
                "the units of its parameters"
            )


def check_units(name: str, part: Part, *, scaled: bool, exponent: float) -> None:
    """Reject units in a scaled chain, and a unit of stiffness that belongs to another exponent."""
    fields = " and ".join(sorted(part.with_units))
    if scaled:
        raise InputError(
            f"{name} has a unit in its {fields}, but the chain is in scaled variables; give plain "
            "numbers or build a chain in SI units"
        )
    if "stiffness" in part.with_units and exponent not in (HERTZ_EXPONENT, 1.0):
        raise InputError(
            f"the stiffness of {name} was given in N/m^1.5, but its contact has p = "
            f"{exponent:g}; give a plain number in N/m^{exponent:g}"
        )


def check_drive(drive: Drive | None, left_wall: Wall | None) -> None:
    """Reject a drive of displacement without a left wall."""
    if drive is not None and drive.of == "displacement" and left_wall is None:
        raise InputError(
            "a drive of displacement moves the left wall, but the left end is free; give "
            "left_wall=Wall() or a drive of force"
        )


def check_precompression(loads: Loads, held_by: HeldBy) -> None:
    """Check that something holds a precompressed chain, and that its beads touch."""
    if loads.precompression == 0.0:
        return
    if held_by == "walls":
        _check_held_by_walls(loads)
    else:
        _check_held_by_force(loads)
    apart = np.flatnonzero(loads.gaps[loads.strikers :] > 0.0)
    if len(apart):
        k = loads.strikers + int(apart[0]) + 1
        raise InputError(
            f"contact {k} has a gap of {loads.gaps[k - 1]:g}, but precompressed beads touch; "
            "omit the gap or the precompression"
        )
    if any(wall is not None and wall.gap > 0.0 for wall in loads.walls):
        raise InputError(
            "a wall with a gap cannot hold a precompressed chain; omit the gap or the "
            "precompression"
        )


def _check_held_by_walls(loads: Loads) -> None:
    if loads.strikers:
        raise InputError(
            "a precompressed chain with strikers cannot be held by a left wall; use held_by='force'"
        )
    for side, wall in zip(("left", "right"), loads.walls, strict=True):
        if wall is None:
            raise InputError(
                f"the {side} end of the precompressed chain is free, and nothing holds it; "
                f"give {side}_wall, or held_by='force' for a constant force at this end"
            )


def _check_held_by_force(loads: Loads) -> None:
    if None not in loads.walls:
        raise InputError(
            "held_by='force' applies a constant force to a free end, but both ends have walls; "
            "omit one wall or use held_by='walls'"
        )
    if loads.strikers and loads.walls[0] is not None:
        raise InputError(
            "the left wall is behind the strikers and cannot hold the precompressed "
            "chain; omit left_wall to hold it by a constant force"
        )


def warn_soft_walls(walls: tuple[Wall | None, Wall | None], exponents: Array) -> None:
    """Warn about walls of an SI chain whose stiffness, a plain number, is that of no real wall."""
    for side, wall, exponent in zip(("left", "right"), walls, exponents[[0, -1]], strict=True):
        if wall and wall.stiffness is not None and "stiffness" not in wall.with_units:
            warn_soft(f"the stiffness of the {side} wall", wall.stiffness, float(exponent))
