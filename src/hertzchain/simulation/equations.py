"""A chain as the arrays that the compiled equations take.

`equation_of` writes down what acts on the beads, `start_of` where they are and how they
move at time 0.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from hertzchain.chain.chain import Chain
from hertzchain.chain.drives import Drive, SineBurst, Step, Table
from hertzchain.chain.equilibrium import equilibrium
from hertzchain.chain.losses import (
    Dashpot,
    Restitution,
    UnloadingRatio,
    VelocityPower,
    Viscoelastic,
    WaltonBraun,
)
from hertzchain.contacts import Array, collision_overlap, compression_time, reduced_mass
from hertzchain.errors import InputError

if TYPE_CHECKING:
    from hertzchain.kernels.forces import Bench, Law, Plain

# What the loop for plain chains knows: anything else goes through the general one.
PLAIN_FEATURES: Final = frozenset({"SI units", "masses", "stiffness", "strikers", "velocities"})

# Steps are implicit where damping would bring contacts to rest more often than this within the
# time of a pulse: explicit steps become so short that they take longer.
STIFF: Final = 300.0
# Beyond, contacts are rigid for any step, and the equations of an implicit one overflow.
RIGID: Final = 1e250
# Speeds below this part of the fastest do not matter while a chain at rest is set in motion.
SLOWEST: Final = 1e-3


def equation_of(chain: Chain) -> Plain | Bench:
    """What acts on the beads of a chain, for the compiled loop.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    Plain or Bench

    Examples
    --------
    >>> type(equation_of(Chain.uniform(3).replace(gravity=0.1))).__name__
    'Bench'
    """
    from hertzchain.kernels.driving import MOVING_WALL, NOTHING, PUSH
    from hertzchain.kernels.forces import Bench, Plain

    if PLAIN_FEATURES.issuperset(chain.features):
        return Plain(1.0 / chain.masses, np.array(chain.stiffness), chain.exponent)
    left, right = chain.wall_stiffness
    static = equilibrium(chain)
    drive = NOTHING
    if chain.drive is not None:
        drive = PUSH if chain.drive.of == "force" else MOVING_WALL
    try:
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            starts, pieces = drive_pieces(chain.drive)
    except ArithmeticError:
        starts, pieces = np.zeros(1), np.full((1, 1), np.inf)
    if not np.isfinite(pieces).all():
        raise InputError(f"{chain.drive} cannot be represented: look at the units of its times")
    stiffness = np.concatenate(([left], chain.stiffness, [right]))
    with np.errstate(over="ignore"):
        law, damping = _law(chain, stiffness)
    if not np.isfinite(damping).all():
        raise InputError(
            f"the damping by {chain.loss} is too large to be represented: look at its units"
        )
    return Bench(
        inverse_mass=1.0 / chain.masses,
        stiffness=stiffness,
        exponent=chain.exponent,
        # Positions are counted from equilibrium, where contacts overlap: rounding is then
        # that of an overlap, not of the length of the chain.
        gap=static.gaps - static_closing(chain),
        damping=damping,
        law=law,
        body_force=static.body_forces,
        drive=drive,
        piece_starts=starts,
        pieces=pieces,
    )


def steps_are_implicit(chain: Chain) -> bool:
    """Whether the damping of a chain is too stiff for explicit steps.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    bool

    Examples
    --------
    >>> from hertzchain.chain.losses import VelocityPower
    >>> steps_are_implicit(Chain.uniform(2).replace(loss=VelocityPower(0.1, 0.5)))
    True
    """
    from hertzchain.kernels.forces import Plain

    equation = equation_of(chain)
    return not isinstance(equation, Plain) and equation.law.implicit


def static_closing(chain: Chain) -> Array:
    """What each contact, counted with the walls, is closed by the static positions.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    ndarray, shape (N + 1,)

    Examples
    --------
    >>> static_closing(Chain.uniform(2).replace(precompression=8.0, held_by="force"))
    array([-4.,  4.,  0.])
    """
    return -np.diff(np.pad(equilibrium(chain).positions, 1))


def start_of(chain: Chain) -> Array:
    """Positions, counted from equilibrium, and velocities at time 0.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    ndarray, shape (2N,)

    Examples
    --------
    >>> start_of(Chain.uniform(2))
    array([0., 0., 1., 0.])
    """
    return np.concatenate([np.zeros(chain.beads), chain.velocities])


def _law(chain: Chain, stiffness: Array) -> tuple[Law, Array]:
    """The chain's contact law in the kernel's terms, and the damping of each contact."""
    from hertzchain.kernels.forces import DAMPED, ELASTIC, PLASTIC, UNLOADING, Law

    law, p = chain.loss, chain.exponent
    kind, kept, overlap_power, speed_power = DAMPED, 1.0, 0.0, 1.0
    damping = np.zeros(chain.beads + 1)
    if law is None:
        kind = ELASTIC
    elif isinstance(law, UnloadingRatio):
        kind, kept = UNLOADING, 1.0 - law.ratio
    elif isinstance(law, WaltonBraun):
        kind, kept = PLASTIC, law.ratio
    elif isinstance(law, Restitution):
        damping = law.damping(p) * np.sqrt(_reduced_masses(chain) * stiffness)
        overlap_power = 0.5 * (p - 1.0)
    elif isinstance(law, Viscoelastic):
        damping, overlap_power = p * law.time * stiffness, p - 1.0
    elif isinstance(law, VelocityPower):
        damping, speed_power = damping + law.gamma, law.alpha
    elif isinstance(law, Dashpot):
        damping = damping + law.gamma
    damping = np.where(stiffness > 0.0, damping, 0.0)
    attractive = bool(getattr(law, "attractive", True))
    implicit = kind == DAMPED and (
        speed_power < 1.0
        or STIFF < _relaxation(chain, stiffness, damping, overlap_power, speed_power) < RIGID
    )
    slowest = SLOWEST * _speed_of(chain) if implicit else 0.0
    return Law(kind, p, overlap_power, speed_power, kept, attractive, implicit, slowest), damping


def _reduced_masses(chain: Chain) -> Array:
    """Those of all contacts: a wall is as heavy as can be, so that its is the bead's."""
    inner = reduced_mass(chain.masses[:-1], chain.masses[1:])
    return np.concatenate((chain.masses[:1], inner, chain.masses[-1:]))


def _speed_of(chain: Chain) -> float:
    """The fastest motion of a chain, roughly, by its start, its drive or else its static forces."""
    fastest = float(np.abs(chain.velocities).max())
    if chain.drive is None and fastest > 0.0:
        return fastest
    if chain.drive is None:
        static = equilibrium(chain)
        return _pushed(chain, float(max(static.forces.max(), np.abs(static.body_forces).sum())))
    starts, pieces = drive_pieces(chain.drive)
    lengths, powers = np.append(np.diff(starts), 0.0)[:, np.newaxis], np.arange(4)
    cubics, sines, rates = np.abs(pieces[:, :4]), np.abs(pieces[:, 4::2]), np.abs(pieces[:, 5::2])
    if chain.drive.of == "displacement":
        slopes = (powers[1:] * cubics[:, 1:] * lengths ** powers[:3]).sum(axis=1)
        return max(fastest, float((slopes + (sines * rates).sum(axis=1)).max()))
    # A force gives a free bead an impulse, and one in a chain an overlap.
    size = float(((cubics * lengths**powers).sum(axis=1) + sines.sum(axis=1)).max())
    time = float(transit_times(chain).min())
    return max(fastest, min(size * time / chain.masses[0], _pushed(chain, size)))


def _pushed(chain: Chain, force: float) -> float:
    """Speed of bead 1 with the energy that a force has over the overlap that bears it."""
    overlap = (force / chain.stiffness[0]) ** (1.0 / chain.exponent)
    return math.sqrt(force * overlap / chain.masses[0])


def _relaxation(
    chain: Chain, stiffness: Array, damping: Array, overlap_power: float, speed_power: float
) -> float:
    """How often, at most, damping would bring a contact to rest within the time of a pulse."""
    there = stiffness > 0.0
    speed = _speed_of(chain)
    if speed == 0.0:
        return 0.0
    mass, k, p = _reduced_masses(chain)[there], stiffness[there], chain.exponent
    static = (equilibrium(chain).forces[there] / k) ** (1.0 / p)
    overlap = np.maximum(collision_overlap(mass, k, speed, p), static)
    steepness = speed_power * damping[there] * overlap**overlap_power * speed ** (speed_power - 1.0)
    return float(np.max(steepness * compression_time(mass, k, speed, p) / mass))


def transit_times(chain: Chain, energy: float | None = None) -> Array:
    """Time that a pulse takes for each contact, roughly.

    The least of what a pulse takes that keeps its energy, as it nearly does in a slow taper
    (with v ~ m^(-1/2), each contact is passed in the compression time of its two beads),
    of what sound takes in a compressed contact, and of the pieces of the drive.  Used for
    the first step and the spacing of saved times, where a guess is enough.

    Parameters
    ----------
    chain : Chain
        Any chain.
    energy : float, optional
        Energy of the pulse, of which a drive is no longer a part; by default that of the bead
        that is fastest at time 0.

    Returns
    -------
    ndarray, shape (N - 1,)

    Examples
    --------
    >>> transit_times(Chain.uniform(2)).round(5)
    array([1.21942])
    """
    masses, p = chain.masses, chain.exponent
    reduced = reduced_mass(masses[:-1], masses[1:])
    times = np.full(chain.beads - 1, np.inf)
    fastest = int(np.argmax(np.abs(chain.velocities)))
    speed = abs(chain.velocities[fastest]) * np.sqrt(masses[fastest] / masses[:-1])
    if energy is not None:
        speed = np.sqrt(2.0 * energy / masses[:-1])
    if speed.any():
        times = compression_time(reduced, chain.stiffness, speed, p)
    force = equilibrium(chain).forces[1:-1]
    held = force > 0.0
    slope = p * chain.stiffness[held] ** (1.0 / p) * force[held] ** (1.0 - 1.0 / p)
    times[held] = np.minimum(times[held], np.sqrt(reduced[held] / slope))
    if chain.drive is not None and energy is None:
        kinks = np.unique(np.append(0.0, chain.drive.kinks))
        lengths = np.diff(kinks[np.isfinite(kinks) & (kinks >= 0.0)])
        times = np.minimum(times, np.min(lengths, initial=np.inf))
    # Nothing sets a time: beads at rest, in free fall or pushed by a constant force.
    return np.where(np.isfinite(times), times, 1.0)


def drive_pieces(drive: Drive | None) -> tuple[Array, Array]:
    r"""A drive as pieces of smooth curves.

    Piece j holds from its start :math:`t_j` on and is, with :math:`s = t - t_j`,

    .. math:: c_0 + c_1 s + c_2 s^2 + c_3 s^3 + \sum_{i=1}^3 a_i \sin \omega_i s .

    A sine under a Hann window of n periods is three sines: with the carrier's angular
    frequency :math:`\omega`,
    :math:`\tfrac{A}{2}\sin\omega s - \tfrac{A}{4}[\sin(\omega + \tfrac{\omega}{n})s
    + \sin(\omega - \tfrac{\omega}{n})s]`.

    Parameters
    ----------
    drive : SineBurst, Step, Table or None
        The drive.

    Returns
    -------
    starts : ndarray, shape (pieces,)
        Increasing; the first is 0.
    pieces : ndarray, shape (pieces, 10)
        Coefficients :math:`c_0 \dots c_3, a_1, \omega_1, \dots, a_3, \omega_3`.

    Examples
    --------
    >>> starts, pieces = drive_pieces(Step(2.0))
    >>> starts, pieces[:, 0]
    (array([0.]), array([2.]))
    """
    if isinstance(drive, Step):
        rest = _cubic(drive.amplitude)
        if drive.rise == 0.0:
            return np.zeros(1), rest[np.newaxis]
        rise = _cubic(0.0, 0.0, 3.0 * drive.amplitude / drive.rise**2,
                      -2.0 * drive.amplitude / drive.rise**3)  # fmt: skip
        return np.array([0.0, drive.rise]), np.array([rise, rest])
    if isinstance(drive, SineBurst):
        amplitude, carrier = drive.amplitude, 2.0 * math.pi * drive.frequency
        burst = _cubic()
        burst[4:6] = amplitude, carrier
        if drive.window == "hann":
            side = carrier / drive.cycles
            burst[4:] = (0.5 * amplitude, carrier, -0.25 * amplitude, carrier + side,
                         -0.25 * amplitude, carrier - side)  # fmt: skip
        if math.isinf(drive.cycles):
            return np.zeros(1), burst[np.newaxis]
        return np.array([0.0, drive.cycles / drive.frequency]), np.array([burst, _cubic()])
    if isinstance(drive, Table):
        return _table_pieces(drive)
    return np.zeros(1), _cubic()[np.newaxis]


def _table_pieces(drive: Table) -> tuple[Array, Array]:
    """Straight lines from 0 on; the first and last value are kept outside the table."""
    later = drive.times[drive.times > 0.0]
    starts = np.concatenate(([0.0], later))
    values = drive.value(starts)
    slopes = np.append(np.diff(values) / np.diff(starts), 0.0)
    pieces = np.zeros((len(starts), 10))
    pieces[:, 0], pieces[:, 1] = values, slopes
    return starts, pieces


def _cubic(*coefficients: float) -> Array:
    piece = np.zeros(10)
    piece[: len(coefficients)] = coefficients
    return piece
