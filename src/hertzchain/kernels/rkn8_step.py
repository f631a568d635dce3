"""One step of RKN8(6) and its error, for several chains side by side.

The layout is that of `hertzchain.kernels.elastic_layout`, the method that of
`hertzchain.kernels.rkn8`.
"""

from __future__ import annotations

from .compilation import CONTRACTED, internal
from .elastic_forces import acceleration, press, press_hertz
from .elastic_kinks import shift
from .elastic_layout import (
    CROSSED,
    DEFECT,
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
    KINK_AT,
    KINK_ERROR,
    KINK_SHIFT,
    KINK_SHIFT_V,
    KINK_SHIFT_X,
    LANES,
    MAX_KINKS,
    NEAR,
    NEW_V,
    NEW_X,
    NOISE,
    PEAKED,
    SCALE,
    SPEED,
    TRIAL,
    WORK,
    WORST,
    H,
    V,
    X,
)
from .limits import NEIGHBOURS, SLOW
from .rkn8_stages import V0, V2, V3, V4, Rows, step_on

compiled = internal(**CONTRACTED)
inlined = internal(forceinline=True, **CONTRACTED)
summing = internal(forceinline=True, **(CONTRACTED | {"fastmath": True}))

STAGES = 9
# Safety factor, and bounds of the change of the step.
SAFETY, SHRINKAGE, GROWTH = 0.8, 0.1, 4.0
# Smallest scale.
MIN_SCALE = 1e-290


@inlined
def keep(w, places, pushes, stage):
    """Store the forces of the gauges, which are means of two contacts, at a stage."""
    for g in range(len(places)):
        a, b = FORCE + places[g, 0] * LANES, FORCE + places[g, 1] * LANES
        for lane in range(LANES):
            pushes[stage, g, lane] = 0.5 * (w[a + lane] + w[b + lane])


@inlined
def press_at_stage(w, low, high, stage, hertz, gauges):  # noqa: ARG001
    """Store the forces of the last stage but the first, and begin with those of this stage."""
    places, pushes, kinks, count = gauges
    if stage > 2:
        keep(w, places, pushes, stage - 1)
    shift(w, TRIAL, kinks, count, KINK_SHIFT + stage * MAX_KINKS)
    if hertz:
        # The compiler does not use vectors if the number of lanes is a constant.
        for i in range(pushes.shape[2]):
            press_hertz(w, i, TRIAL)
    else:
        press(w, high // LANES, TRIAL, hertz)


@inlined
def accelerate(w, i, hertz):
    """Acceleration of a bead at a stage, after the force of the next contact.

    Square roots then overlap with the sums over stages.
    """
    if hertz:
        press_hertz(w, i + LANES, TRIAL)
    return acceleration(w, i)


take_stages, velocity_error = step_on(
    Rows(
        X + LANES, V + LANES, TRIAL + LANES, NEW_X + LANES, NEW_V + LANES,
        (F0, F1, F2, F3, F4, F5, F6, F7), H,
    ),
    press_at_stage, accelerate,
)  # fmt: skip


@inlined
def try_step(w, beads, hertz, places, pushes, kinks, count):
    """Positions, velocities and accelerations at the end of a step of each lane."""
    size = beads * LANES
    take_stages(w, 0, size, None, hertz, (places, pushes, kinks, count))
    keep(w, places, pushes, 7)
    shift(w, NEW_X, kinks, count, KINK_SHIFT_X)
    shift(w, NEW_V, kinks, count, KINK_SHIFT_V)
    press(w, beads, NEW_X, hertz)
    for i in range(size):
        w[F8 + i] = acceleration(w, i)
    keep(w, places, pushes, 8)


@inlined
def largest(w, beads, out):
    """Largest of each lane over the row `WORK`, which is overwritten; NaN propagates."""
    while beads > 1:
        half = (beads + 1) // 2
        rest = w[WORK + half * LANES :]
        for i in range((beads - half) * LANES):
            a, b = w[WORK + i], rest[i]
            w[WORK + i] = a if (a >= b) | (a != a) else b
        beads = half
    for lane in range(LANES):
        out[lane] = w[WORK + lane]


@inlined
def spread(w, row, beads, values):
    """Copy a value of each lane to all beads in a row."""
    for lane in range(LANES):
        w[row + lane] = values[lane]
    # Vectors are copied, not single numbers.
    done, size = LANES, beads * LANES
    while done < size:
        rest = w[row + done :]
        for i in range(min(done, size - done)):
            rest[i] = w[row + i]
        done += done


@summing
def total(w, at, size):
    """Sum of a row."""
    s = 0.0
    for i in range(size):
        s += w[at + i]
    return s


@inlined
def estimate(w, beads, rtol, lane):
    """Largest error of each lane, in units of nearby speeds; marks beads and contacts with events.

    Returns the sum of the marks: 1 for a bead whose velocity may have its first maximum, 2 for a
    contact whose overlap has its first maximum.
    """
    size = beads * LANES
    for i in range(size):
        a, b = abs(w[V + LANES + i]), abs(w[NEW_V + LANES + i])
        a = a if a > b else b
        w[SPEED + NEIGHBOURS * LANES + i] = a
        w[WORK + i] = a if w[F0 + i] != 0.0 else 0.0
    largest(w, beads, lane[FASTEST])
    spread(w, SCALE, beads, lane[FASTEST])
    for i in range(size + 4 * LANES):
        a, b, c = w[SPEED + i], w[SPEED + LANES + i], w[SPEED + 2 * LANES + i]
        a = a if a > b else b
        w[NEAR + i] = a if a > c else c
    for i in range(size):
        a, b, c = w[NEAR + i], w[NEAR + 4 * LANES + i], w[SPEED + 3 * LANES + i]
        a = a if a > b else b
        a = a if a > c else c
        b, c = SLOW * w[SCALE + i] + MIN_SCALE, w[NOISE + i] * w[H + i] / rtol
        a = a if a > b else b
        a = a if a > c else c
        w[SCALE + i] = a
        w[WORK + i] = abs(w[H + i] * (velocity_error(w, i, F0, F8) + w[DEFECT + LANES + i])) / a
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
def take_step(w, beads, hertz, rtol, places, pushes, state, kinks, count):
    """Try a step of each lane and return the result of `estimate`."""
    try_step(w, beads, hertz, places, pushes, kinks, count)
    shift(w, DEFECT, kinks, count, KINK_ERROR)
    events = estimate(w, beads, rtol, state)
    for n in range(count):
        at = int(kinks[KINK_AT + n])
        w[DEFECT + at] = w[DEFECT + LANES + at] = 0.0
    return events


@inlined
def impulse_of(h, pushes, gauge, lane):
    """Impulse of a gauge in a step, by the weights of the method."""
    ends = V0 * (pushes[0, gauge, lane] + pushes[7, gauge, lane])
    within = V2 * (pushes[2, gauge, lane] + pushes[6, gauge, lane])
    within += V3 * (pushes[3, gauge, lane] + pushes[5, gauge, lane])
    return h * (ends + within + V4 * pushes[4, gauge, lane])
