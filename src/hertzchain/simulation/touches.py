"""Forces in a sensor at the times at which contacts close whose force begins with a jump.

The force of a dashpot, or of any other viscous force that does not depend on the overlap, begins
with a jump and often falls at once, so that saved times do not show its first maximum.  Before it
closes, an open contact moves with the acceleration of its beads, which determines the time and the
relative velocity at which it closes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..collision import Array
from ..kernels.law_kinds import DAMPED
from .budget import overlaps_of
from .end_forces import is_driven
from .kernel_input import kernel_chain
from .trajectory import Trajectory


class Touches(NamedTuple):
    """Saved times before contacts close, times, forces in the sensor, and bounds of their errors.

    The errors are those of the relative velocity and of the force on the other side.
    """

    before: Array
    times: Array
    forces: Array
    errors: Array

    def inserted(self, times: Array, force: Array) -> tuple[Array, Array]:
        """Saved times and forces, with those at which contacts close."""
        places = self.before.astype(int) + 1
        return np.insert(times, places, self.times), np.insert(force, places, self.forces)

    def at(self, time: float) -> int | None:
        """Number of the contact that closes at a time; `None` if none does."""
        found = np.flatnonzero(self.times == time)
        return int(found[0]) if len(found) else None


def touches_of(run: Trajectory, bead: int, force: Array) -> Touches:
    """The contacts of a bead that close with a jump of their force, in order of time."""
    rows = [row for contact in (bead - 1, bead) for row in _of_contact(run, contact, force)]
    # Two contacts that close in the same interval are each without the other.
    rows.sort(key=lambda row: row[1])
    return Touches(*np.array(rows, float).reshape(-1, 4).T)


def _of_contact(run: Trajectory, contact: int, force: Array) -> list[tuple[float, ...]]:
    chain, times = run.chain, run.times
    law = chain.contact_losses[contact]
    row = law.row(float(chain.contact_exponents[contact]))
    jumps = row.kind == DAMPED and row.overlap_power == 0.0
    if not jumps or chain.contact_stiffness[contact] == 0.0 or is_driven(chain, contact):
        return []
    equation: Any = kernel_chain(chain)
    damping, power = float(equation.damping[contact]), row.speed_power
    net = run.forces[:, :-1] - run.forces[:, 1:] + chain.static_state.body_forces
    overlap = overlaps_of(chain, times, run.positions)[:, contact]
    rate, bend = (
        -np.diff(np.pad(each, ((0, 0), (1, 1))), axis=1)[:, contact]
        for each in (run.velocities, net / chain.masses)
    )
    own = run.forces[:, contact]
    other = force - 0.5 * own
    found: list[tuple[float, ...]] = []
    for i in np.flatnonzero((overlap[:-1] < 0.0) & (overlap[1:] > 0.0) & (own[:-1] == 0.0)):
        discriminant = rate[i] ** 2 - 2.0 * bend[i] * overlap[i]
        if not (discriminant > 0.0 and rate[i] + np.sqrt(discriminant) > 0.0):
            continue
        speed = float(np.sqrt(discriminant))
        wait, step = -2.0 * float(overlap[i]) / (rate[i] + speed), times[i + 1] - times[i]
        if not 0.0 < wait < step:
            continue
        jump = damping * speed**power
        error = 0.5 * abs(jump - damping * abs(float(rate[i])) ** power)
        change = abs(float(other[i + 1] - other[i]))
        height = 0.5 * jump + float(other[i]) + (wait / step) * float(other[i + 1] - other[i])
        found.append((float(i), float(times[i] + wait), height, 0.5 * error + 0.25 * change))
    return found
