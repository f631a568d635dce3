"""The largest force on the last body of a free end, located between the saved times."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from ..collision import Array
from ..errors import InputError, SimulationError
from ..recorded_warnings import ignore_warnings
from .body_peak import BodyForce
from .resolved_body import resolved
from .sensor_curve import crossings_around
from .sensor_force import sensor_maxima
from .wall_bound import RIGHT

if TYPE_CHECKING:
    from .run import Run

# Part of the largest force above which the duration of an acceleration is counted.
ABOVE: Final = 0.1
# Of a peak that is not complete.
MAY_FOLLOW: Final = "a larger force may follow"


def force_on_body(run: Run) -> Array:
    """Force of the last contact at the saved times, without the static force."""
    contact = run.chain.beads - 1
    force: Array = run.forces[:, contact] - float(run.chain.static_state.forces[contact])
    return force


def body_curve(run: Run) -> tuple[Array, Array]:
    """Saved times and force on the last body, without the static force, with the largest one."""
    times, force = run.times, force_on_body(run)
    found = body_force(run)
    if found is None or found.time in times or not times[0] < found.time < times[-1]:
        return times, force
    at = int(np.searchsorted(times, found.time))
    return np.insert(times, at, found.time), np.insert(force, at, found.force)


def body_force(run: Run) -> BodyForce | None:
    """The force on the last body of a free end, regardless of the saved times.

    `None` with a right wall, and before the force has had a maximum.  If the saved times do not
    resolve the force, the run is repeated with others.  If it cannot be repeated, for example
    because it is read from a file and began with dents, its own times are used.
    """
    if run.chain.right_wall is not None:
        return None
    # `Run` is frozen; a converted or replaced run has no such entry.
    if "_body_force" not in run.__dict__:
        with ignore_warnings():
            try:
                fine = resolved(run)
            except (InputError, SimulationError):
                fine = run
            found = _from_saved_times(fine)
            if found is not None:
                whole = fine.times[0] <= 0.0
                found = replace(found, complete=whole and bool(run._complete[RIGHT]))
            run.__dict__["_body_force"] = found
    known: BodyForce | None = run.__dict__["_body_force"]
    return known


def _from_saved_times(run: Run) -> BodyForce | None:
    """The force that the saved times of a run show; `None` without a maximum."""
    chain = run.chain
    if len(run.times) < 2:
        return None
    sensor = sensor_maxima(run, chain.beads)
    if not sensor.reached or math.isnan(sensor.first_maximum):
        return None
    # The sensor has half of the force on one face, and the static force acts on both.
    rest = sensor.static_force
    level = rest + ABOVE * (sensor.largest_so_far - rest)
    start, end = crossings_around(run, chain.beads, sensor.force, sensor.largest_so_far_time, level)
    return BodyForce(
        2.0 * (sensor.largest_so_far - rest), sensor.largest_so_far_time, end - start,
        float(chain.masses[-1]), 2.0 * sensor.error,
        sensor.largest_so_far_time != sensor.first_maximum_time, units=chain.units,
    )  # fmt: skip
