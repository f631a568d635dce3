"""The largest force of the first pulse on a wall, at which a run may continue to a larger force."""

from __future__ import annotations

import math

import numpy as np

from ..chain.chain import Chain
from ..recorded_warnings import ignore_warnings
from ..simulation.sensor_force import MANY_TIMES, find_maxima
from ..simulation.simulate import simulate

# Saved times around a maximum through which a spline is drawn.
AROUND = 4


def first_on_wall(
    chain: Chain, peak: float, peak_time: float, until: float | None
) -> tuple[float, float]:
    """Largest force of the first pulse on the right wall, and its time; NaN if there is none yet.

    It is the first maximum by the rule of sensors in beads.  The run ends after its peak; if the
    first maximum is next to the peak, this is more exact.
    """
    after = until if math.isnan(peak_time) else 1.3 * peak_time
    with ignore_warnings():
        run = simulate(chain, until=after, times=MANY_TIMES)
        times, force = run.times, run.wall_force().force
    found = find_maxima(0, times, force, float(force[0]))
    if math.isnan(found.first_maximum):
        return peak, peak_time
    i = int(np.argmin(np.abs(times - found.first_maximum_time)))
    near = times[max(i - 1, 0)] <= peak_time <= times[min(i + 1, len(times) - 1)]
    if near or not AROUND <= i < len(times) - AROUND:
        return (peak, peak_time) if near else (found.first_maximum, found.first_maximum_time)
    return _top_of_spline(times[i - AROUND : i + AROUND + 1], force[i - AROUND : i + AROUND + 1])


def _top_of_spline(times: np.ndarray, force: np.ndarray) -> tuple[float, float]:
    """Largest value of a cubic spline next to its middle, and its time."""
    from scipy.interpolate import CubicSpline

    curve = CubicSpline(times, force)
    places = curve.derivative().roots(extrapolate=False)
    inside = places[(places >= times[AROUND - 1]) & (places <= times[AROUND + 1])]
    places = np.append(inside, times[AROUND])
    top = int(np.argmax(curve(places)))
    return float(curve(places[top])), float(places[top])
