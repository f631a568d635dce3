r"""The solitary wave of a uniform chain without precompression, exact to round-off.

A wave :math:`d_k(t) = \varphi(k - ct)` of overlaps solves the equation of motion if

.. math:: c^2 \varphi = \Lambda * \varphi^{\,p}, \qquad \Lambda(\xi) = (1 - |\xi|)_+

(stiffness and mass one; J. M. English and R. L. Pego, Proc. Am. Math. Soc. 133, 1763,
2005).  `hertzchain.theory.fixed_point` solves it.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from hertzchain.checks import number
from hertzchain.contacts import HERTZ_EXPONENT, Array
from hertzchain.theory.fixed_point import POINTS_PER_BEAD, box_transform, fixed_point
from hertzchain.theory.wave_profile import WaveProfile
from hertzchain.theory.wave_tail import WaveTail

# Below, the wave is wide and the iteration slow; above, the grid is too coarse for ten digits.
SMALLEST_EXPONENT: Final = 1.05
LARGEST_EXPONENT: Final = 20.0
# Of velocity, mass and stiffness, and its inverse the smallest: no power of them overflows.
LARGEST: Final = 1e60


@dataclass(frozen=True, eq=False)
class SolitaryWave:
    r"""The solitary wave of a uniform chain, made by `solitary_wave`.

    With peak velocity v of a bead, mass m and contact stiffness k, in any consistent
    units, speed V, momentum P, energy E and peak force F of the wave are

    .. math::

        V = C \left(\frac km\right)^{\frac1{p+1}} v^{\frac{p-1}{p+1}}, \quad
        P = P_1\, m v, \quad E = E_1\, m v^2, \quad
        F = F_1\, k^{\frac1{p+1}} (m v^2)^{\frac p{p+1}} .

    Attributes
    ----------
    exponent : float
        Exponent p of the contact force.
    speed_constant, momentum_constant, energy_constant, force_constant : float
        The constants C (speed in beads per time), P_1, E_1 and F_1.
    velocity, overlap, force : WaveProfile
        Velocity of a bead, overlap and force of a contact over their crest values, as
        functions of the distance from the crest in beads: ``wave.velocity(0.5)``,
        ``wave.force.width()``.  Within some three beads they are right to 1e-15 of the crest,
        beyond to 1e-9 of themselves, until they are smaller than the smallest number.

    Examples
    --------
    >>> wave = solitary_wave()
    >>> wave
    SolitaryWave(p = 1.5, C = 0.9074700784)

    The wave that a strike with velocity one makes in equal beads has the amplitude
    0.681631548571 and takes 1.18975557698 from bead to bead (both by integration):

    >>> round(1 / wave.speed(0.681631548571), 10)
    1.189755577
    """

    exponent: float
    speed_constant: float
    momentum_constant: float
    energy_constant: float
    force_constant: float
    velocity: WaveProfile
    overlap: WaveProfile
    force: WaveProfile

    def speed(self, velocity: float, mass: float = 1.0, stiffness: float = 1.0) -> float:
        r"""Speed V of the wave.

        Parameters
        ----------
        velocity, mass, stiffness : float
            Peak velocity of a bead, its mass, stiffness of its contacts, in scaled or any
            other consistent units; all positive.

        Returns
        -------
        float
            Speed [beads per time].

        Raises
        ------
        InputError
            If one of them is not positive and finite.

        Examples
        --------
        Steel beads of radius 5 mm struck at 1 m/s, in SI units: 674.659 m/s.

        >>> speed = solitary_wave().speed(0.681631548571, mass=4.073598e-3, stiffness=7.435897e9)
        >>> round(speed * 0.010, 3)
        674.659
        """
        v, m, k = _checked_wave(velocity, mass, stiffness)
        s = 1.0 / (self.exponent + 1.0)
        return self.speed_constant * (k / m) ** s * v ** ((self.exponent - 1.0) * s)

    def momentum(self, velocity: float, mass: float = 1.0) -> float:
        r"""Momentum :math:`P = P_1 m v` of the whole wave.

        Parameters
        ----------
        velocity, mass : float
            As for `speed`.

        Returns
        -------
        float

        Examples
        --------
        More than the striker brought (1), since beads behind the wave fly back:

        >>> round(solitary_wave().momentum(0.681631548571), 9)
        1.138305089
        """
        v, m, _ = _checked_wave(velocity, mass, 1.0)
        return self.momentum_constant * m * v

    def energy(self, velocity: float, mass: float = 1.0) -> float:
        r"""Energy :math:`E = E_1 m v^2` of the whole wave, kinetic and elastic.

        Parameters
        ----------
        velocity, mass : float
            As for `speed`.

        Returns
        -------
        float

        Examples
        --------
        99.366 per cent of the energy of the strike, 1/2:

        >>> round(2 * solitary_wave().energy(0.681631548571), 9)
        0.993661008
        """
        v, m, _ = _checked_wave(velocity, mass, 1.0)
        return self.energy_constant * m * v**2

    def peak_force(self, velocity: float, mass: float = 1.0, stiffness: float = 1.0) -> float:
        r"""Largest contact force F.

        Parameters
        ----------
        velocity, mass, stiffness : float
            As for `speed`.

        Returns
        -------
        float

        Examples
        --------
        >>> round(solitary_wave().peak_force(0.681631548571), 9)
        0.639554232
        """
        v, m, k = _checked_wave(velocity, mass, stiffness)
        s = 1.0 / (self.exponent + 1.0)
        return self.force_constant * k**s * (m * v**2) ** (self.exponent * s)

    @property
    def kinetic_fraction(self) -> float:
        r"""Kinetic part of the energy, averaged over time: (p + 1)/(p + 3), by the virial."""
        return (self.exponent + 1.0) / (self.exponent + 3.0)

    def __repr__(self) -> str:
        return f"SolitaryWave(p = {self.exponent:g}, C = {self.speed_constant:.10f})"


def solitary_wave(exponent: float = HERTZ_EXPONENT) -> SolitaryWave:
    r"""Solve for the solitary wave of a uniform chain.

    The fixed point of :math:`c^2 \varphi = \Lambda * \varphi^p` by Fourier transform; with
    crest overlap, mass and stiffness one, the velocity of a bead is the force on either
    side, averaged: :math:`w(\xi) = c^{-1} \int_{\xi-1/2}^{\xi+1/2} \varphi^p`.

    Parameters
    ----------
    exponent : float
        Exponent p of the contact force, 1.05 .. 20.  (Toward 1 the wave becomes ever
        wider; far above, the beads are hard spheres.)

    Returns
    -------
    SolitaryWave
        Constants good to about 1e-13.  The same object for the same exponent.

    Raises
    ------
    InputError
        If the exponent is out of this range.

    Examples
    --------
    The constant C of the speed, for Hertz contacts and for p = 2:

    >>> round(solitary_wave().speed_constant, 10), round(solitary_wave(2.0).speed_constant, 10)
    (0.9074700784, 0.8552519319)
    """
    return _solved(_checked_exponent(exponent))


@functools.lru_cache(maxsize=64)
def _solved(p: float) -> SolitaryWave:
    half = float(math.ceil(max(6.0, math.sqrt(40.0 / (3.0 * (p - 1.0))))))
    squared_speed, overlap = fixed_point(p, half)
    force = overlap**p
    spectrum, box = np.fft.rfft(force), box_transform(half, len(force))
    c = math.sqrt(squared_speed)
    velocity = np.fft.irfft(spectrum * box, len(force)) / c
    v, step = float(velocity[len(force) // 2]), 1.0 / POINTS_PER_BEAD
    core = WaveProfile.from_samples(overlap, half)
    tail = WaveTail(p, squared_speed, core)
    forward = WaveProfile.from_samples(velocity / v, half)
    energy = step * np.sum(0.5 * velocity**2 + overlap ** (p + 1.0) / (p + 1.0))
    return SolitaryWave(
        exponent=p,
        speed_constant=c * v ** (-(p - 1.0) / (p + 1.0)),
        momentum_constant=step * float(np.sum(force)) / (c * v),
        energy_constant=float(energy) / v**2,
        force_constant=v ** (-2.0 * p / (p + 1.0)),
        velocity=forward.with_tail(tail.start, _Scaled(tail.velocity, 1.0 / v)),
        overlap=core.with_tail(tail.start, tail.overlap),
        force=WaveProfile.from_samples(overlap, half, p).with_tail(tail.start, tail.overlap),
    )


@dataclass(frozen=True, eq=False)
class _Scaled:
    """A function times a factor, which unlike a lambda can be pickled."""

    function: Callable[[Array], Array]
    factor: float

    def __call__(self, at: Array) -> Array:
        return self.factor * self.function(at)


def _checked_exponent(exponent: float) -> float:
    return number(
        "exponent of a solitary wave", exponent, least=SMALLEST_EXPONENT, most=LARGEST_EXPONENT,
        hint="Hertz contacts have 1.5",
    )  # fmt: skip


def _checked_wave(velocity: float, mass: float, stiffness: float) -> tuple[float, float, float]:
    v, m, k = (
        number(f"{name} of a solitary wave", value, least=1.0 / LARGEST, most=LARGEST)
        for name, value in (("velocity", velocity), ("mass", mass), ("stiffness", stiffness))
    )
    return v, m, k
