"""Events that the quantities of a gradient need, and when the run may end."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ..collision import Array
from ..kernels.wall_rule import HELD, MAX_REBOUNDS, ROUNDING, has_released, longest_watch
from ..simulation.body_bound import body_bound
from ..simulation.time_scales import impact_momentum, rebound_time
from ..simulation.wall_bound import LEFT, RIGHT, Target, motion_can_escape, wall_targets
from .equation import Equation
from .names import Name
from .record import Record, nothing_can_happen

SAMPLE: Final = 8


@dataclass(eq=False)
class Targets:
    """Events by kind and place, each once."""

    rows: list[tuple[int, int, int]] = field(default_factory=list)

    def number(self, kind: int, first: int, second: int | None = None) -> int:
        """Number of an event, which is added if it is new."""
        row = kind, first, first if second is None else second
        if row not in self.rows:
            self.rows.append(row)
        return self.rows.index(row)

    def array(self) -> Array:
        """The events as the kernel expects them."""
        return np.array(self.rows, float).reshape(-1, 3)


def targets_of(equation: Equation, names: list[Name]) -> Targets:
    """All events that some quantities need."""
    from ..kernels.adjoint_layout import CLOSING, GAUGE, MAXIMUM, VELOCITY

    targets = Targets()
    for name in names:
        bead = name.bead or 0
        if name.group == "sensor":
            targets.number(GAUGE, bead - 1, bead)
        elif name.group in ("wall_force", "left_wall_force"):
            wall = equation.beads if name.group == "wall_force" else 0
            targets.number(GAUGE, wall)
        elif name.group == "body_force":
            targets.number(GAUGE, equation.beads - 1)
        elif name.group == "bead":
            targets.number(MAXIMUM, bead - 1)
        elif name.group != "pulse":
            continue
        elif name.item in ("velocity", "momentum", "energy", "peak_time"):
            if is_moving(equation, bead):
                targets.number(VELOCITY, bead - 1)
        elif name.item == "arrival" and bead > 1:
            targets.number(CLOSING, bead - 1)
        elif name.item in ("residence", "peak_overlap", "peak_force"):
            targets.number(CLOSING, bead)
            if name.item == "residence" and bead > 1:
                targets.number(CLOSING, bead - 1)
    return targets


def is_moving(equation: Equation, bead: int) -> bool:
    """Whether a bead's velocity has its first maximum after time 0."""
    return bead > max(1, equation.chain.strikers)


@dataclass(eq=False)
class Ending:
    """Decides whether a run without a given end may stop."""

    equation: Equation
    names: list[Name]
    targets: Targets
    # By side: time since which the motion cannot exceed the peak on a wall, end of the impact,
    # whether the wall is pressed, and end of the last contact.
    bounded: dict[int, float] = field(default_factory=dict)
    since: dict[int, float] = field(default_factory=dict)
    pressed: dict[int, bool] = field(default_factory=dict)
    last_ends: dict[int, float] = field(default_factory=dict)
    watched: int = 0
    exhausted: bool = False
    # Largest force so far and its time, by side.
    peak_times: dict[int, float] = field(default_factory=dict)
    peaks: dict[int, float] = field(default_factory=dict)

    def finished(self, record: Record) -> bool:
        """Whether all quantities are complete at the end of a block, or never will be."""
        if nothing_can_happen(record):
            self.exhausted = True
            self._watch(record)
            return True
        watched = self._watch(record) and self._events(record) and self._sensors(record)
        return watched and all(
            is_past(record, name.bead or 1) for name in self.names if name.group == "bead"
        )  # fmt: skip

    def body_is_complete(self, record: Record) -> bool:
        """Whether no later force on the last body of a free end can exceed the largest one."""
        equation = self.equation
        chain = equation.chain
        if chain.right_wall is not None or record.moves:
            return True
        contact = equation.beads - 1
        peak = max(
            (float(equation.kept_forces(each.kept, contact).max()) for each in record.blocks),
            default=0.0,
        )
        overlaps, p = equation.overlaps_at(record.positions), equation.exponents
        stored = equation.stiffness * np.maximum(overlaps, 0.0) ** (p + 1.0) / (p + 1.0)
        bound = body_bound(chain)
        return bound.excludes_more(bound.later(overlaps, stored, record.velocities), peak)

    def _events(self, record: Record) -> bool:
        from ..kernels.adjoint_layout import GAUGE

        first = [row[0] < GAUGE for row in self.targets.rows]
        return bool((record.found[first, 0] >= 0.0).all())

    def _sensors(self, record: Record) -> bool:
        from .gauges import first_maximum

        return all(
            first_maximum(record, name.bead or 0) is not None
            for name in self.names if name.group == "sensor"
        )  # fmt: skip

    def _sides(self) -> list[int]:
        sides = {"wall_force": RIGHT, "left_wall_force": LEFT}
        return sorted({sides[each.group] for each in self.names if each.group in sides})

    def _watch(self, record: Record) -> bool:
        done = True
        for side in self._sides():
            done = self._watch_wall(record, side) and done
        self.watched = len(record.blocks)
        return done

    def _watch_wall(self, record: Record, side: int) -> bool:
        """Update the state of a wall's peak by the new blocks; whether it is complete."""
        equation, c = self.equation, -1 if side == RIGHT else 0
        target = self._target(side)
        for block in record.blocks[self.watched :]:
            times = block.start + np.cumsum(block.lengths) - block.lengths
            stages = equation.kept_forces(block.kept, c)
            highest = stages.max(axis=1)
            top = np.maximum(np.maximum.accumulate(highest), self.peaks.get(side, 0.0))
            if top[-1] > self.peaks.get(side, 0.0):
                self.peaks[side] = float(top[-1])
                self.peak_times[side] = float(times[np.argmax(highest)])
            if not top[-1] > 0.0:
                continue
            some = slice(None, None, SAMPLE)
            bounds = bound_of(equation, block.positions[some], block.velocities[some], side)
            static = float(equation.chain.static_state.forces[c])
            low = bounds <= (1.0 + ROUNDING) * top[some]
            low |= self._rebounded(block.positions[some], block.velocities[some], side)
            complete = (top[some] > 0.0) & low
            ends = self._last_ends(side, times, stages[:, 0] > 0.0)[some]
            rows = zip(times[some], complete, stages[some, 0], top[some], ends, strict=True)
            for time, below, force, peak, end in rows:
                # The impact remains over while beads fall back, as in `simulate`.
                if not below and not (target.may_rebound and self._held(side, float(time))):
                    self.bounded.pop(side, None)
                    self.since.pop(side, None)
                elif end > self.bounded.setdefault(side, float(time)):
                    self.since.setdefault(side, float(end))
                elif has_released(force, static, peak):
                    self.since.setdefault(side, float(time))
        if self.exhausted:
            self.since.setdefault(side, record.time)
        transit, held = self.peak_times.get(side, 0.0), self._held(side, record.time)
        last = transit + longest_watch(
            transit, self._rebounds(side), motion_can_escape(self.equation.chain, side)
        )
        expired = transit > 0.0 and record.time > last
        return expired or (held and self._proven(record, side))

    def _target(self, side: int) -> Target:
        return next(each for each in wall_targets(self.equation.chain) if each.side == side)

    def _held(self, side: int, time: float) -> bool:
        """Whether half a transit has passed since the end of the impact on a wall."""
        enough = HELD * self.peak_times.get(side, 0.0)
        return side in self.since and time - self.since[side] >= enough

    def _stored(self, overlaps: Array) -> Array:
        p = self.equation.exponents
        stored = self.equation.stiffness * np.maximum(overlaps, 0.0) ** (p + 1.0) / (p + 1.0)
        return np.asarray(stored)

    def _rebounded(self, positions: Array, velocities: Array, side: int) -> Array:
        """Whether the first beads have rebounded under gravity, at several times."""
        target = self._target(side)
        if not target.may_rebound:
            return np.zeros(len(positions), bool)
        overlaps = self.equation.overlaps_at(positions)
        rows = zip(overlaps, self._stored(overlaps), velocities, strict=True)
        return np.array([target.rebounded(*row) for row in rows], bool)

    def _last_ends(self, side: int, times: Array, pressed: Array) -> Array:
        """End of the last contact with a wall before the start of each step; 0 before the first."""
        before = np.append(self.pressed.get(side, False), pressed[:-1])
        ends = np.where(before & ~pressed, times, self.last_ends.get(side, 0.0))
        last = np.maximum.accumulate(ends)
        self.pressed[side], self.last_ends[side] = bool(pressed[-1]), float(last[-1])
        return np.asarray(last)

    def _rebounds(self, side: int) -> float:
        """Time that the impact of the whole chain at the right wall may take."""
        chain = self.equation.chain
        if side == LEFT:
            return 0.0
        return MAX_REBOUNDS * rebound_time(chain, impact_momentum(chain))

    def _proven(self, record: Record, side: int) -> bool:
        """Whether no later force exceeds the peak, if this can be proven."""
        equation = self.equation
        if not motion_can_escape(equation.chain, side):
            return True
        overlaps = equation.overlaps_at(record.positions)
        stored = self._stored(overlaps)
        reach = self._target(side).reach(overlaps, stored, record.velocities)
        return reach.bound <= (1.0 + ROUNDING) * self.peaks.get(side, 0.0)

    def complete(self, record: Record, side: int, until: float | None) -> bool:
        """Whether the peak on a wall is complete at the end of the run."""
        if until is None and self.exhausted:
            return True
        if motion_can_escape(self.equation.chain, side):
            return self.peaks.get(side, 0.0) > 0.0 and self._proven(record, side)
        return side in self.since


def is_past(record: Record, bead: int) -> bool:
    """Whether a bead cannot become faster any more in a chain with a free right end.

    Beads that move away from all beads behind them do not return.  The energy of the others is at
    least that of the bead.
    """
    equation, i = record.equation, bead - 1
    top = max(float(block.velocities[:, i].max()) for block in record.blocks)
    if not top > 0.0:
        return False
    overlaps, v = equation.overlaps_at(record.positions), record.velocities
    leaving = (overlaps[1:-1] <= 0.0) & (np.diff(v) >= 0.0)
    inner = np.flatnonzero(~leaving)
    last = max(i, int(inner[-1]) + 1 if len(inner) else 0)
    energy = 0.5 * float(equation.masses[: last + 1] @ v[: last + 1] ** 2)
    closed = np.maximum(overlaps[: last + 1], 0.0)
    forces, p = equation.forces(overlaps)[: last + 1], equation.exponents[: last + 1]
    energy += float((forces * closed / (p + 1.0)).sum())
    return energy <= 0.5 * float(equation.masses[i]) * top**2


def bound_of(equation: Equation, positions: Array, velocities: Array, side: int) -> Array:
    """Largest force that the motion towards a wall can still cause, at several times.

    `hertzchain.simulation.wall_bound` has the equation.
    """
    forward = velocities if side == RIGHT else -velocities
    forces, exponents = equation.chain.static_state.forces, equation.exponents
    k, there = equation.stiffness, equation.stiffness > 0.0
    rest = np.zeros(len(k))
    rest[there] = (forces[there] / k[there]) ** (1.0 / exponents[there])
    energy = (0.5 * equation.masses * np.maximum(forward, 0.0) ** 2).sum(axis=-1)
    overlaps = equation.overlaps_at(positions)
    pairs = np.pad(forward, [(0, 0), (1, 1)])
    moving = there & ((pairs[:, :-1] + pairs[:, 1:] > 0.0) | ((overlaps < 0.0) & (forces > 0.0)))
    closed = np.maximum(overlaps, 0.0)
    stored = (equation.forces(overlaps) * closed - forces * rest) / (exponents + 1.0)
    stored = np.maximum(stored - forces * (overlaps - rest), 0.0)
    energy = energy + np.where(moving, stored, 0.0).sum(axis=-1)
    c = -1 if side == RIGHT else 0
    depth = ((exponents[c] + 1.0) * energy / k[c]) ** (1.0 / (exponents[c] + 1.0)) + rest[c]
    bound = k[c] * depth ** exponents[c]
    if equation.damping[c] > 0.0:
        # The damping of the deepest and fastest impact.
        fastest = np.sqrt(2.0 * energy / equation.masses[c if side == LEFT else -1])
        bound = bound + equation.damping[c] * depth ** equation.overlap_powers[c] * fastest
    return np.asarray(bound)
