"""The leading pulse of a free chain, integrated in a window that moves with it."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ..collision import Array
from .equation import Equation
from .record import Block, Record, kept_of, load_rows, room_for

# Settings of the kernel.  With them, a gradient changes by less than its error if masses and
# stiffness of neighbours differ by at most a factor exp(SMOOTH).
SETTINGS: Final = (8.0, 4.0, 5.0, 3.0, 0.1, 1e-9)
SMOOTH: Final = 0.5
# Pulses of smaller exponents are longer.
NARROW: Final = 1.4
# Steps per bead, and at the impact; if more are needed, the window is not used.
PER_BEAD, MORE = 24, 256


def follow_pulse(equation: Equation, targets: Array, rtol: float) -> Record | None:
    """Integrate until all events are found; `None` if the window is not large enough."""
    from ..kernels import adjoint_layout as layout
    from ..kernels import adjoint_window

    kernel: Any = adjoint_window
    beads = equation.beads
    if not (len(targets) and _is_smooth(equation)):
        return None
    clock, counts = np.zeros(layout.CLOCK), np.zeros(layout.COUNTS, np.int64)
    clock[layout.STEP], clock[layout.MOST] = equation.first_step, 4.0
    counts[layout.HIGH] = min(beads, 2 + int(SETTINGS[2]))
    found = np.full((len(targets), layout.FOUND), -1.0)
    rows, events, room = load_rows(equation), load_rows(equation), room_for(equation)
    size = PER_BEAD * (int(targets[:, 1].max()) + 1) + MORE
    positions, velocities = np.empty((size, beads)), np.empty((size, beads))
    lengths, windows = np.empty(size), np.empty((size, 2), np.int64)
    kept = np.empty((size, equation.stages, beads + 1))
    candidates, end = np.empty((0, 2)), kept_of(equation, equation.overlaps)
    status = kernel.follow(
        rows, events, beads, clock, counts, rtol, 2 * size, np.array(SETTINGS), equation.hertz,
        targets, found, candidates, positions, velocities, lengths, windows, kept, room, end,
    )  # fmt: skip
    if status != layout.ALL_FOUND:
        return None
    n = int(counts[layout.STEPS])
    block = Block(
        0, 0.0, positions[:n], velocities[:n], lengths[:n], windows[:n], kept[:n], candidates
    )
    moved = [rows[at + 1 : at + 1 + beads].copy() for at in (layout.X, layout.V)]
    return Record(equation, targets, found, [block], float(clock[layout.TIME]), *moved)


def _is_smooth(equation: Equation) -> bool:
    """Whether the window has been found to be large enough for chains of this kind."""
    if (
        not (equation.has_free_pulse and equation.velocities[0] > 0.0)
        or equation.velocities[1:].any()
    ):
        return False
    if float(equation.exponents[1:-1].min()) < NARROW:
        return False
    steps = (np.diff(np.log(each)) for each in (equation.masses, equation.stiffness[1:-1]))
    return all(not len(step) or float(np.abs(step).max()) <= SMOOTH for step in steps)
