"""Quantities that sweeps keep, by the number of their values at a point."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final, NamedTuple

from ..chain.bead_names import bead_number
from ..chain.chain import Chain
from ..errors import InputError, unknown_name_error
from ..pulse.quantities import (
    LARGEST_QUANTITIES,
    ON_REQUEST,
    QUANTITIES,
    SENSOR_QUANTITIES,
    WALL_QUANTITIES,
    Quantity,
)
from ..pulse.quantity_names import column_name, full_name

# One value per bead or contact, and one value per run.
PER_PLACE: Final[dict[str, Quantity]] = {
    **QUANTITIES,
    **{name: each for name, each in LARGEST_QUANTITIES.items() if each.per == "contact"},
}
PER_RUN: Final[dict[str, Quantity]] = {
    **WALL_QUANTITIES,
    **{name: each for name, each in LARGEST_QUANTITIES.items() if each.per == "run"},
}
SWEEP_QUANTITIES: Final[dict[str, Quantity]] = PER_PLACE | PER_RUN
# Quantities that only the method `simulate` gives.
OF_RUNS: Final = (*WALL_QUANTITIES, *LARGEST_QUANTITIES, *SENSOR_QUANTITIES)
_SENSORS: Final = "|".join(sorted(SENSOR_QUANTITIES, key=len, reverse=True))
_VARIABLE: Final = re.compile(rf"({_SENSORS})_((?:ball_|bead_)?[1-9][0-9]{{0,8}}|last)")


class Sensor(NamedTuple):
    """A quantity of one sensor: its column in a `RunTable`, and the name of its bead."""

    column: str
    place: str

    @property
    def quantity(self) -> Quantity:
        """The quantity, without the bead."""
        return SENSOR_QUANTITIES[self.column]

    @property
    def name(self) -> str:
        """Name as in designs: ``sensor.largest@ball 4``."""
        return f"{full_name(self.column)}@{self.place}"

    @property
    def where(self) -> str:
        """The bead in words."""
        words = {"last": "the last bead"}
        return words.get(self.place, f"bead {self.place}" if self.place.isdigit() else self.place)

    def bead(self, chain: Chain) -> int:
        """Number of the bead; 0 if the chain does not have it."""
        if self.place == "last":
            return chain.beads
        try:
            return bead_number(chain, int(self.place) if self.place.isdigit() else self.place)
        except InputError:
            return 0


def sensor_of(variable: str) -> Sensor | None:
    """The sensor of a variable such as ``sensor_largest_so_far_ball_4``; `None` of any other."""
    found = _VARIABLE.fullmatch(variable)
    return Sensor(found[1], found[2].replace("_", " ")) if found else None


def variable_name(name: str) -> str:
    """Name of the variable of a quantity, also from a name as in designs.

    ``sensor.largest@ball 4`` is ``sensor_largest_so_far_ball_4``.
    """
    key, at, place = name.partition("@")
    column = str(column_name(key.strip()))
    return f"{column}_{'_'.join(place.lower().split())}" if at else column


def unknown_quantity(name: object, known: Sequence[str]) -> InputError | str:
    """Why a sweep does not keep a quantity, or what its name lacks."""
    own, at, bead = str(name).partition("@")
    column = str(column_name(own.strip()))
    if column in SENSOR_QUANTITIES and bead != "wall":
        own = full_name(column)
        return f"{own} needs the bead of the sensor: write {own}@5 or '{own}@ball 4', got {name!r}"
    if own in ON_REQUEST:
        return f"sweeps do not keep the {own} of the pulse; keep residence, from which it follows"
    if own in ("largest_velocity", "largest_momentum", "largest_energy"):
        first = own.removeprefix("largest_")
        return (
            f"sweeps do not keep {own}, which only designs and gradients have; keep {first}, that "
            "at the first maximum of the velocity of each bead"
        )
    if at and column in known and bead != "wall":
        return f"{name!r} is {column} of one bead: keep {column}, and give at = [{bead}]"
    sensors = [f"{full_name(each)}@k" for each in SENSOR_QUANTITIES]
    return unknown_name_error("quantity", name, (*known, *sensors))


def absent_sensors(keep: Sequence[str], chains: Sequence[Chain]) -> list[str]:
    """Messages on sensors in beads that none of some chains has."""
    found = []
    for place, name in enumerate(keep, start=1):
        sensor = sensor_of(name)
        if sensor is not None and chains and not any(map(sensor.bead, chains)):
            most = max(chain.beads for chain in chains)
            found.append(f"sweep.keep[{place}]: {sensor.name}: there is no such bead in {most} "
                         "beads")  # fmt: skip
    return found
