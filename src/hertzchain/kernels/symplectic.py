r"""Splitting methods with fixed steps, for long runs of lossless chains.

A step alternates kicks and drifts,

.. math:: v \to v + c_s h\, a(x + g_s h^2 a(x)), \qquad x \to x + d_s h\, v ,

with the coefficients of a `Splitting`; `SPLITTINGS` has the available methods.  They conserve
phase-space volume.  With :math:`g_s = 0` in every kick, the energy error only oscillates as long as
contacts stay closed.  A kick with :math:`g_s \ne 0` uses the gradient of the force, to first order
in :math:`g_s h^2` (Chin, Phys. Lett. A 226, 344, 1997); the slope of a power-law force follows from
the force without another square root.

`take_steps` is the only function that depends on the method; `advance` corresponds to
`hertzchain.kernels.full_chain.advance` for DOP853 and records the same events.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .compilation import CONTRACTED, compiled, entry_point, internal
from .conservation import update_drift
from .fixed_step_events import record_events, save_frames, watch_wall
from .forces import LEFT_IMPULSE, RIGHT_IMPULSE, copy
from .full_chain import (
    FRAMES_FULL,
    LAST_STEP,
    PULSE_LEFT,
    PULSE_LOST,
    RUNNING,
    TIME_REACHED,
    nothing_can_happen,
)
from .limits import MIN_PUSH
from .powers import powers
from .scratch import aligned_zeros
from .state_layout import (
    CROSSING_TIME,
    CROSSINGS,
    EVALUATIONS,
    FRAMES,
    MOMENTUM_UNIT,
    PEAKS,
    SINCE_CROSSING,
    STEP,
    STEPS,
    TIME,
)


class Splitting(NamedTuple):
    """Factors of the step in the stages of a splitting method."""

    kicks: tuple[float, ...]
    drifts: tuple[float, ...]  # one fewer
    gradients: tuple[float, ...]  # of the kicks, in squares of the step
    limit: float  # largest stable step times the angular frequency of a linear contact


SPLITTINGS = {
    "verlet": Splitting((0.5, 0.5), (1.0,), (0.0, 0.0), 2.0),
    "forward-4": Splitting(
        (1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0), (0.5, 0.5), (0.0, 1.0 / 24.0, 0.0), 12.0**0.5
    ),
}

# Steps between two evaluations of energy and momentum.
CHECK = 32
# Smaller overlaps exert no force, because computing powers of them would be slow.
TINY = 1e-40

inlined = internal(forceinline=True, **CONTRACTED)
contracted = internal(**CONTRACTED)


class Springs(NamedTuple):
    """Beads and contacts of a chain, walls included, in the form that the steps use."""

    inverse_mass: Any  # (N,)
    stiffness: Any  # (N + 1,); 0 where there is no wall
    closed_by: Any  # (N + 1,) overlaps at displacement 0
    exponents: Any  # (N + 1,)
    same: bool  # whether all contacts have the exponent of the first
    outside: Any  # (N,) constant accelerations


class Scratch(NamedTuple):
    """Scratch arrays of `advance`."""

    positions: Any  # (N + 2,), with those of the walls
    velocities: Any  # (N,)
    forces: Any  # (N + 1,)
    slopes: Any  # (N + 1,)
    accelerations: Any  # (N + 2,) accelerations, with those of the walls
    powers: Any  # (3, N + 1)
    before: Any  # (3, N + 2) positions, velocities and accelerations at the start of a step
    state: Any  # (2N,) velocities at an event, as `note_leading_pulse` takes them


@inlined
def find_forces(x, stiffness, closed_by, exponents, same, f, rows):
    """Forces of all contacts."""
    if same and exponents[0] == 1.5:
        for c in range(len(f)):
            d = closed_by[c] + (x[c] - x[c + 1])
            d = d if d > TINY else 0.0
            f[c] = stiffness[c] * d * np.sqrt(d)
    else:
        other_forces(x, stiffness, closed_by, exponents, same, f, f, rows)


@inlined
def find_slopes(x, stiffness, closed_by, exponents, same, f, slopes, rows):
    """Forces of all contacts, and their derivatives with respect to the overlaps."""
    if same and exponents[0] == 1.5:
        for c in range(len(f)):
            d = closed_by[c] + (x[c] - x[c + 1])
            d = d if d > TINY else 0.0
            root = stiffness[c] * np.sqrt(d)
            f[c] = root * d
            slopes[c] = 1.5 * root
    else:
        other_forces(x, stiffness, closed_by, exponents, same, f, slopes, rows)


@contracted
def other_forces(x, stiffness, closed_by, exponents, same, f, slopes, rows):
    """Forces of contacts with any exponents; also their slopes if ``slopes`` is not ``f``."""
    overlap, power, scratch = rows[0], rows[1], rows[2:]
    for c in range(len(f)):
        d = closed_by[c] + (x[c] - x[c + 1])
        overlap[c] = d if d > TINY else 0.0
    if same:
        powers(overlap, exponents[0] - 1.0, power, scratch)
    else:
        for c in range(len(f)):
            power[c] = overlap[c] ** (exponents[c] - 1.0) if overlap[c] > 0.0 else 0.0
    for c in range(len(f)):
        slopes[c] = exponents[c] * stiffness[c] * power[c]
    for c in range(len(f)):
        f[c] = stiffness[c] * power[c] * overlap[c]


@inlined
def soften(f, slopes, inverse_mass, outside, part, accelerations):
    """Change forces to those after a displacement by ``part`` times the accelerations."""
    for i in range(len(inverse_mass)):
        accelerations[i + 1] = (f[i] - f[i + 1]) * inverse_mass[i] + outside[i]
    for c in range(len(f)):
        f[c] += slopes[c] * part * (accelerations[c] - accelerations[c + 1])


@inlined
def kick_and_drift(x, v, f, inverse_mass, outside, kick, drift):
    """One kick and the drift after it."""
    for i in range(len(v)):
        w = v[i] + kick * ((f[i] - f[i + 1]) * inverse_mass[i] + outside[i])
        v[i] = w
        x[i + 1] += drift * w


@inlined
def kick_twice_and_drift(x, v, f, inverse_mass, outside, kick, next_kick, drift):
    """The last kick of a step, the first one of the next, and the drift after it."""
    for i in range(len(v)):
        a = (f[i] - f[i + 1]) * inverse_mass[i] + outside[i]
        # Two additions instead of one of the sum, so that results do not depend, in any digit, on
        # where a run stops.
        w = v[i] + kick * a
        w = w + next_kick * a
        v[i] = w
        x[i + 1] += drift * w


@contracted
def take_steps(
    number, h, time, y, kicks, drifts, gradients, springs, rows, ends, walls, passed, least_push
):  # fmt: skip
    """Take steps of the method; on entry and on return, ``rows.forces`` belong to the positions."""
    x, v, f, slopes, accelerations = (
        rows.positions,
        rows.velocities,
        rows.forces,
        rows.slopes,
        rows.accelerations,
    )
    im, outside, stiffness = springs.inverse_mass, springs.outside, springs.stiffness
    closed_by, exponents, same = springs.closed_by, springs.exponents, springs.same
    beads, last_stage = len(v), len(kicks) - 1
    left, right = 0.0, 0.0
    if len(y) > 2 * beads:
        left, right = y[2 * beads + LEFT_IMPULSE], y[2 * beads + RIGHT_IMPULSE]
    kick_and_drift(x, v, f, im, outside, kicks[0] * h, drifts[0] * h)
    for n in range(number):
        left += kicks[0] * h * f[0]
        right += kicks[0] * h * f[beads]
        for s in range(1, last_stage):
            if gradients[s] == 0.0:
                find_forces(x, stiffness, closed_by, exponents, same, f, rows.powers)
            else:
                find_slopes(x, stiffness, closed_by, exponents, same, f, slopes, rows.powers)
                soften(f, slopes, im, outside, gradients[s] * h * h, accelerations)
            kick_and_drift(x, v, f, im, outside, kicks[s] * h, drifts[s] * h)
            left += kicks[s] * h * f[0]
            right += kicks[s] * h * f[beads]
        find_forces(x, stiffness, closed_by, exponents, same, f, rows.powers)
        kick = kicks[last_stage] * h
        left += kick * f[0]
        right += kick * f[beads]
        time += h
        # Velocities at the end of the step, of the beads at the walls.
        first = (f[0] - f[1]) * im[0] + outside[0]
        last = (f[beads - 1] - f[beads]) * im[beads - 1] + outside[beads - 1]
        watch_wall(
            0, time, h, f[0], left, least_push, passed, x[1], v[0] + kick * first, first,
            (stiffness[0], closed_by[0], exponents[0]), ends, walls,
        )  # fmt: skip
        watch_wall(
            1, time, h, f[beads], right, least_push, passed, -x[beads],
            -v[beads - 1] - kick * last, -last,
            (stiffness[beads], closed_by[beads], exponents[beads]), ends, walls,
        )  # fmt: skip
        if n == number - 1:
            kick_and_drift(x, v, f, im, outside, kick, 0.0)
        else:
            kick_twice_and_drift(x, v, f, im, outside, kick, kicks[0] * h, drifts[0] * h)
    if len(y) > 2 * beads:
        y[2 * beads + LEFT_IMPULSE] = left
        y[2 * beads + RIGHT_IMPULSE] = right
    return time


@compiled
def accelerations_of(springs, rows, out):
    """Write the accelerations of the beads to entries 1 to N; entries 0 and N + 1 are the walls."""
    f = rows.forces
    for i in range(len(springs.inverse_mass)):
        out[i + 1] = (f[i] - f[i + 1]) * springs.inverse_mass[i] + springs.outside[i]


@compiled
def synchronise(springs, rows, y, accelerations):
    """Copy positions, velocities and accelerations of the beads to the state."""
    beads = len(rows.velocities)
    copy(rows.positions[1 : beads + 1], y[:beads])
    copy(rows.velocities, y[beads : 2 * beads])
    accelerations_of(springs, rows, rows.accelerations)
    copy(rows.accelerations[1 : beads + 1], accelerations)


@compiled
def steps_before(stop, time, h, most):
    """Number of whole steps that end before a time, but not more than ``most``."""
    number = 0
    while number < most and time + h < stop:
        time += h
        number += 1
    return number


@entry_point
def advance(
    y, clock, counts, setup, contacts, springs, kicks, drifts, gradients, until, stop_when_left,
    budget, bead_steps, pause, frame_times, growing, frames, frame_forces, peaks, crossings, walls,
    accelerations, rows, ends,
):  # fmt: skip
    """Take up to ``budget`` steps, as `hertzchain.kernels.full_chain.advance` does.

    ``clock[STEP]`` is the step; only the last one, to ``until``, may be shorter.  ``ends`` is
    scratch of shape (2, 4), used by `watch_wall`.
    """
    beads = len(springs.inverse_mass)
    copy(y[:beads], rows.positions[1 : beads + 1])
    copy(y[beads : 2 * beads], rows.velocities)
    find_forces(
        rows.positions, springs.stiffness, springs.closed_by, springs.exponents, springs.same,
        rows.forces, rows.powers,
    )  # fmt: skip
    synchronise(springs, rows, y, accelerations)
    for side in range(2):
        i, sign = side * (beads - 1), 1.0 - 2.0 * side
        ends[side, 0], ends[side, 1] = sign * y[i], sign * y[beads + i]
        ends[side, 2], ends[side, 3] = sign * accelerations[i], rows.forces[side * beads]
    budget = min(budget, 1 + bead_steps // beads)
    per_step = 0
    for kick in kicks:
        per_step += 1 if kick != 0.0 else 0
    code = RUNNING
    while budget > 0:
        time, h = clock[TIME], clock[STEP]
        cut = time + h >= until
        if cut and pause:
            code = LAST_STEP
            break
        if cut:
            h = until - time
        if growing and time + h >= frame_times[-1]:
            code = FRAMES_FULL
            break
        frame = counts[FRAMES]
        next_frame = frame_times[frame] if frame < len(frame_times) else np.inf
        time_new = until if cut else time + h
        left = counts[PEAKS] == beads - 1 and counts[CROSSINGS] == beads - 1
        number = 1
        single = cut or not left or next_frame <= time_new
        if not single:
            stop = min(next_frame, until)
            number = steps_before(stop, time, h, min(budget, CHECK - counts[STEPS] % CHECK))
            number = max(number, 1)
        else:
            copy(rows.positions, rows.before[0])
            copy(rows.velocities, rows.before[1, 1 : beads + 1])
            accelerations_of(springs, rows, rows.before[2])
        ended = take_steps(
            number, h, time, y, kicks, drifts, gradients, springs, rows, ends, walls,
            crossings[CROSSING_TIME, -1] != 0.0, MIN_PUSH * clock[MOMENTUM_UNIT],
        )  # fmt: skip
        counts[EVALUATIONS] += number * (per_step - 1)
        if single:
            accelerations_of(springs, rows, rows.accelerations)
            if not left:
                record_events(h, clock, counts, setup, contacts, springs, rows, peaks, crossings)
            if next_frame <= time_new:
                save_frames(time, time_new, h, y, springs, rows, counts, frame_times, frames,
                            frame_forces)  # fmt: skip
        clock[TIME] = until if cut else ended
        clock[SINCE_CROSSING] += number * h
        counts[STEPS] += number
        budget -= number
        if counts[STEPS] % CHECK == 0 or cut:
            synchronise(springs, rows, y, accelerations)
            update_drift(y, clock, setup, contacts, 0, (0.0, 0.0, 0.0), False)
            if stop_when_left and nothing_can_happen(y, setup, contacts):
                code = PULSE_LOST
                break
        if stop_when_left and counts[PEAKS] == beads - 1 and counts[CROSSINGS] == beads - 1:
            code = PULSE_LEFT
            break
        if cut:
            code = TIME_REACHED
            break
    synchronise(springs, rows, y, accelerations)
    return code


def new_scratch(beads):
    """Scratch arrays of `advance`."""
    rows = Scratch(
        aligned_zeros(beads + 2), aligned_zeros(beads), aligned_zeros(beads + 1),
        aligned_zeros(beads + 1), aligned_zeros(beads + 2), aligned_zeros(4, beads + 1),
        aligned_zeros(3, beads + 2), aligned_zeros(2 * beads),
    )  # fmt: skip
    return rows, np.zeros((2, 4))
