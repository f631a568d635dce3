"""One RKN8(6) step of one elastic chain, which keeps the overlaps of all stages.

The method is that of `hertzchain.kernels.rkn8`, the measure of errors that of
`hertzchain.kernels.rkn8_step`.  For Hertz contacts the kept numbers are the roots of the overlaps,
otherwise the overlaps; they determine the forces and their derivatives.
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
from .compilation import CONTRACTED
from .elastic_forces import LEAST
from .powers import power
from .rkn8 import A1, A2, A3, A4, A5, A6, A7, C1, C2, C3, C4, C5, C6, C7
from .rkn8_stages import B0, B2, B3, B4, B5, B6, E0, E2, E3, E4, E5, E6, E7, E8, V0, V2, V3, V4
from .rkn8_step import NEIGHBOURS, SLOW, SMALLEST

compiled = njit(**CONTRACTED)
inlined = njit(forceinline=True, **CONTRACTED)
maximal = njit(forceinline=True, **(CONTRACTED | {"fastmath": True}))


@inlined
def forces(w, low, high, at, out, hertz, kept):
    """Accelerations of the beads of a window at the positions in row ``at``, in row ``out``.

    ``hertz`` is None if contacts are damped; velocities are then those of row V.
    """
    if hertz is None:
        damped_forces(w, low, high, at, V, out, kept, w[SPARE : SPARE + ROW])
    else:
        elastic_forces(w, low, high, at, out, hertz, kept)


@inlined
def elastic_forces(w, low, high, at, out, hertz, kept):
    """`forces` without damping."""
    if hertz:
        for c in range(low, high + 1):
            d = w[AT_REST + c] + (w[at + c] - w[at + c + 1])
            d = d if d > LEAST else 0.0
            root = math.sqrt(d)
            kept[c] = root
            w[FORCE + c] = w[STIFFNESS + c] * (d * root)
    else:
        for c in range(low, high + 1):
            d = w[AT_REST + c] + (w[at + c] - w[at + c + 1])
            d = d if d > LEAST else 0.0
            kept[c] = d
            w[FORCE + c] = w[STIFFNESS + c] * power(d, w[EXPONENT + c])
    if low > 0:
        kept[low] = w[FORCE + low] = 0.0
    for i in range(low, high):
        w[out + i] = (w[FORCE + i] - w[FORCE + i + 1]) * w[INVERSE_MASS + i] + w[BODY + i]


@inlined
def place(w, low, high, h, c, weights):
    """Positions at a stage."""
    for i in range(low, high):
        push, stage = 0.0, F0 + i
        for weight in weights:
            push += weight * w[stage]
            stage += ROW
        at = 1 + i
        w[TRIAL + at] = w[X + at] + h * (c * w[V + at] + h * push)


@compiled
def elastic_step(w, low, high, h, hertz, kept, last):
    """`try_step` without damping."""
    place(w, low, high, h, C1, A1)
    elastic_forces(w, low, high, TRIAL, F1, hertz, kept[1])
    place(w, low, high, h, C2, A2)
    elastic_forces(w, low, high, TRIAL, F2, hertz, kept[2])
    place(w, low, high, h, C3, A3)
    elastic_forces(w, low, high, TRIAL, F3, hertz, kept[3])
    place(w, low, high, h, C4, A4)
    elastic_forces(w, low, high, TRIAL, F4, hertz, kept[4])
    place(w, low, high, h, C5, A5)
    elastic_forces(w, low, high, TRIAL, F5, hertz, kept[5])
    place(w, low, high, h, C6, A6)
    elastic_forces(w, low, high, TRIAL, F6, hertz, kept[6])
    place(w, low, high, h, C7, A7)
    elastic_forces(w, low, high, TRIAL, F7, hertz, kept[7])
    for i in range(low, high):
        at = 1 + i
        push = B0 * w[F0 + i] + B2 * w[F2 + i] + B3 * w[F3 + i]
        push += B4 * w[F4 + i] + B5 * w[F5 + i] + B6 * w[F6 + i]
        change = V0 * (w[F0 + i] + w[F7 + i]) + V2 * (w[F2 + i] + w[F6 + i])
        change += V3 * (w[F3 + i] + w[F5 + i]) + V4 * w[F4 + i]
        w[NEW_X + at] = w[X + at] + h * (w[V + at] + h * push)
        w[NEW_V + at] = w[V + at] + h * change
    elastic_forces(w, low, high, NEW_X, F8, hertz, last)


@compiled
def try_step(w, low, high, h, hertz, kept, last):
    """Stages of a step from row F0 on; ``last`` receives the overlaps at its end."""
    if hertz is None:
        damped_step(w, low, high, h, kept, last)
    else:
        elastic_step(w, low, high, h, hertz, kept, last)


@maximal
def largest(w, at, low, high):
    """Largest number of a part of a row; NaN is found by the caller."""
    top = 0.0
    for i in range(low, high):
        top = max(top, w[at + i])
    return top


@inlined
def elastic_errors(w, low, high, h):
    """Error of each bead in units of its scale, in the row WORK."""
    for i in range(low, high):
        error = E0 * w[F0 + i] + E2 * w[F2 + i] + E3 * w[F3 + i] + E4 * w[F4 + i]
        error += E5 * w[F5 + i] + E6 * w[F6 + i] + E7 * w[F7 + i] + E8 * w[F8 + i]
        w[WORK + i] = abs(h * error) / w[SCALE + i]


@compiled
def error_of(w, low, high, h, rtol, hertz):
    """Largest error of a step, in units of speeds nearby."""
    own, after = SPEED + NEIGHBOURS, NEAR + NEIGHBOURS + 1
    for i in range(low, high):
        a, b = abs(w[V + 1 + i]), abs(w[NEW_V + 1 + i])
        a = a if a > b else b
        w[own + i] = a
        w[WORK + i] = a if w[F0 + i] != 0.0 else 0.0
    for i in range(NEIGHBOURS):
        w[SPEED + low + i] = w[own + high + i] = 0.0
    least = SLOW * largest(w, WORK, low, high) + SMALLEST
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
