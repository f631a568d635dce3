r"""The passage of a wave through one contact: a maximum of its force, with impulse and work.

With the force :math:`f = F - F_0` beyond the static one and the mean velocity
:math:`v = (v_k + v_{k+1})/2` of the two beads, the impulse and work that a wave transfers through
contact k between the force minima (or contact openings) before and after its crest are

.. math:: J = \int f\,dt, \qquad W = \int f\,v\,dt .

Without losses :math:`f\,v` is exactly the flux of energy through the contact, with the energy
of the contact shared equally between both sides.  An isolated wave therefore has momentum
:math:`J` and energy :math:`|W|`, and the sign of :math:`W` is its direction.

Between saved times :math:`f` and :math:`f v` are quintic splines.  With eight saved times per
duration the amplitude of a solitary wave is accurate to 1e-6, and J and W to 1e-8.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, Final

import numpy as np

from ..chain.bisection import bisected
from ..collision import Array
from ..errors import InputError
from ..frozen import Compared
from ..representation import counted, measure, short
from .trajectory import Trajectory
from .wave_samples import MIN_SAMPLES, advised_times

# Fraction of its height by which a maximum must exceed the minima next to it.
PROMINENCE: Final = 0.1
# Waves meet, or a wall reflects one, if |W| is less than this fraction of the integral of |f v|.
STANDING: Final = 0.2
# Impulse over that of the crest, 1 in a symmetric pulse, and force between two waves over that of
# the smaller one.
MERGED, BETWEEN = 1.5, 0.1
SPLINE_ORDER: Final = 5
# Bisections of the time between two saved times that give double precision.
BISECTIONS: Final = 45


@dataclass(frozen=True, eq=False)
class WaveEvent(Compared):
    """One wave at one contact.

    Attributes
    ----------
    contact : int
        Number k of the contact.
    time : float
        Time of the force maximum [scaled, or s].
    amplitude : float
        Largest force beyond the static one [scaled, or N].
    impulse : float
        Impulse J of this force from ``begin`` to ``end`` [scaled, or N s].
    impulse_before : float
        The part of this impulse before the maximum [scaled, or N s].
    work : float
        Work W of this force, positive towards bead N [scaled, or J].
    direction : int
        1 towards bead N, -1 towards bead 1; 0 where waves meet, and at walls.
    width : float
        Full width at half maximum in time [scaled, or s]; NaN where the force does not fall
        to half of its maximum on both sides.
    begin, end : float
        Times of the force minima, or of the closing and opening of the contact, before and
        after the maximum [scaled, or s].
    samples : float
        Saved times per `duration`; the numbers above are reliable from 8 on.
    lowest : float
        Larger of the forces at ``begin`` and ``end``, relative to the amplitude.
    units : str
        ``"scaled"`` or ``"SI"``.
    """

    contact: int
    time: float
    amplitude: float
    impulse: float
    impulse_before: float
    work: float
    direction: int
    width: float
    begin: float
    end: float
    samples: float
    lowest: float = 0.0
    units: str = "scaled"

    @property
    def momentum(self) -> float:
        """Momentum with the sign of the direction; NaN without a direction."""
        return self.direction * self.impulse if self.direction else math.nan

    @property
    def energy(self) -> float:
        """Absolute energy of the wave; NaN without a direction."""
        return abs(self.work) if self.direction else math.nan

    @property
    def duration(self) -> float:
        """Impulse divided by amplitude; 1.06 times the width of a solitary wave (p = 3/2)."""
        return self.impulse / self.amplitude

    @property
    def impulse_of_crest(self) -> float:
        """Twice the smaller part of the impulse, before or after the maximum [scaled, or N s].

        In a symmetric pulse, this is the impulse.  It is smaller where later waves have not
        separated yet and the force does not fall between them.
        """
        return 2.0 * min(self.impulse_before, self.impulse - self.impulse_before)

    @property
    def merged(self) -> bool:
        """Whether `impulse` includes waves that have not separated from this one.

        This is so if it is more than 1.5 times that of the crest, or if the force does not fall
        below a tenth of its maximum on both sides.
        """
        return self.lowest > BETWEEN or self.impulse > MERGED * self.impulse_of_crest

    @property
    def resolved(self) -> bool:
        """Whether enough times were saved while the wave passed."""
        return self.samples >= MIN_SAMPLES

    def __repr__(self) -> str:
        force, impulse, time = (
            measure(value, unit, self.units)
            for value, unit in ((self.amplitude, "N"), (self.impulse, "N s"), (self.time, "s"))
        )
        direction = {1: "to the right", -1: "to the left"}.get(self.direction, "no direction")
        doubt = ", merged" * self.merged + ", unresolved" * (not self.resolved)
        return short(
            "WaveEvent",
            f"contact {self.contact}, {direction}, t = {time}",
            f"force {force}, impulse {impulse}, energy "
            f"{measure(abs(self.work), 'J', self.units)}{doubt}",
        )


def static_forces_of(run: Trajectory) -> Array:
    """Static force of each contact, 0 at ends without a wall."""
    return np.where(run.chain.contact_stiffness > 0.0, run.chain.static_state.forces, 0.0)


def largest_force_of(run: Trajectory) -> float:
    """Largest force beyond the static one in any contact of a run, 0 if there is none."""
    most = np.max(run.forces, axis=0, initial=0.0) - static_forces_of(run)
    return max(0.0, float(most.max()))


def check_saved_times(run: Trajectory) -> None:
    """Raise `InputError` if there are too few saved times for a spline."""
    if len(run.times) <= SPLINE_ORDER:
        raise InputError(
            f"waves require many saved times, the run has {len(run.times)}; {advised_times(run)}"
        )


def require_resolved(
    run: Trajectory, event: WaveEvent, name: str, contacts: Sequence[int] = ()
) -> None:
    """Raise `InputError` if too few times were saved during the passage of a wave.

    The advice includes other waves at these contacts.
    """
    if not event.resolved:
        samples = min(max(1, round(event.samples)), math.ceil(MIN_SAMPLES) - 1)
        raise InputError(
            f"{name} has about {counted(samples, 'saved time')} while it passes contact "
            f"{event.contact}, but at least {MIN_SAMPLES:g} are required; "
            f"{advised_times(run, (event.contact, *contacts))}"
        )


class Curves:
    """Force beyond the static one and power at one place, as functions of time."""

    def __init__(self, times: Array, force: Array, power: Array) -> None:
        self.times, self.force, self.power = times, force, power

    @cached_property
    def force_curve(self) -> Any:
        """Spline of the force."""
        from scipy.interpolate import make_interp_spline

        return make_interp_spline(self.times, self.force, k=SPLINE_ORDER)

    @cached_property
    def power_curve(self) -> Any:
        """Spline of the power."""
        from scipy.interpolate import make_interp_spline

        return make_interp_spline(self.times, self.power, k=SPLINE_ORDER)


class ContactCurves(Curves):
    """Force beyond the static one and power of one contact, as functions of time."""

    def __init__(self, run: Trajectory, contact: int) -> None:
        force = run.forces[:, contact] - static_forces_of(run)[contact]
        power = np.zeros(len(run.times))
        if 0 < contact < run.chain.beads:
            power = 0.5 * force * (run.velocities[:, contact - 1] + run.velocities[:, contact])
        super().__init__(run.times, force, power)


def events_at(run: Trajectory, contact: int, floor: float) -> list[WaveEvent]:
    """The waves that pass one contact, in order of time."""
    return events_of(ContactCurves(run, contact), contact, floor, run.chain.units)


def events_of(curves: Curves, contact: int, floor: float, units: str) -> list[WaveEvent]:
    """The maxima of a force that are large enough, in order of time."""
    times, force = curves.times, curves.force
    crests = _crests(force, floor)
    if not len(crests):
        return []
    peak_times = sign_change(curves.force_curve.derivative(), times[crests - 1], times[crests + 1])
    heights = curves.force_curve(peak_times)
    # A kink of the force near the crest may distort the spline, but not the sample.
    lower = heights < force[crests]
    peak_times, heights = (
        np.where(lower, times[crests], peak_times), np.where(lower, force[crests], heights)
    )  # fmt: skip
    begin, end = _limits(curves, crests)
    impulses, before = (_integrals(curves.force_curve, begin, until) for until in (end, peak_times))
    works = _integrals(curves.power_curve, begin, end)
    spacing = 0.5 * (times[crests + 1] - times[crests - 1])
    columns = {
        "time": peak_times, "amplitude": heights, "impulse": impulses,
        "impulse_before": before, "work": works,
        "direction": _directions(curves, works, begin, end),
        "width": _widths(curves, crests, 0.5 * heights), "begin": begin, "end": end,
        "samples": impulses / heights / spacing,
        "lowest": np.maximum(*(curves.force_curve(each) for each in (begin, end))) / heights,
    }  # fmt: skip
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [WaveEvent(contact, units=units, **dict(zip(columns, row, strict=True))) for row in rows]


def _crests(force: Array, floor: float) -> Array:
    """Indices of the maxima that are high enough above the minima next to them."""
    from scipy.signal import find_peaks, peak_prominences

    if not floor > 0.0:
        return np.zeros(0, int)
    crests = find_peaks(force, height=floor)[0]
    return np.asarray(crests[peak_prominences(force, crests)[0] > PROMINENCE * force[crests]])


def sign_change(curve: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Find a change of sign of a function between two times by bisection."""
    negative = curve(low) < 0.0
    return bisected(lambda time: (curve(time) < 0.0) == negative, low, high, BISECTIONS)


def _integrals(curve: Any, begin: Array, end: Array) -> Array:
    whole = curve.antiderivative()
    return np.asarray(whole(end) - whole(begin))


def _limits(curves: Curves, crests: Array) -> tuple[Array, Array]:
    """Begin and end of each event: zeros of the force, or the minima between two crests."""
    times, force = curves.times, curves.force
    last = len(times) - 1
    zeros = np.flatnonzero(force <= 0.0)
    valleys = np.array([a + np.argmin(force[a:b]) for a, b in pairwise(crests)], int)
    place = np.searchsorted(zeros, crests)
    before = np.concatenate(([-1], zeros))[place]
    after = np.concatenate((zeros, [last + 1]))[place]

    low, high = np.maximum(valleys - 1, 0), np.minimum(valleys + 1, last)
    minima = sign_change(curves.force_curve.derivative(), times[low], times[high])
    begin = np.concatenate((times[:1], minima))
    end = np.concatenate((minima, times[-1:]))
    opens_before = before >= np.concatenate(([0], valleys))
    opens_after = after <= np.concatenate((valleys, [last]))
    begin[opens_before] = _zeros(curves, before[opens_before], before[opens_before] + 1)
    end[opens_after] = _zeros(curves, after[opens_after], after[opens_after] - 1)
    return begin, end


def _zeros(curves: Curves, outside: Array, inside: Array) -> Array:
    """Zeros of the force between two saved times; the outer time if the force is 0 there."""
    times, force = curves.times, curves.force
    passed = sign_change(curves.force_curve, times[outside], times[inside])
    return np.where(force[outside] == 0.0, times[outside], passed)


def _directions(curves: Curves, works: Array, begin: Array, end: Array) -> Array:
    """Sign of the work; 0 where it is small compared with the energy that flows to and fro."""
    from scipy.integrate import cumulative_trapezoid

    flow = cumulative_trapezoid(np.abs(curves.power), curves.times, initial=0.0)
    both = np.interp(end, curves.times, flow) - np.interp(begin, curves.times, flow)
    standing = (np.abs(works) < STANDING * both) | (both == 0.0)
    return np.where(standing, 0, np.sign(works)).astype(int)


def _widths(curves: Curves, crests: Array, halves: Array) -> Array:
    """Full widths at half maximum; NaN where the force does not fall to half on both sides."""
    times, force = curves.times, curves.force
    bounds = [0, *crests, len(force) - 1]
    inside = np.full((2, len(crests)), -1)
    for i, (crest, half) in enumerate(zip(crests, halves, strict=True)):
        rising = np.flatnonzero(force[bounds[i] : crest] < half)
        falling = np.flatnonzero(force[crest : bounds[i + 2] + 1] < half)
        if len(rising) and len(falling):
            inside[:, i] = bounds[i] + rising[-1], crest + falling[0] - 1
    known = inside[0] >= 0
    places, levels = inside[:, known].ravel(), np.tile(halves[known], 2)

    def above_half(time: Array) -> Array:
        return np.asarray(curves.force_curve(time) - levels)

    left, right = sign_change(above_half, times[places], times[places + 1]).reshape(2, -1)
    widths = np.full(len(crests), np.nan)
    widths[known] = right - left
    return widths
