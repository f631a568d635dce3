"""Maxima and impulses of the forces of walls and sensors in a recorded run."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ..collision import Array
from ..kernels.limits import FALL, MIN_HEIGHT
from .backward_pass import Place, place_of
from .equation import Equation
from .record import Record, load_rows, room_for

# The rate of a force at its maximum is smaller than this fraction of its terms, and the maximum is
# lower than the forces at stages by at most this fraction.
SMOOTH, HEIGHT = 1e-4, 1e-3
# Candidates whose force at a stage exceeds this fraction of the largest are located.
NEAR_TOP: Final = 0.97
# Maxima lower than this fraction of the largest one are not separate peaks.
LOWEST: Final = 0.5


class Missing(Exception):
    """The quantity does not exist in this run; the text states why."""


def contacts_of(bead: int) -> tuple[int, int]:
    """Contacts whose mean force a sensor in a bead measures."""
    return bead - 1, bead


def stage_forces(record: Record, contacts: tuple[int, ...]) -> Array:
    """Mean force of some contacts at the stages of each step, shape (steps, stages)."""
    equation = record.equation
    total: Any = 0.0
    for c in contacts:
        parts = [equation.kept_forces(block.kept, c) for block in record.blocks]
        total = total + np.concatenate(parts) / len(contacts)
    return np.asarray(total)


def impulse(record: Record, contacts: tuple[int, ...]) -> Array:
    """Impulse of the mean force of some contacts in each step, by the weights of the method."""
    equation, total = record.equation, np.zeros(record.steps)
    kept = np.concatenate([block.kept for block in record.blocks])
    lengths = np.concatenate([block.lengths for block in record.blocks])
    after = np.maximum(equation.overlaps_at(record.positions), 0.0)
    for c in contacts:
        total += equation.kept_impulses(kept, lengths, c, after[c]) / len(contacts)
    return total


def maxima(record: Record, target: int) -> list[tuple[int, float]]:
    """Steps with a maximum of a gauge, and the largest force at their stages."""
    row = record.targets[target].astype(int)
    contacts = tuple(dict.fromkeys((int(row[1]), int(row[2]))))
    forces = stage_forces(record, contacts)
    steps = []
    for block in record.blocks:
        own = block.candidates[block.candidates[:, 0] == target, 1]
        steps += [block.first + int(n) for n in own]
    tops = []
    for n in steps:
        after = forces[n + 1, 0] if n + 1 < len(forces) else 0.0
        tops.append(float(max(forces[n].max(), after)))
    return list(zip(steps, tops, strict=True))


def locate(record: Record, target: int, step: int) -> Place | None:
    """State at the maximum of a gauge, or at another event, in a step."""
    from ..kernels import adjoint_events
    from ..kernels.adjoint_layout import KEPT_RELEASED, RELEASED

    kernel: Any = adjoint_events
    equation = record.equation
    block, n = record.block_of(step)
    low, high = (int(each) for each in block.windows[n])
    rows, room = load_rows(equation), room_for(equation)
    if equation.hertz is None:
        rows[RELEASED : RELEASED + equation.beads + 1] = block.kept[n, KEPT_RELEASED]
    s = kernel.locate_from(
        rows, equation.beads, low, high, float(block.lengths[n]), equation.hertz,
        record.targets[target], room, room[-1], block.positions[n], block.velocities[n],
    )  # fmt: skip
    return place_of(record, equation, step, s, room, rows) if s <= 1.0 else None


def largest(record: Record, target: int) -> Place | None:
    """State at the largest maximum of a gauge."""
    candidates = maxima(record, target)
    top = max((force for _, force in candidates), default=0.0)
    places = [locate(record, target, n) for n, force in candidates if force >= NEAR_TOP * top]
    found = [place for place in places if place is not None]
    best = max(found, key=lambda place: force_at(record, target, place), default=None)
    if best is None or record.equation.hertz is not None:
        return best
    if force_at(record, target, best) < (1.0 - HEIGHT) * top:
        raise Missing(JUMPS)
    return best


def fastest(record: Record, target: int, i: int) -> Place | None:
    """State at the largest maximum of the velocity of bead i; `None` if there is none."""
    speeds = np.concatenate([*(block.velocities[:, i] for block in record.blocks),
                             record.velocities[i : i + 1]])  # fmt: skip
    steps = np.concatenate([
        block.first + block.candidates[block.candidates[:, 0] == target, 1].astype(int)
        for block in record.blocks
    ])  # fmt: skip
    tops = np.maximum(speeds[steps], speeds[steps + 1])
    near = steps[tops >= NEAR_TOP * np.max(tops, initial=0.0)]
    places = [locate(record, target, int(n)) for n in near]
    found = [place for place in places if place is not None]
    return max(found, key=lambda place: float(place.velocities[i]), default=None)


JUMPS: Final = (
    "it is largest where a force jumps, because a contact closes or opens, and has no exact "
    "derivatives there; use differences of simulate_many"
)


def check_smooth(
    equation: Equation, place: Place, contacts: tuple[int, ...], *, in_velocity: bool = False
) -> None:
    """Raise `Missing` if the maximum of the force, or of the bead's velocity, is a kink."""
    if equation.hertz is not None:
        return
    forces = contact_forces(equation, place.positions, place.velocities)
    if in_velocity:
        terms = forces[list(contacts)] * [1.0, -1.0]
        weight = equation.masses[contacts[0]] * equation.body[contacts[0]]
        terms = np.append(terms, weight)
    else:
        closed = [c for c in contacts if forces[c] != 0.0]
        d = equation.overlaps_at(place.positions)[closed]
        closing, bend = (-np.diff(np.pad(each, 1))[closed]
                         for each in (place.velocities, place.accelerations))  # fmt: skip
        p, q = equation.exponents[closed], equation.overlap_powers[closed]
        damping = equation.damping[closed] * d**q
        slope = p * equation.stiffness[closed] * d ** (p - 1.0) + q * damping / d * closing
        terms = np.concatenate((slope * closing, damping * bend))
    if not abs(terms.sum()) < SMOOTH * np.abs(terms).sum():
        raise Missing(JUMPS)


def contact_forces(equation: Equation, positions: Array, velocities: Array) -> Array:
    """Forces of all contacts at a state."""
    overlaps = equation.overlaps_at(positions)
    forces = equation.forces(overlaps)
    if equation.hertz is None:
        closed = np.maximum(overlaps, 0.0)
        closing = -np.diff(np.pad(velocities, 1))
        forces = forces + equation.damping * closed**equation.overlap_powers * closing
        pushes = (closed > 0.0) & ((forces > 0.0) | (equation.pulls > 0.0))
        forces = np.where(pushes, forces, 0.0)
    return forces


def force_at(record: Record, target: int, place: Place) -> float:
    """Force of a gauge at a state."""
    row = record.targets[target].astype(int)
    forces = contact_forces(record.equation, place.positions, place.velocities)
    return 0.5 * float(forces[row[1]] + forces[row[2]])


def first_maximum(record: Record, bead: int) -> int | None:
    """Step of the first maximum of a sensor's force, as `SensorForce` defines it."""
    from ..kernels.adjoint_layout import GAUGE

    contacts = contacts_of(bead)
    target = record.targets.astype(int).tolist().index([GAUGE, *contacts])
    rest = 0.5 * float(record.equation.chain.static_state.forces[list(contacts)].sum())
    excess = stage_forces(record, contacts)[:, 0] - rest
    tops = [(n, top - rest) for n, top in maxima(record, target)]
    highest = max((top for _, top in tops), default=0.0)
    best = -1.0
    for i, (n, top) in enumerate(tops):
        if top <= max(best, MIN_HEIGHT * highest):
            continue
        until = next((m for m, other in tops[i + 1 :] if other > top), len(excess))
        if (excess[n + 1 : until + 1] < (1.0 - FALL) * top).any():
            return n
        best = top
    return None
