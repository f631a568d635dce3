"""The force in a sensor, its first maximum and its largest value so far."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ..chain.bead_names import bead_number, wall_number
from ..chain.chain import Chain
from ..chain.laws.unloading_ratio import UnloadingRatio
from ..collision import Array
from ..errors import IncompleteWarning, InputError, warn_user
from ..frozen import Compared
from ..kernels.limits import FALL, MIN_HEIGHT
from ..representation import listed, measure, short
from ..validation.keywords import checked_methods
from .end_forces import has_free_face
from .force_table import force_dataframe
from .sensor_curve import maximum_near, place_and_bound_of_largest
from .sensor_passages import passages_of
from .touches import touches_of
from .trajectory import Trajectory
from .wave_samples import advised_times

if TYPE_CHECKING:
    import pandas as pd

# Number of saved times that suffices for sensors in contacts with losses.
MANY_TIMES = 4000
# Warn if the error of the largest force exceeds this fraction of it.
COARSE = 1e-2
# Fraction of the largest change of a force below which the pulse has not arrived: the computed
# motion ahead of the pulse decreases to this size within a few beads, and further without limit.
NEGLIGIBLE = 1e-6
# Relative error above which an error is shown.
SHOWN = 1e-4
# Of a sensor in a bead at a free end.
FREE_FACE = (
    "mean of the forces on both faces; the free face has none: the force on the body is twice this"
)
# Quantity with the whole force on the last body, and a remark in labels of figures.
WHOLE_FORCE = "body_force.peak"
HALF = "half of that on the body"


def free_face_note(chain: Chain, sensors: Mapping[str, int]) -> str:
    """That sensors in beads at free ends have half of the force, by name; empty without any."""
    half = {name: bead for name, bead in sensors.items() if has_free_face(chain, bead)}
    if not half:
        return ""
    whole = f" ({WHOLE_FORCE})" if chain.beads in half.values() else ""
    return f"{listed([*half])}: {FREE_FACE}{whole}"


@checked_methods
@dataclass(frozen=True, eq=False)
class SensorForce(Compared):
    """The force in a sensor embedded in a bead, :math:`(F_{k-1} + F_k)/2`.

    Attributes
    ----------
    bead : int
        Number k of the bead.
    times, force : ndarray, shape (T,)
        Force at the saved times [scaled, or s and N].  Both maxima are those from the first saved
        time on: in a run that was resumed, they do not include the time before.
    first_maximum, first_maximum_time : float
        The first maximum and its time: the largest force before the first fall by 10% of it that
        begins above 1% of the largest force, both counted from the force at rest.  Ripples after
        which the force falls by less and rises further are part of the rising flank.  NaN if there
        is none yet.
    largest_so_far, largest_so_far_time : float
        Largest force and its time.  Waves that follow the first one, or return from a wall, may
        exceed it later.
    error : float
        Bound of the error of both maxima [scaled, or N], which are interpolated between saved
        times.  In elastic chains, the overlaps are interpolated by polynomials of degree 5, and
        the bound is usually negligible.  With losses or a drive, the forces are interpolated by a
        spline; the bound then assumes that the force may have a jump or a corner.  If it has none,
        as with `Restitution`, the error is about a hundredth of the bound.  Saved times that do not
        show the largest overlaps of both contacts are too few: the bound then includes the force
        at these overlaps.  With `UnloadingRatio`, the force jumps whenever a contact begins to
        open, and which maximum is the first depends on the saved times: the bound is then at least
        that of the jumps.  With `Dashpot` and `VelocityPower`, the force begins with a jump when a
        contact closes between saved times; this time follows from the preceding motion.
    units : str
        ``"scaled"`` or ``"SI"``.
    static_force : float
        Force at rest, of gravity or precompression, which all other forces include.  A
        piezoelectric sensor does not show it.
    reached : bool
        Whether the pulse has arrived: the force has changed by at least 1e-6 of the largest change
        of a force in the chain.
    free_face : bool
        Whether the bead is at a free end, so that one of its faces has no force.  The force on the
        other face, which accelerates the bead, is then twice the force in the sensor.
    velocity : ndarray, shape (T,)
        Velocity of the bead at the saved times [scaled, or m/s].
    """

    bead: int
    times: Array = field(repr=False)
    force: Array = field(repr=False)
    first_maximum: float
    first_maximum_time: float
    largest_so_far: float
    largest_so_far_time: float
    units: str = "scaled"
    error: float = 0.0
    static_force: float = 0.0
    reached: bool = True
    free_face: bool = False
    velocity: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    # Advice for a run with too few saved times for passages.
    _advice: str = field(default="give simulate more times", repr=False)

    passages = passages_of

    def __repr__(self) -> str:
        if not self.reached:
            return short("SensorForce", f"bead {self.bead}", "the pulse has not arrived")
        first, largest = (
            f"{measure(force, 'N', self.units)} at t = {measure(time, 's', self.units)}"
            for force, time in (
                (self.first_maximum, self.first_maximum_time),
                (self.largest_so_far, self.largest_so_far_time),
            )
        )
        if math.isnan(self.first_maximum):
            first = "none yet"
        facts = [f"first maximum {first}", f"largest so far {largest}"]
        if self.static_force:
            static = measure(self.static_force, "N", self.units)
            facts.append(f"both with the static force of {static}")
        if self.error > SHOWN * abs(self.largest_so_far):
            facts.append(f"errors at most {measure(self.error, 'N', self.units, digits=2)}")
        if len(self.times) and self.times[0] > 0.0:
            begin = measure(float(self.times[0]), "s", self.units)
            facts.append(f"forces before t = {begin} are not included")
        if self.free_face:
            facts.append(FREE_FACE)
        return short("SensorForce", f"bead {self.bead}", *facts)

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per saved time.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``time``; the column ``force``.  ``attrs["units"]`` has their units ("1":
            scaled).

        Examples
        --------
        >>> import hertzchain as hc
        >>> run = hc.simulate(hc.Chain.uniform(9), until=30.0, times=1001)
        >>> table = run.sensor_force(5).to_dataframe()
        >>> len(table), table.attrs["units"]["force"]
        (1001, '1')
        """
        return force_dataframe(self.times, self.force, self.units)

    def _repr_html_(self) -> str:
        from ..notebook.runs import sensor_force_html

        return sensor_force_html(self)


def sensor_force_of(self: Trajectory, bead: int | str) -> SensorForce:
    """Force in a sensor in a bead, with its first maximum and its largest value so far.

    Parameters
    ----------
    bead : int or str
        Number k of the bead, from 1, strikers included; or a name as in traces: ``"ball 11"``,
        counted without the strikers, is bead 12 of a chain with one striker.

    Raises
    ------
    InputError
        If there is no such bead, or no times were saved.

    Warns
    -----
    IncompleteWarning
        If the force has had no maximum yet; ``first_maximum`` is then NaN.  Also if saved times
        are so few that the largest force is uncertain by more than 1%.

    Examples
    --------
    The pulse passes bead 10 and returns from the wall:

    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    >>> sensor = hc.simulate(chain, until=60.0, times=2000).sensor_force(10)
    >>> sensor.first_maximum_time < 15.0 and sensor.largest_so_far >= sensor.first_maximum
    True
    """
    if (wall := wall_number(self.chain, bead)) is not None:
        side = "left" if wall == 0 else "right"
        raise InputError(
            f"sensor_force is the force in a bead, got {bead!r}; run.wall_force({side!r}) is that "
            "on the wall, with its peak"
        )
    bead = bead_number(self.chain, bead)
    found = sensor_maxima(self, bead)
    if math.isnan(found.first_maximum):
        end = measure(float(self.times[-1]), "s", self.chain.units, 6)
        missing = f"the pulse had not reached bead {bead} at t = {end}; simulate for longer"
        if found.reached:
            missing = (
                f"the force in bead {bead} had no maximum before t = {end}; simulate for longer, "
                "or save more times"
            )
        warn_user(missing, IncompleteWarning)
    warn_if_coarse(self, found)
    return found


def _jumps(run: Trajectory, bead: int) -> float:
    """Largest sum of the jumps of the force in a sensor, of contacts with `UnloadingRatio`."""
    laws, loads = run.chain.contact_losses, run.forces.max(axis=0)
    return 0.5 * sum(
        law.ratio * float(loads[contact])
        for contact in (bead - 1, bead)
        if isinstance(law := laws[contact], UnloadingRatio)
    )


def warn_if_coarse(run: Trajectory, found: SensorForce) -> None:
    """Warn if saved times are so few that the largest force is uncertain by more than 1%."""
    if found.reached and found.error > COARSE * found.largest_so_far:
        if found.error == _jumps(run, found.bead):
            warn_user(
                f"the force in bead {found.bead} jumps whenever a contact with UnloadingRatio "
                f"begins to open, so that its maxima may have errors of "
                f"{measure(found.error, 'N', run.chain.units)}; for forces in sensors, use another "
                "law, such as Restitution",
                IncompleteWarning,
            )
            return
        warn_user(
            f"the largest force in bead {found.bead} may have an error of "
            f"{measure(found.error, 'N', run.chain.units)}, because it is interpolated between "
            f"{len(run.times)} saved times; save more times",
            IncompleteWarning,
        )


def sensor_maxima(run: Trajectory, bead: int) -> SensorForce:
    """As `sensor_force_of`, without warnings."""
    run._require_times()
    force = run.sensor(bead)
    # The first force is that on the end behind the strikers, which carry none.
    static = run.chain.static_state.forces[bead - 1 : bead + 1]
    at_rest = 0.5 * float(static.sum()) if bead > run.chain.strikers else 0.0
    found = find_maxima(bead, run.times, force, at_rest, run.chain.units)
    tops, bound = _tops(run, bead, force, at_rest)
    largest_change = float((run.forces - run.chain.static_state.forces).max())
    reached = float(np.abs(force - at_rest).max()) > NEGLIGIBLE * largest_change
    first, first_time, _ = tops[0] if len(tops) > 1 else (math.nan,) * 3
    # The first maximum may be larger between saved times than the one at a saved time.
    largest, largest_time, _ = max(tops)
    return replace(
        found, first_maximum=first, first_maximum_time=first_time, largest_so_far=largest,
        largest_so_far_time=largest_time,
        error=max(bound - largest, _jumps(run, bead), *(top[2] for top in tops)),
        static_force=at_rest, reached=reached, free_face=has_free_face(run.chain, bead),
        velocity=run.velocity(bead), _advice=advised_times(run, (bead - 1, bead)),
    )  # fmt: skip


def _tops(
    run: Trajectory, bead: int, force: Array, at_rest: float
) -> tuple[list[tuple[float, float, float]], float]:
    """Heights, times and errors of the first maximum, if any, and of the largest force.

    The second result is an upper bound of the largest force.
    """
    touches = touches_of(run, bead, force)
    place, bound = place_and_bound_of_largest(run, bead, force)

    def top(time: float) -> tuple[float, float, float]:
        closes = touches.at(time)
        if closes is not None:
            return float(touches.forces[closes]), time, float(touches.errors[closes])
        return maximum_near(run, bead, force, int(np.searchsorted(run.times, time)))

    curve = touches.inserted(run.times, force)
    found = find_maxima(bead, *curve, at_rest)
    largest = float(run.times[place])
    if touches.forces.max(initial=0.0) > force.max():
        largest = found.largest_so_far_time
    tops = [top(largest)]
    if not math.isnan(found.first_maximum_time):
        tops.insert(0, top(found.first_maximum_time))
    return tops, bound


def find_maxima(
    bead: int, times: Array, force: Array, at_rest: float, units: str = "scaled"
) -> SensorForce:
    """Find the maxima of the force in a sensor."""
    excess = force - at_rest
    top = np.maximum.accumulate(excess)
    fallen = (top > MIN_HEIGHT * top[-1]) & (excess < (1.0 - FALL) * top)
    first = first_time = math.nan
    if fallen.any():
        i = int(np.argmax(excess[: int(np.argmax(fallen))]))
        first, first_time = float(force[i]), float(times[i])
    j = int(np.argmax(force))
    largest = float(force[j]), float(times[j])
    return SensorForce(bead, times, force, first, first_time, *largest, units)
