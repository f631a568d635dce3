"""Curves of chains with alternating beads: one for the heavy beads and one for the light ones."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..chain.chain import Chain
from ..chain.repeated_cells import cell_repeats
from ..pulse.pulse import EFFECTIVE_CHAIN, Pulse
from ..pulse.quantities import COLUMN_QUANTITIES

# Labels of filled and of open symbols.
HEAVY_BEADS, LIGHT_BEADS = "heavy beads", "light beads"
# Symbols that can be filled or open, and that of free ends beside them.
FILLABLE: Final = ("o", "s", "^", "v", "D")
END_SYMBOL: Final = "*"
# Smallest number of beads whose alternation is drawn as two curves.
LEAST: Final = 8
# Relative difference of masses that alternate.
SAME: Final = 1e-9


def light_beads(pulse: Pulse, quantity: str) -> NDArray[np.bool_] | None:
    """Which beads are the light ones of alternating beads, behind any strikers, or `None`."""
    chain: Chain = pulse.chain
    masses = chain.masses[chain.strikers :]
    if pulse.method == EFFECTIVE_CHAIN or COLUMN_QUANTITIES[quantity].per != "bead":
        return None
    if len(masses) < LEAST or np.allclose(masses[0], masses[1], rtol=SAME, atol=0.0):
        return None
    if not cell_repeats(2, masses, rtol=SAME):
        return None
    light = np.zeros(chain.beads, bool)
    light[chain.strikers + int(masses[1] < masses[0]) :: 2] = True
    return light
