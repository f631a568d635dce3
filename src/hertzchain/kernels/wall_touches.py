"""Count of the touches of walls; a contact that opens and closes again is another touch."""

from __future__ import annotations

from .compilation import compiled
from .forces import LEFT_IMPULSE
from .state_layout import TOUCHES, TOUCHING


@compiled
def count_touches(beads, rates, walls):
    """Count walls that are touched now and were not before the step."""
    for side in range(2):
        pressed = 1.0 if rates[2 * beads + LEFT_IMPULSE + side] != 0.0 else 0.0
        if pressed > walls[TOUCHING, side]:
            walls[TOUCHES, side] += 1.0
        walls[TOUCHING, side] = pressed
