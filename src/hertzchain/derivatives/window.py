"""The leading pulse of a free chain, integrated in a window that moves with it."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ..collision import Array
from .equation import Equation
from .record import Block, Record, load_rows

# Settings of the kernel.  With them, a gradient changes by less than its error if masses and
# stiffness of neighbours differ by at most a factor exp(SMOOTH).
SETTINGS: Final = (8.0, 4.0, 5.0, 3.0, 0.1, 1e-9, 0.5, 1e-5)
SMOOTH: Final = 0.4
# More beads behind open contacts, and no releases: steps become short before contacts open.
OTHER_SETTINGS: Final = (9.0, 7.0, 5.0, *SETTINGS[3:6], 0.0, SETTINGS[7])
# Pulses of smaller exponents are longer.
NARROW: Final = 1.4
# Steps per bead, and at the impact; if more are needed, the window is not used.
PER_BEAD, MORE = 24, 256


def follow_pulse(
    equation: Equation, targets: Array, rtol: float, *, other: bool = False
) -> Record | None:
    """Integrate until all events are found; `None` if the window is not large enough.

    Another run, with ``OTHER_SETTINGS``, shows the errors of these settings.
    """
    from ..kernels import adjoint_layout as layout
    from ..kernels import adjoint_window

    kernel: Any = adjoint_window
    beads = equation.beads
    if not (len(targets) and _is_smooth(equation)):
        return None
    clock, counts = np.zeros(layout.CLOCK), np.zeros(layout.COUNTS, np.int64)
    clock[layout.STEP], clock[layout.MOST] = equation.first_step, 4.0
    found = np.full((len(targets), layout.FOUND), -1.0)
    rows, events = load_rows(equation), load_rows(equation)
    contacts = kernel.WINDOW + 1
    room = np.zeros((equation.stages + 1, contacts))
    located = np.zeros((len(targets), len(room) + layout.EVENT_ROWS, max(contacts, beads)))
    size = PER_BEAD * (int(targets[:, 1].max()) + 1) + MORE
    lengths, windows = np.empty(size), np.empty((size, 2), np.int64)
    kept = np.empty((size + 1, equation.stages, contacts))
    releases = np.empty((2 * beads, layout.RELEASE))
    settings = np.array(OTHER_SETTINGS if other else SETTINGS)
    status = kernel.follow(
        rows, events, beads, clock, counts, rtol, 2 * size, settings, equation.hertz, targets,
        found, located, np.empty((0, 2)), lengths, windows, kept, releases, room,
    )  # fmt: skip
    if status != layout.ALL_FOUND:
        return None
    n, nothing = int(counts[layout.STEPS]), np.empty((0, 0))
    block = Block(
        0, 0.0, nothing, nothing, lengths[:n], windows[:n], kept[:n], nothing,
        releases[: counts[layout.RELEASES]],
    )  # fmt: skip
    moved = [rows[at + 1 : at + 1 + beads].copy() for at in (layout.X, layout.V)]
    return Record(equation, targets, found, located, [block], float(clock[layout.TIME]), *moved)


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
