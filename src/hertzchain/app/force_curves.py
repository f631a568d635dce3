"""Forces in sensors and on walls at times that resolve their contacts, and their peaks."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np

from ..chain.bead_names import Side, bead_label
from ..chain.chain import Chain
from ..chain.drives import Drive
from ..collision import Array, compression_time
from ..errors import SimulationError
from ..notebook.drawing import engineering
from ..recorded_warnings import record_warnings
from ..simulation.body_force import force_on_body
from ..simulation.end_forces import has_free_face
from ..simulation.run import Run
from ..simulation.sensor_force import FREE_FACE, SHOWN
from ..simulation.simulate import simulate
from ..simulation.time_scales import UNBALANCED
from .body_curve import BODY, body_peaks, duration_shown
from .yield_notes import known_peak, peaks_if_yielding

# Intervals in the shortest contact, and the smallest number that needs no warning.  A light bead
# between two others oscillates faster than a collision of two beads suggests.
PER_CONTACT: Final = 16
ENOUGH: Final = 10
# Largest number of intervals, and of states of single beads in all of them.
MAX_INTERVALS: Final = 4000
MAX_STATES: Final = 2_400_000
# No force has acted if velocities have changed by less than this fraction of the largest one.
UNCHANGED: Final = 1e-6
# A collision changes a velocity by at least this fraction of the largest one.
COLLISION: Final = 0.01
# Times among which the largest force of a drive is found.
TIMES_OF_DRIVE: Final = 20_001
# Saved times in each of the two intervals next to the maximum of the force in a sensor.
NEAR_MAXIMA: Final = 65

Places = Sequence[int]


def run_for_forces(
    run: Run, places: Places, rtol: float, progress: Callable[..., None]
) -> tuple[Run, str]:
    """The same run with times that resolve contacts, and a sentence if they do not.

    ``places`` are beads with a sensor, 0 for the left wall and N + 1 for the right end.
    """
    if not places or not run.success:
        return run, ""
    if run.chain._free_cap:
        # The force on this body is twice that in a sensor in it.
        places = [min(k, run.chain.beads) for k in places]
    needed = _needed_intervals(run, places)
    most = min(MAX_INTERVALS, MAX_STATES // run.chain.beads)
    share = max(1.0, float(needed.sum()) / most)
    options: dict[str, Any] = {"rtol": rtol, "check": False, "progress": progress}
    fine = run
    try:
        with record_warnings():
            times = _divided(run.times, needed / share)
            fine = simulate(run.chain, times=times, **options)
            fine = _near_maxima(fine, [k for k in places if 1 <= k <= run.chain.beads], options)
    except SimulationError:  # A repetition would take too long.
        share = share if fine is not run else float(needed.max())
    return fine, _coarse(fine, PER_CONTACT / share)


def coarse_frames(run: Run) -> str:
    """Sentence about collisions between the saved times, which the animation does not show."""
    needed = _needed_intervals(run, range(1, run.chain.beads + 1), COLLISION)
    missed = needed > PER_CONTACT
    if not run.success or not missed.any():
        return ""
    longest = float(np.diff(run.times)[missed].max())
    shortest = float(contact_durations(run.chain, run.largest_overlaps).min())
    apart, lasts = (engineering(each, "s", run.chain.units) for each in (longest, shortest))
    return (
        f"The animation, the map and the budget show times up to {apart} apart, but the shortest "
        f"collisions last {lasts}: they do not show all collisions."
    )


def _needed_intervals(run: Run, places: Places, least: float = UNCHANGED) -> Array:
    """Number of intervals into which each interval of saved times must be divided.

    Intervals in which no velocity changes by ``least`` of the largest one are not divided.
    """
    durations = contact_durations(run.chain, run.largest_overlaps)
    widths, needed = np.diff(run.times), np.ones(len(run.times) - 1)
    fastest = np.abs(run.velocities).max(initial=0.0)
    changed = np.abs(np.diff(run.velocities, axis=0)) > least * fastest
    for k in places:
        shortest = durations[max(k - 1, 0) : k + 1].min()
        moved = changed[:, max(k - 2, 0) : k + 1].any(axis=1)
        needed = np.maximum(needed, np.where(moved, PER_CONTACT * widths / shortest, 1.0))
    return needed


def contact_durations(chain: Chain, overlaps: Array) -> Array:
    """Durations of head-on collisions of two beads with these largest overlaps, shape (N + 1,).

    Walls have an infinite mass; the duration is infinite without contact.
    """
    inverse = np.concatenate(([0.0], 1.0 / chain.masses, [0.0]))
    reduced, found = 1.0 / (inverse[:-1] + inverse[1:]), np.full(chain.beads + 1, np.inf)
    touched = (overlaps > 0.0) & (chain.contact_stiffness > 0.0)
    d, m, k, p = (
        each[touched]
        for each in (overlaps, reduced, chain.contact_stiffness, chain.contact_exponents)
    )
    # The energy stored in the contact is the kinetic energy of the collision.
    speed = np.sqrt(2.0 * k * d ** (p + 1.0) / ((p + 1.0) * m))
    found[touched] = 2.0 * compression_time(m, k, speed, p)
    return found


def _divided(times: Array, parts: Array) -> Array:
    """Times with each interval divided into at least so many equal parts."""
    counts = np.maximum(np.ceil(parts), 1.0).astype(int)
    pieces = zip(times[:-1], times[1:], counts, strict=True)
    return np.concatenate(
        [np.linspace(begin, end, n, endpoint=False) for begin, end, n in pieces] + [times[-1:]]
    )


def _near_maxima(run: Run, sensors: Places, options: dict[str, Any]) -> Run:
    """The same run with many saved times near maxima that are not known accurately."""
    found = [run.sensor_force(bead) for bead in sensors]
    near = np.array([
        (each.first_maximum_time, each.largest_so_far_time)
        for each in found
        if each.error > SHOWN * each.largest_so_far
    ])  # fmt: skip
    if not near.size:
        return run
    after = np.searchsorted(run.times, near[np.isfinite(near)])
    # Equal intervals are divided once: no two times may differ by rounding only.
    parts = np.ones(len(run.times) - 1)
    parts[np.clip((after - 1, after), 0, len(parts) - 1)] = NEAR_MAXIMA - 1
    return simulate(run.chain, times=_divided(run.times, parts), **options)


def _coarse(run: Run, resolution: float) -> str:
    """Sentence about forces between the times at which they are drawn."""
    if resolution >= ENOUGH:
        return ""
    return (
        f"forces in sensors and on walls are drawn at {len(run.times)} times, about "
        f"{resolution:.2g} in the shortest contact; forces in between are not shown, and the "
        "largest force in a sensor may be higher"
    )


def beads_of(chain: Chain, balls: Places) -> list[int]:
    """Beads with a sensor, from numbers that do not count the strikers; others are omitted."""
    return [k for k in (ball + chain.strikers for ball in balls) if 1 <= k <= chain.beads]


def places_of(chain: Chain, balls: Places) -> dict[str, int]:
    """Beads with a sensor, walls and a free body behind the row by the names of their curves."""
    found = {str(bead): bead for bead in beads_of(chain, balls)}
    sides = (("left", 0), ("right", chain.beads + 1))
    if chain._free_cap:
        found[BODY] = chain.beads + 1
    return found | {side: k for side, k in sides if f"{side} wall" in chain.features}


def force_at(run: Run, place: int) -> Array:
    """Force in a sensor in a bead, on a wall, or on a free body, at the saved times."""
    if 1 <= place <= run.chain.beads:
        return run.sensor(place)
    if place > 0 and run.chain._free_cap:
        return force_on_body(run)
    return run.forces[:, 0 if place == 0 else -1]


def _largest_in_words(chain: Chain, draft: bool) -> str:
    """Name of the largest force of a run; that of a draft is not final."""
    static = {"precompression", "gravity"}.intersection(chain.features)
    words = "largest so far" if draft else "largest in this run"
    return f"{words} (with the static force)" if static else words


def _time_of_change(time: float, largest: float, smallest: float) -> float | None:
    """Time of the largest force, unless the force is constant except for rounding errors."""
    return time if largest - smallest > UNBALANCED * largest else None


def peaks_at(
    forces: Run, whole: Run, place: int, progress: Callable[..., None] | None
) -> dict[str, Any]:
    """Peaks of a curve; ``whole`` is long enough for the peak on the wall or the cap."""
    if 1 <= place <= forces.chain.beads:
        label, ball = bead_label(forces.chain, place), place - forces.chain.strikers
        # In a comparison with a chain that has other strikers, the ball has one name.
        names = {
            "label": f"sensor in {label}",
            "ball": f"sensor in {f'ball {ball}' if ball > 0 else label}",
        }
        found = _sensor_peaks(forces, place, progress is None)
        if has_free_face(forces.chain, place):
            found["remark"] = FREE_FACE
        return {**names, **found}
    if place > 0 and forces.chain._free_cap:
        return body_peaks(whole, progress)
    side: Side = "left" if place == 0 else "right"
    found = _wall_peaks(whole, side, progress, float(force_at(forces, place).min()))
    return {"name": f"wall-{side}", "label": f"{side} wall", **found}


def drive_in_words(drive: Drive, end: float) -> dict[str, Any]:
    """Name and largest force of a drive until the end of a run."""
    kinks = np.array([each for each in drive.kinks if 0.0 <= each <= end])
    times = np.union1d(np.linspace(0.0, end, TIMES_OF_DRIVE), kinks)
    values = drive.value(times)
    k = int(np.argmax(np.abs(values)))
    # A constant force has no time.
    time = None if np.ptp(values) == 0.0 else float(times[k])
    shown = [["largest", float(values[k]), time]]
    return {"name": "drive", "label": "drive, force on bead 1", "shown": shown}


def _sensor_peaks(run: Run, bead: int, draft: bool) -> dict[str, Any]:
    """The first maximum of the force in a sensor, and the largest force."""
    force = run.sensor_force(bead)
    first, time = force.first_maximum, force.first_maximum_time
    largest, smallest = force.largest_so_far, float(force_at(run, bead).min())
    largest_time = _time_of_change(force.largest_so_far_time, largest, smallest)
    shown = [] if largest_time is None or math.isnan(first) else [["first maximum", first, time]]
    return {
        "first": first, "time": time, "largest": largest, "largest_time": largest_time,
        "shown": [*shown, [_largest_in_words(run.chain, draft), largest, largest_time]],
    }  # fmt: skip


def _wall_peaks(
    run: Run, side: Side, progress: Callable[..., None] | None, smallest: float
) -> dict[str, Any]:
    """The peak on a wall or the largest force; with ``progress``, also that if contacts yield.

    ``smallest`` is the smallest force that is shown.
    """
    # This property does not issue the warning of `wall_force`.
    wall = run._wall_force(side)
    # A peak that a later impact may exceed is shown as the largest force of the run.
    complete = not math.isnan(wall.peak)
    known = wall.proven and complete
    first, time = wall.peak if known else None, wall.peak_time
    largest = wall.largest_so_far
    largest_time = _time_of_change(wall.largest_so_far_time, largest, smallest)
    words = _largest_in_words(run.chain, progress is None)
    shown = [[words, largest, largest_time] if first is None else ["peak", first, time]]
    yielding = None
    if side == "right" and complete and progress is not None:
        shown += (with_yield := peaks_if_yielding(run, progress))
        yielding = known_peak(run, with_yield, first)
    above = " above the static force" if wall.static_force else ""
    lasts = f"duration (impulse / peak{', both' + above if above else ''})"
    impact = [
        ("impulse of the impact" + above, wall.excess_impulse, "N s"),
        (lasts, *duration_shown(run.chain, wall.duration)),
    ]
    # In a draft, the impact need not have ended, but the text on the page keeps its length.
    if progress is not None and not (known and wall.complete_since is not None):
        impact = []
    return {
        "first": first, "time": time, "largest": largest, "largest_time": largest_time,
        "yielding": yielding, "shown": shown, "impact": impact,
    }  # fmt: skip
