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
    """Taper and its parameters, or materials and sizes, or ``"uniform"``."""
    if taper is not None:
        symbols = taper_named(taper).symbols
        values = ", ".join(f"{symbols[name]} = {value:g}" for name, value in parameters)
        return f"{taper}, {values}"
    if not scaled:
        return f"SI, {_composition(radii, materials or ())}"
    return "uniform" if np.all(radii == 1.0) else "free radii"


def _composition(radii: Array, materials: Sequence[Material]) -> str:
    names = dict.fromkeys(each.name for each in materials)
    kinds = " and ".join(names) if len(names) < 3 else f"{len(names)} materials"
    low, high = 1e3 * radii.min(), 1e3 * radii.max()
    sizes = f"R = {low:g} mm" if low == high else f"R = {low:g} .. {high:g} mm"
    return f"{kinds}, {sizes}" if kinds else sizes
