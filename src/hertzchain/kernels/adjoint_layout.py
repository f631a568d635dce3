"""Layout of the rows of the kernels that integrate one chain and differentiate the integration.

All rows are in one flat array with constant offsets, as in `hertzchain.kernels.elastic_layout`.
Positions, velocities and `U` have an entry for each wall, the first and the last; other rows begin
with bead 1, or with contact 0.  Contact c joins entries c and c + 1 of the positions.

Rows of the integration:

- `X`, `V`: positions and velocities at the start of a step; `NEW_X`, `NEW_V`: at its end;
  `TRIAL`: positions at a stage;
- `F0` to `F8`: accelerations at the stages, of which the last is at the end of the step;
- `AT_REST`: overlap of each contact at displacement 0, negative for a gap; `STIFFNESS`,
  `EXPONENT`, `INVERSE_MASS`; `BODY`: constant acceleration of each bead;
- `NOISE`, `SPEED`, `NEAR`, `SCALE`: units of the errors, as in `hertzchain.kernels.rkn8_step`.

Rows of the adjoint:

- `LX`, `LV`: derivatives with respect to the state; `U`: those with respect to the accelerations
  at a stage, divided by the masses; `XI0` to `XI7`: those with respect to positions at the stages;
- `BY_MASS`, `BY_STIFFNESS`, `BY_OVERLAP`, `BY_BODY`: derivatives with respect to parameters.
"""

from __future__ import annotations

# Five cache lines more than a multiple of 4096 bytes, so that rows do not compete for cache lines.
ROW = 4096 + 40
(X, V, TRIAL, NEW_X, NEW_V, FORCE, F0, F1, F2, F3, F4, F5, F6, F7, F8, AT_REST, STIFFNESS, EXPONENT,
 INVERSE_MASS, BODY, NOISE, SPEED, NEAR, SCALE, WORK, LX, LV, U, XI0, XI1, XI2, XI3, XI4, XI5, XI6,
 XI7, TRANSFER, FACTOR, BY_MASS, BY_STIFFNESS, BY_OVERLAP, BY_BODY, END_OF_ROWS,
 ) = range(0, 43 * ROW, ROW)  # fmt: skip
# Further rows of damped contacts.  `STAGE_V`, `STAGE_A`, `ZX` and `ZV` have one row for each of the
# twelve stages.  `PULLS` is 1 for contacts that may pull, `RELEASED` for those that are released.
(DAMPING, OVERLAP_POWER, PULLS, RELEASED, RATE, P, NEW_P, TRIAL_P, TRIAL_V, IMPULSE, PUSH, END_A,
 SPARE, BY_DAMPING, STAGE_V,
 ) = range(END_OF_ROWS, END_OF_ROWS + 15 * ROW, ROW)  # fmt: skip
STAGE_A, ZX, ZV, END_OF_DAMPED_ROWS = range(STAGE_V + 12 * ROW, STAGE_V + 60 * ROW, 12 * ROW)
# A step uses up to this number of entries in addition to the beads.
SPACE = 40
MAX_BEADS = ROW - SPACE

STAGES = 9
# Numbers kept in a step with damping: overlaps and closing speeds at twelve stages, the contacts
# that are released, and those released (their overlap) or joined again (minus it) at its end.
KEPT_CLOSINGS, KEPT_RELEASED, KEPT_SWITCHES, KEPT_DAMPED = 12, 24, 25, 26
# Clock of a run, and its counts: steps in the block, window, steps tried.  The usual step is that
# without a contact that opens.
TIME, STEP, MOST, USUAL, CLOCK = range(5)
STEPS, LOW, HIGH, TRIED, CANDIDATES, BASE, RELEASES, COUNTS = range(8)
# Reasons to return.
BLOCK_FULL, TIME_REACHED, ALL_FOUND, STEP_TOO_SMALL, STEP_LIMIT, CUT_OFF = range(1, 7)

# Kinds of events: first velocity maximum of a bead, first largest overlap of a contact, all maxima
# of the mean force of two contacts, all maxima of a bead's velocity.
VELOCITY, CLOSING, GAUGE, MAXIMUM = range(4)
# Columns of a target: kind, bead or contact, second contact; columns of events: number of the
# step, fraction of the step, time.
KIND, PLACE, SECOND, TARGET = range(4)
AT_STEP, FRACTION, AT_TIME, FOUND = range(4)
# Rows of an event, after the numbers kept in its step: positions, velocities, accelerations.
EVENT_X, EVENT_V, EVENT_A, EVENT_ROWS = range(4)
# A released contact: number of the step after which it is released, its number, and the overlaps
# and closing speeds of the contact behind it, itself, and the contact ahead.
AT_RELEASE, RELEASED_CONTACT, RELEASED_OVERLAPS, RELEASED_CLOSINGS, RELEASE = 0, 1, 2, 5, 8
