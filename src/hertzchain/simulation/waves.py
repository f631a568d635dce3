"""The waves that pass one bead: a train of solitary waves, one after another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from hertzchain.contacts import Array
from hertzchain.errors import InputError

# Maxima lower than this part of the highest are ripples.
RIPPLE: Final = 0.01


@dataclass(frozen=True, eq=False)
class Waves:
    """Velocity maxima of one bead, in order of time.

    Attributes
    ----------
    bead : int
        Number k of the bead.
    times : ndarray, shape (W,)
        When each wave's crest passes [scaled, or s].
    amplitudes : ndarray, shape (W,)
        Largest velocity [scaled, or m/s].
    widths : ndarray, shape (W,)
        Full width at half maximum of the velocity in time [scaled, or s]; NaN where a wave
        does not fall to half of its height on both sides.
    """

    bead: int
    times: Array
    amplitudes: Array
    widths: Array

    def __len__(self) -> int:
        return len(self.times)


def waves_at(bead: int, times: Array, velocity: Array, acceleration: Array) -> Waves:
    """The waves in a bead's velocity.

    Between saved times the velocity is the cubic that has both velocities and both
    accelerations; the error of an amplitude falls as the fourth power of the spacing.

    Parameters
    ----------
    bead : int
        Number of the bead.
    times, velocity, acceleration : ndarray, shape (T,)
        At the saved times.

    Returns
    -------
    Waves

    Raises
    ------
    InputError
        If fewer than two times were saved.

    Examples
    --------
    >>> t = np.linspace(0.0, 6.0, 200)
    >>> waves = waves_at(1, t, np.sin(t) ** 2, np.sin(2 * t))
    >>> waves.amplitudes.round(6), waves.widths.round(3)
    (array([1., 1.]), array([1.571, 1.571]))
    """
    from scipy.interpolate import CubicHermiteSpline

    if len(times) < 2:
        raise InputError(f"waves need at least 2 saved times, the run has {len(times)}")
    curve = CubicHermiteSpline(times, velocity, acceleration)
    turning = curve.derivative().roots(extrapolate=False)
    turning = turning[np.isfinite(turning)]
    highest = turning[curve(turning, 2) < 0.0]
    heights = curve(highest)
    kept = heights > RIPPLE * np.max(heights, initial=0.0)
    crests, amplitudes = highest[kept], heights[kept]
    widths = np.full(len(crests), np.nan)
    for i, (crest, height) in enumerate(zip(crests, amplitudes, strict=True)):
        halves = curve.solve(0.5 * height, extrapolate=False)
        before, after = halves[halves < crest], halves[halves > crest]
        if len(before) and len(after):
            widths[i] = after[0] - before[-1]
    return Waves(bead, crests, amplitudes, widths)
