"""Order-of-magnitude estimates of the speeds and times of the motion of a chain."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from ..chain.chain import Chain
from ..collision import Array, compression_time, reduced_mass
from ..errors import InputError, InputWarning, warn_user
from ..frozen import once
from .drive_pieces import drive_pieces

# Smallest contact time: steps are fractions of it, which must be representable.
MIN_CONTACT_TIME: Final = 1e-280
# Time [s] and transits beyond which the unit of the end of a run is probably wrong.
LONG_TIME: Final = 0.5
MANY_TRANSITS: Final = 1e3
# Largest net force on a bead in equilibrium, over the largest force: that of rounding errors.
UNBALANCED: Final = 1e-9
# Distance of two times of a drive, over the largest time, that is a rounding error.
ROUNDING: Final = 1e-12


def check_clock(chain: Chain) -> None:
    """Raise `InputError` if transit times are too short to represent."""
    times = transit_times(chain)
    k = int(np.argmin(times))
    if times[k] < MIN_CONTACT_TIME:
        raise InputError(
            f"a pulse would pass contact {k + 1} in {times[k]:g}{' s' * (chain.units == 'SI')}, "
            "too short a time to represent; check the units of masses, stiffness and velocities"
        )


def closing_speed(chain: Chain) -> float:
    """Largest speed at which two neighbours, or a bead and a wall, approach each other at time 0.

    It is negative or 0 if nothing approaches.
    """
    velocities = chain.velocities
    at_walls = (-velocities[0] if chain.left_wall else 0.0,
                velocities[-1] if chain.right_wall else 0.0)  # fmt: skip
    return float(max(*at_walls, *-np.diff(velocities)))


def impact_momentum(chain: Chain) -> float:
    """Momentum of the beads that move towards the right end at time 0."""
    return float(chain.masses @ np.maximum(chain.velocities, 0.0))


def is_static(chain: Chain) -> bool:
    """Whether the chain is at rest in equilibrium, so that nothing ever moves."""
    if chain.drive is not None or chain.velocities.any():
        return False
    state = chain.static_state
    contacts = np.where(chain.contact_stiffness > 0.0, state.forces, 0.0)
    net = state.body_forces - np.diff(contacts)
    largest = max(float(np.abs(each).max()) for each in (state.body_forces, contacts))
    return bool(np.abs(net).max() <= UNBALANCED * largest)


def fall_height(chain: Chain) -> float:
    """Distance of bead 1 from its position above the right wall without gaps, if it falls there.

    It is 0 if the chain is struck or driven, rests, or does not fall towards a right wall.
    """
    at_rest = chain.drive is None and not chain.velocities.any()
    if not at_rest or chain.right_wall is None or not chain.gravity > 0.0:
        return 0.0
    return float(chain.gaps.sum()) + chain.right_wall.gap


def fall_time(chain: Chain) -> float:
    """Time of free fall through `fall_height`, after which every bead may have hit the next one."""
    height = fall_height(chain)
    return math.sqrt(2.0 * height / chain.gravity) if height > 0.0 else 0.0


def rebound_time(chain: Chain, momentum: float) -> float:
    """Time in which all beads, as one body with a momentum, rebound from the row and its wall.

    It is half a period of their mass on all contacts in series; 0 without momentum, or without a
    right wall.
    """
    if chain.right_wall is None or not momentum > 0.0:
        return 0.0
    mass = float(chain.masses.sum())
    stiffness, p = chain.contact_stiffness[1:], chain.contact_exponents[1:]
    return float(rebound_in_series(mass, momentum / mass, stiffness, p))


def rebound_in_series(
    mass: ArrayLike, speed: ArrayLike, stiffness: Array, exponents: Array
) -> Array:
    """Half a period of a mass on contacts in series, which are along the last axis.

    If the exponents p are equal, the compliances k^(-1/p) add up, so that the result is the s-norm
    of the times on each contact, with s = (p + 1)/p.  Otherwise the largest p gives a longer time.
    """
    times = 2.0 * compression_time(
        np.expand_dims(mass, -1), stiffness, np.expand_dims(speed, -1), exponents
    )
    longest = times.max(axis=-1)
    s = 1.0 + 1.0 / exponents.max(axis=-1)
    ratios = times / np.expand_dims(longest, -1)
    return np.asarray(longest * (ratios ** np.expand_dims(s, -1)).sum(axis=-1) ** (1.0 / s))


def typical_speed(chain: Chain) -> float:
    """Estimate the largest speed from initial velocities, fall and drive, or from static forces."""
    fastest = float(np.abs(chain.velocities).max()) or chain.gravity * fall_time(chain)
    if chain.drive is None and fastest > 0.0:
        return fastest
    if chain.drive is None:
        static = chain.static_state
        return _pushed(chain, float(max(static.forces.max(), np.abs(static.body_forces).sum())))
    starts, pieces = drive_pieces(chain.drive)
    length = np.append(np.diff(starts), 0.0)
    cubic, sines, rates = np.abs(pieces[:, :4]).T, np.abs(pieces[:, 4::2]), np.abs(pieces[:, 5::2])
    if chain.drive.of == "displacement":
        slopes = cubic[1] + length * (2.0 * cubic[2] + length * 3.0 * cubic[3])
        return max(fastest, float((slopes + (sines * rates).sum(axis=1)).max()))
    # A force accelerates a free bead, and compresses the contact of a bead that is not free.
    sizes = cubic[0] + length * (cubic[1] + length * (cubic[2] + length * cubic[3]))
    size = float((sizes + sines.sum(axis=1)).max())
    time = float(transit_times(chain).min())
    return max(fastest, min(size * time / chain.masses[0], _pushed(chain, size)))


def _pushed(chain: Chain, force: float) -> float:
    """Speed at which bead 1 has the energy of the force times the overlap that it causes."""
    overlap = (force / chain.stiffness[0]) ** (1.0 / chain.contact_exponents[1])
    return math.sqrt(force * overlap / chain.masses[0])


def transit_times(chain: Chain, energy: float | None = None) -> Array:
    """Estimate the time in which a pulse passes each contact, shape (N - 1,).

    The estimate is the smallest of three times: the compression time of the two beads for a pulse
    that keeps its energy, as in a slow taper (v ~ m^(-1/2)); the time of sound in a compressed
    contact; and the duration of the pieces of the drive.  It determines the first step and the
    spacing of saved times.
    """
    return _first_times(chain) if energy is None else _times(chain, energy)


@once
def _first_times(chain: Chain) -> Array:
    times = _times(chain, None)
    times.setflags(write=False)
    return times


def _times(chain: Chain, energy: float | None) -> Array:
    """`transit_times`, of the motion at the start unless an energy is given."""
    masses, p = chain.masses, chain.exponents
    reduced = reduced_mass(masses[:-1], masses[1:])
    times = np.full(chain.beads - 1, np.inf)
    fastest = int(np.argmax(np.abs(chain.velocities)))
    speed = abs(chain.velocities[fastest]) * np.sqrt(masses[fastest] / masses[:-1])
    if (time := fall_time(chain)) > 0.0:
        speed = np.full(chain.beads - 1, chain.gravity * time)
    if energy is not None:
        speed = np.sqrt(2.0 * energy / masses[:-1])
    if speed.any():
        times = compression_time(reduced, chain.stiffness, speed, p)
    force = chain.static_state.forces[1:-1]
    held = force > 0.0
    p = p if isinstance(p, float) else p[held]
    slope = p * chain.stiffness[held] ** (1.0 / p) * force[held] ** (1.0 - 1.0 / p)
    times[held] = np.minimum(times[held], np.sqrt(reduced[held] / slope))
    if chain.drive is not None and energy is None:
        kinks = np.unique(np.append(0.0, chain.drive.kinks))
        kinks = kinks[np.isfinite(kinks)]
        lengths = np.diff(kinks[kinks >= 0.0])
        # One of the times of a table may differ from 0 by rounding only.
        lengths = lengths[lengths > ROUNDING * np.abs(kinks).max()]
        times = np.minimum(times, np.min(lengths, initial=np.inf))
    # There is no time scale: beads are at rest, or pushed by a constant force.
    return np.where(np.isfinite(times), times, 1.0)


def check_length(chain: Chain, until: float) -> None:
    """Warn about a run of many transits, whose time was probably meant in us or ms."""
    if chain.units != "SI" or until < LONG_TIME:
        return
    transits = (until - fall_time(chain)) / float(transit_times(chain).sum())
    if transits > MANY_TRANSITS:
        warn_user(
            f"until = {until:g} s is {transits:.4g} transits of a pulse; times are in s, so check "
            "the unit ('500 us' is possible, too)",
            InputWarning,
        )
