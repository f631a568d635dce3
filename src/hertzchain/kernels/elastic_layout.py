"""Layout of the arrays of the elastic kernel: rows of chains, lanes, gauges and results.

Several chains are integrated side by side, one per *lane*.  All rows of all lanes are in one flat
array with constant offsets, so that the compiler can exclude overlaps between them: entry i
of lane l in row r is ``w[r + i * LANES + l]``.  Positions and velocities have an entry for each
wall, the first and the last; other rows begin with bead 1, or with contact 0.
"""

from __future__ import annotations

# With as many lanes as a cache line has numbers, the entries of the same lane of two neighbouring
# beads never share a vector register, and a value just stored is read back as it was stored.
LANES = LINE = 8
# Five cache lines more than a multiple of 4096 bytes, so that rows do not compete for cache lines.
ROW = LINE * (4096 + 5)
(X, TRIAL, NEW_X, V, NEW_V, FORCE, F0, F1, F2, F3, F4, F5, F6, F7, F8, AT_REST, STIFFNESS,
 EXPONENT, BODY, INVERSE_MASS, H, PEAKED, CROSSED, FLAG, SPEED, NEAR, SCALE, NOISE, WORK,
 DEFECT, KEPT_X, KEPT_V, KEPT_F0, END_OF_ROWS) = range(0, 34 * ROW, ROW)  # fmt: skip
# A step uses up to seven entries per lane in addition to the beads.
MAX_BEADS = ROW // LANES - 7

# Rows of a chain as given: (ROWS, N + 1).  Beads have the first N entries; contacts are numbered
# with the walls.  Overlaps at rest are the initial ones, negative across a gap; `STATIC_*` are
# the forces and overlaps of `hertzchain.simulation.wall_bound`.
(START_V, GIVEN_INVERSE_MASS, GIVEN_BODY, GIVEN_NOISE, GIVEN_AT_REST, GIVEN_STIFFNESS,
 GIVEN_EXPONENT, STATIC_FORCE, STATIC_OVERLAP, GIVEN_ROWS) = range(10)  # fmt: skip
# Scalars of a chain: time to stop at, first step, whether the run ends without that time, number of
# strikers, least momentum transferred by the first contact with the wall, whether motion can escape
# from the wall, the time after the first transit that a run on a soft wall may take, whether
# only the largest force on the wall is requested, so that the run may end before the impact does
# (without constant forces), and the longest run, in times of the pulse, until the largest force on
# a cap behind the row is complete (0 without a cap or a bound).
(UNTIL, FIRST_STEP, BY_ITSELF, STRIKERS, LEAST_PUSH, CAN_ESCAPE, REBOUNDS, PEAK_ONLY, LONGEST,
 NUMBERS) = range(10)  # fmt: skip

# Entries of a lane.  The last ones are its tolerance, and the largest force on the wall and its
# time while it is proven with a larger tolerance (`hertzchain.kernels.elastic_proof`).
(TIME, STEP, LENGTH, WORST, FASTEST, MOST, TRIED, STEPS, GOOD, SINCE_CROSSING, LAST_CROSSING, PEAKS,
 CROSSINGS, FIRST_IMPULSE, FIRST_END, LAST_IMPULSE, LAST_END, WATCH_START, TRANSIT, DUE, BOUNDED,
 SINCE, IMPACT_IMPULSE, TOLERANCE, EXACT_PEAK, EXACT_TIME, LANE_ROWS) = range(27)  # fmt: skip
# Entries of a gauge: gauge 0 is the right wall, others are sensors in beads.  Up to four maxima of
# increasing height are stored, because only the end of the run determines which of them is high
# enough.
IMPULSE, PEAK, PEAK_TIME, REST, HIGHEST_FALLEN, MAXIMA, MAXIMUM_0 = range(7)
KEPT_MAXIMA = 4
GAUGE_ROWS = MAXIMUM_0 + 2 * KEPT_MAXIMA

# Rows of results per bead or contact, (RECORDS, N).
(RECORD_PEAK_TIME, RECORD_PEAK, RECORD_CROSSING, RECORD_OVERLAP, RECORD_RESIDENCE, FINAL_X, FINAL_V,
 RECORDS) = range(8)  # fmt: skip
# Results of a chain; the last ones correspond to entries of the lane with the same names.
(END_TIME, STATUS, TAKEN, REFUSED, WALL_FIRST_IMPULSE, WALL_FIRST_END, WALL_SINCE,
 WALL_IMPACT_IMPULSE, WALL_COMPLETE, SUMMARY) = range(10)  # fmt: skip

# Reasons for the end of a chain; 0 while it is running.
(PULSE_LEFT, TIME_REACHED, WALL_DONE, TRANSIT_LIMIT, NOTHING_MORE, STEP_LIMIT,
 STEP_TOO_SMALL) = range(1, 8)  # fmt: skip

# Rows of kinks (`hertzchain.kernels.elastic_kinks`), in one flat array, too: entry of the contact
# in the rows, sign of the time, time since closing or until opening, length of the step,
# coefficients, inverse masses of both beads, and the defects of stages 1 to 7 (row 0 is unused), of
# the end of the step and of its error.
MAX_KINKS = 8 * LINE
(
    KINK_AT,
    KINK_SIGN,
    KINK_Q,
    KINK_STEP,
    KINK_A,
    KINK_B,
    KINK_LEFT,
    KINK_RIGHT,
    KINK_SHIFT,
    *_,
    KINK_SHIFT_X,
    KINK_SHIFT_V,
    KINK_ERROR,
    FOUND,
) = range(0, 20 * MAX_KINKS, MAX_KINKS)
# The same rows, without defects, of contacts that may have a kink, and then: distance to go until
# the contact opens or closes and the derivatives of this distance by other forces, acceleration by
# a unit of the contact's own force, stiffness, largest time to the kink, and unit of errors of the
# velocity.
(
    FOUND_D,
    FOUND_RATE,
    FOUND_A,
    FOUND_J,
    FOUND_PUSH,
    FOUND_STIFFNESS,
    FOUND_REACH,
    FOUND_UNIT,
    KINK_ROWS,
) = range(FOUND + KINK_SHIFT, FOUND + KINK_SHIFT + 9 * MAX_KINKS, MAX_KINKS)

# Entries of `signal`: set the first one to stop; the second counts chains that have ended.
STOP, DONE = 0, 1
