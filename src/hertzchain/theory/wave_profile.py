"""Profile of a wave: a smooth even function of the distance from its crest."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from ..collision import Array
from ..errors import InputError
from ..frozen import Frozen
from ..validation.numbers import FRACTION, number, real_numbers, whole_number


@dataclass(frozen=True, eq=False)
class WaveProfile(Frozen):
    r"""Profile of a wave, normalised to its crest, as a function of the distance from the crest.

    .. math:: f(\xi) = \Bigl(\sum_j a_j \cos \frac{\pi j \xi}{h}\Bigr)^{n}

    The series is accurate to about 1e-15 of the crest value.  The profiles of a
    `hertzchain.SolitaryWave` continue in a tail (`hertzchain.theory.wave_tail`) where rounding
    errors would dominate the series.  The relative error of the tail is 1e-9, down to the
    smallest representable numbers.

    Attributes
    ----------
    half_length : float
        Half the period of the series, h [beads].  Without a tail, it is the largest distance
        at which the profile can be evaluated.
    power : float
        The power n, which is 1 except for forces.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.solitary_wave().velocity([0.0, 0.5, -1.0]).round(5)
    array([1.     , 0.75888, 0.32625])
    """

    half_length: float
    power: float
    _coefficients: Array = field(repr=False)
    # Distance at which the tail begins, and its values before the power is taken.
    _seam: float = field(default=math.inf, repr=False)
    _tail: Callable[[Array], Array] | None = field(default=None, repr=False)

    @classmethod
    def from_samples(cls, samples: Array, half_length: float, power: float = 1.0) -> WaveProfile:
        """Interpolate samples of an even and smooth function.

        Parameters
        ----------
        samples : ndarray, shape (n,)
            Values at n equidistant points of [-half_length, half_length), where n is even.
        half_length : float
            Half the period [beads].
        power : float
            Power to which the function is raised.

        Examples
        --------
        >>> import hertzchain as hc
        >>> import numpy as np
        >>> from hertzchain.theory.wave_profile import WaveProfile
        >>> x = np.arange(-8, 8) / 8
        >>> float(WaveProfile.from_samples(0.5 + 0.5 * np.cos(np.pi * x), 1.0)(0.5).round(12))
        0.5
        """
        coefficients = np.fft.rfft(np.fft.ifftshift(samples)).real * (2.0 / len(samples))
        coefficients[[0, -1]] *= 0.5
        last = int(np.flatnonzero(np.abs(coefficients) > 1e-16)[-1])
        kept = coefficients[: last + 1].copy()
        kept.setflags(write=False)
        return cls(half_length, power, kept)

    def with_tail(self, start: float, tail: Callable[[Array], Array]) -> WaveProfile:
        """Return the profile with a tail, which extends to any distance.

        Parameters
        ----------
        start : float
            Distance from the crest at which the tail begins [beads].
        tail : callable
            Function of an array of distances that returns the values of the tail before the
            power is taken.

        Examples
        --------
        >>> import hertzchain as hc
        >>> from hertzchain.theory.wave_profile import WaveProfile
        >>> import numpy as np
        >>> core = WaveProfile.from_samples(np.ones(16), 1.0)
        >>> core.with_tail(1.0, lambda x: np.exp(1.0 - x))([0.5, 3.0]).round(4)
        array([1.    , 0.1353])
        """
        return replace(self, _seam=start, _tail=tail)

    def __call__(self, distance: ArrayLike) -> Array:
        """Evaluate the profile at distances from the crest [beads].

        An `InputError` is raised if a distance is not finite, or beyond ``half_length`` for a
        profile without a tail.
        """
        xi = np.abs(real_numbers("distance", distance))
        within = np.isfinite(xi) & ((self._tail is not None) | (xi <= self.half_length))
        if not within.all():
            allowed = "be finite"
            if self._tail is None:
                allowed = f"be at most {self.half_length:g} beads"
            raise InputError(
                f"distance from the crest must {allowed}, got {float(xi.flat[np.argmin(within)]):g}"
            )
        # T_j(cos x) = cos(j x) for the Chebyshev polynomials T_j.
        cosine = np.cos(np.pi / self.half_length * np.minimum(xi, self.half_length))
        values = np.array(np.polynomial.chebyshev.chebval(cosine, self._coefficients))
        far = xi > self._seam
        if self._tail is not None and far.any():
            values[far] = self._tail(xi[far])
        # Rounding errors of the series may be negative, where the power is not defined.
        return values if self.power == 1.0 else np.maximum(values, 0.0) ** self.power

    def width(self, level: float = 0.5) -> float:
        """Full width at a fraction of the crest value, by default one half.

        Parameters
        ----------
        level : float
            Fraction, between 0 and 1.

        Returns
        -------
        float
            Width [beads].

        Raises
        ------
        InputError
            If the level is not between 0 and 1.

        Examples
        --------
        >>> import hertzchain as hc
        >>> wave = hc.solitary_wave()
        >>> [round(f.width(), 5) for f in (wave.overlap, wave.force, wave.velocity)]
        [1.72571, 1.41193, 1.57914]
        """
        level = number(
            "level of a width", level, unit=FRACTION, above=0.0, below=1.0, hint="try 0.5"
        )
        inside, outside = 0.0, self.half_length
        while self._tail is not None and self(outside) > level:
            outside *= 2.0
        for _ in range(60):
            middle = 0.5 * (inside + outside)
            if self(middle) > level:
                inside = middle
            else:
                outside = middle
        return inside + outside

    def crest_derivative(self, order: int) -> float:
        """Derivative of a profile of power one at its crest.

        Parameters
        ----------
        order : int
            Order of the derivative; odd ones are 0.

        Returns
        -------
        float
            Derivative with respect to the distance in beads.

        Raises
        ------
        InputError
            If the profile has a power other than one.

        Examples
        --------
        >>> import hertzchain as hc
        >>> round(hc.solitary_wave().velocity.crest_derivative(0), 12)
        1.0
        """
        if self.power != 1.0:
            raise InputError(
                "crest_derivative requires a profile of power one: velocity or overlap"
            )
        order = whole_number("order of a derivative", order, least=0)
        if order % 2:
            return 0.0
        wave_numbers = np.pi / self.half_length * np.arange(len(self._coefficients))
        with np.errstate(over="ignore"):
            terms = (-1) ** (order // 2) * self._coefficients * wave_numbers**order
        if not np.isfinite(terms).all():
            raise InputError(
                f"derivative {order} at the crest cannot be represented; use a lower order"
            )
        return math.fsum(terms)
