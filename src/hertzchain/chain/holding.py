"""What holds a chain and what moves it: walls, drives and precompression go together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

from hertzchain.chain.drives import Drive
from hertzchain.chain.losses import Loss
from hertzchain.chain.walls import Wall
from hertzchain.errors import InputError, unknown_name

if TYPE_CHECKING:
    from hertzchain.chain.chain import Chain

HeldBy = Literal["walls", "force"]
HELD_BY: Final[tuple[HeldBy, ...]] = get_args(HeldBy)


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
    for side, wall in (("left", chain.left_wall), ("right", chain.right_wall)):
        if wall is not None and not isinstance(wall, Wall):
            raise InputError(f"{side}_wall must be a Wall or None, got {wall!r}")
    if chain.loss is not None and not isinstance(chain.loss, Loss):
        raise InputError(
            f"loss must be a law of hertzchain.chain.losses or None, got {chain.loss!r}"
        )
    if chain.drive is not None and not isinstance(chain.drive, Drive):
        raise InputError(f"drive must be a SineBurst, a Step, a Table or None, got {chain.drive!r}")
    if chain.drive is not None and chain.drive.of == "displacement" and chain.left_wall is None:
        raise InputError(
            "a drive of displacement moves the left wall, but the left end is free: give "
            "left_wall=Wall(), or a drive of force"
        )
    # Refuses a wall whose material has no meaning beside this chain.
    _ = chain.wall_stiffness
    if chain.held_by not in HELD_BY:
        raise unknown_name("way to hold a chain", chain.held_by, HELD_BY)
    if chain.precompression > 0.0:
        _check_precompression(chain)


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
