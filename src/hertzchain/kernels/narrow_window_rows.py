r"""Arrays, forces and step of the narrow window (`hertzchain.kernels.narrow_window`).

Contact ``s`` of the window joins slots ``s`` and ``s + 1``; the last contact joins the last slot
and a bead at rest.  All numbers of the window are in one array ``w``, with a *row* for positions,
one for velocities, and so on; in a row, slot ``s`` of lane ``l`` has index ``s * lanes + l``::

      w = [ position        | velocity | trial | ... | stage 0 | ... | stage 7 ]
            ^ slot 0: lanes 0..7, slot 1: lanes 0..7, ...

Each *lane* is a separate chain with its own step; several chains are integrated side by side.  One
array with constant offsets, and loops without branches over a row, allow the compiler to process
several lanes with one instruction.

Forces of Hertz's law require only a square root, `hertz`; other exponents, which may differ between
contacts, use `hertzchain.kernels.powers.power`.  The functions are compiled for either kind when
they are first needed.
"""

from __future__ import annotations

import math

from numba import njit

from .compilation import CONTRACTED, internal
from .powers import power
from .rkn8_stages import Rows, step_on

LANES = 8
MAX_SLOTS = 32
# Length of a row: the longest window and a few more entries, so that the rows are not mapped to the
# same lines of the processor's cache.
ROW = (MAX_SLOTS + 3) * LANES
(
    POSITION, VELOCITY, TRIAL, STIFFNESS, EXPONENT, INVERSE_MASS, FORCE, STEP, ERROR,
    OLD_POSITION, OLD_VELOCITY, OLD_STAGE_0,
    STAGE_0, STAGE_1, STAGE_2, STAGE_3, STAGE_4, STAGE_5, STAGE_6, STAGE_7, CLOCK, END,
) = range(0, 22 * ROW, ROW)  # fmt: skip
# Scalars of each lane: entries of the row CLOCK, LANES for each. Time is counted from the last
# arrival. ARRIVED is 1 from the arrival at the candidate on, LAST is 1 if the candidate is the last
# bead, WATCH is 1 if an event may have occurred in the last step.
(
    ARRIVAL_TIME, TIME, OLD_STEP, TARGET_STEP, FREE_STEP, MAX_FORCE, ARRIVED, LAST, STEPS,
    NEXT_STEP, WATCH, CLOCK_SIZE,
) = range(0, 12 * LANES, LANES)  # fmt: skip
CHAIN, FIRST, BEAD, BEADS, PLACE_SIZE = range(5)

# Status codes of a chain.
WAITING, FOLLOWED, OUT_OF_ORDER, REAR_CUT, FRONT_CUT, INACCURATE, STALLED, BROKEN = range(8)
# Rows of `chains`, the parameters of every bead, and of `results`.
GIVEN_INVERSE_MASS, GIVEN_STIFFNESS, GIVEN_EXPONENT = 0, 1, 2
PEAK_VELOCITY, PEAK_TIME, ARRIVAL, PEAK_OVERLAP, RESIDENCE, COLUMNS = range(6)

# First step as a fraction of the local time scale, and growth factor of the steps that follow.
FIRST_STEP, GRADING = 1e-3, 1.4
# Before a contact opens, steps are at most this fraction of the time left until it opens.
APPROACH = 0.5
# Maximum number of steps per bead: ten times the number that any taper needs.
MAX_STEPS = 400

# In these short functions, reference counting would take longer than the computation; contraction
# saves 5% of the time. The second option is for functions called in every step and for the events,
# whose many arguments would take as long to pass as a step.
entry_point = njit(**CONTRACTED)
compiled = internal(**CONTRACTED)
inlined = internal(forceinline=True, **CONTRACTED)


@inlined
def hertz(overlap, stiffness):
    """Contact force k d^1.5; zero without overlap."""
    d = overlap if overlap > 0.0 else 0.0
    return stiffness * d * math.sqrt(d)


@inlined
def pushing(w, i, overlap, exponents):
    """Force of contact i at an overlap; ``exponents`` is `None` for Hertz's law."""
    if exponents is None:
        return hertz(overlap, w[STIFFNESS + i])
    return w[STIFFNESS + i] * power(overlap, w[EXPONENT + i])


@inlined
def press(w, low, high, stage, lanes, exponents):
    """Contact forces of slots at a stage."""
    positions = POSITION if stage == 0 else TRIAL
    for i in range(low, high):
        overlap = w[positions + i] - w[positions + i + lanes]
        w[FORCE + lanes + i] = pushing(w, i, overlap, exponents)


@inlined
def acceleration(w, i, lanes):
    """Acceleration of a slot by the forces of its contacts, Eq. (4) of the paper."""
    return (w[FORCE + i] - w[FORCE + lanes + i]) * w[INVERSE_MASS + i]


@inlined
def accelerate(w, low, high, out, lanes, exponents):
    """Forces and accelerations of slots at their positions."""
    press(w, low, high, 0, lanes, exponents)
    for i in range(low, high):
        w[out + i] = acceleration(w, i, lanes)


try_step, velocity_error = step_on(
    Rows(
        POSITION, VELOCITY, TRIAL, POSITION, VELOCITY,
        (STAGE_0, STAGE_1, STAGE_2, STAGE_3, STAGE_4, STAGE_5, STAGE_6, STAGE_7), STEP,
    ),
    press, acceleration,
)  # fmt: skip


@inlined
def take_step(w, size, lanes, exponents):
    """One step of order 8 in every lane; stage 0 must hold the accelerations at its start."""
    try_step(w, 0, size, None, lanes, exponents)
