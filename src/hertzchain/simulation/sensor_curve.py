"""The force in a sensor between saved times, and its maxima."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import numpy as np

from ..chain.contact_groups import loading_forces
from ..collision import Array
from .budget import overlaps_of
from .end_forces import force_on_end, is_driven, static_forces_around
from .largest_overlaps import largest_between
from .trajectory import Trajectory

# Saved times before and after a maximum that determine the force there, and points in between.
NEIGHBOURS: Final = 4
POINTS: Final = 64
REFINEMENTS: Final = 4
# Saved forces and those of the elastic law agree within this fraction of the largest force.
AGREEMENT: Final = 1e-6
# Points at which the force is interpolated between two saved times.
BETWEEN: Final = 8
# The force at a saved time is interpolated between its neighbours.  If the error is less than the
# first fraction of the largest force, intervals of half this length resolve the force, and their
# error is at least the second number of times smaller (64 times for short intervals).
RESOLVED: Final = 0.1
SMALLER: Final = 16.0
# Changes of a force next to a jump, over the jump: before it, and of the slope after it.
JUMP: Final = 0.5
STRAIGHT: Final = 0.05
# Largest overlaps are seen if the saved times show at least this fraction of them.
SEEN: Final = 0.98

Curve = Callable[[Array], Array]


def maximum_near(run: Trajectory, bead: int, force: Array, i: int) -> tuple[float, float, float]:
    """Height and time of the maximum next to saved time i, and a bound of the error of its height.

    The bound is twice the change of the height if only every second saved time is used; for a
    smooth force this is many times the error.  A force with losses may have a corner, where a
    spline overshoots; the bound is then at least the height of the spline above the saved force.
    """
    if not 0 < i < len(force) - 1:
        return float(force[i]), float(run.times[i]), _rise_to_the_end(run, force) if i else 0.0
    around = np.arange(max(i - NEIGHBOURS, 0), min(i + NEIGHBOURS + 1, len(force)))
    height, time, elastic = _top(run, bead, force, around, i)
    if not elastic and (bound := _bound_at_jump(run.times, force, i)) is not None:
        return float(force[i]), float(run.times[i]), bound
    coarse, *_ = _top(run, bead, force, around[(around - i) % 2 == 1], i)
    corner = 0.0 if elastic else max(abs(height - float(force[i])), _beginning(run, bead, force, i))
    return height, time, max(2.0 * abs(height - coarse), corner)


def _beginning(run: Trajectory, bead: int, force: Array, i: int) -> float:
    """Largest change of the force next to saved time i if a contact begins or ends near it."""
    used = slice(max(i - NEIGHBOURS, 0), i + NEIGHBOURS + 1)
    acts = run.forces[used, bead - 1 : bead + 1] != 0.0
    if not (acts.any(axis=0) & ~acts.all(axis=0)).any():
        return 0.0
    return float(np.abs(np.diff(force[max(i - 2, 0) : i + 3])).max())


def _rise_to_the_end(run: Trajectory, force: Array) -> float:
    """Bound of the rise of the force from the last saved time to the end of the run."""
    steps = run.end_time - run.times[-1], run.times[-1] - run.times[-2]
    return 2.0 * abs(float(force[-1] - force[-2])) * float(max(steps[0], 0.0) / steps[1])


def _bound_at_jump(times: Array, force: Array, i: int) -> float | None:
    """Bound of the error of the force at a jump next to saved time i; `None` without a jump.

    A contact with a `Dashpot` begins with a force that is often the largest.  A spline would
    overshoot there, by a tenth of the jump at any spacing of the times.  The force jumps if it
    changes much less in both intervals on the other side, and in the one before the jump.
    """
    bounds = []
    for step in (1, -1):
        # The jump is between i - step and i.
        places = i + step * np.arange(-2, 3)
        if places.min() < 0 or places.max() >= len(force):
            continue
        (before, jump, first, second), steps = np.diff(force[places]), np.diff(times[places])
        bend = abs(second / steps[3] - first / steps[2]) * abs(steps[2])
        if jump > 0.0 and before < JUMP * jump and bend < STRAIGHT * jump:
            bounds.append(2.0 * (abs(first) + bend) * float(steps[1] / steps[2]))
    return min(bounds, default=None)


def crossings_around(
    run: Trajectory, bead: int, force: Array, top: float, level: float
) -> tuple[float, float]:
    """Times before and after that of the maximum at which the force crosses a level.

    NaN for a force that is above the level from the first or to the last saved time.
    """
    from scipy.optimize import brentq

    curve, _ = _curve(run, bead, force, np.arange(len(force)))
    below = np.flatnonzero(force < level)
    times = run.times
    before, after = (below[times[below] < top], below[times[below] > top])
    if not (len(before) and len(after)):
        return math.nan, math.nan
    i, j = int(before[-1]), int(after[0])
    # The maximum is between the saved times i and j.
    inside = (times[i], min(times[i + 1], top)), (max(times[j - 1], top), times[j])
    start, end = (brentq(lambda t: float(curve(np.asarray(t))) - level, *each) for each in inside)
    return float(start), float(end)


def place_and_bound_of_largest(run: Trajectory, bead: int, force: Array) -> tuple[int, float]:
    """Number of the saved time next to the largest force, and an upper bound of this force.

    The force is interpolated between all saved times if the contacts are elastic.  Contacts whose
    overlaps were larger than the saved times show may have had larger forces in between.
    """
    place, bound = int(np.argmax(force)), float(force.max())
    curve, elastic = _curve(run, bead, force, np.arange(len(force)))
    limit, unseen = _limit(run, bead)
    if elastic and len(force) > 2 * NEIGHBOURS:
        within = np.linspace(0.0, 1.0, BETWEEN + 2)
        tops = curve(run.times[:-1, np.newaxis] + np.outer(np.diff(run.times), within)).max(axis=1)
        errors = _errors_between_neighbours(run, bead, force)
        errors = np.maximum(errors[:-1], errors[1:])
        clear = errors < RESOLVED * bound
        bound = min(float(np.max(tops + np.where(clear, errors / SMALLER, errors))), limit)
        first = int(np.argmax(np.where(clear, tops, -np.inf)))
        if clear.any() and tops[first] > force[place]:
            place = first + int(force[first + 1] > force[first])
    return place, limit if unseen else bound


def _limit(run: Trajectory, bead: int) -> tuple[float, bool]:
    """Force on a sensor with the largest overlaps of both contacts, and whether one is unseen.

    The largest overlaps are located within the steps of the whole run.
    """
    chain, sides = run.chain, slice(bead - 1, bead + 1)
    largest = run.largest_overlaps
    overlaps = overlaps_of(chain, run.times, run.positions)
    seen = largest_between(run.times, overlaps, run.velocities)
    unseen = _saved_throughout(run) and bool(np.any(seen[sides] < SEEN * largest[sides]))
    outside = sum(
        float(force_on_end(chain, contact, run.times).max()) for contact in (bead - 1, bead)
    )
    outside += static_forces_around(chain, bead)
    inside = float(loading_forces(chain.contact_groups, largest)[sides].sum())
    return 0.5 * (inside + outside), unseen


def _saved_throughout(run: Trajectory) -> bool:
    """Whether times were saved from the start to the end; without ``until`` that is between two."""
    times = run.times
    if len(times) < 2:
        return False
    return bool(times[0] == 0.0 and run.end_time - times[-1] <= times[-1] - times[-2])


def _errors_between_neighbours(run: Trajectory, bead: int, force: Array) -> Array:
    """Error at each saved time of the elastic force that is interpolated between its neighbours."""
    errors, every = np.zeros(len(force)), np.arange(len(force))
    for first in (0, 1):
        inside = every[1 + first : len(force) - 1 : 2]
        curve, _ = _curve(run, bead, force, every[first::2])
        errors[inside] = np.abs(curve(run.times[inside]) - force[inside])
    return errors


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
        rest = static_forces_around(run.chain, bead)
        return lambda t: 0.5 * (rest + sum(side(t) for side in sides)), True  # type: ignore[misc]
    if len(used) < 4:
        return lambda t: np.interp(t, run.times[used], force[used]), False
    return CubicSpline(run.times[used], force[used]), False


def _elastic_force(run: Trajectory, contact: int, used: Array) -> Curve | None:
    """Force of an elastic contact, from a polynomial of degree 5 for its overlap in each interval.

    The polynomial has the saved overlap, its rate and its acceleration at both ends.  `None` if the
    saved forces do not agree with the law of elastic contacts.
    """
    chain, times = run.chain, run.times[used]
    stiffness = float(chain.contact_stiffness[contact])
    if stiffness == 0.0:
        saved = run.forces[used, contact]
        if saved.any() or is_driven(chain, contact):
            return None
        return lambda t: force_on_end(chain, contact, t)
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
    quintic = _quintic(times, overlap, *rates)
    return lambda t: law(quintic(t))


def _quintic(times: Array, values: Array, rates: Array, curvatures: Array) -> Curve:
    """Polynomial of degree 5 in each interval, from values and two derivatives at both ends.

    `scipy.interpolate.BPoly.from_derivatives` is the same, but takes a loop over the intervals.
    """
    from scipy.interpolate import PPoly

    h = np.diff(times)
    slope, bend = h * rates[:-1], 0.5 * h**2 * curvatures[:-1]
    rest = np.diff(values) - slope - bend
    turn = h * rates[1:] - slope - 2.0 * bend
    bent = 0.5 * h**2 * curvatures[1:] - bend
    high = (
        6.0 * rest - 3.0 * turn + bent,
        -15.0 * rest + 7.0 * turn - 2.0 * bent,
        10.0 * rest - 4.0 * turn + bent,
    )
    rows = (*high, bend, slope, values[:-1])
    return PPoly(np.array([row / h ** (5 - i) for i, row in enumerate(rows)]), times)
