"""Limits that several kernels share, and the Python code that prepares or reads their arrays.

This module does not import numba.
"""

from __future__ import annotations

# Number of beads on either side whose speeds determine the unit of the error of a bead, and lower
# bound of the unit as a fraction of the speed of the fastest bead in contact, used behind a pulse.
NEIGHBOURS, SLOW = 3, 1e-4
# Relative rounding error of a force, as amplified by the error estimates of DOP853.
ROUNDING = 5e-15
# Speeds below this fraction of the change that the contact forces on a bead cause in a step are not
# taken for the pulse: static forces cancel except for rounding.
ROUNDED = 1e-11
# The pulse has not reached a bead that is slower than this fraction of the speeds around it.  Ahead
# of the pulse, rounding errors may have maxima.
REACHED = 1e-11
# A first contact with a wall has an impulse of at least this fraction of the sum of all momenta.
# Weaker contacts are ignored: the foot of a pulse presses the last bead against a very stiff wall
# so weakly that the errors of the steps decide whether the contact opens briefly.  With the larger
# tolerances of ensembles and gradients, these errors cause impulses of up to 2e-7.
MIN_PUSH, MIN_ROUGH_PUSH = 1e-9, 1e-6
# The force of a sensor has passed a maximum when it has decreased by this fraction of it; maxima
# less than this fraction of the largest one are ignored.  Both are counted from the force at rest.
FALL, MIN_HEIGHT = 0.1, 0.01
