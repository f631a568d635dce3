r"""The tail of a solitary wave, far below the rounding errors at its crest.

Far from the crest, the equation :math:`c^2\varphi = \Lambda * \varphi^p` can be solved outwards,
because :math:`\varphi` is determined by its values closer to the crest:

.. math::

    \ln\varphi(\xi) = p \ln\varphi(\xi - 1) - \ln c^2 +
    \ln \int_{-1}^{1} (1-|s|)\,\frac{\varphi^p(\xi-s)}{\varphi^p(\xi-1)}\,ds

Therefore :math:`\ln\varphi(\xi+1)/\ln\varphi(\xi) \to p`, and the tail decays doubly exponentially
(J. M. English, R. L. Pego, Proc. Am. Math. Soc. 133, 1763, 2005).  All terms of the integral are
positive and evaluated in logarithms, without cancellation.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..collision import Array
from ..errors import InputError

if TYPE_CHECKING:
    from .wave_profile import WaveProfile

# Overlap at which the tail begins; the rounding errors of the profile, 1e-15, are 1e-12 of it.
SEAM: Final = 1e-3
# Value of -ln(overlap) beyond which the overlap is 0 in double precision.
UNDERFLOW: Final = 750.0
# Number of points in which ln(-ln(overlap)), which is nearly linear, increases by one.
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
        Squared speed c^2, for unit crest overlap, mass and stiffness.
    core : WaveProfile
        Overlap within the core of the wave.
    """

    exponent: float
    squared_speed: float
    core: WaveProfile

    @cached_property
    def start(self) -> float:
        """Distance from the crest at which the tail begins [beads]."""
        return self.core.width(SEAM) / 2.0

    def overlap(self, distance: Array) -> Array:
        """Overlap over that at the crest; 0 if it underflows.

        Parameters
        ----------
        distance : ndarray
            Distances from the crest, from ``start`` on [beads].

        Returns
        -------
        ndarray
            Overlaps.

        Examples
        --------
        >>> import hertzchain as hc
        >>> f"{hc.solitary_wave().overlap(6.0):.10e}"
        '5.4206027679e-26'
        """
        return np.exp(-self._minus_log(distance))

    def velocity(self, distance: Array) -> Array:
        r"""Velocity of a bead for unit crest overlap.

        .. math:: w(\xi) = c^{-1} \int_{\xi-1/2}^{\xi+1/2} \varphi^p

        Parameters
        ----------
        distance : ndarray
            Distances from the crest, from ``start`` on [beads].

        Returns
        -------
        ndarray
            Velocities.

        Examples
        --------
        >>> import hertzchain as hc
        >>> f"{hc.solitary_wave().velocity(6.0):.6e}"
        '1.478831e-31'
        """
        s, _, weight = _rule()
        near = distance - 0.5
        reference = self._minus_log(near)[..., None]
        # Overlaps do not grow, but where they underflow their logarithms end at a constant.
        ratio = np.maximum(self._minus_log(near[..., None] + s) - reference, 0.0)
        integral = np.sum(weight * np.exp(-self.exponent * ratio), axis=-1)
        force = np.exp(-self.exponent * reference[..., 0])
        return np.asarray(force * integral / math.sqrt(self.squared_speed))

    def _minus_log(self, distance: Array) -> Array:
        """Minus the logarithm of the overlap, in the core and in the tail."""
        spline, end = self._spline
        found = np.full(distance.shape, 2.0 * UNDERFLOW)
        inside, tail = distance <= self.start, distance < end
        found[inside] = -np.log(self.core(distance[inside]))
        tail &= ~inside
        found[tail] = np.exp(spline(distance[tail]))
        return found

    @cached_property
    def _spline(self) -> tuple[Callable[[Array], Array], float]:
        """Spline of ln(-ln(overlap)) in the tail, found by iteration, and its last point."""
        from scipy.interpolate import make_interp_spline

        # The spline includes a few points of the core, to avoid an end at the seam.
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
        raise InputError(
            f"the tail of the solitary wave of exponent {self.exponent:g} did not converge"
        )

    def _points(self, value: float, slope: float, step: float) -> int:
        """Number of points until the overlap underflows."""
        # Near the seam the wave is Gaussian and the slope is proportional to 1/distance; far out
        # it approaches ln p.
        count, far = 0, math.log(2.0 * UNDERFLOW)
        while value < far:
            count += 1
            falling = slope * self.start / (self.start + count * step)
            value += step * max(math.log(self.exponent), falling)
        return count


class _TailEquation:
    """Integral equation at points of the tail."""

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
        """New values of ln(-ln(overlap)) at the points, from the previous spline."""
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
    """Nodes s of a double-exponential rule on [0, 1], 1 - s without cancellation, and weights."""
    step = 0.06
    t = np.arange(-60, 61) * step
    s, rest = (1.0 / (1.0 + np.exp(sign * np.pi * np.sinh(t))) for sign in (-1.0, 1.0))
    return s, rest, step * np.pi * np.cosh(t) * s * rest
