"""A table with one row per chain of several that were simulated."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, Literal, NamedTuple, TypeVar

from ..representation import listed, measure
from ..simulation.yielding import not_a_prediction
from .compared_sensors import title_of_sensors, with_sensors
from .compared_yield import (
    all_known,
    at_pressures,
    compared,
    comparison_notes,
    has_law_of_yield,
    limited_pressure_notes,
    possible_factors,
    predicted,
)
from .last_bead import last_bead_of, shown_acceleration
from .marked_entries import (
    FIRST,
    LARGEST,
    NONE,
    UNPREDICTED,
    dash_notes,
    mark,
    mark_unpredicted,
    shown_columns,
    sign_notes,
)

if TYPE_CHECKING:
    from rich.table import Table

    from ..chain.bead_names import Side
    from ..simulation.run import Run

    # A wall, the body behind each row, or the first sensor.
    Place = Side | Literal["body", "sensor"]
    from .compared_yield import AtPressures, Yielding
    from .repeated_impacts import Impacts

T = TypeVar("T")
OF_WALLS: Final = ("peak", "time", "impulse", "duration")
# Headings on two lines, so that the table fits on a page.
HEADINGS: Final = MappingProxyType({
    "overlap/radius": "overlap\n/radius", "pressure/yield": "pressure\n/yield",
    "deepest dent": "deepest\ndent", "velocity of last bead": "velocity of\nlast bead",
    "momentum of last bead": "momentum of\nlast bead", "force on the cap": "force on\nthe cap",
})  # fmt: skip


class Peaks(NamedTuple):
    """Peaks of all chains at one place, and those with contacts that yield."""

    place: Place
    own: dict[str, float]
    at: dict[str, AtPressures]
    unpredicted: list[str]

    @property
    def where(self) -> str:
        """The place in words."""
        words = {"body": "the last body", "sensor": "the first sensor"}
        return words.get(self.place, f"the {self.place} wall")


def peaks_of(
    runs: Mapping[str, Run],
    others: Mapping[str, Run | None],
    yielding: Mapping[str, Yielding],
    beads: Mapping[str, Sequence[int]],
) -> Peaks | None:
    """Peaks at the first place that all chains have; none if there is none.

    Peaks that are not known are infinite.
    """
    one_unit = len({run.chain.units for run in runs.values()}) == 1
    if not one_unit or (place := _common_place(runs, beads)) is None:
        return None
    own = {name: _peak(run, beads[name], place) for name, run in runs.items()}
    unpredicted = [name for name, run in runs.items() if not_a_prediction(run)]
    at = {
        name: at_pressures(
            run, own[name], _peak(others[name], beads[name], place), yielding[name],
            (name in unpredicted, (other := others[name]) is not None and not_a_prediction(other)),
            at_right_end=place in ("right", "body"),
        )
        for name, run in runs.items()
    }  # fmt: skip
    return Peaks(place, own, at, unpredicted)


def compared_runs(
    runs: Mapping[str, Run],
    others: Mapping[str, Run | None],
    yielding: Mapping[str, Yielding],
    beads: Mapping[str, Sequence[int]],
    impacts: Impacts,
    peaks: Peaks | None,
) -> tuple[Table, list[str]] | None:
    """Table of the forces at one place of all chains, the smallest one marked, and notes on it.

    The place is the right wall, the body behind each row, the left wall or else the first sensor.
    If the chains have none of them in common, forces on right walls are not marked, and free ends
    have the motion of their last beads.  There is no table of one chain, or of chains in different
    units.  The ``others`` have the largest possible yield pressure; ``yielding`` are the peaks of
    elastic runs if their contacts yield, and ``peaks`` those at the place in common.  Of several
    ``impacts``, each has its own marks.  Forces beyond the range of the law are not compared.
    """
    if len(runs) == 1 or len({run.chain.units for run in runs.values()}) > 1:
        return None
    if peaks is None:
        return _of_different_ends(runs, others, yielding, beads, impacts)
    place, own, at, unpredicted = peaks
    first = place == "sensor"
    rows = {
        name: _speed_after_fall(run, impacts)
        | _of_place(run, beads[name], place)
        | _of_contacts(run)
        for name, run in runs.items()
    }
    lawful = [name for name, run in runs.items() if has_law_of_yield(run)]
    elastic = any(each.elastic for each in at.values())
    groups = {label: [*names.values()] for label, names in impacts.names.items()} or {"": [*runs]}
    # Chains are compared at the same speed or height only.
    several = {label: names for label, names in groups.items() if len(names) > 1}
    # Peaks of elastic contacts beyond yield and of contacts that yield are not compared.
    if not (elastic and lawful):
        for names in several.values():
            sound = {name: runs[name] for name in names if name not in unpredicted}
            _mark_peaks(rows, sound, own, place)
    mark_unpredicted(rows, unpredicted, ("peak", "acceleration"))
    if elastic or any(others.values()):
        # If all contacts have a law, the own peaks are those at the smallest pressure.
        for i in (0, 1) if elastic else (1,):
            _add_peaks(rows, i, at, runs, several)
    marks = "; * marks the smallest" * bool(several)
    marks += f" of each {impacts.kind}" * bool(impacts and several)
    force = f"force {'in' if first else 'on'} {peaks.where}"
    force += title_of_sensors(beads, impacts, first_is_peak=first)
    notes = [
        f"at {label}: {note}" if label else note
        for label, names in several.items()
        for note in comparison_notes(
            _part(own, names), _part(at, names), [name for name in lawful if name in names],
            unpredicted,
        )
    ]  # fmt: skip
    rows = with_sensors(rows, runs, beads, impacts, first_is_peak=first)
    signs = [*sign_notes(rows), *dash_notes(rows, at, impacts)]
    table = _table(rows, f"{_counted(rows, impacts)}: {force}{marks}", impacts)
    notes += limited_pressure_notes(rows, runs)
    return table, [*_notes_on_place(runs, beads, place), *signs, *notes]


def _part(values: Mapping[str, T], names: Sequence[str]) -> dict[str, T]:
    return {name: values[name] for name in names}


def _counted(rows: Mapping[str, object], impacts: Impacts) -> str:
    """Numbers of chains and, if there are several, of speeds or heights."""
    if not impacts:
        return f"{len(rows)} chains"
    chains = len(next(iter(impacts.names.values())))
    return f"{chains} chain{'s' * (chains > 1)} at {len(impacts.names)} {impacts.kind}s"


def _mark_peaks(
    rows: dict[str, dict[str, str]], runs: Mapping[str, Run], own: Mapping[str, float], place: Place
) -> None:
    """Mark the smallest peak of some chains and, on bodies, the smallest acceleration."""
    mark(rows, "peak", compared(_part(own, [*runs])))
    if place == "body":
        # The least force on a heavy body is not the least acceleration of a light one.
        masses = {name: float(run.chain.masses[-1]) for name, run in runs.items()}
        found = compared({name: own[name] / masses[name] for name in runs})
        mark(rows, "acceleration", found)


def _notes_on_place(
    runs: Mapping[str, Run], beads: Mapping[str, Sequence[int]], place: Place
) -> list[str]:
    """The definition of an acceleration, or the chains whose sensors have a free face."""
    from ..simulation.body_force import ABOVE
    from ..simulation.end_forces import has_free_face
    from ..simulation.sensor_force import FREE_FACE
    from ..units import STANDARD_GRAVITY

    if place == "body":
        si = next(iter(runs.values())).chain.units == "SI"
        unit = f"; g0 = {STANDARD_GRAVITY:g} m/s^2" if si else ""
        return [
            "peak: force of the last contact; acceleration: peak / mass of the last body, "
            f"unfiltered; duration: time around the peak above {ABOVE:.0%} of it{unit}"
        ]
    if place in ("left", "right"):
        return _peaks_so_far(runs, place)
    half = [name for name, run in runs.items() if has_free_face(run.chain, beads[name][0])]
    return [f"sensor of {listed(half)}: {FREE_FACE}"] if half else []


def _peaks_so_far(runs: Mapping[str, Run], side: Side) -> list[str]:
    """That complete peaks of some runs on a wall may be exceeded by later impacts."""
    from ..simulation.wall_bound import LATER_IMPACTS

    found = {name: run._wall_force(side) for name, run in runs.items()}
    so_far = [name for name, wall in found.items() if wall.complete and not wall.proven]
    if not so_far:
        return []
    which = f" of {listed(so_far)}" if len(so_far) < len(runs) else ""
    return [f"peak{which}: so far; {LATER_IMPACTS}"]


def _of_different_ends(
    runs: Mapping[str, Run], others: Mapping[str, Run | None], yielding: Mapping[str, Yielding],
    beads: Mapping[str, Sequence[int]], impacts: Impacts,
) -> tuple[Table, list[str]] | None:  # fmt: skip
    """Table of the forces on right walls and of the last beads of free ends; nothing is marked."""
    ends: dict[str, Place] = {
        name: "right" if run.chain.right_wall is not None else "body" for name, run in runs.items()
    }
    last = {name: {} if ends[name] == "right" else _of_last_bead(run) for name, run in runs.items()}
    walled = "right" in ends.values()
    of_sensors = bool(impacts) and any(beads.values())
    if not walled and not any(last.values()) and not of_sensors:
        return None
    # Columns of walls come first; those without any entry are omitted.
    rows = {
        name: _speed_after_fall(run, impacts)
        | dict.fromkeys(OF_WALLS, NONE)
        | (_of_wall(run, "right") if ends[name] == "right" else last[name])
        | _of_contacts(run)
        for name, run in runs.items()
    }
    unpredicted = [name for name, run in runs.items() if not_a_prediction(run)]
    mark_unpredicted(rows, unpredicted, ("peak", "force on the cap", "acceleration"))
    at = {
        name: _at_end(run, others[name], yielding[name], ends[name])
        for name, run in runs.items()
        if ends[name] == "right" or run.chain._free_cap
    }
    elastic = any(each.elastic for each in at.values())
    if elastic or any(others.values()):
        for i in (0, 1) if elastic else (1,):
            _add_peaks(rows, i, at, runs, {})
    places = ["force on the right wall"] * walled
    places += ["last bead of free ends in the leading pulse"] * any(last.values())
    places += ["force in sensors"] * of_sensors
    rows = with_sensors(rows, runs, beads, impacts, first_is_peak=False)
    notes = [*sign_notes(rows), *dash_notes(rows, at, impacts, ends_differ=True)]
    notes += limited_pressure_notes(rows, runs)
    return _table(rows, f"{_counted(rows, impacts)}: {', '.join(places)}", impacts), notes


def _at_end(run: Run, other: Run | None, yielding: Yielding, place: Place) -> AtPressures:
    """Peaks on the right wall or on a cap at both yield pressures."""
    outside = not_a_prediction(run), other is not None and not_a_prediction(other)
    own, harder = _peak(run, (), place), _peak(other, (), place)
    return at_pressures(run, own, harder, yielding, outside, at_right_end=True)


def _add_peaks(
    rows: dict[str, dict[str, str]], i: int, at: Mapping[str, AtPressures],
    runs: Mapping[str, Run], several: Mapping[str, Sequence[str]],
) -> None:  # fmt: skip
    """Add the column of a yield pressure; the smallest peak is marked if all are known."""
    column = f"peak at {possible_factors()[i]} Y"
    for name, each in at.items():
        known, sign = math.isfinite(each.both[i]), f"{UNPREDICTED} " * each.outside[i]
        text = measure(each.both[i], "N", runs[name].chain.units, 5) if known else NONE
        rows[name][column] = f"{sign * known}{text}"
    for names in several.values():
        if all_known(found := predicted(_part(at, names), i)):
            mark(rows, column, compared(found))


def _table(rows: Mapping[str, Mapping[str, str]], title: str, impacts: Impacts) -> Table:
    """A table of the columns in which any row has an entry."""
    from rich import box
    from rich.table import Table

    columns = shown_columns(rows)
    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left", padding=0)
    named = not impacts or any(any(names) for names in impacts.names.values())
    first = [impacts.kind] * bool(impacts) + ["chain"] * named
    for key in (*first, *columns):
        heading = HEADINGS.get(key, key).replace("peak at ", "peak at\n")
        heading = heading.replace(FIRST, "first max.\n").replace(LARGEST, "largest\n")
        table.add_column(heading, justify="left" if key in first else "right", vertical="bottom")
    groups = impacts.names or {"": dict(zip(rows, rows, strict=True))}
    for label, names in groups.items():
        for i, (chain, name) in enumerate(names.items()):
            begin = ["" if i else label] * bool(impacts) + [chain] * named
            table.add_row(*begin, *(rows[name].get(key, NONE) for key in columns))
        if named:
            table.add_section()
    return table


def _common_place(runs: Mapping[str, Run], beads: Mapping[str, Sequence[int]]) -> Place | None:
    """The first of the places that all chains have."""
    chains = {name: run.chain for name, run in runs.items()}
    # A first sensor elsewhere is the place that was asked for.
    sensors = {name: beads[name][:1] or [chain.beads] * chain._free_cap
               for name, chain in chains.items()}  # fmt: skip
    body = all(
        chain.right_wall is None and sensors[name] == [chain.beads]
        for name, chain in chains.items()
    )
    common: dict[Place, bool] = {
        "right": all(chain.right_wall is not None for chain in chains.values()),
        "body": body,
        "left": all(chain.left_wall is not None for chain in chains.values()),
        "sensor": all(beads.values()),
    }
    return next((place for place, known in common.items() if known), None)


def _speed_after_fall(run: Run, impacts: Impacts) -> dict[str, str]:
    """The speed of the impact in a table over heights."""
    if impacts.kind == "speed":
        return {}
    return {"speed": measure(float(run.chain.velocities.max()), "m/s", run.chain.units, 4)}


def _of_place(run: Run, beads: Sequence[int], place: Place) -> dict[str, str]:
    if place == "body":
        return _of_body(run)
    return _of_sensor(run, beads[0]) if place == "sensor" else _of_wall(run, place)


def _of_body(run: Run) -> dict[str, str]:
    """Force on the last body of a free end, its acceleration and its duration."""
    from ..simulation.body_force import body_force

    units = run.chain.units
    if (body := body_force(run)) is None:
        return {"peak": "not reached"}
    if not body.complete:
        return {"peak": "not complete"}
    found = {
        "peak": measure(body.force, "N", units, 5), "time": measure(body.time, "s", units, 5),
    }  # fmt: skip
    found["acceleration"], in_g0 = shown_acceleration(body.acceleration, units)
    if in_g0:
        found["in g0"] = in_g0
    if not math.isnan(body.duration):
        found["duration"] = measure(body.duration, "s", units, 3)
    return found


def _of_wall(run: Run, side: Side) -> dict[str, str]:
    wall = run.wall_force(side)
    if not wall.complete:
        return {"peak": "not complete"}
    found = {
        "peak": measure(wall.peak, "N", wall.units, 5),
        "time": measure(wall.peak_time, "s", wall.units, 5),
    }
    if wall.complete_since is not None:
        found["impulse"] = measure(wall.excess_impulse, "N s", wall.units)
        found["duration"] = measure(wall.duration, "s", wall.units)
    return found


def _of_sensor(run: Run, bead: int) -> dict[str, str]:
    sensor, units = run.sensor_force(bead), run.chain.units
    if not sensor.reached:
        return {"peak": "not reached"}
    return {
        "peak": measure(sensor.largest_so_far, "N", units, 5),
        "time": measure(sensor.largest_so_far_time, "s", units, 5),
    }


def _of_last_bead(run: Run) -> dict[str, str]:
    """Velocity and momentum of the last bead of a free end, if the pulse has arrived."""
    if (found := last_bead_of(run)) is None:
        return {}
    from ..simulation.body_force import body_force

    units = run.chain.units
    row = {
        "velocity of last bead": measure(found["velocity"], "m/s", units, 5),
        "momentum of last bead": measure(found["momentum"], "N s", units),
    }
    if run.chain._free_cap and (body := body_force(run)) is not None:
        force = measure(body.force, "N", units, 5)
        row["force on the cap"] = force if body.complete else f"not complete ({force} so far)"
        if body.complete:
            row["acceleration"] = shown_acceleration(body.acceleration, units)[0]
    return row


def _of_contacts(run: Run) -> dict[str, str]:
    """Largest overlap and pressure in comparison with limits, and the deepest dent."""
    import numpy as np

    from ..chain.contact_groups import dents
    from ..chain.hertz_range import hertz_range

    chain, found = run.chain, dict[str, str]()
    if chain.units == "SI" and chain.materials is not None:
        limits = hertz_range(chain, run.largest_overlaps)
        pressure = np.nan_to_num(np.fmax(limits.yield_ratio, limits.law_yield_ratio)).max()
        found["overlap/radius"] = f"{np.nan_to_num(limits.overlap_ratio).max():.2g}"
        found["pressure/yield"] = f"{pressure:.3g}" if pressure else NONE
    dent = float(dents(chain.contact_groups, run._furthest_overlaps).max())
    if dent:
        found["deepest dent"] = measure(dent, "m", chain.units, 3)
    return found


def _peak(run: Run | None, beads: Sequence[int], place: Place) -> float:
    """The peak of a row of the table; infinite if it is not known."""
    if run is None:
        return math.inf
    if place == "body":
        from ..simulation.body_force import body_force

        body = body_force(run)
        return body.force if body is not None and body.complete else math.inf
    if place == "sensor":
        sensor = run.sensor_force(beads[0])
        return sensor.largest_so_far if sensor.reached else math.inf
    wall = run.wall_force(place)
    return wall.peak if wall.complete else math.inf
