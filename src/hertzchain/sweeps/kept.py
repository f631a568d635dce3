"""Quantities that sweeps keep, by the number of their values at a point."""

from __future__ import annotations

from typing import Final

from ..pulse.quantities import LARGEST_QUANTITIES, QUANTITIES, WALL_QUANTITIES, Quantity

# One value per bead or contact, and one value per run.
PER_PLACE: Final[dict[str, Quantity]] = {
    **QUANTITIES,
    **{name: each for name, each in LARGEST_QUANTITIES.items() if each.per == "contact"},
}
PER_RUN: Final[dict[str, Quantity]] = {
    **WALL_QUANTITIES,
    **{name: each for name, each in LARGEST_QUANTITIES.items() if each.per == "run"},
}
KEPT: Final[dict[str, Quantity]] = PER_PLACE | PER_RUN
# Quantities that only the method `simulate` gives.
OF_RUNS: Final = (*WALL_QUANTITIES, *LARGEST_QUANTITIES)
