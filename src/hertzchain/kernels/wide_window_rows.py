r"""Arrays, forces and step of the wide window (`hertzchain.kernels.wide_window`).

One chain is followed at a time, and the loops without branches over the slots of the window allow
the compiler to process several *slots* with one instruction.  All numbers are in one array ``w``,
in *rows* with constant offsets; in a row, slot ``s`` is entry ``s``, and contact ``s`` joins slots
``s`` and ``s + 1``.
"""

from __future__ import annotations

import math

from .compilation import OPTIONS, compiled, internal
from .powers import power
from .rkn8_stages import Rows, step_on

SLOTS = 256
# Entries before and after a row, for reads beyond its ends; rows are aligned to the lines of the
# processor's cache.
MARGIN = 8
ROW = SLOTS + 2 * MARGIN
(
    POSITION, VELOCITY, TRIAL, STIFFNESS, EXPONENT, INVERSE_MASS, FORCE, SPEED, SCALE, GRADE,
    ERROR, NEW_VELOCITY,
    STAGE_0, STAGE_1, STAGE_2, STAGE_3, STAGE_4, STAGE_5, STAGE_6, STAGE_7, STAGE_8, END,
) = range(MARGIN, MARGIN + 22 * ROW, ROW)  # fmt: skip

# Scalars of the chain: time, time since the last crossing, next step; velocity of the bead and
# force of the contact at the last crossing.
TIME, SINCE_CROSSING, STEP, CREST, MAX_FORCE, CLOCK_SIZE = range(6)
# The chain's first entry in `given` and its number of beads; bead in slot 0, slots in use, first
# bead that still waits for an event, contact of the last crossing.
FIRST, BEADS, LOW, SIZE, WAITING, LAST_CROSSING, PLACE_SIZE = range(7)
# Rows of `given`, the parameters of every bead, and of `results`; 0 = not yet.
GIVEN_INVERSE_MASS, GIVEN_STIFFNESS, GIVEN_EXPONENT = 0, 1, 2
PEAK_VELOCITY, PEAK_TIME, ARRIVAL, PEAK_OVERLAP, RESIDENCE, COLUMNS = range(6)
# Beads behind `waiting` from which on the tolerated error grows from bead to bead.
UNGRADED = 4
# Lower bound of the speeds that scale the errors, as a fraction of the crest's velocity.
AT_REST = 1e-9

inlined = internal(forceinline=True, **OPTIONS)


@inlined
def force(w, i, overlap):
    """Force k d^p of contact i at an overlap."""
    if overlap <= 0.0:
        return 0.0
    if w[EXPONENT + i] == 1.5:
        return w[STIFFNESS + i] * overlap * math.sqrt(overlap)
    return w[STIFFNESS + i] * power(overlap, w[EXPONENT + i])


@compiled
def press(w, size, exponent):
    """Forces of all contacts at the trial positions.

    If all contacts have ``exponent`` 1.5 or 2, no powers are computed; any other value selects
    their own exponents.
    """
    if exponent == 1.5:
        for i in range(size):
            d = w[TRIAL + i] - w[TRIAL + i + 1]
            d = d if d > 0.0 else 0.0
            w[FORCE + 1 + i] = w[STIFFNESS + i] * d * math.sqrt(d)
    elif exponent == 2.0:
        for i in range(size):
            d = w[TRIAL + i] - w[TRIAL + i + 1]
            d = d if d > 0.0 else 0.0
            w[FORCE + 1 + i] = w[STIFFNESS + i] * d * d
    else:
        for i in range(size):
            d = w[TRIAL + i] - w[TRIAL + i + 1]
            w[FORCE + 1 + i] = w[STIFFNESS + i] * power(d, w[EXPONENT + i])


@inlined
def acceleration(w, i, exponent):  # noqa: ARG001
    """Acceleration of a slot by the forces of its contacts, Eq. (4) of the paper."""
    return (w[FORCE + i] - w[FORCE + 1 + i]) * w[INVERSE_MASS + i]


@inlined
def accelerate(w, size, exponent, accelerations):
    """Accelerations of all slots at the trial positions."""
    press(w, size, exponent)
    for i in range(size):
        w[accelerations + i] = acceleration(w, i, exponent)


@inlined
def press_at_stage(w, low, high, stage, exponent, nothing):  # noqa: ARG001
    """Forces of all contacts at a stage."""
    press(w, high, exponent)


take_step, velocity_error = step_on(
    Rows(
        POSITION, VELOCITY, TRIAL, TRIAL, NEW_VELOCITY,
        (STAGE_0, STAGE_1, STAGE_2, STAGE_3, STAGE_4, STAGE_5, STAGE_6, STAGE_7),
    ),
    press_at_stage, acceleration,
)  # fmt: skip


@inlined
def try_step(w, size, h, exponent):
    """One step of order 8; stage 0 must hold the accelerations at its start."""
    take_step(w, 0, size, h, exponent, None)
    accelerate(w, size, exponent, STAGE_8)


@inlined
def spread(w, size, speeds, wider):
    """Write the largest of the speeds of each slot and its two neighbours to row ``wider``."""
    for i in range(size):
        a, b, c = w[speeds + i - 1], w[speeds + i], w[speeds + i + 1]
        larger = a if a > b else b
        w[wider + i] = larger if larger > c else c


@compiled
def measure(w, size, crest):
    """Compute the speeds that scale the errors: the largest within three beads, graded."""
    for i in range(size):
        w[SPEED + i] = abs(w[VELOCITY + i]) + AT_REST * crest
    spread(w, size, SPEED, SCALE)
    spread(w, size, SCALE, SPEED)
    spread(w, size, SPEED, SCALE)
    for i in range(size):
        w[SCALE + i] *= w[GRADE + i]


@compiled
def grade(w, size, waiting, grading):
    """Compute the factors by which the tolerated error grows behind the waiting slot."""
    tolerated = 1.0
    for i in range(size - 1, -1, -1):
        if i < waiting - UNGRADED:
            tolerated *= grading
        w[GRADE + i] = tolerated


@compiled
def error_of_step(w, size, h):
    """Largest estimated error of the velocities, in units of their scales; NaN propagates."""
    for i in range(size):
        w[ERROR + i] = abs(h * velocity_error(w, i, STAGE_0, STAGE_8)) / w[SCALE + i]
    worst = 0.0
    for i in range(size):
        if not w[ERROR + i] <= worst:
            worst = w[ERROR + i]
    return worst
