"""The force in a sensor: the first maximum, which belongs to the pulse, and the largest so far."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from hertzchain.contacts import Array

# The first maximum is above this part of the largest force, and the force falls by that part of
# the maximum before it rises again; both are counted from the force at rest.
MIN_HEIGHT, FALL = 0.01, 0.1


@dataclass(frozen=True, eq=False)
class SensorForce:
    """The force in a sensor embedded in a bead, :math:`(F_{k-1} + F_k)/2`.

    Attributes
    ----------
    bead : int
        Number k of the bead.
    times, force : ndarray, shape (T,)
        Force at the saved times [scaled, or s and N].
    first_maximum, first_maximum_time : float
        The first maximum at the saved times and its time: above 1% of the largest force, and
        followed by a fall of at least 10%, both counted from the force at rest.  NaN if there is
        none yet.
    largest_so_far, largest_so_far_time : float
        Largest force at the saved times and its time.  Waves that follow the first one, or return
        from a wall, may exceed it later.
    """

    bead: int
    times: Array = field(repr=False)
    force: Array = field(repr=False)
    first_maximum: float
    first_maximum_time: float
    largest_so_far: float
    largest_so_far_time: float


def sensor_force_of(bead: int, times: Array, force: Array, at_rest: float) -> SensorForce:
    """The maxima of a sensor's trace.

    Parameters
    ----------
    bead : int
        Number of the bead.
    times, force : ndarray, shape (T,)
        At least one saved time.
    at_rest : float
        Force at rest.

    Returns
    -------
    SensorForce

    Examples
    --------
    >>> found = sensor_force_of(3, np.arange(5.0), np.array([0.0, 2.0, 1.0, 3.0, 3.5]), 0.0)
    >>> found.first_maximum, found.largest_so_far
    (2.0, 3.5)
    """
    excess = force - at_rest
    top = np.maximum.accumulate(excess)
    fallen = (top > MIN_HEIGHT * top[-1]) & (excess < (1.0 - FALL) * top)
    first = first_time = math.nan
    if fallen.any():
        i = int(np.argmax(excess[: int(np.argmax(fallen))]))
        first, first_time = float(force[i]), float(times[i])
    j = int(np.argmax(force))
    return SensorForce(bead, times, force, first, first_time, float(force[j]), float(times[j]))
