"""The answers for the teacher: exponents, speed of the pulse, losses and gaps."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from ..chain.bead_names import bead_number
from ..chain.chain import Chain
from ..chain.hertz_ratios import scale_free_loss
from ..chain.laws.restitution import Restitution
from ..chain.modifications import with_one_loss
from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings
from ..representation import listed
from .row import at_place, names, place_in_words
from .sheet import WALL, LabSheet, lab_sheet
from .similarity import EXPONENT_OF_FORCES, other_scales

# Differences of exponents that are shown with three decimals.
SEEN: Final = 5e-4
# Relative error of the height or speed, and causes of differences, in the answers.
ERROR: Final = 0.05
NO_GAPS: Final = (
    "The effect of gaps is not computed: the balls rest on each other, and a static force closes "
    "the contacts."
)
RESTITUTIONS: Final = (0.95, 0.9)
GAP: Final = 1e-5


class Table(NamedTuple):
    """A table of texts with a caption, and notes below it."""

    caption: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()


def exponents(sheet: LabSheet) -> Table:
    """Exponents of the forces between successive speeds, and of all speeds."""
    heads = ("sensor", *(f"{1e3 * a:.1f} to {1e3 * b:.1f} mm/s" for a, b in pairwise(sheet.speeds)),
             "all speeds")  # fmt: skip
    rows = tuple(
        (place, *map(_exponent, steps), _exponent(float(overall)))
        for place, steps, overall in zip(
            names(sheet), sheet.exponents.T, fitted_exponents(sheet, sheet.forces), strict=True
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
    height = (f" As a function of the height h, with v² = 2gh, Hertz's exponent is "
              f"{EXPONENT_OF_FORCES / 2:.1f}.")  # fmt: skip
    if not scales:
        lossy = (
            " This includes the loss: the coefficient of restitution of its law does not depend on "
            "the speed, so that all forces, those of the loss included, are proportional to "
            "v^(6/5). A loss that depends on the speed, such as a viscoelastic one, would "
            "change the exponent."
        ) if scale_free_loss(sheet.chain) else ""  # fmt: skip
        return (
            f"All contacts of this row follow Hertz's law without other scales of force or "
            f"length. Every force is therefore {law}, and every time to v^(-1/5).{lossy}{height}"
        )
    others = [
        f"{at_place(sheet.chain, place)} ({found:.3f})"
        for place, found in zip(sheet.places, fitted_exponents(sheet, sheet.forces), strict=True)
        if not abs(found - EXPONENT_OF_FORCES) <= SEEN
    ]
    first = (f"Forces are exactly {law} only if all contacts follow Hertz's law and there is no "
             f"other scale of force or length. Here, {listed(scales)}.")  # fmt: skip
    if not others:
        return f"{first} The computed exponents are nevertheless 1.200 at all sensors.{height}"
    return (f"{first} The computed exponent differs from 1.200 {listed(others)}, and it may "
            f"change with the speed: see the table.{height}")  # fmt: skip


def travel(sheet: LabSheet) -> Table | None:
    """Speeds of the pulse between successive balls with sensors; None without two of them."""
    pairs = [
        (i, j, _distance(sheet.chain, sheet.places[i], sheet.places[j]))
        for i, j in pairwise(balls_with_sensors(sheet))
    ]
    if not pairs:
        return None
    called = names(sheet)
    heads = ("v [mm/s]", *(f"{called[i]} to {called[j]} [m/s]" for i, j, _ in pairs))
    rows = tuple(
        (f"{1e3 * speed:.1f}",
         *(f"{abs(distance / (times[j] - times[i])):#.4g}".rstrip(".") for i, j, distance in pairs))
        for speed, times in zip(sheet.speeds, sheet.times, strict=True)
    )  # fmt: skip
    caption = "Speed of the pulse: distance of the centres over the time between the largest forces"
    return Table(caption, heads, rows)


def balls_with_sensors(sheet: LabSheet) -> list[int]:
    """Indices of the sensors in balls, without those on walls and in bodies with a flat face."""
    radii = sheet.chain.face_radii
    return [
        j
        for j, place in enumerate(sheet.places)
        if place != WALL and np.isfinite(radii[bead_number(sheet.chain, place) - 1])
    ]


def _distance(chain: Chain, first: str, second: str) -> float:
    """Distance between the centres of two balls."""
    one, other = sorted(bead_number(chain, place) - 1 for place in (first, second))
    between = chain.face_radii[one : other + 1]
    whole = 2.0 * between.sum() - between[0] - between[-1]
    return float(whole + chain.gaps[one:other].sum())


def on_travel(sheet: LabSheet) -> str:
    """How the travel times depend on the speed."""
    text = (
        "In contacts that follow Hertz's law, times are proportional to v^(-1/5), so that a "
        "stronger pulse is faster."
    )
    found = [
        f"{one} to {other}: {_exponent(float(slope))}"
        for (one, other), slope in zip(
            pairwise(names(sheet)), fitted_exponents(sheet, np.abs(np.diff(sheet.times))),
            strict=True,
        )
    ]  # fmt: skip
    if found:
        text = f"{text} Exponents of the predicted times: {'; '.join(found)}."
    return f"{text} {_on_the_wall(sheet)}" if WALL in sheet.places else text


def _on_the_wall(sheet: LabSheet) -> str:
    """Why no speed of the pulse follows from the time at which the force on a wall is largest."""
    place = place_in_words(sheet.chain, WALL)
    cap = " and the cap" if sheet.chain.cap is not None else ""
    return (f"The time to the largest force on {place} includes the compression of {place}{cap}, "
            "so that it does not give the speed of the pulse.")  # fmt: skip


def on_errors(sheet: LabSheet) -> str:
    """The error of forces from an error of the height or speed."""
    what, power = ("speed", 1.0) if sheet.heights is None else ("height", 0.5)
    found = [
        f"{100.0 * ERROR * power * slope:.1f}% ({place})"
        for place, slope in zip(names(sheet), fitted_exponents(sheet, sheet.forces), strict=True)
        if math.isfinite(slope)
    ]
    return f"An error of {100.0 * ERROR:g}% of the {what} changes the force by {listed(found)}."


def causes(sheet: LabSheet) -> Table | None:
    """Forces and delays at the middle speed with other losses and gaps, relative to predictions.

    Notes state why a change is not computed.
    """
    chain, middle = sheet.chain, len(sheet.speeds) // 2
    rows, notes = [], [NO_GAPS] if rests(chain) else []
    for name, changed in _changes(chain).items():
        try:
            with ignore_warnings():
                found = lab_sheet(changed(), sensors=sheet.places, speeds=sheet.speeds[middle - 1 :
                                  middle + 1].tolist())  # fmt: skip
        except (InputError, SimulationError) as error:
            notes.append(f"The effect {name} is not computed: {error}.")
            continue
        ratios = found.forces[-1] / sheet.forces[middle]
        delays = 1e6 * (found.times[-1] - sheet.times[middle])
        rows.append((name, *map(_effect, ratios, delays)))
    if not rows and not notes:
        return None
    caption = (f"Forces at {1e3 * sheet.speeds[middle]:.1f} mm/s, relative to the predictions, and "
               "delays of the first maxima")  # fmt: skip
    return Table(caption, ("change", *names(sheet)), tuple(rows), tuple(notes))


def _changes(chain: Chain) -> dict[str, Callable[[], Chain]]:
    """Functions that return the chain with or without losses or gaps, by names of the changes."""
    found: dict[str, Callable[[], Chain]] = {
        f"with restitution {each:g}": partial(chain.replace, loss=Restitution(each))
        for each in RESTITUTIONS
    }
    if not chain.lossless:
        found = {"without losses": partial(with_one_loss, chain, None)}
    if rests(chain):
        return found
    # A gap behind a striker or moving ball only postpones the impact.
    inside = (np.arange(chain.beads - 1) >= chain.strikers) & (chain.velocities[:-1] == 0.0)
    if chain.gaps[inside].any():
        return found | {"without gaps": partial(_with_gaps, chain, inside, 0.0)}
    name = f"with gaps of {1e6 * GAP:g} µm between the balls"
    between = inside & (np.arange(chain.beads - 1) < chain.beads - 1 - (chain.cap is not None))
    found[name] = partial(_with_gaps, chain, between, GAP)
    if chain.cap is not None:
        found[f"{name}, and before the cap"] = partial(_with_gaps, chain, inside, GAP)
    return found


def rests(chain: Chain) -> bool:
    """Whether a static force closes the contacts, so that there are no gaps."""
    return bool(chain.gravity or chain.precompression > 0.0)


def _with_gaps(chain: Chain, at: np.ndarray, gap: float) -> Chain:
    """The chain with other gaps at some contacts."""
    return chain.replace(gaps=np.where(at, gap, chain.gaps))


def _effect(ratio: float, delay: float) -> str:
    """A ratio of forces and a delay in microseconds."""
    return "not complete" if math.isnan(ratio) else f"{100.0 * ratio:.1f}%, {delay:+.1f} µs"
