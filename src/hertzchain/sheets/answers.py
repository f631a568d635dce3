"""The answers for the teacher: exponents, speed of the pulse, losses and gaps."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np

from ..chain.bead_names import bead_number
from ..chain.chain import Chain
from ..chain.laws.restitution import Restitution
from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings
from ..representation import listed
from .sheet import WALL, LabSheet, lab_sheet
from .similarity import EXPONENT_OF_FORCES, EXPONENT_OF_TIMES, other_scales

# Differences of exponents that are shown with three decimals.
SEEN: Final = 5e-4
# Relative error of the height or speed, and causes of differences, in the answers.
ERROR: Final = 0.05
CAUSES: Final[dict[str, dict[str, Any]]] = {
    "restitution 0.95": {"loss": Restitution(0.95)},
    "restitution 0.9": {"loss": Restitution(0.9)},
    "gaps of 10 µm": {"gaps": 1e-5},
}


class Table(NamedTuple):
    """A table of texts with a caption."""

    caption: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def exponents(sheet: LabSheet) -> Table:
    """Exponents of the forces between successive speeds, and of all speeds."""
    heads = ("sensor", *(f"{1e3 * a:.4g} to {1e3 * b:.4g} mm/s" for a, b in pairwise(sheet.speeds)),
             "all speeds")  # fmt: skip
    rows = tuple(
        (place, *map(_exponent, steps), _exponent(float(overall)))
        for place, steps, overall in zip(
            sheet.places, sheet.exponents.T, fitted_exponents(sheet, sheet.forces), strict=True
        )
    )
    return Table("Exponents of the speed in the predicted forces", heads, rows)


def fitted_exponents(sheet: LabSheet, values: np.ndarray) -> np.ndarray:
    """Slopes of straight lines through the logarithms of values over those of the speeds."""
    return np.array([
        np.polyfit(np.log(sheet.speeds), np.log(column), 1)[0]
        if np.isfinite(column).all() else math.nan
        for column in values.T
    ])  # fmt: skip


def _exponent(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.3f}"


def on_exponents(sheet: LabSheet) -> str:
    """Which exponents theory predicts, and why others are computed."""
    scales, law = other_scales(sheet.chain), "proportional to v^(6/5)"
    height = f" With the height h, v² = 2 g h halves it: {EXPONENT_OF_FORCES / 2:.1f}."
    if not scales:
        return (
            f"All contacts of this row follow Hertz's law without other scales of force or "
            f"length. Every force is therefore {law}, and every time to v^(-1/5).{height}"
        )
    others = [
        f"{_at(place)} ({found:.3f})"
        for place, found in zip(sheet.places, fitted_exponents(sheet, sheet.forces), strict=True)
        if not abs(found - EXPONENT_OF_FORCES) <= SEEN
    ]
    first = (f"Forces are exactly {law} only if all contacts follow Hertz's law and there is no "
             f"other scale of force or length. Here, {listed(scales)}.")  # fmt: skip
    if not others:
        return f"{first} The computed exponents are nevertheless 1.200 at all sensors.{height}"
    return (f"{first} The computed exponent differs from 1.200 {listed(others)}, and it may "
            f"change with the speed: see the table.{height}")  # fmt: skip


def _at(place: str) -> str:
    return "on the wall" if place == WALL else f"in {place}"


def travel(sheet: LabSheet) -> Table | None:
    """Speeds of the pulse between successive sensors; None if no distance is known."""
    pairs = [
        (i, j, distance)
        for i, j in pairwise(range(len(sheet.places)))
        if (distance := _distance(sheet.chain, sheet.places[i], sheet.places[j])) is not None
    ]
    if not pairs:
        return None
    heads = ("v [mm/s]", *(f"{sheet.places[i]} to {sheet.places[j]} [m/s]" for i, j, _ in pairs))
    rows = tuple(
        (f"{1e3 * speed:.1f}",
         *(f"{abs(distance / (times[j] - times[i])):.4g}" for i, j, distance in pairs))
        for speed, times in zip(sheet.speeds, sheet.times, strict=True)
    )  # fmt: skip
    return Table("Speed of the pulse", heads, rows)


def _distance(chain: Chain, first: str, second: str) -> float | None:
    """Distance between the centres of two balls, or to the wall or the face of the cap in front."""
    radii = chain.face_radii
    ends = []
    for place in (first, second):
        k = (
            chain.beads - (chain.cap is not None)
            if place == WALL
            else bead_number(chain, place) - 1
        )
        ends.append(k)
    one, other = min(ends), max(ends)
    between = radii[one:other].copy()
    if not np.isfinite(between).all() or one == other:
        return None
    whole = 2.0 * between.sum() - between[0] + chain.gaps[one:other].sum()
    if other == chain.beads - (chain.cap is not None):
        return float(whole)
    return float(whole + radii[other]) if np.isfinite(radii[other]) else None


def on_travel(sheet: LabSheet) -> str:
    """How the travel times depend on the speed."""
    text = (f"In contacts that follow Hertz's law, times are proportional to "
            f"v^({EXPONENT_OF_TIMES:g}), so that a stronger pulse is faster.")  # fmt: skip
    found = [
        f"{one} to {other}: {_exponent(float(slope))}"
        for (one, other), slope in zip(
            pairwise(sheet.places), fitted_exponents(sheet, np.abs(np.diff(sheet.times))),
            strict=True,
        )
    ]  # fmt: skip
    return f"{text} Exponents of the predicted times: {'; '.join(found)}." if found else text


def on_errors(sheet: LabSheet) -> str:
    """The error of forces from an error of the height or speed."""
    what, power = ("speed", 1.0) if sheet.heights is None else ("height", 0.5)
    found = [
        f"{100.0 * ERROR * power * slope:.1f}% ({place})"
        for place, slope in zip(sheet.places, fitted_exponents(sheet, sheet.forces), strict=True)
        if math.isfinite(slope)
    ]
    return f"An error of {100.0 * ERROR:g}% of the {what} changes the force by {listed(found)}."


def causes(sheet: LabSheet) -> Table | None:
    """Forces with a loss or gaps at the middle speed, relative to the predicted ones."""
    chain, middle = sheet.chain, len(sheet.speeds) // 2
    if not chain.lossless or chain.gaps.any():
        return None
    rows = []
    for name, change in CAUSES.items():
        try:
            changed = chain.replace(**change)
            with ignore_warnings():
                found = lab_sheet(changed, sensors=sheet.places, speeds=sheet.speeds[middle - 1 :
                                  middle + 1].tolist())  # fmt: skip
        except (InputError, SimulationError):
            continue
        ratios = found.forces[-1] / sheet.forces[middle]
        rows.append((name, *(f"{100.0 * each:.1f}%" for each in ratios)))
    if not rows:
        return None
    caption = f"Forces at {1e3 * sheet.speeds[middle]:.4g} mm/s, relative to the prediction, with"
    return Table(caption, ("cause", *sheet.places), tuple(rows))
