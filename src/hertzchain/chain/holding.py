"""What holds a chain and what moves it: walls, drives and precompression go together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

from hertzchain.arguments import one_of
from hertzchain.chain.drives import Drive
from hertzchain.chain.losses import Loss
from hertzchain.chain.parts import Part
from hertzchain.chain.walls import Wall
from hertzchain.contacts import HERTZ_EXPONENT, Array
from hertzchain.errors import InputError, shown

if TYPE_CHECKING:
    from hertzchain.chain.chain import Chain

HeldBy = Literal["walls", "force"]
HELD_BY: Final[tuple[HeldBy, ...]] = get_args(HeldBy)
# Largest static overlap of a scaled chain, in units of those of the strike: beside larger ones
# velocities lose more than half of their digits in rounding.
LARGEST_SCALED_OVERLAP: Final = 1e6
_WALLS: Final = (
    "Wall() is of the bead's own material, Wall.of('brass') of another, Wall.rigid() is rigid"
)
# Parts of a chain: their types, and what to give.
PARTS: Final = (
    ("left_wall", Wall, "a Wall", _WALLS),
    ("right_wall", Wall, "a Wall", _WALLS),
    ("loss", Loss, "a law of hertzchain.chain.losses",
     "Restitution(0.95) has the coefficient of restitution 0.95"),
    ("drive", Drive, "a SineBurst, a Step, a Table",
     "Step(100.0) is a force of 100 on bead 1"),
)  # fmt: skip


def check_holding(chain: Chain) -> None:
    """Refuse walls, drives and precompression that contradict each other.

    Parameters
    ----------
    chain : Chain
        The chain they are fields of.

    Raises
    ------
    InputError
        If one of them is of another type, or two exclude each other.

    Examples
    --------
    >>> import hertzchain as hc
    >>> check_holding(hc.Chain.uniform(3).replace(right_wall=hc.Wall()))
    """
    for name, kind, allowed, advice in PARTS:
        part = getattr(chain, name)
        if part is not None and not isinstance(part, kind):
            raise InputError(f"{name} must be {allowed} or None, got {shown(part)}; {advice}")
        if part is not None and part.with_units:
            _check_units(chain, name, part)
    if chain.drive is not None and chain.drive.of == "displacement" and chain.left_wall is None:
        raise InputError(
            "a drive of displacement moves the left wall, but the left end is free: give "
            "left_wall=Wall(), or a drive of force"
        )
    # Refuses a wall whose material has no meaning beside this chain.
    _ = chain.wall_stiffness
    one_of("way to hold a chain", chain.held_by, HELD_BY)
    if chain.precompression > 0.0:
        _check_precompression(chain)
    _check_static_overlaps(chain)


def _check_units(chain: Chain, name: str, part: Part) -> None:
    """Refuse numbers with a unit in a scaled chain, or of another exponent."""
    fields = " and ".join(sorted(part.with_units))
    if chain.units != "SI":
        raise InputError(
            f"{name} has a unit in its {fields}, but the chain is in scaled variables: give plain "
            "numbers, or make a chain in SI units"
        )
    if (
        isinstance(part, Wall)
        and "stiffness" in part.with_units
        and chain.exponent != HERTZ_EXPONENT
    ):
        raise InputError(
            f"the stiffness of {name} was given in N/m^1.5, but the contacts have p = "
            f"{chain.exponent:g}: give a plain number in N/m^{chain.exponent:g}"
        )


def _check_precompression(chain: Chain) -> None:
    walls = (chain.left_wall, chain.right_wall)
    if chain.held_by == "walls":
        if chain.strikers:
            raise InputError(
                "strikers come from where the left wall would hold the precompressed chain: "
                "hold it by held_by='force'"
            )
        for side, wall in zip(("left", "right"), walls, strict=True):
            if wall is None:
                raise InputError(
                    f"nothing holds the precompressed chain at its {side} end, which is free: "
                    f"give {side}_wall, or held_by='force' for a constant force there"
                )
    elif None not in walls:
        raise InputError(
            "held_by='force' puts a constant force on free ends, but both ends have walls: "
            "leave one wall out, or held_by='walls'"
        )
    elif chain.strikers and chain.left_wall is not None:
        raise InputError(
            "the left wall stands behind the strikers and cannot hold the precompressed "
            "chain: leave left_wall out, and a constant force will"
        )
    apart = np.flatnonzero(chain.gaps[chain.strikers :] > 0.0)
    if len(apart):
        k = chain.strikers + int(apart[0]) + 1
        raise InputError(
            f"contact {k} has a gap of {chain.gaps[k - 1]:g}, but precompressed beads touch: "
            "leave the gap or the precompression out"
        )
    if any(wall is not None and wall.gap > 0.0 for wall in walls):
        raise InputError(
            "a wall with a gap cannot hold a precompressed chain: leave the gap or the "
            "precompression out"
        )


def static_forces(chain: Chain) -> Array:
    """Force that each contact bears before anything moves.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    ndarray, shape (N + 1,)
        Of contacts 0 (left wall) to N (right wall); that of a free end is what holds it.

    Examples
    --------
    >>> import hertzchain as hc
    >>> static_forces(hc.Chain.uniform(2).replace(gravity=0.1, right_wall=hc.Wall()))
    array([0. , 0.1, 0.2])
    """
    forces = np.zeros(chain.beads + 1)
    first = chain.strikers
    weights = np.abs(chain.gravity) * chain.masses[first:]
    if not (chain.precompression > 0.0 or _stands(chain)):
        return forces
    from_top = weights if chain.gravity >= 0.0 else weights[::-1]
    held = chain.precompression + np.concatenate(([0.0], np.cumsum(from_top)))
    forces[first:] = held if chain.gravity >= 0.0 else held[::-1]
    return forces


def static_overlaps(chain: Chain, forces: Array) -> Array:
    r"""Overlaps :math:`(F_c/k_c)^{1/p}` under static forces; 0 at a free end.

    Parameters
    ----------
    chain : Chain
        Any chain.
    forces : ndarray, shape (N + 1,)
        Of `static_forces`.

    Returns
    -------
    ndarray, shape (N + 1,)

    Examples
    --------
    >>> import hertzchain as hc
    >>> static_overlaps(hc.Chain.uniform(3), np.full(4, 8.0)).round(9)
    array([0., 4., 4., 0.])
    """
    left, right = chain.wall_stiffness
    stiffness = np.concatenate(([left], chain.stiffness, [right]))
    overlaps = np.zeros(chain.beads + 1)
    bearing = (forces > 0.0) & (stiffness > 0.0)
    overlaps[bearing] = (forces[bearing] / stiffness[bearing]) ** (1.0 / chain.exponent)
    return overlaps


def _check_static_overlaps(chain: Chain) -> None:
    """Refuse forces that press beads through each other before anything moves."""
    forces = static_forces(chain)
    if not forces.any():
        return
    overlaps = static_overlaps(chain, forces)
    limits = np.full(chain.beads + 1, LARGEST_SCALED_OVERLAP)
    if chain.units == "SI":
        row = np.concatenate((chain.radii[:1], chain.radii, chain.radii[-1:]))
        limits = np.minimum(row[:-1], row[1:])
    excess = overlaps / limits
    worst = int(np.argmax(excess))
    if excess[worst] <= 1.0:
        return
    left, right = chain.wall_stiffness
    stiffness = np.concatenate(([left], chain.stiffness, [right]))[worst]
    # Rounded down, to be met when asked for.
    largest = 0.995 * stiffness * limits[worst] ** chain.exponent
    what = "precompression" if chain.precompression > 0.0 else "gravity"
    unit, beside = "", f"{limits[worst]:g} times those of a strike"
    if chain.units == "SI":
        unit, beside = " N", f"the radius of a bead, {limits[worst]:g} m"
    raise InputError(
        f"{what} presses contact {worst} with {forces[worst]:g}{unit} to an overlap of more than "
        f"{beside}: it bears at most {largest:.3g}{unit} there; use less {what}"
    )


def _stands(chain: Chain) -> bool:
    """Whether gravity presses the touching chain against a wall that it touches."""
    down = chain.right_wall if chain.gravity > 0.0 else chain.left_wall
    on_wall = chain.gravity != 0.0 and down is not None and down.gap == 0.0
    from_strikers = chain.strikers > 0 and chain.gravity < 0.0
    return on_wall and not from_strikers and not chain.gaps[chain.strikers :].any()
