"""A step of RKN8(6) and its error estimate, for kernels with all rows in one flat array.

`step_on` creates both functions for a layout of the rows.  The offsets of the rows are constants of
these functions, so that the compiler can exclude overlaps between rows and vectorise loops.  The
kernels differ in their forces, in the number of chains side by side and in whether each chain has
its own step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import int64

from .compilation import CONTRACTED, internal
from .rkn8 import (
    A1,
    A2,
    A3,
    A4,
    A5,
    A6,
    A7,
    B_POSITION,
    B_VELOCITY,
    C1,
    C2,
    C3,
    C4,
    C5,
    C6,
    C7,
    E_VELOCITY,
)

# These functions are compiled into those that call them, which are cached.
inlined = internal(forceinline=True, **(CONTRACTED | {"cache": False}))

B0, _, B2, B3, B4, B5, B6 = B_POSITION
V0, _, V2, V3, V4, _, _, _ = B_VELOCITY
E0, _, E2, E3, E4, E5, E6, E7, E8 = E_VELOCITY


class Rows(NamedTuple):
    """Offsets of rows; entry i of every row belongs to the same bead of the same chain."""

    position: int
    velocity: int
    trial: int
    # Values at the end of the step; these may be the rows of the values at its start.
    new_position: int
    new_velocity: int
    # Accelerations at stages 0 to 7; the offsets are equidistant.
    stages: tuple[int, ...]
    # Length of the step for each entry, unless all entries have the same step.
    step: int = 0


def step_on(rows: Rows, press: Any, acceleration: Any) -> tuple[Any, Any]:
    """Create functions ``try_step(w, low, high, h, a, b)`` and ``error(w, i, first, last)``.

    ``try_step`` takes a step of entries ``low`` to ``high`` - 1, of length ``h`` or, if this is
    `None`, of the lengths in row ``step``.  It requires the accelerations of stage 0, and calls
    ``press(w, low, high, stage, a, b)``, which must compute the contact forces at the trial
    positions, and ``acceleration(w, i, a)``, which must return the acceleration of entry i by these
    forces; ``a`` and ``b`` are passed on.  ``error`` returns the estimated error of velocity i
    divided by the length of the step; rows ``first`` and ``last`` have the accelerations at the
    start and at the end of the step.
    """
    x, v, trial, new_x, new_v, _, lengths = rows
    s0, s1, s2, s3, s4, s5, s6, s7 = rows.stages
    distance = s1 - s0

    @inlined
    def trial_position(w, i, h, c, weights):
        """Position of an entry at a stage."""
        push, stage = 0.0, s0 + i
        for weight in weights:
            push += weight * w[stage]
            stage += distance
        step = w[lengths + i] if h is None else h
        return w[x + i] + step * (c * w[v + i] + step * push)

    # One loop per stage: the processor waits less for values that it has just stored.
    @inlined
    def move(w, low, high, h, stage, c, weights, a):
        """Accelerations at a stage and positions at the next one."""
        for i in range(low, high):
            w[stage + i] = acceleration(w, i, a)
            w[trial + i] = trial_position(w, i, h, c, weights)

    @inlined
    def try_step(w, low, high, h, a, b):
        """Stages of a step, and positions and velocities at its end."""
        for i in range(low, high):
            w[trial + i] = trial_position(w, i, h, C1, A1)
        # Without `int64`, `press` would be compiled again for every constant.
        press(w, low, high, int64(1), a, b)
        move(w, low, high, h, s1, C2, A2, a)
        press(w, low, high, int64(2), a, b)
        move(w, low, high, h, s2, C3, A3, a)
        press(w, low, high, int64(3), a, b)
        move(w, low, high, h, s3, C4, A4, a)
        press(w, low, high, int64(4), a, b)
        move(w, low, high, h, s4, C5, A5, a)
        press(w, low, high, int64(5), a, b)
        move(w, low, high, h, s5, C6, A6, a)
        press(w, low, high, int64(6), a, b)
        move(w, low, high, h, s6, C7, A7, a)
        press(w, low, high, int64(7), a, b)
        for i in range(low, high):
            w[s7 + i] = acceleration(w, i, a)
            push = B0 * w[s0 + i] + B2 * w[s2 + i] + B3 * w[s3 + i]
            push += B4 * w[s4 + i] + B5 * w[s5 + i] + B6 * w[s6 + i]
            change = V0 * (w[s0 + i] + w[s7 + i]) + V2 * (w[s2 + i] + w[s6 + i])
            change += V3 * (w[s3 + i] + w[s5 + i]) + V4 * w[s4 + i]
            step = w[lengths + i] if h is None else h
            w[new_x + i] = w[x + i] + step * (w[v + i] + step * push)
            w[new_v + i] = w[v + i] + step * change

    @inlined
    def error(w, i, first, last):
        """Error of the velocity of an entry, divided by the length of the step."""
        error = E0 * w[first + i] + E2 * w[s2 + i] + E3 * w[s3 + i] + E4 * w[s4 + i]
        error += E5 * w[s5 + i] + E6 * w[s6 + i] + E7 * w[s7 + i] + E8 * w[last + i]
        return error

    return try_step, error
