"""Check the number of beads, the radii and the exponent of the contact force."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError, InputWarning, short_repr, warn_user
from ..units import STANDARD_GRAVITY, unit_of_stiffness
from ..validation.memory import check_memory
from ..validation.numbers import has_unit, number, per_bead_array, real_numbers, whole_number

# Memory of a simulation per bead: sixteen stages and the state, at 8 bytes per number.
BYTES_PER_BEAD: Final = 400
# With a larger exponent, a contact resembles a rigid wall and the steps become too small.
MAX_EXPONENT: Final = 50.0
# Limits of the largest velocity, scaled or in m/s, if it is not 0: the energy and the forces of an
# impact must be representable.
MIN_VELOCITY: Final = 1e-100
MAX_VELOCITY: Final = 1e100
# Largest gap, scaled or in m: at larger distances the rounding of positions is noticeable in the
# overlaps of an impact, whose unit is 1.
MAX_GAP: Final = 1e8
GAP_HINT: Final = (
    "a gap is a free distance (precompression presses bodies together), and larger distances are "
    "rounded too coarsely for the overlaps of an impact"
)
# SI radii above this value [m], and limits from it on, cause a warning, because they are probably
# in millimetres; so do limits above this multiple of the largest bead.
LARGE_RADIUS: Final = 1.0
LARGE_RATIO: Final = 100.0
# SI radii below this value [m] cause a warning: their contacts adhere, or the unit is wrong.
SMALL_RADIUS: Final = 5e-7
# SI gravity above this value [m/s^2], which is probably in mm/s^2 or cm/s^2.
LARGE_GRAVITY: Final = 500.0
# A plain number for the mass of a cap from this value on [kg] is probably in grams, if it is also
# above this multiple of the heaviest ball; real caps of this mass are heavier than rows of balls.
HEAVY_CAP: Final = (1.0, 30.0)
# A plain number for the stiffness of a spring or contact is probably in kN/mm or N/mm if that of a
# ball of this radius [m] and modulus [Pa], which is softer than foam, would be larger.
SOFT_BALL: Final = (0.01, 1e5)
# First radius of a scaled chain; radii in metres are below, and would give wrong times.
FIRST_RADIUS: Final = (0.02, 50.0)


def checked_beads(beads: int, least: int = 1) -> int:
    """Check a number of beads: whole, not too small, and not more than fit in memory."""
    count = whole_number("beads", beads, least=least)
    check_memory(f"{count} beads", count * BYTES_PER_BEAD, "use fewer beads")
    return count


def checked_exponent(exponent: float) -> float:
    """Check an exponent of the contact force: above 1 and at most 50."""
    return number(
        "exponent of the contact force", exponent, above=1.0, most=MAX_EXPONENT,
        hint="Hertz contacts have 1.5",
    )  # fmt: skip


def checked_wall_exponent(
    exponent: float, what: str = "exponent of the contact with a wall"
) -> float:
    """Check an exponent of the contact with a wall, or another one that may be a linear spring."""
    return number(
        what, exponent, least=1.0, most=MAX_EXPONENT,
        hint="Hertz contacts have 1.5, and linear springs 1",
    )  # fmt: skip


def checked_radii(radii: ArrayLike) -> Array:
    """Check a list of radii, positive and finite, and return a copy."""
    values = real_numbers("radius", radii, "bead")
    if values.ndim != 1 or len(values) == 0:
        raise InputError(
            f"radii must be a list of numbers, one for each bead, got {short_repr(radii)}"
        )
    checked_beads(len(values))
    good = (values > 0.0) & (values < math.inf)
    if not good.all():
        k = int(np.argmin(good))
        raise InputError(
            f"radius of bead {k + 1} is {values[k]:g}: radii must be positive and finite"
        )
    return values


def checked_sizes(what: str, given: ArrayLike | Any, unit: str | None = "m") -> Array:
    """Check one positive radius or diameter, or several; messages show them as typed."""
    if isinstance(given, str) and ":" in given:
        ends = "first_diameter and last_diameter" if what == "diameter" else "first and last"
        raise InputError(f"{what} {given!r} is a range; for a taper between two sizes, give {ends}")
    values = real_numbers(what, given, "bead", unit=unit)
    if values.ndim == 0:
        number(what, given, unit=unit, above=0.0)
    elif values.ndim == 1:
        per_bead_array(what, given, len(values), "bead", unit=unit, above=0.0)
    return values


def scaled_radii(radii: ArrayLike) -> Array:
    """Check radii of a scaled chain, whose cubes must be representable; return a copy."""
    values = real_numbers("radius", radii, "bead")
    # Most chains are far from the limits; the rest is for the messages.
    if values.ndim == 1 and values.size and values.min() > 1e-100 and values.max() < 1e100:
        checked_beads(len(values))
        return values
    with np.errstate(over="ignore", under="ignore"):
        masses = values**3
    good = (masses >= np.finfo(float).tiny) & (masses < math.inf)
    if values.ndim == 1 and not good.all():
        k = int(np.argmin(good))
        if not values[k] < 0.0:
            raise InputError(
                f"bead {k + 1} has {values[k]:g} times the radius of the first bead; masses can be "
                "represented for ratios from 1e-102 to 1e102, so use fewer beads or a weaker taper"
            )
    return checked_radii(values)


def check_unit_of_length(first: float, *, strikers: int) -> None:
    """Raise `InputError` if the first radius of a scaled chain is probably in metres."""
    low, high = FIRST_RADIUS
    if not low <= first <= high:
        which = " after the strikers" if strikers else ""
        raise InputError(
            f"the first radius{which} of a scaled chain must be 1, or from {low:g} to {high:g} if "
            f"another bead is the unit of length, got {first:g}; Chain.from_radii accepts radii in "
            "any unit"
        )


def check_velocities(values: Array) -> None:
    """Raise `InputError` if the energy of an impact cannot be represented."""
    speeds = np.abs(values)
    if speeds.max(initial=0.0) > MAX_VELOCITY:
        k = int(np.argmax(speeds))
        raise InputError(
            f"velocity of bead {k + 1} is {values[k]:g}: it must be from {-MAX_VELOCITY:g} to "
            f"{MAX_VELOCITY:g}; check its unit"
        )
    if 0.0 < speeds.max(initial=0.0) < MIN_VELOCITY:
        k = int(np.argmax(speeds))
        raise InputError(
            f"velocity of bead {k + 1}, the fastest one, is {values[k]:g}: it must be 0, or at "
            f"least {MIN_VELOCITY:g} in magnitude; check its unit"
        )


def positive_derived(what: str, place: str, values: Array) -> Array:
    """Read-only values computed from radii and materials, if positive and finite."""
    good = (values > 0.0) & np.isfinite(values)
    if not good.all():
        k = int(np.argmin(good))
        raise InputError(
            f"{place} {k + 1} has {what} {values[k]:g}, computed from radius and material; check "
            "their units (to model a rigid body, use Wall.rigid())"
        )
    values.setflags(write=False)
    return values


def warn_unusual_radius(radii: Array) -> None:
    """Warn about radii in metres that are probably in another unit."""
    if radii.min() < SMALL_RADIUS:
        k = int(np.argmin(radii))
        warn_user(
            f"bead {k + 1} has a diameter of {2e9 * float(radii[k]):.3g} nm; contacts of beads "
            "below about 1 um adhere, which is not modelled: check the unit",
            InputWarning,
        )
    if radii.max() > LARGE_RADIUS:
        k = int(np.argmax(radii))
        diameter, count = 2.0 * float(radii[k]), int((radii == radii[k]).sum())
        # Strikers change the numbers of equal balls: the same words appear only once.
        which = f"bead {k + 1} has" if count == 1 else "several beads have"
        warn_user(
            f"{which} a diameter of {diameter:g} m; if millimetres are meant, write the "
            f"diameter as '{diameter:g} mm' or the radius as '{0.5 * diameter:g} mm', or divide by "
            "1000",
            InputWarning,
        )


def warn_heavy_cap(given: Any, mass: float, balls: Array) -> None:
    """Warn about the mass of a cap [kg] that was given without a unit and is probably in grams."""
    least, times = HEAVY_CAP
    if not has_unit(given) and mass >= max(least, times * float(balls.max())):
        warn_user(
            f"the cap has {mass / float(balls.max()):,.0f} times the mass of the heaviest ball, "
            f"and a mass of {mass:g} without a unit is in kg; if grams are meant, write "
            f"mass='{mass:g} g', otherwise mass='{mass:g} kg'",
            InputWarning,
        )


def warn_soft(what: str, stiffness: float, exponent: float) -> None:
    """Warn about a stiffness that was given without a unit and is probably not in N/m^p."""
    radius, modulus = SOFT_BALL
    if stiffness >= modulus * radius ** (2.0 - exponent):
        return
    unit = unit_of_stiffness(exponent)
    advice = "check its unit"
    if exponent in (1.0, HERTZ_EXPONENT):
        others = ("kN/mm", "N/mm") if exponent == 1.0 else ("N/mm^1.5",)
        meant = " or ".join(f"'{stiffness:g} {each}'" for each in others)
        advice = f"if another unit is meant, write {meant}, otherwise '{stiffness:g} {unit}'"
    warn_user(
        f"{what} is {stiffness:g}, which without a unit is in {unit}, softer than foam; {advice}",
        InputWarning,
    )


def checked_gaps(
    gaps: ArrayLike, contacts: int, unit: str | None, strikers: int, cap: object
) -> Array:
    """Check the gaps between neighbouring beads."""
    # A chain file adds strikers after its gaps.
    others = "strikers included, but without" if strikers else "without strikers and"
    values = per_bead_array(
        "gap", gaps, contacts, "contact", unit=unit, least=0.0,
        counted=f" of two beads, {others} walls{', but with the cap' * (cap is not None)}",
    )  # fmt: skip
    if (c := int(np.argmax(np.append(values, 0.0)))) < contacts:
        number(f"gap of contact {c + 1}", values.item(c), most=MAX_GAP, hint=GAP_HINT)
    return values


def warn_large_gap(gaps: Array, of_walls: Sequence[float], radii: Array) -> None:
    """Warn about gaps between beads and of both walls in metres that are probably in another unit.

    Those of the walls of a falling chain, which may begin far from the wall, are given as 0.
    """
    names = [*(f"gap {k + 1}" for k in range(len(gaps))), "the gap of the left wall",
             "the gap of the right wall"]  # fmt: skip
    distances, length = [*gaps, *of_walls], 2.0 * float(radii.sum())
    k = int(np.argmax(distances))
    if distances[k] > length:
        warn_user(
            f"{names[k]} is {distances[k]:g} m, but the beads are only {length:.3g} m long in "
            "total; gaps are in metres, so check their unit",
            InputWarning,
        )


def warn_large_gravity(gravity: float) -> None:
    """Warn about a gravity that is probably in mm/s^2 or cm/s^2."""
    if abs(gravity) > LARGE_GRAVITY:
        times = abs(gravity) / STANDARD_GRAVITY
        warn_user(
            f"the gravity is {gravity:g} m/s^2, {times:.0f} times that of the earth; if "
            f"millimetres are meant, write '{gravity:g} mm/s^2'",
            InputWarning,
        )


def warn_large_limit(low: float, high: float, radii: Array) -> None:
    """Warn about limits in metres, for beads of these radii, that are probably in millimetres."""
    if high >= min(LARGE_RADIUS, LARGE_RATIO * radii.max()):
        warn_user(
            f"the radii vary from {low:g} m to {high:g} m; if millimetres are meant, write "
            f"'{high:g} mm', or divide by 1000",
            InputWarning,
        )
