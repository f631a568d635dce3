"""Quantities of a run at a bead, such as that of a sensor, or at an object between two contacts."""

from __future__ import annotations

import math
import re
from typing import Final, NamedTuple

import numpy as np

from ..chain.bead_names import bead_number
from ..chain.chain import Chain
from ..errors import IncompleteWarning, InputError, SimulationError, warn_user
from ..pulse.quantities import QUANTITIES, SENSOR_QUANTITIES, Quantity
from ..pulse.quantity_names import column_name, full_name
from ..recorded_warnings import record_warnings
from ..simulation.ends_of_runs import sensors_of_run
from ..simulation.run import Run
from ..simulation.velocity_peaks import peaks_from


def _largest(name: str) -> Quantity:
    own, at = QUANTITIES[name], "" if name == "velocity" else f"{name} at the "
    return Quantity(
        f"largest_{name}", "", f"{at}largest forward velocity of the bead in the run",
        unit=own.unit, scale=own.scale, label=f"largest {name}",
    )  # fmt: skip


def _coefficient(part: str, name: str) -> Quantity:
    return Quantity(
        f"{part}_{name}", "", f"{part} {name} relative to that of the incident wave",
        unit="1", scale="1", label=f"{part} {name} / incident {name}", per="wave", values="finite",
    )  # fmt: skip


# Quantities at the largest forward velocity of a bead, as in designs.
LARGEST: Final = {each.name: each for each in map(_largest, ("velocity", "momentum", "energy"))}
# Attributes of a `Reflection` between two contacts; those that are kept are never incomplete.
REFLECTION: Final = {
    each.name: each
    for part in ("reflected", "transmitted") for name in ("energy", "momentum", "force")
    for each in (_coefficient(part, name),)
} | {
    name: Quantity(
        name, "", f"{what} that remains between the contacts at the end of the run or was lost, "
        "relative to that of the incident wave",
        unit="1", scale="1", label=f"kept {what} / incident {what}", per="wave", values="finite",
    )
    for what in ("energy", "momentum") for name in (f"kept_{what}",)
}  # fmt: skip
PLACED: Final = {**SENSOR_QUANTITIES, **LARGEST, **REFLECTION}
_FULL_NAMES: Final = {name: f"reflection.{name}" for name in REFLECTION}
_COLUMNS: Final = {full: name for name, full in _FULL_NAMES.items()}


def _either(names: dict[str, Quantity]) -> str:
    return "|".join(sorted(names, key=len, reverse=True))


_AT_BEAD: Final = re.compile(
    rf"({_either({**SENSOR_QUANTITIES, **LARGEST})})_((?:ball_|bead_)?[1-9][0-9]{{0,8}}|last|cap)"
)
_BETWEEN: Final = re.compile(
    rf"({_either(REFLECTION)})_([1-9][0-9]{{0,8}}_(?:0|[1-9][0-9]{{0,8}}|last))"
)


class Placed(NamedTuple):
    """A quantity at a bead or between two contacts: its name in `PLACED`, and its place."""

    column: str
    place: str

    @property
    def quantity(self) -> Quantity:
        """The quantity, without the place."""
        return PLACED[self.column]

    @property
    def name(self) -> str:
        """Name as in designs: ``sensor.largest@ball 4``, ``reflection.reflected_energy@20-35``."""
        return f"{full_name_of(self.column)}@{self.place}"

    @property
    def where(self) -> str:
        """The bead or the contacts in words."""
        if self.column in REFLECTION:
            before, after = self.place.split("-")
            return f"contacts {before} to {after.replace('last', 'N')}"
        words = {"last": "the last bead", "cap": "the cap"}
        return words.get(self.place, f"bead {self.place}" if self.place.isdigit() else self.place)

    @property
    def label(self) -> str:
        """The quantity with its place, for axes."""
        link = " in " if self.column in SENSOR_QUANTITIES else " of "
        link = ", " if self.column in REFLECTION else link
        return f"{self.quantity.label.removesuffix(' so far')}{link}{self.where}"

    @property
    def absent(self) -> str:
        """That a chain does not have the place."""
        contacts = self.column in REFLECTION
        words = "there are no such contacts" if contacts else "there is no such bead"
        return f"{self.name}: {words}"

    def numbers(self, chain: Chain) -> tuple[int, ...]:
        """Number of the bead, or of both contacts; none if the chain does not have them."""
        last = chain.beads
        if self.column in REFLECTION:
            before, after = (last if each == "last" else int(each)
                             for each in self.place.split("-"))  # fmt: skip
            return (before, after) if before < last and after <= last else ()
        try:
            name = int(self.place) if self.place.isdigit() else self.place
            return (last if name == "last" else bead_number(chain, name),)
        except InputError:
            return ()

    def evaluate(self, run: Run) -> tuple[float, list[str]]:
        """Value of a run, and why it is missing or inaccurate."""
        notes: list[str] = []
        if self.column in REFLECTION:
            value, notes = _coefficient_of(run, self.column, *self.numbers(run.chain))
        elif self.column in LARGEST:
            (bead,) = self.numbers(run.chain)
            value = _largest_of(run, self.column, bead)
        else:
            value = float(sensors_of_run(run, self.numbers(run.chain))[self.column][0])
            notes = ["the force has no maximum in the run"] if np.isnan(value) else []
        # All coefficients between two contacts have the same notes.
        name = f"reflection@{self.place}" if self.column in REFLECTION else self.name
        return value, [f"{name}: {note}" for note in notes]


def _coefficient_of(run: Run, column: str, before: int, after: int) -> tuple[float, list[str]]:
    """A coefficient, or NaN with an `IncompleteWarning` if the run ends too early for it."""
    try:
        with record_warnings() as warned:
            value = float(getattr(run.reflection(before, after), column))
    except (InputError, SimulationError) as error:
        return math.nan, [str(error)]
    notes = [*map(str, warned)]
    if late := [str(each) for each in warned if isinstance(each, IncompleteWarning)]:
        warn_user(late[0], IncompleteWarning)
        return value if column.startswith("kept_") else math.nan, notes
    return value, notes


def _largest_of(run: Run, column: str, bead: int) -> float:
    """Quantity at the largest forward velocity, also between saved times."""
    peaks = peaks_from(run, bead).velocities
    velocity = max(peaks.max(initial=0.0), float(run.velocity(bead).max()))
    mass = float(run.chain.masses[bead - 1])
    values = {"velocity": velocity, "momentum": mass * velocity, "energy": mass * velocity**2 / 2}
    return values[column.removeprefix("largest_")]


def full_name_of(column: str) -> str:
    """Name of a quantity as in designs, or of an attribute of a `Reflection`."""
    return _FULL_NAMES.get(column) or full_name(column)


def column_of(name: str) -> str:
    """Name of the variable of a quantity, without its place."""
    return _COLUMNS.get(name) or str(column_name(name))


def placed(variable: str) -> Placed | None:
    """The quantity of a variable such as ``sensor_first_maximum_ball_4``; `None` of any other."""
    if found := _AT_BEAD.fullmatch(variable):
        return Placed(found[1], found[2].replace("_", " "))
    found = _BETWEEN.fullmatch(variable)
    return Placed(found[1], found[2].replace("_", "-")) if found else None


def example_of(column: str) -> str:
    """The place that a name lacks, with an example."""
    name = full_name_of(column)
    if column in REFLECTION:
        return (
            f"{name} needs the contacts on both sides of the object: write {name}@20-35, or "
            f"{name}@20-last for the right end"
        )
    of = " of the sensor" if column in SENSOR_QUANTITIES else ""
    return (
        f"{name} needs the bead{of}: write {name}@5, '{name}@ball 4', {name}@last or, with a cap, "
        f"{name}@cap"
    )
