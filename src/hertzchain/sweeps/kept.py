"""Quantities that sweeps keep, by the number of their values at a point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from ..chain.chain import Chain
from ..errors import InputError, unknown_name_error
from ..pulse.quantities import (
    BODY_QUANTITIES,
    LARGEST_QUANTITIES,
    ON_REQUEST,
    QUANTITIES,
    SENSOR_QUANTITIES,
    WALL_QUANTITIES,
    Quantity,
)
from ..pulse.quantity_names import full_names_meant
from .placed import LARGEST, PLACED, REFLECTION, column_of, example_of, full_name_of, placed

# One value per bead or contact, and one value per run.
PER_PLACE: Final[dict[str, Quantity]] = {
    **QUANTITIES,
    **{name: each for name, each in LARGEST_QUANTITIES.items() if each.per == "contact"},
}
PER_RUN: Final[dict[str, Quantity]] = {
    **WALL_QUANTITIES,
    **BODY_QUANTITIES,
    **{name: each for name, each in LARGEST_QUANTITIES.items() if each.per == "run"},
}
SWEEP_QUANTITIES: Final[dict[str, Quantity]] = PER_PLACE | PER_RUN
# Quantities that only the method `simulate` gives.
OF_RUNS: Final = (*WALL_QUANTITIES, *BODY_QUANTITIES, *LARGEST_QUANTITIES)


def variable_name(name: str) -> str:
    """Name of the variable of a quantity, also from a name as in designs.

    ``sensor.largest@ball 4`` is ``sensor_largest_so_far_ball_4``.
    """
    key, at, place = name.partition("@")
    column = column_of(key.strip())
    return f"{column}_{'_'.join(place.lower().replace('-', ' ').split())}" if at else column


def unknown_quantity(name: object, known: Sequence[str]) -> InputError | str:
    """Why a sweep does not keep a quantity, or what its name lacks."""
    own, at, bead = str(name).partition("@")
    column = column_of(own.strip())
    if column in PLACED and bead != "wall":
        return f"{example_of(column)}, got {name!r}"
    if own in ON_REQUEST:
        return f"sweeps do not keep the {own} of the pulse; keep residence, from which it follows"
    if at and column in known and bead != "wall":
        return f"{name!r} is {column} of one bead: keep {column}, and give at = [{bead}]"
    full = [other for each in known if (other := full_name_of(each)) not in known]
    sensors = [f"{full_name_of(each)}@k" for each in (*SENSOR_QUANTITIES, *LARGEST)]
    reflections = [f"{full_name_of(each)}@j-k" for each in REFLECTION]
    # Full names are those of designs and of the other commands.
    meant = full_names_meant(name, known)
    return unknown_name_error(
        "quantity", name, (*known, *full, *sensors, *reflections), meant=meant
    )


def absent_places(keep: Sequence[str], chains: Sequence[Chain]) -> list[str]:
    """Messages on beads and contacts that none of some chains has."""
    found = []
    for place, name in enumerate(keep, start=1):
        each = placed(name)
        if each is not None and chains and not any(map(each.numbers, chains)):
            most = max(chain.beads for chain in chains)
            found.append(f"sweep.keep[{place}]: {each.absent} in {most} beads")
    return found
