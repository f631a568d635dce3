"""Short description of the beads of a chain, for titles of tables and figures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..collision import Array
from .materials import Material
from .tapers import taper_named


def beads_description(
    radii: Array,
    materials: Sequence[Material] | None,
    taper: str | None,
    parameters: Sequence[tuple[str, float]],
    *,
    scaled: bool,
) -> str:
    """Such as ``uniform, 20 beads``, or ``20 steel-52100 beads, diameter 10 mm``."""
    beads = f"{len(radii)} beads"
    if taper is not None:
        symbols = taper_named(taper).symbols
        values = ", ".join(f"{symbols[name]} = {value:g}" for name, value in parameters)
        return f"{taper}, {values}, {beads}"
    if scaled:
        return f"{'uniform' if np.all(radii == 1.0) else 'free radii'}, {beads}"
    names = list(dict.fromkeys(each.name for each in materials or ()))
    diameters = "diameter" if np.ptp(radii) == 0.0 else "diameters"
    counted = beads_of(len(radii), "beads", names or ["SI"])
    return f"{counted}, {diameters} {sizes_in_words(radii)}"


def beads_of(count: int, noun: str, materials: Sequence[str]) -> str:
    """Such as ``20 brass balls``, ``20 balls of brass and glass``, ``20 balls of 3 materials``."""
    if len(materials) == 1:
        return f"{count} {materials[0]} {noun}"
    few = " and ".join(materials) if len(materials) == 2 else f"{len(materials)} materials"
    return f"{count} {noun} of {few}"


def sizes_in_words(radii: Array) -> str:
    """Diameter, or those of both ends of a taper, or the smallest and the largest."""
    low, high = 2e3 * radii.min(), 2e3 * radii.max()
    if low == high:
        return f"{low:.4g} mm"
    first, last = (high, low) if np.all(np.diff(radii) <= 0.0) else (low, high)
    return f"{first:.4g} mm to {last:.4g} mm"
