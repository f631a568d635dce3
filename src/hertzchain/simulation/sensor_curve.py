"""The force in a sensor between saved times, and its maxima."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from ..collision import Array
from .budget import overlaps_of
from .trajectory import Trajectory

# Saved times before and after a maximum that determine the force there, and points in between.
NEIGHBOURS: Final = 4
POINTS: Final = 64
REFINEMENTS: Final = 4
# Saved forces and those of the elastic law agree within this fraction of the largest force.
AGREEMENT: Final = 1e-6

Curve = Callable[[Array], Array]


def maximum_near(run: Trajectory, bead: int, force: Array, i: int) -> tuple[float, float, float]:
    """Height and time of the maximum next to saved time i, and a bound of the error of its height.

    The bound is twice the change of the height if only every second saved time is used; for a
    smooth force this is many times the error.  A force with losses may have a corner, where a
    spline overshoots; the bound is then at least the height of the spline above the saved force.
    """
    if not 0 < i < len(force) - 1:
        return float(force[i]), float(run.times[i]), 0.0
    around = np.arange(max(i - NEIGHBOURS, 0), min(i + NEIGHBOURS + 1, len(force)))
    height, time, elastic = _top(run, bead, force, around, i)
    coarse, *_ = _top(run, bead, force, around[(around - i) % 2 == 1], i)
    corner = 0.0 if elastic else abs(height - float(force[i]))
    return height, time, max(2.0 * abs(height - coarse), corner)


def _top(
    run: Trajectory, bead: int, force: Array, used: Array, i: int
) -> tuple[float, float, bool]:
    """Maximum of the force between the neighbours of saved time i, and whether it is elastic."""
    curve, elastic = _curve(run, bead, force, used)
    low, high = run.times[i - 1], run.times[i + 1]
    for _ in range(REFINEMENTS):
        points = np.linspace(low, high, POINTS)
        values = curve(points)
        j = int(np.argmax(values))
        low, high = points[max(j - 1, 0)], points[min(j + 1, POINTS - 1)]
    return float(values[j]), float(points[j]), elastic


def _curve(run: Trajectory, bead: int, force: Array, used: Array) -> tuple[Curve, bool]:
    """Force as a function of time, and whether it follows from the law of elastic contacts.

    Otherwise, it is a spline through the saved forces.
    """
    from scipy.interpolate import CubicSpline

    sides = [_elastic_force(run, contact, used) for contact in (bead - 1, bead)]
    if all(side is not None for side in sides):
        return lambda t: 0.5 * sum(side(t) for side in sides), True  # type: ignore[misc]
    if len(used) < 4:
        return lambda t: np.interp(t, run.times[used], force[used]), False
    return CubicSpline(run.times[used], force[used]), False


def _elastic_force(run: Trajectory, contact: int, used: Array) -> Curve | None:
    """Force of an elastic contact, from a polynomial of degree 5 for its overlap in each interval.

    The polynomial has the saved overlap, its rate and its acceleration at both ends.  `None` if the
    saved forces do not agree with the law of elastic contacts.
    """
    from scipy.interpolate import BPoly

    chain, times = run.chain, run.times[used]
    stiffness = float(chain.contact_stiffness[contact])
    if stiffness == 0.0:
        saved = run.forces[used, contact]
        return None if saved.any() else np.zeros_like
    net = run.forces[used, :-1] - run.forces[used, 1:] + chain.static_state.body_forces
    moved = np.zeros((3, len(used), chain.beads + 2))
    moved[1, :, 1:-1], moved[2, :, 1:-1] = run.velocities[used], net / chain.masses
    overlap = overlaps_of(chain, times, run.positions[used])[:, contact]
    rates = moved[1:, :, contact] - moved[1:, :, contact + 1]
    exponent = float(chain.contact_exponents[contact])

    def law(d: Array) -> Array:
        return np.asarray(stiffness * np.maximum(d, 0.0) ** exponent)

    saved = run.forces[used, contact]
    driven = chain.drive is not None and contact < 2
    if driven or not np.allclose(law(overlap), saved, rtol=0.0, atol=AGREEMENT * saved.max()):
        return None
    quintic = BPoly.from_derivatives(times, np.stack((overlap, *rates), axis=1))
    return lambda t: law(quintic(t))
