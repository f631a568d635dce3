"""Layout of the state arrays: clock, counters, peaks, crossings and wall records.

These parts of the state are in addition to the motion; `hertzchain.kernels.full_chain` writes them
and `hertzchain.simulation` reads them.
"""

from __future__ import annotations

# Entries of `clock`: time, next step, time since the last crossing, largest speed so far; energy
# and momentum at the start, the units of their drifts, and the drifts.
TIME, STEP, SINCE_CROSSING, FASTEST = 0, 1, 2, 3
INITIAL_ENERGY, INITIAL_MOMENTUM, ENERGY_UNIT, MOMENTUM_UNIT = range(4, 8)
ENERGY_DRIFT, MOMENTUM_DRIFT = 8, 9
# Speed below which relative motion is not resolved; time until which beads behind the window stay
# out of contact (`hertzchain.kernels.active_beads`).
UNRESOLVED, IDLE_UNTIL, CLOCK_SIZE = 10, 11, 12
# Entries of `counts`: steps, evaluations of the forces, saved times, velocity maxima, crossings,
# contact of the last crossing, successive steps too short to change the time, piece of the drive,
# changes of modes.
STEPS, EVALUATIONS, FRAMES, PEAKS, CROSSINGS, LAST_CROSSING, FROZEN, SEGMENT, SWITCHES = range(9)
# First bead of the window and the one after its last; beads that the leading pulse has left.
LOW, HIGH, LEFT_BY_PULSE, COUNTS_SIZE = range(9, 13)
# Rows of `flights`: position and time at which each bead behind the window left it.
FLIGHT_POSITION, FLIGHT_TIME, FLIGHT_ROWS = range(3)
# Rows of `peaks`: first velocity maximum of each bead.
PEAK_TIME, PEAK_VELOCITY = 0, 1
# Rows of `crossings`, one column per contact.  A crossing is the first time at which the two beads
# have equal velocities; `OVERLAP` is the overlap there, `LARGEST_OVERLAP` the largest of all waves.
# `HANDED_OVER` starts as minus the initial momentum of the beads ahead; at the crossing, their
# momentum is added.
CROSSING_TIME, OVERLAP, RESIDENCE, HANDED_OVER, RISE_TIME = range(5)
LEADING_MOMENTUM, LEADING_ENERGY, LARGEST_OVERLAP, CROSSING_ROWS = range(5, 9)
# Rows of `walls`: largest force and its time; impulse and end of the first contact; time at which
# the bead at the wall first moves back; number of touches; 1 while the bead touches the wall; end
# of the last contact, and impulse until then.
WALL_PEAK_TIME, WALL_PEAK, FIRST_IMPULSE, FIRST_END, TURNED_BACK = range(5)
TOUCHES, TOUCHING, LAST_END, LAST_IMPULSE, WALL_ROWS = range(5, 10)
# Rows of `completion`, one column per wall, written between calls of the compiled loop: time from
# which the wall is watched, transit time, time of the next check, time since which the motion
# towards the wall cannot exceed the largest force; end of the impact, and impulse and number of
# touches until then.
WATCH_START, TRANSIT, DUE, BOUNDED, SINCE, IMPACT_IMPULSE, IMPACT_TOUCHES = range(7)
COMPLETION_ROWS = 7
# Peak time of a striker, which has its largest velocity from the start.
STRIKER_PEAK_TIME = -1.0
