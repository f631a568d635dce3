"""Derivatives of a quantity by all numbers of the equation of motion, in one backward pass."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..collision import Array
from .equation import Equation
from .record import Record, load_rows


@dataclass(eq=False)
class Slopes:
    """Derivatives with respect to the numbers of the equation of motion."""

    masses: Array
    stiffness: Array
    overlaps: Array
    velocities: Array
    body: Array
    damping: Array

    def copy(self) -> Slopes:
        """Independent slopes of the same values."""
        return Slopes(*(each.copy() for each in vars(self).values()))

    @classmethod
    def zero(cls, beads: int) -> Slopes:
        """No dependence."""
        return cls(*(np.zeros(n) for n in (beads, beads + 1, beads + 1, beads, beads, beads + 1)))

    def add_impulses(
        self, equation: Equation, positions: Array, released: Array, by_velocity: Array,
        gauge: Array, sign: float,
    ) -> Array:  # fmt: skip
        """Add derivatives through the impulses of the damping; return those by the positions.

        The kernels integrate the velocities less (``sign`` -1) these impulses over the masses.
        Impulses of contacts contain them with the weights ``gauge``.
        """
        d = np.maximum(equation.overlaps_at(positions), 0.0)
        per_mass = by_velocity / equation.masses
        share = sign * (np.diff(np.pad(per_mass, 1)) + gauge) * (d > 0.0) * (1.0 - released)
        powers = equation.overlap_powers + 1.0
        weight = d**powers / powers
        impulses = equation.damping * weight * (1.0 - released)
        by_overlap = share * equation.damping * d**equation.overlap_powers
        self.overlaps += by_overlap
        self.damping += share * weight
        self.masses += sign * per_mass / equation.masses * np.diff(impulses)
        return np.diff(by_overlap)


@dataclass(eq=False)
class Place:
    """A state within a step: its number, length of its part, window, and overlaps at stages."""

    step: int
    length: float
    low: int
    high: int
    kept: Array
    time: float
    positions: Array
    velocities: Array
    accelerations: Array
    # Derivatives of the quantity by this state.
    by_position: Array
    by_velocity: Array


@dataclass(eq=False)
class Dependence:
    """How a quantity depends on states of the run, on impulses and directly on parameters."""

    value: float
    places: list[Place]
    direct: Slopes
    # Weight of each contact in an impulse, and number of steps that it includes.
    gauge: Array = field(default_factory=lambda: np.zeros(0))
    last: int = 0


def backward_pass(record: Record, dependence: Dependence) -> Slopes:
    """Derivatives of a quantity, backward from the last state on which it depends."""
    from ..kernels import adjoint_layout as layout
    from ..kernels import adjoint_reverse

    kernel: Any = adjoint_reverse
    equation, beads = record.equation, record.equation.beads
    rows, hertz = load_rows(equation), equation.hertz
    nothing, direct = np.zeros(beads + 1), dependence.direct.copy()
    damped = hertz is None
    gauge = dependence.gauge if len(dependence.gauge) else nothing
    # A window may end beyond the last contact.
    unused = np.zeros(beads + 1 + layout.SPACE)
    weights = dependence.gauge if len(dependence.gauge) else unused

    def row(at: int, count: int = beads) -> Array:
        return rows[at : at + count]

    starts: dict[int, list[tuple[Array, Array]]] = {}
    for place in dependence.places:
        row(layout.LX)[:], row(layout.LV)[:] = place.by_position, place.by_velocity
        if damped:
            row(layout.LX)[:] += direct.add_impulses(
                equation, place.positions, place.kept[layout.KEPT_RELEASED], place.by_velocity,
                nothing, 1.0,
            )  # fmt: skip
        kernel.reverse_step(
            rows, place.low, place.high, place.length, hertz, place.kept, unused, 0.0
        )
        state = row(layout.LX).copy(), row(layout.LV).copy()
        starts.setdefault(place.step, []).append(state)
    row(layout.LX)[:] = row(layout.LV)[:] = 0.0
    stops = sorted({*starts, dependence.last, 0}, reverse=True)
    step = stops[0]
    for stop in stops:
        on = 1.0 if stop < dependence.last else 0.0
        while step > stop:
            step = _reverse_block(record, rows, step, stop, weights, on)
        if damped and stop == dependence.last > 0:
            row(layout.LX)[:] += direct.add_impulses(
                equation, *record.state_after(stop), np.zeros(beads), gauge, 1.0
            )
        for by_position, by_velocity in starts.get(stop, []):
            row(layout.LX)[:] += by_position
            row(layout.LV)[:] += by_velocity
    if damped and record.steps:
        released = record.blocks[0].kept[0, layout.KEPT_RELEASED]
        own = gauge if dependence.last else nothing
        direct.add_impulses(equation, np.zeros(beads), released, row(layout.LV), own, -1.0)
    by_velocity = row(layout.LV) + _times_of_entry(record) * row(layout.LX)
    return Slopes(
        direct.masses + row(layout.BY_MASS) / equation.masses,
        direct.stiffness + row(layout.BY_STIFFNESS, beads + 1),
        direct.overlaps + row(layout.BY_OVERLAP, beads + 1),
        direct.velocities + by_velocity,
        direct.body + row(layout.BY_BODY) * equation.masses,
        direct.damping + (row(layout.BY_DAMPING, beads + 1) if damped else 0.0),
    )


def _reverse_block(
    record: Record, rows: Array, step: int, stop: int, weights: Array, on: float
) -> int:
    """Reverse the steps of a block, at most down to ``stop``; returns the first one."""
    from ..kernels import adjoint_reverse

    kernel: Any = adjoint_reverse
    block, _ = record.block_of(step - 1)
    to = max(stop, block.first)
    steps = (rows, step - block.first, to - block.first, block.lengths, block.windows,
             record.equation.hertz)  # fmt: skip
    if record.moves:
        kernel.reverse_window(*steps, block.kept, block.releases, weights)
    else:
        kernel.reverse(*steps, block.kept, weights, on)
    return to


def _times_of_entry(record: Record) -> Array:
    """Times at which the beads enter the window; until then they are in free flight."""
    beads, high = record.equation.beads, 0
    times = np.full(beads, record.time)
    for block in record.blocks:
        now = min(beads, int(block.windows[-1, 1]))
        if now > high:
            starts = block.start + np.concatenate(([0.0], np.cumsum(block.lengths)[:-1]))
            new = np.arange(high, now)
            times[new] = starts[np.searchsorted(block.windows[:, 1], new, side="right")]
            high = now
    return times


def place_of(
    record: Record, equation: Equation, step: int, fraction: float, room: Array, rows: Array
) -> Place:
    """A state found by the kernel, which is in ``rows``."""
    from ..kernels import adjoint_layout as layout

    beads = equation.beads
    states = [rows[at : at + beads].copy()
              for at in (layout.NEW_X + 1, layout.NEW_V + 1, layout.F8)]  # fmt: skip
    return _place(record, step, fraction, room.copy(), states)


def place_of_event(record: Record, target: int) -> Place | None:
    """The state at an event of a bead or contact; `None` if it has not been found."""
    from ..kernels import adjoint_layout as layout

    step = int(record.found[target, layout.AT_STEP])
    if step < 0:
        return None
    rows = record.located[target]
    kept = len(rows) - layout.EVENT_ROWS
    states = [row[: record.equation.beads].copy() for row in rows[kept:]]
    fraction = float(record.found[target, layout.FRACTION])
    return _place(record, step, fraction, rows[:kept], states)


def _place(record: Record, step: int, fraction: float, kept: Array, states: list[Array]) -> Place:
    block, n = record.block_of(step)
    low, high = (int(each) for each in block.windows[n])
    length = fraction * float(block.lengths[n])
    start, nothing = block.start + float(block.lengths[:n].sum()), np.zeros(record.equation.beads)
    x, v, a = states
    return Place(
        step, length, low, high, kept, start + length, x, v, a, nothing, nothing.copy()
    )  # fmt: skip
