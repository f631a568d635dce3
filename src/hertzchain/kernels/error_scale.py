"""Units in which errors of velocities are measured, bead by bead.

The unit is the largest speed of nearby beads, or larger if rounding errors of forces require it.
"""

from __future__ import annotations

from .active_beads import unresolved_speed
from .compilation import compiled, reduced
from .driving import PUSH, drive_at, rounding_of_drive
from .limits import NEIGHBOURS, SLOW

# Lower bound of the unit as a multiple of `unresolved_speed`.
FAINT = 100.0
# Errors of slower beads are ignored: the front has not reached them, and numbers may underflow.
AT_REST = 1e-290


@compiled
def fastest_nearby(speeds, scale):
    """Raise each bead's scale to the largest speed within a few beads."""
    beads = len(scale)
    raise_to(scale, speeds)
    for shift in range(1, min(NEIGHBOURS, beads - 1) + 1):
        raise_to(scale[: beads - shift], speeds[shift:beads])
        raise_to(scale[shift:], speeds[: beads - shift])


@compiled
def raise_to(values, least):
    """Raise each value to at least the corresponding entry of ``least``."""
    for i in range(len(values)):
        values[i] = least[i] if least[i] > values[i] else values[i]


@reduced
def fastest_pushed(speeds, pushing):
    """Largest speed of the beads on which a contact force acts."""
    fastest = 0.0
    for k in range(len(pushing) - 1):
        speed = speeds[k] if (pushing[k] != 0.0) | (pushing[k + 1] != 0.0) else 0.0
        fastest = speed if speed > fastest else fastest
    return fastest


@compiled
def velocity_scale(y, rtol, setup, speeds, scale):
    """Units of the errors of the velocities of beads."""
    # Beads without contact are ignored in the lower bound, because their motion is exact at any
    # speed.  The bound avoids short steps for the slow motion that remains behind a pulse, which is
    # not known accurately anyway.
    beads = len(scale)
    velocities = y[beads : 2 * beads]
    for k in range(beads):
        speeds[k] = abs(velocities[k])
    fastest = 0.0
    for k in range(beads - 1):
        if y[k] > y[k + 1]:
            fastest = max(fastest, speeds[k], speeds[k + 1])
    scale[:] = max(SLOW * fastest, FAINT * unresolved_speed(y, beads, rtol, setup, None))
    fastest_nearby(speeds, scale)


@compiled
def general_scale(
    time, h, y, y_new, wall_speed, setup, contacts, segment, rtol, rounding, speeds, scale
):
    """Units of errors for both ends of a step of a general chain.

    ``rounding`` is the relative rounding error of a force, as amplified by the error estimate.
    """
    # Beads may start from or come to rest within a step, because of gaps or a moving left wall.
    # The accuracy of velocities is limited by the rounding of static forces, and that of a force
    # that begins at a late time by the rounding of the time.
    beads = len(scale)
    before, after = y[beads : 2 * beads], y_new[beads : 2 * beads]
    for k in range(beads):
        a, b = abs(before[k]), abs(after[k])
        speeds[k] = a if a > b else b
    # Forces at the start are used, because a step that is far too long ends with arbitrary forces.
    pushing, inverse_mass = contacts.last_force, setup.inverse_mass
    fastest = fastest_pushed(speeds, pushing)
    rounded = rounding * h / rtol
    least = max(SLOW * fastest, FAINT * unresolved_speed(y, beads, rtol, setup, contacts))
    least = max(least, setup.law.slowest)
    for k in range(beads):
        unknown = (abs(pushing[k]) + abs(pushing[k + 1])) * inverse_mass[k] * rounded
        scale[k] = unknown if unknown > least else least
    if setup.drive == PUSH:
        unknown = abs(drive_at(time + h, setup, segment)[1]) * (time + h)
        unknown = max(unknown, rounding_of_drive(time, setup, segment))
        scale[0] = max(scale[0], unknown * inverse_mass[0] * rounded)
    for k in range(min(NEIGHBOURS, beads)):
        scale[k] = max(scale[k], abs(wall_speed), scale[0] if setup.drive == PUSH else 0.0)
    fastest_nearby(speeds, scale)
