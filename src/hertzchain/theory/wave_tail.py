r"""The tail of a solitary wave, far below the round-off of its crest.

Ahead of the wave, where :math:`\varphi` is small, the equation
:math:`c^2\varphi = \Lambda * \varphi^p` is read from the crest outwards: only beads one place
nearer to the crest push with a force that counts, so that

.. math::

    \ln\varphi(\xi) = p \ln\varphi(\xi - 1) - \ln c^2 +
    \ln \int_{-1}^{1} (1-|s|)\,\frac{\varphi^p(\xi-s)}{\varphi^p(\xi-1)}\,ds

and :math:`\ln\varphi(\xi+1)/\ln\varphi(\xi) \to p`: the tail falls doubly exponentially (J. M.
English, R. L. Pego, Proc. Am. Math. Soc. 133, 1763, 2005).  All terms of the integral are
positive, and it is evaluated in logarithms, so that nothing is lost to round-off.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hertzchain.contacts import Array
from hertzchain.errors import InputError

if TYPE_CHECKING:
    from hertzchain.theory.wave_profile import WaveProfile

# Where the tail begins: the round-off of the profile, 1e-15, is 1e-12 of it there.
SEAM: Final = 1e-3
# Beyond this -ln(overlap) the overlap is 0 in double precision.
NOTHING: Final = 750.0
# Of ln(-ln(overlap)), which is nearly straight: so many points in which it rises by one.
POINTS: Final = 32
CONVERGED: Final = 1e-13
ITERATION_LIMIT: Final = 1000


@dataclass(frozen=True, eq=False)
class WaveTail:
    """Overlap and velocity of a solitary wave beyond its core.

    Attributes
    ----------
    exponent : float
        Exponent p of the contact force.
    squared_speed : float
        c^2, with crest overlap, mass and stiffness one.
    core : WaveProfile
        The overlap where it is larger than its round-off.
    """

    exponent: float
    squared_speed: float
    core: WaveProfile

    @cached_property
    def start(self) -> float:
        """Distance from the crest at which the tail begins [beads]."""
        return self.core.width(SEAM) / 2.0

    def overlap(self, distance: Array) -> Array:
        """Overlap over that of the crest; 0 where it is below the smallest number.

        Parameters
        ----------
        distance : ndarray
            Distances from the crest, from ``start`` on [beads].

        Returns
        -------
        ndarray

        Examples
        --------
        >>> import hertzchain as hc
        >>> f"{hc.solitary_wave().overlap(6.0):.10e}"
        '5.4206027679e-26'
        """
        return np.exp(-self._minus_log(distance))

    def velocity(self, distance: Array) -> Array:
        r"""Velocity of a bead with crest overlap one: the force on either side, averaged.

        .. math:: w(\xi) = c^{-1} \int_{\xi-1/2}^{\xi+1/2} \varphi^p

        Parameters
        ----------
        distance : ndarray
            Distances from the crest, from ``start`` on [beads].

        Returns
        -------
        ndarray

        Examples
        --------
        >>> import hertzchain as hc
        >>> f"{hc.solitary_wave().velocity(6.0):.6e}"
        '1.478831e-31'
        """
        s, _, weight = _rule()
        near = distance - 0.5
        reference = self._minus_log(near)[..., None]
        ratio = self._minus_log(near[..., None] + s) - reference
        integral = np.sum(weight * np.exp(-self.exponent * ratio), axis=-1)
        force = np.exp(-self.exponent * reference[..., 0])
        return np.asarray(force * integral / math.sqrt(self.squared_speed))

    def _minus_log(self, distance: Array) -> Array:
        """Minus the logarithm of the overlap, of core and tail alike."""
        spline, end = self._spline
        found = np.full(distance.shape, 2.0 * NOTHING)
        inside, tail = distance <= self.start, distance < end
        found[inside] = -np.log(self.core(distance[inside]))
        tail &= ~inside
        found[tail] = np.exp(spline(distance[tail]))
        return found

    @cached_property
    def _spline(self) -> tuple[Callable[[Array], Array], float]:
        """Spline of ln(-ln(overlap)) in the tail, and where it ends; by iteration."""
        from scipy.interpolate import make_interp_spline

        # A few points of the core, so that the spline has no end at the seam.
        before = np.log(-np.log(self.core(self.start - 1e-3 * np.arange(2))))
        slope = 1e3 * float(before[0] - before[1])
        step = 1.0 / (POINTS * slope)
        inner = self.start + step * np.arange(-4, 1)
        known = np.log(-np.log(self.core(inner)))
        count = self._points(float(known[-1]), slope, step)
        outer = self.start + step * np.arange(1, count + 1)
        guess = known[-1] + math.log(self.exponent) * (outer - self.start)
        tail = _TailEquation(self, outer)
        for _ in range(ITERATION_LIMIT):
            spline: Any = make_interp_spline(
                np.concatenate([inner, outer]), np.concatenate([known, guess]), k=5
            )
            new = tail.iterate(spline)
            change = float(np.max(np.abs(new - guess)))
            guess = new
            if change < CONVERGED:
                return spline, float(outer[-1])
        raise InputError(f"the tail of the wave of exponent {self.exponent:g} was not found")

    def _points(self, value: float, slope: float, step: float) -> int:
        """How many points there are until the overlap is nothing.

        Near the seam the wave is a Gaussian, of which the slope falls as 1/distance; far out
        ln p is left.
        """
        count, far = 0, math.log(2.0 * NOTHING)
        while value < far:
            count += 1
            falling = slope * self.start / (self.start + count * step)
            value += step * max(math.log(self.exponent), falling)
        return count


class _TailEquation:
    """The integral equation at some points of the tail."""

    def __init__(self, tail: WaveTail, points: Array) -> None:
        s, rest, weight = _rule()
        self.tail, self.end = tail, float(points[-1])
        self.behind, self.ahead = points[:, None] - 1.0 + s, points[:, None] + s
        self.nearest = points - 1.0
        self.rising, self.falling = weight * s, weight * rest
        self.known = [self._core(at) for at in (self.nearest, self.behind)]

    def _core(self, distance: Array) -> tuple[Any, Array]:
        inside = distance <= self.tail.start
        return inside, -np.log(self.tail.core(distance[inside]))

    def _filled(self, distance: Array, known: tuple[Any, Array], spline: Any) -> Array:
        inside, values = known
        found = np.empty(distance.shape)
        found[inside] = values
        found[~inside] = np.exp(spline(distance[~inside]))
        return found

    def iterate(self, spline: Any) -> Array:
        """ln(-ln(overlap)) at the points, by the equation, from what it was."""
        p = self.tail.exponent
        nearest = self._filled(self.nearest, self.known[0], spline)
        behind = self._filled(self.behind, self.known[1], spline)
        ahead = np.full(self.ahead.shape, np.inf)
        inside = self.ahead <= self.end
        ahead[inside] = np.exp(spline(self.ahead[inside]))
        integral = np.sum(
            self.rising * np.exp(-p * (behind - nearest[:, None]))
            + self.falling * np.exp(-p * (ahead - nearest[:, None])),
            axis=1,
        )
        return np.log(math.log(self.tail.squared_speed) + p * nearest - np.log(integral))


def _rule() -> tuple[Array, Array, Array]:
    """Points s of a doubly exponential rule on 0 .. 1, 1 - s without cancellation, weights."""
    step = 0.06
    t = np.arange(-60, 61) * step
    s, rest = (1.0 / (1.0 + np.exp(sign * np.pi * np.sinh(t))) for sign in (-1.0, 1.0))
    return s, rest, step * np.pi * np.cosh(t) * s * rest
