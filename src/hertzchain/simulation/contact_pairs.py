"""Two contacts, on both sides of an object that reflects waves."""

from __future__ import annotations

from typing import Final

from ..chain.bead_names import wall_number
from ..chain.chain import Chain
from ..errors import InputError
from ..validation.numbers import whole_number

# Least distance of two contacts at which a wave passes them one after the other.
CLOSEST: Final = 3
NAMES: Final = ("before", "after")


def pair_of_contacts(
    chain: Chain, before: int, after: int | str, names: tuple[str, str] = NAMES, where: str = ""
) -> tuple[int, int]:
    """Numbers of two different contacts, of which the second one may be a wall."""
    beads, (one, other) = chain.beads, names
    first = whole_number(f"{one}{where}", before, least=1, most=beads - 1)
    wall = wall_number(chain, after)
    number = after if wall is None else min(wall, beads)
    second = whole_number(f"{other}{where}", number, least=0, most=beads)
    if first == second:
        raise InputError(f"{one} and {other}{where} must be two contacts, got {first} twice")
    return first, second


def separate_contacts(
    chain: Chain, before: int, after: int | str, names: tuple[str, str] = NAMES, where: str = ""
) -> tuple[int, int]:
    """Numbers of two contacts that waves pass one after another, not at the same time.

    At the two contacts of a heavy bead, for example, no wave is reflected.
    """
    first, second = pair_of_contacts(chain, before, after, names, where)
    ends = {0: chain.left_wall, chain.beads: chain.right_wall}
    if second in ends:
        return first, second
    if abs(second - first) < CLOSEST:
        raise InputError(
            f"{' and '.join(names)}{where} must be at least {CLOSEST} contacts apart, because "
            f"a wave passes contacts {first} and {second} at the same time; choose one at least 5 "
            "contacts from the object on each side"
        )
    for end, wall in ends.items():
        if wall and abs(end - second) == 1:
            raise InputError(
                f"{names[1]}{where} must not be contact {second} next to the wall, where a wave "
                f"meets its own reflection; give the wall itself, {end}"
            )
    return first, second
