"""One step of RKN8(6) and its error, for several chains side by side.

The layout is that of `hertzchain.kernels.elastic_layout`, the method that of
`hertzchain.kernels.rkn8`.
"""

from __future__ import annotations

from numba import njit

from .compilation import CONTRACTED
from .elastic_forces import forces
from .elastic_layout import (
    CROSSED,
    F0,
    F1,
    F2,
    F3,
    F4,
    F5,
    F6,
    F7,
    F8,
    FASTEST,
    FLAG,
    FORCE,
    LANES,
    NEAR,
    NEW_V,
    NEW_X,
    NOISE,
    PEAKED,
    ROW,
    SCALE,
    SPEED,
    TRIAL,
    WORK,
    WORST,
    H,
    V,
    X,
)
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

compiled = njit(**CONTRACTED)
inlined = njit(forceinline=True, **CONTRACTED)
summing = njit(forceinline=True, **(CONTRACTED | {"fastmath": True}))

STAGES = 9
# Safety factor, and bounds of the change of the step.
SAFETY, SHRINKAGE, GROWTH = 0.85, 0.1, 4.0
# Speeds below this fraction of that of the fastest bead in contact are not resolved; smallest
# scale.
SLOW, SMALLEST = 1e-4, 1e-290
# Speeds are those of the fastest bead within this distance.
NEIGHBOURS = 3
B0, _, B2, B3, B4, B5, B6 = B_POSITION
V0, _, V2, V3, V4, _, _, _ = B_VELOCITY
E0, _, E2, E3, E4, E5, E6, E7, E8 = E_VELOCITY


@inlined
def place(w, size, c, weights):
    """Positions at a stage."""
    for i in range(size):
        push, stage = 0.0, F0 + i
        for weight in weights:
            push += weight * w[stage]
            stage += ROW
        h, at = w[H + i], LANES + i
        w[TRIAL + at] = w[X + at] + h * (c * w[V + at] + h * push)


@inlined
def keep(w, places, pushes, stage):
    """Store the forces of the gauges, which are means of two contacts, at a stage."""
    for g in range(len(places)):
        a, b = FORCE + places[g, 0] * LANES, FORCE + places[g, 1] * LANES
        for lane in range(LANES):
            pushes[stage, g, lane] = 0.5 * (w[a + lane] + w[b + lane])


@inlined
def try_step(w, beads, hertz, places, pushes):
    """Positions, velocities and accelerations at the end of a step of each lane."""
    size = beads * LANES
    place(w, size, C1, A1)
    forces(w, beads, TRIAL, F1, hertz)
    place(w, size, C2, A2)
    forces(w, beads, TRIAL, F2, hertz)
    keep(w, places, pushes, 2)
    place(w, size, C3, A3)
    forces(w, beads, TRIAL, F3, hertz)
    keep(w, places, pushes, 3)
    place(w, size, C4, A4)
    forces(w, beads, TRIAL, F4, hertz)
    keep(w, places, pushes, 4)
    place(w, size, C5, A5)
    forces(w, beads, TRIAL, F5, hertz)
    keep(w, places, pushes, 5)
    place(w, size, C6, A6)
    forces(w, beads, TRIAL, F6, hertz)
    keep(w, places, pushes, 6)
    place(w, size, C7, A7)
    forces(w, beads, TRIAL, F7, hertz)
    keep(w, places, pushes, 7)
    for i in range(size):
        h, at = w[H + i], LANES + i
        push = B0 * w[F0 + i] + B2 * w[F2 + i] + B3 * w[F3 + i]
        push += B4 * w[F4 + i] + B5 * w[F5 + i] + B6 * w[F6 + i]
        change = V0 * (w[F0 + i] + w[F7 + i]) + V2 * (w[F2 + i] + w[F6 + i])
        change += V3 * (w[F3 + i] + w[F5 + i]) + V4 * w[F4 + i]
        w[NEW_X + at] = w[X + at] + h * (w[V + at] + h * push)
        w[NEW_V + at] = w[V + at] + h * change
    forces(w, beads, NEW_X, F8, hertz)
    keep(w, places, pushes, 8)


@inlined
def largest(w, beads, out):
    """Largest of each lane over the row `WORK`, which is overwritten."""
    n = beads
    while n > 1:
        half = (n + 1) // 2
        for i in range((n - half) * LANES):
            a, b = w[WORK + i], w[WORK + half * LANES + i]
            # NaN is kept.
            w[WORK + i] = a if (a >= b) | (a != a) else b
        n = half
    for lane in range(LANES):
        out[lane] = w[WORK + lane]


@summing
def total(w, at, size):
    """Sum of a row."""
    s = 0.0
    for i in range(size):
        s += w[at + i]
    return s


@inlined
def estimate(w, beads, rtol, lane):
    """Largest error of each lane, in units of speeds nearby; marks beads and contacts with events.

    Returns the sum of the marks: 1 for a bead whose push has ended, 2 for a contact that has
    stopped closing.
    """
    size = beads * LANES
    for i in range(size):
        a, b = abs(w[V + LANES + i]), abs(w[NEW_V + LANES + i])
        a = a if a > b else b
        w[SPEED + NEIGHBOURS * LANES + i] = a
        w[WORK + i] = a if w[F0 + i] != 0.0 else 0.0
    largest(w, beads, lane[FASTEST])
    for i in range(beads):
        for one in range(LANES):
            w[SCALE + i * LANES + one] = SLOW * lane[FASTEST, one] + SMALLEST
    for i in range(size + 4 * LANES):
        a, b, c = w[SPEED + i], w[SPEED + LANES + i], w[SPEED + 2 * LANES + i]
        a = a if a > b else b
        w[NEAR + i] = a if a > c else c
    for i in range(size):
        a, b, c = w[NEAR + i], w[NEAR + 4 * LANES + i], w[SPEED + 3 * LANES + i]
        a = a if a > b else b
        a = a if a > c else c
        b, c = w[SCALE + i], w[NOISE + i] * w[H + i] / rtol
        a = a if a > b else b
        a = a if a > c else c
        w[SCALE + i] = a
        error = E0 * w[F0 + i] + E2 * w[F2 + i] + E3 * w[F3 + i] + E4 * w[F4 + i]
        error += E5 * w[F5 + i] + E6 * w[F6 + i] + E7 * w[F7 + i] + E8 * w[F8 + i]
        w[WORK + i] = abs(w[H + i] * error) / a
    for i in range(size):
        falls = (w[F2 + i] <= 0.0) | (w[F3 + i] <= 0.0) | (w[F4 + i] <= 0.0) | (w[F5 + i] <= 0.0)
        falls = falls | (w[F6 + i] <= 0.0) | (w[F7 + i] <= 0.0) | (w[F8 + i] <= 0.0)
        peaks = (w[F0 + i] > 0.0) & falls & (w[PEAKED + i] == 0.0)
        at = LANES + i
        stops = (w[V + at] > w[V + LANES + at]) & (w[NEW_V + at] <= w[NEW_V + LANES + at])
        stops = stops & (w[CROSSED + i] == 0.0)
        w[FLAG + i] = (1.0 if peaks else 0.0) + (2.0 if stops else 0.0)
    largest(w, beads, lane[WORST])
    return total(w, FLAG, size)


@compiled
def take_step(w, beads, hertz, rtol, places, pushes, state):
    """Try a step of each lane and return the result of `estimate`."""
    try_step(w, beads, hertz, places, pushes)
    return estimate(w, beads, rtol, state)


@inlined
def impulse_of(h, pushes, gauge, lane):
    """Impulse of a gauge in a step, by the weights of the method."""
    ends = V0 * (pushes[0, gauge, lane] + pushes[7, gauge, lane])
    within = V2 * (pushes[2, gauge, lane] + pushes[6, gauge, lane])
    within += V3 * (pushes[3, gauge, lane] + pushes[5, gauge, lane])
    return h * (ends + within + V4 * pushes[4, gauge, lane])
