"""One step of one elastic chain, which stores the overlaps at all stages for the adjoint.

The method is RKN8(6) (`hertzchain.kernels.rkn8`); errors are measured as in
`hertzchain.kernels.rkn8_step`.  For Hertz contacts the square roots of the overlaps are stored,
otherwise the overlaps themselves; they determine the forces and their derivatives.
"""

from __future__ import annotations

import math

from numba import njit

from .adjoint_damped import damped_errors, damped_forces, damped_step
from .adjoint_layout import (
    AT_REST,
    BODY,
    EXPONENT,
    F0,
    F1,
    F2,
    F3,
    F4,
    F5,
    F6,
    F7,
    F8,
    FORCE,
    INVERSE_MASS,
    NEAR,
    NEW_V,
    NEW_X,
    NOISE,
    ROW,
    SCALE,
    SPARE,
    SPEED,
    STIFFNESS,
    TRIAL,
    WORK,
    V,
    X,
)
from .compilation import CONTRACTED, internal
from .elastic_forces import LEAST
from .limits import NEIGHBOURS, SLOW
from .powers import power
from .rkn8_stages import Rows, step_on
from .rkn8_step import MIN_SCALE

entry_point = njit(**CONTRACTED)
compiled = internal(**CONTRACTED)
inlined = internal(forceinline=True, **CONTRACTED)
maximal = internal(forceinline=True, **(CONTRACTED | {"fastmath": True}))


@inlined
def forces(w, low, high, at, out, hertz, kept):
    """Accelerations of the beads of a window at the positions in row ``at``, in row ``out``.

    ``hertz`` is None if contacts are damped; velocities are then those of row V.
    """
    if hertz is None:
        damped_forces(w, low, high, at, V, out, kept, w[SPARE : SPARE + ROW])
    else:
        elastic_forces(w[low:], 0, high - low, at, out, hertz, kept)


@inlined
def press(w, low, high, at, hertz, kept):
    """Contact forces of a window without damping; the first number kept is that of ``low``.

    The compiler can use vectors if ``low`` is a constant.
    """
    if hertz:
        for c in range(low, high + 1):
            d = w[AT_REST + c] + (w[at + c] - w[at + c + 1])
            d = d if d > LEAST else 0.0
            root = math.sqrt(d)
            kept[c - low] = root
            w[FORCE + c] = w[STIFFNESS + c] * (d * root)
    else:
        for c in range(low, high + 1):
            d = w[AT_REST + c] + (w[at + c] - w[at + c + 1])
            d = d if d > LEAST else 0.0
            kept[c - low] = d
            w[FORCE + c] = w[STIFFNESS + c] * power(d, w[EXPONENT + c])


@inlined
def acceleration(w, i, hertz):  # noqa: ARG001
    """Acceleration of a bead by the forces of its contacts."""
    return (w[FORCE + i] - w[FORCE + i + 1]) * w[INVERSE_MASS + i] + w[BODY + i]


@inlined
def elastic_forces(w, low, high, at, out, hertz, kept):
    """`forces` without damping."""
    press(w, low, high, at, hertz, kept)
    for i in range(low, high):
        w[out + i] = acceleration(w, i, hertz)


@inlined
def press_at_stage(w, low, high, stage, hertz, kept):
    """Contact forces at a stage."""
    press(w, low, high, TRIAL, hertz, kept[stage])


# Positions and velocities begin with an entry for the left wall.
take_step, velocity_error = step_on(
    Rows(X + 1, V + 1, TRIAL + 1, NEW_X + 1, NEW_V + 1, (F0, F1, F2, F3, F4, F5, F6, F7)),
    press_at_stage, acceleration,
)  # fmt: skip


@compiled
def elastic_step(w, low, high, h, hertz, kept, last):
    """`try_step` without damping."""
    rows = w[low:]
    take_step(rows, 0, high - low, h, hertz, kept)
    elastic_forces(rows, 0, high - low, NEW_X, F8, hertz, last)


@compiled
def try_step(w, low, high, h, hertz, kept, last):
    """Try a step from the accelerations in row F0; ``last`` receives the overlaps at its end."""
    if hertz is None:
        damped_step(w, low, high, h, kept, last)
    else:
        elastic_step(w, low, high, h, hertz, kept, last)


@maximal
def largest(w, at, low, high):
    """Largest number in a part of a row; the caller must check for NaN."""
    top = 0.0
    for i in range(low, high):
        top = max(top, w[at + i])
    return top


@inlined
def elastic_errors(w, low, high, h):
    """Write the error of each bead, in units of its scale, to row WORK."""
    for i in range(low, high):
        error = velocity_error(w, i, F0, F8)
        w[WORK + i] = abs(h * error) / w[SCALE + i]


@compiled
def error_of(w, low, high, h, rtol, hertz):
    """Largest error of the velocities in a step, in units of the speeds of nearby beads."""
    own, after = SPEED + NEIGHBOURS, NEAR + NEIGHBOURS + 1
    for i in range(low, high):
        a, b = abs(w[V + 1 + i]), abs(w[NEW_V + 1 + i])
        a = a if a > b else b
        w[own + i] = a
        w[WORK + i] = a if w[F0 + i] != 0.0 else 0.0
    for i in range(NEIGHBOURS):
        w[SPEED + low + i] = w[own + high + i] = 0.0
    least = SLOW * largest(w, WORK, low, high) + MIN_SCALE
    for i in range(low, high + NEIGHBOURS + 1):
        a, b, c = w[SPEED + i], w[SPEED + i + 1], w[SPEED + i + 2]
        a = a if a > b else b
        w[NEAR + i] = a if a > c else c
    for i in range(low, high):
        a, b, c = w[NEAR + i], w[after + i], w[own + i]
        a = a if a > b else b
        a = a if a > c else c
        b, c = least, w[NOISE + i] * h / rtol
        a = a if a > b else b
        a = a if a > c else c
        w[SCALE + i] = a
    if hertz is None:
        damped_errors(w, low, high, h, SCALE)
    else:
        elastic_errors(w, low, high, h)
    total = 0.0
    for i in range(low, high):
        total += w[WORK + i]
    if not total < math.inf:
        return math.inf
    return largest(w, WORK, low, high)
