"""Places of sensors: names such as ``ball 6`` or ``wall``, and their signals in a run."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from ..chain.bead_names import CAP, CELLS, check_load_cell, numbered_bead, usual_spelling
from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError, similar_names
from ..simulation.run import Run

QUANTITIES: Final = ("force", "velocity")
NAME: Final = re.compile(r"(?:(ball|bead) +([0-9]+)|(?:(left|right) +)?wall|cap)(?: +([a-z]+))?")
NUMBER: Final = re.compile(r"[0-9]{1,9}")


@dataclass(frozen=True)
class Place:
    """Position of a sensor, and the quantity that it measures.

    Attributes
    ----------
    name : str
        Name such as ``"ball 6"``, ``"bead 7"`` (counted with the strikers), ``"cap"``, ``"wall"``
        or ``"ball 3 velocity"``.
    body : str
        ``"ball"``, ``"bead"``, ``"cap"``, ``"left"`` or ``"right"``.
    number : int
        Number of the ball or bead; 0 for a cap and a wall.
    quantity : str
        ``"force"`` or ``"velocity"``.
    cell : bool
        Whether the wall is named as a load cell, which it has to be.
    """

    name: str
    body: str
    number: int
    quantity: str
    cell: bool = field(default=False, compare=False)

    def bead(self, chain: Chain) -> int:
        """Number of the bead in the chain, strikers included; raises `InputError` without it."""
        if self.cell:
            try:
                check_load_cell(chain)
            except InputError as error:
                raise InputError(f"the traces have a sensor 'load cell', but {error}") from None
        if self.body in ("left", "right"):
            if getattr(chain, f"{self.body}_wall") is None:
                raise InputError(
                    f"the traces have a sensor {self.name!r}, but the {self.body} end of the "
                    f"chain is free; add a {self.body}_wall"
                )
            return 0 if self.body == "left" else chain.beads + 1
        if self.body == CAP:
            if chain.cap is None:
                raise InputError(
                    f"the traces have a sensor {self.name!r}, but the chain has no cap; add one or "
                    "change the name of the column"
                )
            return chain.beads
        try:
            return numbered_bead(chain, self.body, self.number)
        except InputError as error:
            raise InputError(
                f"the traces have a sensor in {self.body} {self.number}, but {error}; change the "
                "name of the column or the chain"
            ) from None

    def signal(self, run: Run) -> Array:
        """Force [N] or velocity [m/s] at the saved times of a run."""
        bead = self.bead(run.chain)
        if self.body in ("left", "right"):
            return run.forces[:, 0 if self.body == "left" else -1]
        return run.sensor(bead) if self.quantity == "force" else run.velocity(bead)


def check_places(places: Iterable[Place], chain: Chain) -> None:
    """Check that a chain has the places, and that no two of them are the same."""
    known: dict[tuple[int, str], str] = {}
    for place in places:
        key = place.bead(chain), place.quantity
        if key in known:
            raise InputError(
                f"{known[key]!r} and {place.name!r} are the same place of this chain; keep one "
                "column"
            )
        known[key] = place.name


def place_named(
    name: str, written: str | None = None, *, example: str = "wall", column: str | None = None
) -> Place:
    """The place with a name; raises `InputError`, with the name as it is written, for others.

    ``column`` is the header for which the place is given, if it is not part of it.
    """
    text = usual_spelling(name)
    if text.removesuffix(" force") in CELLS:
        return Place("wall", "right", 0, "force", cell=True)
    found = NAME.fullmatch(text)
    quantity = (found[4] or "force") if found else ""
    capped = text.split(" ")[0] == CAP
    wall = found is not None and found[1] is None and not capped
    if found is None or quantity not in QUANTITIES or (wall and quantity != "force"):
        own = written or name
        what = f"column {own!r} does not name the place of its sensor"
        if column is not None:
            what = f"{own!r}, given for column {column!r}, does not name the place of a sensor"
        what += _meant(text)
        raise InputError(
            f"{what}; write 'ball 6', 'bead 7', 'wall' or 'ball 3 velocity', with a unit such as "
            f"[N], or give load_traces sensors={{{column or own!r}: {example!r}}}"
        )
    body = CAP if capped else found[1] or found[3] or "right"
    return Place(text.removesuffix(" force"), body, int(found[2] or 0), quantity)


def usual_name(sensor: object) -> Any:
    """The usual spelling of a place; other names as they are, which are answered later."""
    try:
        return place_named(sensor).name if isinstance(sensor, str) else sensor
    except InputError:
        return sensor


def by_usual_name(given: Mapping[Any, Any]) -> dict[Any, Any]:
    """Values by the names of sensors in their usual spelling, such as wall for load cell."""
    found: dict[Any, Any] = {}
    for name, value in given.items():
        if (usual := usual_name(name)) in found:
            raise InputError(f"{name!r} names the sensor {usual!r}, which is given twice; keep one")
        found[usual] = value
    return found


def _meant(text: str) -> str:
    """A question whether a similar name is meant; empty without one."""
    number = NUMBER.search(text)
    names = ["wall", "left wall", "right wall"]
    if number is not None and "wall" not in text:
        bodies = [f"{body} {int(number[0])}" for body in ("ball", "bead")]
        names = [*bodies, *(f"{body} {each}" for body in bodies for each in QUANTITIES)]
    # A ball without a number is similar to the wall.
    near = similar_names(text, names) if len(text) > 2 and text not in ("ball", "bead") else ""
    return f" (did you mean {near}?)" if near else ""
