"""The last bead of a free end, and the velocities of few beads after the impact."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from ..simulation.run import Run

# Largest number of beads whose final velocities are printed.
SHORT: Final = 10
# Part of the largest velocity above which a bead moves.
MOVES: Final = 1e-3


def last_bead_of(run: Run) -> dict[str, float] | None:
    """Velocity and momentum that the leading pulse gives the last bead of a free end."""
    if run.chain.right_wall is not None or not run._reached:
        return None
    # A shaker that does not stop creates no pulse of its own.
    if run.chain.drive is not None and math.isinf(run.chain.drive.end):
        return None
    pulse = run.pulse()
    velocity, momentum = float(pulse.velocity[-1]), float(pulse.momentum[-1])
    return None if math.isnan(velocity) else {"velocity": velocity, "momentum": momentum}


def last_bead_line(run: Run, last: dict[str, float]) -> str:
    """Velocity and momentum of the last bead of a free end."""
    from ..chain.bead_names import bead_label
    from ..representation import measure

    velocity = measure(last["velocity"], "m/s", run.chain.units, 5)
    momentum = measure(last["momentum"], "N s", run.chain.units)
    return (
        f"{bead_label(run.chain, run.chain.beads)} at the free end: velocity {velocity}, momentum "
        f"{momentum} in the leading pulse"
    )


def final_velocities_line(run: Run) -> str | None:
    """Velocities after the impact of few beads, if more than one of them moves, or of a cap."""
    from ..chain.bead_names import bead_label
    from ..representation import measure

    velocities, chain = run.state.velocities, run.chain
    moving = abs(velocities) > MOVES * abs(velocities).max()
    over = not (len(run.closed_contacts) or run._unfinished)
    if not over or moving.sum() < 2:
        return None
    if chain.beads > SHORT:
        # The velocity of a body behind the row is that after the impact, not that in the pulse.
        if chain.cap is None or chain.right_wall is not None:
            return None
        velocity = measure(float(velocities[-1]), "m/s", chain.units, 5)
        return f"{bead_label(chain, chain.beads)} at the end of the run: velocity {velocity}"
    unit = " m/s" if chain.units == "SI" else ""
    last = abs(velocities).max()
    # Velocities have the decimals of the fastest bead, of which five digits are shown.
    decimals = max(0, 4 - math.floor(math.log10(last)))
    shown = ", ".join(f"{each:z.{decimals}f}" for each in velocities)
    return (
        f"velocities at the end of the run, from {bead_label(chain, 1)} to "
        f"{bead_label(chain, chain.beads)}: {shown}{unit}"
    )
