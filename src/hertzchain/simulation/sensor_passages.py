"""The passages of waves through a sensor: the first pulse, reflections and later waves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError, InputWarning, warn_user
from ..representation import measure, short
from ..validation.numbers import FRACTION, number
from .wave_events import SPLINE_ORDER, Curves, events_of
from .wave_samples import MIN_SAMPLES

if TYPE_CHECKING:
    from .sensor_force import SensorForce


@dataclass(frozen=True)
class SensorPassage:
    """One wave at a sensor.

    Attributes
    ----------
    bead : int
        Number k of the bead with the sensor.
    time : float
        Time of the maximum of the force [scaled, or s].
    peak : float
        Force in the sensor at this time, with the static force [scaled, or N].
    amplitude : float
        The peak beyond the static force [scaled, or N].
    width : float
        Time during which the force beyond the static one exceeds half of the amplitude [scaled, or
        s]; NaN where it does not fall to this on both sides.
    direction : int
        1 towards bead N, -1 towards bead 1; 0 where waves meet or the pulse is reflected.
    impulse : float
        Impulse of the force beyond the static one between the minima, or zeros, before and after
        the maximum [scaled, or N s].
    samples : float
        Saved times per impulse divided by amplitude; the numbers above are reliable from 8 on.
    units : str
        ``"scaled"`` or ``"SI"``.
    """

    bead: int
    time: float
    peak: float
    amplitude: float
    width: float
    direction: int
    impulse: float
    samples: float
    units: str = "scaled"

    @property
    def resolved(self) -> bool:
        """Whether enough times were saved while the wave passed."""
        return self.samples >= MIN_SAMPLES

    def __repr__(self) -> str:
        where = {1: "to the right", -1: "to the left"}.get(self.direction, "no direction")
        facts = [
            f"{measure(self.peak, 'N', self.units)} at t = {measure(self.time, 's', self.units)}"
        ]
        if np.isfinite(self.width):
            facts.append(f"width {measure(self.width, 's', self.units)}")
        return short("SensorPassage", f"bead {self.bead}, {where}", *facts,
                     *(() if self.resolved else ("unresolved",)))  # fmt: skip


def passages_of(self: SensorForce, *, threshold: float = 0.01) -> tuple[SensorPassage, ...]:
    """The waves that pass the sensor, in order of time: the pulse, reflections and later waves.

    Each maximum of the force that exceeds the minima beside it by a tenth of its height is a
    passage, as in `hertzchain.simulation.wave_events`.  The direction is that of the energy, which
    is the time integral of the force beyond the static one times the velocity of the bead.

    Parameters
    ----------
    threshold : float
        Smallest amplitude of a passage, relative to the largest one in this sensor.

    Returns
    -------
    tuple of SensorPassage

    Raises
    ------
    InputError
        If fewer than 7 times were saved.

    Warns
    -----
    InputWarning
        If fewer than 8 times were saved during a passage; it is marked as unresolved.

    Examples
    --------
    The pulse passes bead 10 and returns from the wall:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    >>> sensor = hc.simulate(chain, until=40.0, times=2000).sensor_force(10)
    >>> [(passage.direction, round(passage.time, 1)) for passage in sensor.passages()]
    [(1, 11.5), (-1, 36.8)]
    """
    threshold = number("threshold", threshold, unit=FRACTION, above=0.0, below=1.0)
    if not _enough(self):
        raise InputError(
            f"passages require many saved times, the run has {len(self.times)}; {self._advice}"
        )
    force = self.force - self.static_force
    curves = Curves(self.times, force, force * self.velocity)
    found = tuple(
        SensorPassage(
            self.bead, time=each.time, peak=each.amplitude + self.static_force,
            amplitude=each.amplitude, width=each.width, direction=each.direction,
            impulse=each.impulse, samples=each.samples, units=self.units,
        )
        for each in events_of(curves, self.bead, threshold * float(force.max()), self.units)
    )  # fmt: skip
    missed = [each for each in found if not each.resolved]
    if missed:
        least = min(each.samples for each in missed)
        warn_user(
            f"{len(missed)} of {len(found)} passages of bead {self.bead} have fewer than "
            f"{MIN_SAMPLES:g} saved times (least: {least:.3g}) and are marked as unresolved; "
            f"{self._advice}",
            InputWarning,
        )
    return found


def passages_if_saved(sensor: SensorForce) -> tuple[SensorPassage, ...]:
    """The passages, or none if too few times were saved."""
    return passages_of(sensor) if _enough(sensor) else ()


def _enough(sensor: SensorForce) -> bool:
    """Whether the saved times suffice for a spline."""
    return len(sensor.times) > SPLINE_ORDER
