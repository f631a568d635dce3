"""Integration of one chain that stores what its adjoint requires."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..collision import Array
from ..errors import SimulationError
from ..representation import measure
from ..validation.memory import check_memory
from .equation import Equation

# Numbers in a block of steps, and bounds of its steps.
BLOCK_SIZE: Final = 2**18
FEWEST, MOST = 64, 512


@dataclass(frozen=True, eq=False)
class Block:
    """Steps of a run: state at the start of each, its length, window and overlaps at stages.

    In a window that moves, states are not stored, and contacts may be released.
    """

    first: int
    start: float
    positions: Array
    velocities: Array
    lengths: Array
    windows: NDArray[np.int64]
    kept: Array
    # Target and step within the block of maxima of gauges.
    candidates: Array
    releases: Array = field(default_factory=lambda: np.empty((0, 8)))

    @property
    def steps(self) -> int:
        """Number of steps."""
        return len(self.lengths)


@dataclass(eq=False)
class Record:
    """Blocks of a run, and the events found in it."""

    equation: Equation
    targets: Array
    found: Array
    # Numbers kept in the parts of steps before events, and states at the events.
    located: Array
    blocks: list[Block] = field(default_factory=list)
    time: float = 0.0
    # State at the end.
    positions: Array = field(default_factory=lambda: np.zeros(0))
    velocities: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def steps(self) -> int:
        """Number of steps."""
        return self.blocks[-1].first + self.blocks[-1].steps if self.blocks else 0

    @property
    def moves(self) -> bool:
        """Whether only a window that moves with the pulse has been integrated."""
        return bool(self.blocks) and not self.blocks[0].positions.size

    def block_of(self, step: int) -> tuple[Block, int]:
        """The block of a step, and the index of the step in it."""
        for block in reversed(self.blocks):
            if step >= block.first:
                return block, step - block.first
        raise IndexError(step)

    def state_after(self, steps: int) -> tuple[Array, Array]:
        """Positions after some steps, and which damped contacts are released there."""
        from ..kernels.adjoint_layout import KEPT_RELEASED, KEPT_SWITCHES

        block, n = self.block_of(steps - 1)
        released = block.kept[n, KEPT_RELEASED] + np.sign(block.kept[n, KEPT_SWITCHES])
        if steps == self.steps:
            return self.positions, released
        block, n = self.block_of(steps)
        return block.positions[n], released

    def largest_overlaps(self) -> Array:
        """Largest overlap of contacts 0..N at the stages of the steps."""
        equation = self.equation
        found = np.maximum(equation.overlaps, 0.0)
        for block in self.blocks:
            tops = block.kept[:, : equation.stages].max(axis=1)
            tops = tops**2 if equation.hertz else tops
            for low in np.unique(block.windows[:, 0]):
                part = tops[block.windows[:, 0] == low].max(axis=0)[: len(found) - low]
                there = slice(low, low + len(part))
                found[there] = np.maximum(found[there], part)
        return np.where(equation.stiffness > 0.0, found, 0.0)


def load_rows(equation: Equation) -> Array:
    """Rows of the kernels with the parameters of a chain and its state at time 0."""
    from ..kernels import adjoint_damped
    from ..kernels import adjoint_layout as layout

    damped = equation.hertz is None
    size = layout.END_OF_DAMPED_ROWS if damped else layout.END_OF_ROWS
    beads, rows = equation.beads, np.empty(size)
    rows.reshape(-1, layout.ROW)[:, : beads + layout.SPACE] = 0.0
    for row, values in (
        (layout.V + 1, equation.velocities),
        (layout.AT_REST, equation.overlaps),
        (layout.STIFFNESS, equation.stiffness),
        (layout.EXPONENT, equation.exponents),
        (layout.INVERSE_MASS, 1.0 / equation.masses),
        (layout.BODY, equation.body),
        (layout.NOISE, equation.noise),
    ):
        rows[row : row + len(values)] = values
    if damped:
        for row, values in (
            (layout.DAMPING, equation.damping),
            (layout.OVERLAP_POWER, equation.overlap_powers),
            (layout.PULLS, equation.pulls),
            (layout.RATE, np.full(beads, equation.rate)),
        ):
            rows[row : row + len(values)] = values
    forces = equation.forces(equation.overlaps)
    rows[layout.FORCE : layout.FORCE + beads + 1] = forces
    rows[layout.F0 : layout.F0 + beads] = -np.diff(forces) / equation.masses + equation.body
    if damped:
        adjoint_damped.release(rows, 0, beads, np.zeros(beads + 1))
    return rows


def kept_of(equation: Equation, overlaps: Array) -> Array:
    """The numbers that the kernels keep for overlaps."""
    closed = np.maximum(overlaps, 0.0)
    return np.sqrt(closed) if equation.hertz else closed


def room_for(equation: Equation) -> Array:
    """Space for the numbers kept in one step, and for the overlaps at its end."""
    from ..kernels.adjoint_layout import KEPT_DAMPED

    numbers = equation.stages if equation.hertz is not None else KEPT_DAMPED
    return np.zeros((numbers + 1, equation.beads + 1))


def run(
    equation: Equation,
    targets: Array,
    until: float,
    rtol: float,
    most_steps: int,
    finished: Callable[[Record], bool],
    stop_when_found: bool = False,
) -> Record:
    """Integrate a chain until a time, until all events are found, or until ``finished``."""
    from ..kernels import adjoint_forward
    from ..kernels import adjoint_layout as layout

    kernel: Any = adjoint_forward
    beads = equation.beads
    clock, counts = np.zeros(layout.CLOCK), np.zeros(layout.COUNTS, np.int64)
    clock[layout.STEP], clock[layout.MOST] = equation.first_step, 4.0
    counts[layout.HIGH] = beads
    if equation.resting:
        moving = np.flatnonzero(equation.velocities)
        counts[layout.HIGH] = min(beads, (moving[-1] if len(moving) else 0) + 1 + kernel.REACH)
    found = np.full((len(targets), layout.FOUND), -1.0)
    rows, events = load_rows(equation), load_rows(equation)
    end, room = kept_of(equation, equation.overlaps), room_for(equation)
    located = np.zeros((len(targets), len(room) + layout.EVENT_ROWS, beads + 1))
    record = Record(equation, targets, found, located)
    size, numbers = int(np.clip(BLOCK_SIZE // (10 * beads + 8), FEWEST, MOST)), len(room) - 1
    status = layout.BLOCK_FULL
    # Without a stop, beads in free flight would reach infinity within a block.
    stop = equation.passage if math.isinf(until) and not stop_when_found else until
    while status == layout.BLOCK_FULL:
        _check_memory(record, size, numbers)
        positions, velocities = np.zeros((size, beads)), np.zeros((size, beads))
        lengths, windows = np.empty(size), np.empty((size, 2), np.int64)
        kept, candidates = np.zeros((size, numbers, beads + 1)), np.empty((size * len(targets), 2))
        counts[layout.BASE] = record.steps
        start = clock[layout.TIME]
        status = kernel.advance(
            rows, events, beads, clock, counts, stop, rtol, most_steps, stop_when_found,
            equation.hertz, equation.careful, equation.resting, targets, found, located,
            candidates, positions, velocities, lengths, windows, kept, room, end,
        )  # fmt: skip
        if status == layout.TIME_REACHED and stop < until:
            stop, status = 2.0 * stop, layout.BLOCK_FULL
        n = int(counts[layout.STEPS])
        if n < size:
            end[:] = kept[n, 0]
        if n:
            block = Block(
                record.steps, start, positions[:n], velocities[:n], lengths[:n], windows[:n],
                kept[:n], candidates[: counts[layout.CANDIDATES]],
            )  # fmt: skip
            record.blocks.append(block)
        record.time = float(clock[layout.TIME])
        record.positions = rows[layout.X + 1 : layout.X + 1 + beads].copy()
        record.velocities = rows[layout.V + 1 : layout.V + 1 + beads].copy()
        if status == layout.BLOCK_FULL and finished(record):
            break
    if status in (layout.STEP_TOO_SMALL, layout.STEP_LIMIT):
        raise _failure(status == layout.STEP_LIMIT, most_steps, record)
    return record


def _failure(limit: bool, most_steps: int, record: Record) -> SimulationError:
    time = measure(record.time, "s", record.equation.chain.units, 6)
    reason = f"reached the limit of {most_steps} steps" if limit else "needs too short steps"
    return SimulationError(
        f"the integration for the gradient {reason} at t = {time}; use a larger rtol or a "
        "shorter until"
    )


def _check_memory(record: Record, size: int, numbers: int) -> None:
    """Raise `InputError` unless all steps, with the next block, would fit in the free memory."""
    beads, steps = record.equation.beads, record.steps + size
    check_memory(
        f"the first {steps} steps of {beads} beads, until t = {record.time:g} and a little later,",
        8.0 * steps * (numbers + 2) * (beads + 1),
        "use a larger rtol, an earlier until, or fewer beads",
    )


def nothing_can_happen(record: Record) -> bool:
    """Whether at the end of a record no contact is closed or closing."""
    equation = record.equation
    if equation.body.any():
        return False
    there = equation.stiffness > 0.0
    with np.errstate(all="ignore"):
        closing = -np.diff(np.pad(record.velocities, 1))
        closed = equation.overlaps_at(record.positions) > 0.0
    return not bool((there & (closed | (closing > 0.0))).any()) and math.isfinite(record.time)
