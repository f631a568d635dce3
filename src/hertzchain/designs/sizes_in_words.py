"""Sizes, parts and order of the balls of a design, in the lines of its summary."""

from __future__ import annotations

import itertools
from math import inf
from typing import TYPE_CHECKING, Final

import numpy as np

from .allowed_sizes import at_bounds
from .size_space import SizeSpace
from .start_rows import ARRIVES

if TYPE_CHECKING:
    from .result import DesignResult

# Factors to the units in which sizes are shown, and the names of these sizes.
SHOWN: Final = {
    "radii": (2e3, "diameters [mm]"), "masses": (1e3, "masses [g]"), "gaps": (1e6, "gaps [um]"),
}  # fmt: skip
# Longer lists of sizes are shortened.
MAX_SIZES: Final = 12
FLAT_STRIKER: Final = "striker with a flat face"


def parts_in_lines(result: DesignResult) -> list[str]:
    """The kinds of balls to buy, with their prices if the catalogue has these."""
    lines, total = [], 0.0
    for (count, name), price in zip(result.parts, result.part_prices, strict=True):
        total += count * price
        shown = f": {count * price:g} ({price:g} each)" if price == price else ""
        lines.append(f"  {count} x {name}{shown}")
    return lines if total != total else [*lines, f"  price of all: {total:g}"]


def sizes_in_lines(result: DesignResult) -> list[str]:
    """Sizes that varied, of all beads or contacts, with the number of equal neighbours."""
    space, chain = result.problem.space, result.chain
    if not isinstance(space, SizeSpace) or not np.isfinite(result.value):
        return []
    lines = []
    for name in dict.fromkeys(block.field for block in space.blocks):
        factor, shown = SHOWN[name] if chain.units == "SI" else (1.0, name)
        values = chain.face_radii if name == "radii" else getattr(chain, name)
        texts = ["flat" if value == inf else f"{factor * value:.4g}" for value in values]
        groups = [(text, len(list(same))) for text, same in itertools.groupby(texts)]
        parts = [f"{count} x {text}" if count > 1 else text for text, count in groups]
        if len(parts) > MAX_SIZES:
            parts = [*parts[: MAX_SIZES // 2], "...", *parts[-(MAX_SIZES // 2) :]]
        lines.append(f"{shown}, from the struck end: {', '.join(parts)}")
    return lines + [f"  {each}" for each in at_bounds(result)]


def order_in_words(result: DesignResult) -> str:
    """Balls from the first to the last, each with the number of equal neighbours."""
    chain, radii = result.chain, result.chain.face_radii
    balls = [FLAT_STRIKER if radius == inf else f"{2e3 * radius:g} mm {kind.name}"
             for radius, kind in zip(radii, chain.materials or (), strict=True)]  # fmt: skip
    if chain.cap is not None:
        balls[-1] = "cap"
    moving = chain.velocities != 0.0
    groups = itertools.groupby(zip(moving.tolist(), balls, strict=True))
    runs = []
    for (arrives, ball), members in groups:
        count = len(list(members))
        runs.append((f"{count} x " if count > 1 else "") + ball + ARRIVES * arrives)
    return ", ".join(runs)
