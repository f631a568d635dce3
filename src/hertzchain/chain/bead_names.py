"""Names of beads and walls: ``ball 11`` is counted without the strikers, ``bead 12`` with them."""

from __future__ import annotations

import re
from typing import Any, Final, Literal

from ..errors import InputError, alternatives, short_repr, similar_names
from ..representation import counted
from ..validation.numbers import whole_number
from .chain import Chain

Side = Literal["left", "right"]
CAP: Final = "cap"
LAST: Final = "last"
# Largest number of a ball in examples of names.
EXAMPLE: Final = 11
# Names of a right wall that is a linear spring.
CELLS: Final = ("load cell", "cell")
NAME: Final = re.compile(r"(ball|bead) +([0-9]{1,9})")
# Names are also written without a space, as ball6, and as ball_6, ball-6 or ball#6.
BEFORE_NUMBER: Final = r"(?:[ _#]*|-)"
AT_NAME: Final = re.compile(
    rf"@ *((?:(?:ball|bead){BEFORE_NUMBER}[0-9]{{1,9}})(?![0-9])|cap\b)", re.IGNORECASE
)
# The same in a range of places, such as "ball 1:last".
PLACE: Final = re.compile(
    rf"(?:ball|bead){BEFORE_NUMBER}[0-9]{{1,9}}(?![0-9])|\b(?:{LAST}|{CAP})\b", re.IGNORECASE
)
OTHER_SPELLING: Final = re.compile(rf"\b(ball|bead){BEFORE_NUMBER}(?=[0-9])")


def usual_spelling(name: str) -> str:
    """A name such as ``Ball6``, ``ball_6`` or ``left_wall`` as ``ball 6`` or ``left wall``."""
    words = " ".join(name.lower().replace("_", " ").split())
    return OTHER_SPELLING.sub(r"\1 ", words)


def _example_ball(chain: Chain) -> int:
    """Number of a ball of the chain, for examples of names."""
    return max(1, min(EXAMPLE, chain.beads - chain.strikers - (chain.cap is not None)))


def bead_number(chain: Chain, bead: int | str, what: str = "bead", *, walls: bool = False) -> int:
    """Number of a bead, strikers included, from that number or a name such as ``"ball 11"``.

    The last bead is also named ``"last"``, and ``"cap"`` if it is one.
    """
    if not isinstance(bead, str):
        try:
            return whole_number(what, bead, least=1, most=chain.beads)
        except InputError as error:
            names = [
                f"ball {_example_ball(chain)}",
                LAST,
                *[CAP] * (chain.cap is not None),
                *["wall"] * walls,
            ]
            raise InputError(f"{error}; or give a name: {alternatives(names)}") from None
    name = usual_spelling(bead)
    if name == LAST:
        return chain.beads
    if name == CAP:
        if chain.cap is None:
            raise InputError("the chain has no cap; add one with with_cap")
        return chain.beads
    found = NAME.fullmatch(name)
    if found is None:
        cap = f", or {CAP!r}" if chain.cap is not None else ""
        wall = ", or 'wall'" if walls else ""
        ball = _example_ball(chain)
        raise InputError(
            f"{what} must be a whole number or a name such as 'ball {ball}' (without the strikers) "
            f"or 'bead {ball + chain.strikers}' (with them){cap}{wall}, got {short_repr(bead)}"
            f"{_meant(chain, name, walls=walls)}"
        )
    return numbered_bead(chain, found[1], int(found[2]))


def _meant(chain: Chain, name: str, *, walls: bool) -> str:
    """A question whether a similar name is meant; empty without one."""
    names = [LAST, *[CAP] * (chain.cap is not None)]
    if walls:
        names += [*(f"{side} wall" for side in walls_of(chain)), *["wall"] * len(walls_of(chain))]
        names += CELLS[: is_load_cell(chain)]
    near = similar_names(name, names)
    return f"; did you mean {near}?" if near else ""


def walls_of(chain: Chain) -> dict[Side, int]:
    """Walls of a chain, with the numbers that they have among the beads: 0 and N + 1."""
    numbers: dict[Side, int] = {"left": 0, "right": chain.beads + 1}
    return {side: number for side, number in numbers.items() if f"{side} wall" in chain.features}


def wall_number(chain: Chain, name: object) -> int | None:
    """Number of a wall, 0 or N + 1, from its name; `None` for anything but the name of a wall.

    The names are "right wall", "left wall" and, if the chain has only one, "wall"; a right wall
    that is a linear spring is also a "load cell".
    """
    words = usual_spelling(name) if isinstance(name, str) else ""
    if words in CELLS:
        check_load_cell(chain)
        return chain.beads + 1
    if words not in ("wall", "left wall", "right wall"):
        return None
    present = {f"{side} wall": number for side, number in walls_of(chain).items()}
    if words == "wall" and len(present) == 1:
        return next(iter(present.values()))
    if words in present:
        return present[words]
    if words == "wall" and present:
        raise InputError("the chain has two walls: give 'right wall' or 'left wall'")
    side = "left" if words == "left wall" else "right"
    raise InputError(f"the chain has no {words}; add a {side}_wall")


def is_load_cell(chain: Chain) -> bool:
    """Whether the wall behind the row is a linear spring, such as a load cell."""
    return chain.right_wall is not None and float(chain.contact_exponents[-1]) == 1.0


def check_load_cell(chain: Chain) -> None:
    """Raise `InputError` unless the chain ends with a load cell."""
    if not is_load_cell(chain):
        ends = {"wall": chain.right_wall is not None, CAP: chain.cap is not None}
        end = next((name for name, present in ends.items() if present), f"bead {chain.beads}")
        raise InputError(
            "the chain has no load cell, that is, a right wall with the exponent 1; use the sensor "
            f"{end!r}"
        )


def numbered_bead(chain: Chain, body: str, number: int) -> int:
    """Number of a bead, strikers included, from that of a ``"ball"`` or ``"bead"``."""
    shift = chain.strikers if body == "ball" else 0
    # A cap is the last bead, but not a ball.
    capped = body == "ball" and chain.cap is not None
    count = chain.beads - shift - capped
    if not 1 <= number <= count:
        after = " after its strikers" if shift else ""
        also, name = (f" and a {CAP}", f", or {CAP!r}") if capped else ("", "")
        raise InputError(
            f"there is no {body} {number}: the chain has {counted(count, body)}{also}{after}; give "
            f"a number from 1 to {count}{name}"
        )
    return number + shift


def with_bead_numbers(chain: Chain, quantity: str) -> str:
    """A quantity such as ``velocity@ball 9`` with the numbers of its beads, ``velocity@10``."""
    return AT_NAME.sub(lambda found: f"@{bead_number(chain, found[1])}", quantity)


def numbered_places(chain: Chain, places: Any) -> Any:
    """Places such as ``"ball 1:"`` or ``["ball 1", 4]`` with the numbers of beads, ``"2:"``."""
    if isinstance(places, list | tuple):
        return [bead_number(chain, k) if isinstance(k, str) else k for k in places]
    if not isinstance(places, str) or not PLACE.search(places):
        return places
    ends = [part.strip() for part in places.split(":")[:2]]
    if chain.strikers and any(map(str.isdigit, ends)):
        raise InputError(
            f"beads = {short_repr(places)} has a name and a number, which count differently behind "
            "a striker: name both ends, as in 'ball 1:ball 5'"
        )
    return PLACE.sub(lambda found: str(bead_number(chain, found[0])), places)


def bead_label(chain: Chain, number: int) -> str:
    """``bead 12``, ``bead 12 (cap)``; with a striker, ``bead 1 (striker)``, ``bead 3 (ball 2)``."""
    if chain.cap is not None and number == chain.beads:
        return f"bead {number} ({CAP})"
    ball = number - chain.strikers
    if not chain.strikers:
        return f"bead {number}"
    return f"bead {number} ({f'ball {ball}' if ball > 0 else 'striker'})"
