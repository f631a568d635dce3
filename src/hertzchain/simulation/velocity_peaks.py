"""Velocity peaks of one bead, in both directions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..chain.bead_names import bead_number
from ..collision import Array
from ..errors import InputError
from ..frozen import Compared
from ..representation import counted, measure, short
from ..validation.keywords import checked_methods
from ..validation.numbers import whole_number
from .trajectory import Trajectory
from .wave_samples import advised_times

if TYPE_CHECKING:
    import pandas as pd

# Peaks lower than this fraction of the highest one are ignored.
RIPPLE: Final = 0.01
# Fraction of the largest velocity of any bead below which velocities are rounding errors, or the
# foot of a pulse that has not arrived, which is too small to be computed accurately.
NOTHING: Final = 1e-12
# Absolute tolerance of the times at half height, which have a relative one.
TINY: Final = 1e-300


@checked_methods
@dataclass(frozen=True, eq=False)
class VelocityPeaks(Compared):
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
    units : str
        ``"scaled"`` or ``"SI"``.
    """

    bead: int
    times: Array
    velocities: Array
    widths: Array
    units: str = "scaled"

    def __repr__(self) -> str:
        def peak(i: int) -> str:
            time = measure(self.times[i], "s", self.units)
            return f"{measure(self.velocities[i], 'm/s', self.units)} at t = {time}"

        facts = [counted(len(self), "peak")]
        if len(self):
            largest = int(np.argmax(self.amplitudes))
            facts += [f"the first {peak(0)}", f"the largest {peak(largest)}"][: 1 + (largest > 0)]
        return short("VelocityPeaks", f"bead {self.bead}", ", ".join(facts))

    def _repr_html_(self) -> str:
        from ..notebook.waves import velocity_peaks_html

        return velocity_peaks_html(self)

    @property
    def amplitudes(self) -> Array:
        """Absolute heights of the peaks, shape (W,) [scaled, or m/s]."""
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


def velocity_peaks_of(self: Trajectory, bead: int | str) -> VelocityPeaks:
    """Find the peaks of the velocity of one bead, forwards and backwards.

    Parameters
    ----------
    bead : int or str
        Number k of the bead, 2 or more, or a name such as ``"ball 11"``, as for `Run.sensor`.

    Returns
    -------
    VelocityPeaks
        Their times, velocities and widths, from the saved times.  Peaks below 1% of the largest
        one of this bead, or below 1e-12 of the largest velocity of any bead, are ignored.

    Raises
    ------
    InputError
        If there is no such bead, or fewer than two times were saved.

    Examples
    --------
    A wave and its reflection from a rigid wall:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(40).replace(right_wall=hc.Wall.rigid())
    >>> run = hc.simulate(chain, until=80.0, times=1600)
    >>> run.velocity_peaks(25).velocities[:2].round(3)
    array([ 0.682, -0.681])
    """
    number = bead_number(self.chain, bead)
    k = whole_number("bead", number, least=2, most=self.chain.beads)
    return peaks_from(self, k)


def peaks_from(run: Trajectory, k: int, which: slice = slice(None)) -> VelocityPeaks:
    """Peaks of the velocity of bead k from some of the saved times."""
    if len(run.times) < 2:
        raise InputError(
            f"velocity peaks require at least 2 saved times, the run has {len(run.times)}; "
            f"{advised_times(run, (k - 1, k))}"
        )
    net = run.forces[:, k - 1] - run.forces[:, k] + run.chain.static_state.body_forces[k - 1]
    acceleration = net / run.chain.masses[k - 1]
    curves = (run.times[which], run.velocity(k)[which], acceleration[which])
    floor = NOTHING * float(np.abs(run.velocities).max(initial=0.0))
    return find_peaks(k, *curves, run.chain.units, floor=floor)


def find_peaks(
    bead: int,
    times: Array,
    velocity: Array,
    acceleration: Array,
    units: str = "scaled",
    floor: float = 0.0,
) -> VelocityPeaks:
    """Find the peaks of a bead's velocity that are higher than ``floor``.

    Between two saved times the velocity is interpolated by the cubic with the given velocities and
    accelerations at both; the error of a peak is of fourth order in the spacing.
    """
    from scipy.interpolate import CubicHermiteSpline

    curve = CubicHermiteSpline(times, velocity, acceleration)
    turning = curve.derivative().roots(extrapolate=False)
    turning = turning[np.isfinite(turning)]
    # Between these times, the velocity rises or falls throughout.
    edges = np.union1d(times, turning)
    # A forward maximum is positive and concave, a backward minimum negative and convex.
    turning = turning[curve(turning, 2) * curve(turning) < 0.0]
    heights = np.abs(curve(turning))
    crests = turning[heights > max(floor, RIPPLE * np.max(heights, initial=0.0))]
    at_edges = curve(edges)
    widths = np.array([
        _width_at_half(curve, edges, at_edges, int(np.searchsorted(edges, crest)))
        for crest in crests
    ])  # fmt: skip
    return VelocityPeaks(bead, crests, curve(crests), widths, units)


def _width_at_half(curve: Any, edges: Array, velocities: Array, crest: int) -> float:
    """Full width at half height of the peak at edge ``crest``; NaN if one side stays above it."""
    from scipy.optimize import brentq

    peak = velocities[crest]
    below = velocities / peak <= 0.5
    before, after = np.flatnonzero(below[:crest]), np.flatnonzero(below[crest:])
    if not (len(before) and len(after)):
        return math.nan
    start, end = (
        brentq(lambda t: float(curve(t) / peak - 0.5), edges[i], edges[i + 1], xtol=TINY)
        for i in (int(before[-1]), crest + int(after[0]) - 1)
    )
    return float(end - start)
