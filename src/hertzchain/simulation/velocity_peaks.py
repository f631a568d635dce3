"""Velocity peaks of one bead, in both directions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from hertzchain.contacts import Array
from hertzchain.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

# Peaks lower than this part of the highest are ripples.
RIPPLE: Final = 0.01


@dataclass(frozen=True, eq=False)
class VelocityPeaks:
    """Forward maxima and backward minima of a bead's velocity, in order of time.

    In a chain without precompression a wave moves the beads in its own direction: a forward
    maximum belongs to a wave towards bead N, a backward minimum to one towards bead 1.

    Attributes
    ----------
    bead : int
        Number k of the bead.
    times : ndarray, shape (W,)
        Times of the peaks [scaled, or s].
    velocities : ndarray, shape (W,)
        Velocities there, negative for motion towards bead 1 [scaled, or m/s].
    widths : ndarray, shape (W,)
        Full widths at half height in time [scaled, or s]; NaN where the velocity does not fall
        to half of the peak on both sides.
    """

    bead: int
    times: Array
    velocities: Array
    widths: Array

    @property
    def amplitudes(self) -> Array:
        """Heights of the peaks, shape (W,), whatever their direction [scaled, or m/s]."""
        return np.abs(self.velocities)

    @property
    def directions(self) -> Array:
        """1 for motion towards bead N, -1 for motion towards bead 1, shape (W,)."""
        return np.sign(self.velocities).astype(int)

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per peak.

        Returns
        -------
        pandas.DataFrame
            Columns ``time``, ``velocity`` and ``width``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(30), until=30.0)
        >>> len(run.velocity_peaks(10).to_dataframe())
        1
        """
        import pandas as pd

        return pd.DataFrame({"time": self.times, "velocity": self.velocities, "width": self.widths})

    def __len__(self) -> int:
        return len(self.times)


def velocity_peaks(bead: int, times: Array, velocity: Array, acceleration: Array) -> VelocityPeaks:
    """Find the peaks of a bead's velocity.

    Between saved times the velocity is the cubic with the given velocities and accelerations
    at both; the error of a peak falls as the fourth power of the spacing.

    Parameters
    ----------
    bead : int
        Number of the bead.
    times, velocity, acceleration : ndarray, shape (T,)
        At the saved times.

    Returns
    -------
    VelocityPeaks

    Raises
    ------
    InputError
        If fewer than two times were saved.

    Examples
    --------
    >>> t = np.linspace(0.0, 6.0, 200)
    >>> peaks = velocity_peaks(1, t, np.sin(t), np.cos(t))
    >>> peaks.times.round(4), peaks.velocities.round(4)
    (array([1.5708, 4.7124]), array([ 1., -1.]))
    """
    from scipy.interpolate import CubicHermiteSpline

    if len(times) < 2:
        raise InputError(
            f"velocity peaks need at least 2 saved times, the run has {len(times)}; give simulate "
            "more times"
        )
    curve = CubicHermiteSpline(times, velocity, acceleration)
    turning = curve.derivative().roots(extrapolate=False)
    turning = turning[np.isfinite(turning)]
    # A forward maximum bends down where it is positive, a backward minimum the other way.
    turning = turning[curve(turning, 2) * curve(turning) < 0.0]
    heights = np.abs(curve(turning))
    crests = turning[heights > RIPPLE * np.max(heights, initial=0.0)]
    peaks = curve(crests)
    widths = np.full(len(crests), np.nan)
    for i, (crest, peak) in enumerate(zip(crests, peaks, strict=True)):
        halves = curve.solve(0.5 * peak, extrapolate=False)
        before, after = halves[halves < crest], halves[halves > crest]
        if len(before) and len(after):
            widths[i] = after[0] - before[-1]
    return VelocityPeaks(bead, crests, peaks, widths)
