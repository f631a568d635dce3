"""Layout of the state arrays: clock, counters, peaks, crossings and wall records.

These parts of the state are in addition to the motion; `hertzchain.kernels.full_chain` writes them
and `hertzchain.simulation` reads them.
"""

from __future__ import annotations

# Entries of `clock` and `counts`, the scalars of the state.
TIME, STEP, SINCE_CROSSING, FASTEST = 0, 1, 2, 3
INITIAL_ENERGY, INITIAL_MOMENTUM, ENERGY_UNIT, MOMENTUM_UNIT = range(4, 8)
ENERGY_DRIFT, MOMENTUM_DRIFT = 8, 9
# Speed below which relative motion is not resolved; time until which beads behind the window stay
# out of contact (`hertzchain.kernels.active_beads`).
UNRESOLVED, IDLE_UNTIL, CLOCK_SIZE = 10, 11, 12
STEPS, EVALUATIONS, FRAMES, PEAKS, CROSSINGS, LAST_CROSSING, FROZEN, SEGMENT, SWITCHES = range(9)
# First bead of the window and the one after its last; beads that the leading pulse has left.
LOW, HIGH, LEFT_BY_PULSE, COUNTS_SIZE = range(9, 13)
# Rows of `flights`: where and when each bead behind the window left it.
FLIGHT_POSITION, FLIGHT_TIME, FLIGHT_ROWS = range(3)
# Rows of `peaks`, of `crossings` and of `walls`; `TOUCHING` is 1 while a bead touches the wall.
PEAK_TIME, PEAK_VELOCITY = 0, 1
# `OVERLAP` is the one at the crossing, `LARGEST_OVERLAP` the largest of all waves so far.
# `HANDED_OVER` begins with minus the momentum of the beads ahead, and is complete at the crossing.
CROSSING_TIME, OVERLAP, RESIDENCE, HANDED_OVER, RISE_TIME = range(5)
LEADING_MOMENTUM, LEADING_ENERGY, LARGEST_OVERLAP, CROSSING_ROWS = range(5, 9)
WALL_PEAK_TIME, WALL_PEAK, FIRST_IMPULSE, FIRST_END, TURNED_BACK = range(5)
TOUCHES, TOUCHING, WALL_ROWS = range(5, 8)
# Rows of `completion`, written between calls of the compiled loop: start of the watch on a wall,
# transit time, time of the next check; time from which the peak is complete, and impulse and number
# of touches until then.
WATCH_START, TRANSIT, DUE, SINCE, IMPACT_IMPULSE, IMPACT_TOUCHES, COMPLETION_ROWS = range(7)
# Peak time of a striker, which has its largest velocity from the start.
STRIKER_PEAK_TIME = -1.0
