r"""The solitary wave of a uniform chain without precompression, exact to rounding.

A wave of overlaps :math:`d_k(t) = \varphi(k - ct)` solves the equation of motion if

.. math:: c^2 \varphi = \Lambda * \varphi^{\,p}, \qquad \Lambda(\xi) = (1 - |\xi|)_+

for unit stiffness and mass (J. M. English and R. L. Pego, Proc. Am. Math. Soc. 133, 1763,
2005).  `hertzchain.theory.solitary_wave_solver` solves this equation.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError
from ..units import unit_of_stiffness
from ..validation.keywords import checked_arguments, checked_methods
from ..validation.numbers import bounded_numbers, has_unit, number
from .solitary_wave_solver import (
    POINTS_PER_BEAD,
    box_transform,
    solve_solitary_wave,
)
from .wave_profile import WaveProfile
from .wave_tail import WaveTail

# Below the minimum the wave is wide and the iteration slow; above the maximum the grid is too
# coarse for ten digits.
MIN_EXPONENT: Final = 1.05
MAX_EXPONENT: Final = 20.0
# Largest velocity, mass and stiffness, and the inverse of the smallest: no power overflows.
MAX_SCALE: Final = 1e60


@checked_methods
@dataclass(frozen=True, eq=False)
class SolitaryWave:
    r"""Solitary wave of a uniform chain, as returned by `solitary_wave`.

    Let v be the peak velocity of a bead, m its mass and k the contact stiffness, in any
    consistent units.  Speed V, momentum P, energy E and peak force F of the wave are

    .. math::

        V = C \left(\frac km\right)^{\frac1{p+1}} v^{\frac{p-1}{p+1}}, \quad
        P = P_1\, m v, \quad E = E_1\, m v^2, \quad
        F = F_1\, k^{\frac1{p+1}} (m v^2)^{\frac p{p+1}} .

    `velocity_from_force` returns v for a measured force F; then
    :math:`V \propto F^{(p-1)/(2p)}`, which is :math:`F^{1/6}` for spheres.

    Attributes
    ----------
    exponent : float
        Exponent p of the contact force.
    speed_constant, momentum_constant, energy_constant, force_constant : float
        Constants C (speed in beads per unit time), P_1, E_1 and F_1.
    velocity, overlap, force : WaveProfile
        Velocity of a bead, overlap and force of a contact, divided by their values at the
        crest, as functions of the distance from the crest in beads: ``wave.velocity(0.5)``,
        ``wave.force.width()``.  Within about three beads the error is 1e-15 of the crest
        value; beyond, the relative error is 1e-9 until the values underflow.

    Examples
    --------
    >>> import hertzchain as hc
    >>> wave = hc.solitary_wave()
    >>> wave
    SolitaryWave(p = 1.5, C = 0.9074700784)

    An impact with velocity one on equal beads creates a wave with a peak velocity of
    0.681631548571 that takes the time 1.18975557698 from bead to bead (both from the
    simulation):

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

    def speed(
        self,
        velocity: ArrayLike,
        mass: ArrayLike = 1.0,
        stiffness: ArrayLike = 1.0,
        *,
        diameter: float | str | None = None,
    ) -> Any:
        r"""Speed V of the wave, in beads per time or, with a diameter, in length per time.

        `hertzchain.Pulse.speed` is a length per time: in scaled variables, where the radius is 1
        and the diameter 2, it is twice the speed in beads per time.

        Parameters
        ----------
        velocity, mass, stiffness : float or array_like
            Peak velocity of a bead, its mass, and the stiffness of its contacts, in scaled or
            any other consistent units; all must be positive, and arrays must fit together as in
            NumPy.  If one is text with a unit, such as
            ``"0.05 m/s"``, the others are in SI units and must be given.
        diameter : float or str, optional
            Diameter of a bead, by which the speed in beads per time is multiplied.

        Returns
        -------
        float or ndarray
            Speed [beads per unit time; with a diameter, its unit per unit time].

        Raises
        ------
        InputError
            If an argument is not positive and finite, one has a unit and another is omitted, or
            the shapes of arrays do not fit together.

        Examples
        --------
        In steel beads of radius 5 mm, struck at 1 m/s, the speed is 674.659 m/s:

        >>> import hertzchain as hc
        >>> wave, steel = hc.solitary_wave(), {"mass": 4.073598e-3, "stiffness": 7.435897e9}
        >>> round(wave.speed(0.681631548571, **steel, diameter="10 mm"), 3)
        674.659
        """
        v, m, k = self._checked(velocity, mass, stiffness)
        if has_unit(diameter) and mass == stiffness == 1.0:
            raise InputError(
                "a diameter with a unit requires velocity, mass and stiffness in SI units: give "
                "all of them"
            )
        length = 1.0 if diameter is None else number("diameter", diameter, unit="m", above=0.0)
        s = 1.0 / (self.exponent + 1.0)
        per_time = self.speed_constant * (k / m) ** s * v ** ((self.exponent - 1.0) * s)
        return length * per_time

    def momentum(self, velocity: ArrayLike, mass: ArrayLike = 1.0) -> Any:
        r"""Momentum :math:`P = P_1 m v` of the whole wave.

        Parameters
        ----------
        velocity, mass : float or array_like
            As for `speed`.

        Returns
        -------
        float or ndarray
            Momentum.

        Examples
        --------
        It is larger than the momentum of the impact, 1, because beads behind the wave move
        backwards:

        >>> import hertzchain as hc
        >>> round(hc.solitary_wave().momentum(0.681631548571), 9)
        1.138305089
        """
        v, m, _ = self._checked(velocity, mass)
        return self.momentum_constant * m * v

    def energy(self, velocity: ArrayLike, mass: ArrayLike = 1.0) -> Any:
        r"""Energy :math:`E = E_1 m v^2` of the whole wave, kinetic and elastic.

        Parameters
        ----------
        velocity, mass : float or array_like
            As for `speed`.

        Returns
        -------
        float or ndarray
            Energy.

        Examples
        --------
        The wave carries 99.366% of the impact energy, 1/2:

        >>> import hertzchain as hc
        >>> round(2 * hc.solitary_wave().energy(0.681631548571), 9)
        0.993661008
        """
        v, m, _ = self._checked(velocity, mass)
        return self.energy_constant * m * v**2

    def peak_force(
        self, velocity: ArrayLike, mass: ArrayLike = 1.0, stiffness: ArrayLike = 1.0
    ) -> Any:
        r"""Largest contact force F.

        Parameters
        ----------
        velocity, mass, stiffness : float or array_like
            As for `speed`.

        Returns
        -------
        float or ndarray
            Force.

        Examples
        --------
        >>> import hertzchain as hc
        >>> round(hc.solitary_wave().peak_force(0.681631548571), 9)
        0.639554232
        """
        v, m, k = self._checked(velocity, mass, stiffness)
        s = 1.0 / (self.exponent + 1.0)
        return self.force_constant * k**s * (m * v**2) ** (self.exponent * s)

    def velocity_from_force(
        self, force: ArrayLike, mass: ArrayLike = 1.0, stiffness: ArrayLike = 1.0
    ) -> Any:
        r"""Peak velocity v of a bead in the wave whose largest contact force is given.

        .. math:: v = \left(\frac{F}{F_1}\right)^{\frac{p+1}{2p}} k^{-\frac1{2p}}\, m^{-\frac12}

        The speed of this wave is proportional to :math:`F^{(p-1)/(2p)}`, or :math:`F^{1/6}` for
        p = 3/2.

        Parameters
        ----------
        force : float or array_like
            Largest force F of a contact.  The force in a sensor in a bead, which is the mean of the
            forces on both halves, has a lower maximum.
        mass, stiffness : float or array_like
            As for `speed`.

        Returns
        -------
        float or ndarray
            Velocity.

        Raises
        ------
        InputError
            As for `speed`.

        Examples
        --------
        The speed of a wave with a force of 20 N in steel balls of 10 mm diameter:

        >>> import hertzchain as hc
        >>> wave, steel = hc.solitary_wave(), {"mass": 4.073598e-3, "stiffness": 7.435897e9}
        >>> velocity = wave.velocity_from_force(20.0, **steel)
        >>> round(velocity, 4), round(wave.speed(velocity, **steel, diameter="10 mm"), 2)
        (0.0964, 456.24)
        >>> wave.velocity_from_force([5.0, 20.0, 80.0], **steel).round(4)
        array([0.0304, 0.0964, 0.3061])
        """
        f, m, k = self._checked(force, mass, stiffness, name="force")
        half = 0.5 / self.exponent
        return (f / self.force_constant) ** (0.5 + half) * k**-half * m**-0.5

    def _checked(
        self, value: Any, mass: Any, stiffness: Any = None, *, name: str = "velocity"
    ) -> tuple[Any, Any, Any]:
        """Velocity or force, mass and stiffness as positive numbers, in SI if one has a unit."""
        units = {name: {"velocity": "m/s", "force": "N"}[name], "mass": "kg",
                 "stiffness": unit_of_stiffness(self.exponent)}  # fmt: skip
        given = {name: value, "mass": mass, "stiffness": stiffness}
        given = {name: value for name, value in given.items() if value is not None}
        if any(map(has_unit, given.values())):
            # The defaults are those of scaled variables.
            omitted = [name for name, value in given.items() if type(value) is float and value == 1]
            if omitted:
                raise InputError(
                    f"an argument has a unit, so {' and '.join(omitted)} must be given in SI units "
                    "too, such as mass='4.07 g' and stiffness=chain.stiffness[0]"
                )
        v, m, k = (
            _positive(f"{name} of a solitary wave", given.get(name, 1.0), units[name])
            for name in units
        )
        shapes = {name: np.shape(each) for name, each in zip(units, (v, m, k), strict=True)}
        try:
            np.broadcast_shapes(*shapes.values())
        except ValueError:
            texts = ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)
            raise InputError(
                f"the shapes of arrays for a solitary wave do not fit together: {texts}"
            ) from None
        return v, m, k

    @property
    def kinetic_fraction(self) -> float:
        r"""Mean kinetic fraction of the energy, (p + 1)/(p + 3) by the virial theorem."""
        return (self.exponent + 1.0) / (self.exponent + 3.0)

    def _repr_html_(self) -> str:
        from ..notebook.theories import solitary_wave_html

        return solitary_wave_html(self)

    def __repr__(self) -> str:
        return f"SolitaryWave(p = {self.exponent:g}, C = {self.speed_constant:.10f})"


@checked_arguments("solitary_wave")
def solitary_wave(exponent: float = HERTZ_EXPONENT) -> SolitaryWave:
    r"""Solve for the solitary wave of a uniform chain.

    The equation :math:`c^2 \varphi = \Lambda * \varphi^p` is solved by fixed-point iteration
    with Fourier transforms.  For unit crest overlap, mass and stiffness, the velocity of a
    bead is :math:`w(\xi) = c^{-1} \int_{\xi-1/2}^{\xi+1/2} \varphi^p`.

    Parameters
    ----------
    exponent : float
        Exponent p of the contact force, from 1.05 to 20.  The wave becomes wider as p
        approaches 1; for large p, the beads behave like hard spheres.

    Returns
    -------
    SolitaryWave
        The wave, whose constants are accurate to about 1e-13.  It is cached: the same
        object is returned for the same exponent.

    Raises
    ------
    InputError
        If the exponent is out of this range.

    Examples
    --------
    The constant C of the speed, for Hertz contacts and for p = 2:

    >>> import hertzchain as hc
    >>> [round(hc.solitary_wave(p).speed_constant, 10) for p in (1.5, 2.0)]
    [0.9074700784, 0.8552519319]
    """
    return _solved(_checked_exponent(exponent))


@functools.lru_cache(maxsize=64)
def _solved(p: float) -> SolitaryWave:
    half = float(math.ceil(max(6.0, math.sqrt(40.0 / (3.0 * (p - 1.0))))))
    squared_speed, overlap = solve_solitary_wave(p, half)
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
    """A function multiplied by a factor; unlike a lambda, it can be pickled."""

    function: Callable[[Array], Array]
    factor: float

    def __call__(self, at: Array) -> Array:
        return self.factor * self.function(at)


def _positive(what: str, value: Any, unit: str) -> Any:
    """A positive number, or an array of them."""
    several = isinstance(value, list | tuple) or np.ndim(getattr(value, "magnitude", value)) > 0
    if not several:
        return number(what, value, unit=unit, least=1.0 / MAX_SCALE, most=MAX_SCALE)
    return bounded_numbers(what, value, unit=unit, least=1.0 / MAX_SCALE, most=MAX_SCALE)


def _checked_exponent(exponent: float) -> float:
    return number(
        "exponent of a solitary wave", exponent, least=MIN_EXPONENT, most=MAX_EXPONENT,
        hint="Hertz contacts have 1.5",
    )  # fmt: skip
