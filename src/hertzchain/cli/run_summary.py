"""Summaries of runs, as text and as JSON: how they ended, and forces on walls and in sensors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from ..recorded_warnings import ignore_warnings
from ..simulation.yielding import (
    contacts_without_strength,
    dents_in_words,
    elastic_springs,
    first_yield_after_peak,
    not_a_prediction,
    peak_with_yielding_contacts,
    pressures_below_yield,
    remark_on_overlaps,
)
from .hit_tables import second_hit_lines
from .last_bead import body_as_dict, final_velocities, free_end_lines, last_bead_of
from .output import show_table
from .reflections import reflection_as_dict, reflection_in_words
from .wording import on_command_line
from .wrapped_text import show_text
from .yield_range import Ends, range_as_dict, range_in_words, range_lines

if TYPE_CHECKING:
    from ..chain.bead_names import Side
    from ..chain.chain import Chain
    from ..simulation.run import Run
    from ..simulation.sensor_force import SensorForce
    from ..simulation.wall_force import WallForce
    from ..simulation.yielding import WithYield
    from .compared_yield import Yielding
    from .reflections import Contacts


def run_as_dict(
    run: Run, beads: Sequence[int], other: Run | None = None, yielding: Yielding = (None, None), *,
    waves: bool, contacts: bool, budget: bool = False, second: bool = False,
    reflection: Contacts | None = None,
) -> dict[str, object]:  # fmt: skip
    """Summary of a run as a JSON document; ``other`` has the largest possible yield pressure.

    ``yielding`` are the `peaks_if_yielding`; ``second`` adds the peak of a second impact.
    """
    from ..simulation.hits import second_hit
    from ..store.results import document_of
    from ..validation.json_types import finite
    from .contact_tables import contacts_as_dict, largest_pressure
    from .wave_tables import horizon_as_dict, waves_as_list

    described, (peak, harder) = document_of(run.chain), yielding
    document: dict[str, object] = {
        **{name: described.pop(name) for name in ("schema_version", "hertzchain_version")},
        "status": run.status,
        "message": run.message,
        "end_time": run.end_time,
        "steps": run.steps,
        "evaluations": run.evaluations,
        "energy_drift": run.energy_drift,
        "momentum_drift": run.momentum_drift,
        "saved_times": len(run.times),
        "closed_contacts": run.closed_contacts.tolist(),
        "impact_velocity": float(run.chain.velocities.max()),
        "walls": [
            {"material": _material(run.chain, wall.side)} | _numbers(wall) for wall in _walls(run)
        ],
        "strikers": strikers_of(run),
        "last_bead": last_bead_of(run),
        "last_bead_force": body_as_dict(run),
        "final_velocities": run.state.velocities.tolist(),
        "peak_with_yielding_contacts": None if peak is None else peak.value,
        "peak_range_with_yielding_contacts": None
        if peak is None or harder is None
        else [peak.value, harder.value],
        "yielding_overlap_ratio": None if peak is None else peak.overlap_ratio,
        "yielding_within_range": None if peak is None else not peak.outside,
        "largest_pressure_over_yield": largest_pressure(run),
        "notes": _notes(run, peak),
        "forces_predicted": not (not_a_prediction(run) or (peak is not None and peak.outside)),
        "yielding_proven": None if peak is None else not peak.so_far,
        "peak_of_second_hit": finite(second_hit(run)) if second else None,
        "yield_pressure_range": range_as_dict(run, other, beads),
        "sensors": [_numbers(run.sensor_force(bead)) for bead in beads],
    }
    if run.known_horizon is not None:
        document["horizon"] = horizon_as_dict(run.known_horizon)
    if contacts:
        document |= contacts_as_dict(run)
    if waves:
        found = run.waves()
        document["waves"] = waves_as_list(found)
        document["unlisted_energy"] = found.unlisted_energy.tolist()
    if reflection:
        document["reflection"] = reflection_as_dict(run, reflection)
    if budget:
        document["budget"] = _budget_as_dict(run)
    return document | described


def _notes(run: Run, yielding: WithYield | None) -> list[str]:
    """Remarks on the run, and on balls that are harder than annealed bars."""
    from ..chain.yield_pressure import note_on_soft_balls

    soft = note_on_soft_balls(run.chain, yielding=yielding is not None)
    return [*map(on_command_line, run.notes), *([soft] if soft else [])]


def together(runs: dict[str, Run], found: list[dict[str, object]]) -> dict[str, object]:
    """One JSON document with the summaries of several runs."""
    names = ("schema_version", "hertzchain_version")
    version = {name: found[0][name] for name in names}
    found = [{name: each[name] for name in each if name not in names} for each in found]
    named = [{"name": name} | each for name, each in zip(runs, found, strict=True)]
    return version | {"runs": named}


def _budget_as_dict(run: Run) -> dict[str, object]:
    """Energy and momentum by location and by origin, at the last saved time."""
    found = run.budget()
    parts = {
        "energy": {"location": found.energy, "origin": found.energy_given},
        "momentum": {"location": found.momentum, "origin": found.momentum_given},
    }
    last = {
        of: {side: {name: float(each[-1]) for name, each in amounts.items()}
             for side, amounts in sides.items()}
        for of, sides in parts.items()
    }  # fmt: skip
    return {"time": float(found.times[-1]), **last}


def show_run(
    run: Run, beads: Sequence[int], other: Run | None = None, yielding: Yielding = (None, None), *,
    waves: bool, contacts: bool, budget: bool = False, second: bool = False,
    reflection: Contacts | None = None, sensors: Sequence[str] = (),
) -> None:  # fmt: skip
    """Print the summary of a run, with a hint at --horizon if it is long.

    The ``other`` run has the largest possible yield pressure; ``yielding`` are the
    `peaks_if_yielding`; ``second`` adds a larger peak of a second impact; one of the ``sensors``,
    as they are typed, may be a load cell.
    """
    from ..representation import measure
    from ..simulation.run_message import LONG_RUN, transits_between_walls
    from .contact_tables import contact_table
    from .wave_tables import wave_table

    show_text(f"{run.chain.description}{_impact(run.chain)}\n{on_command_line(run.message)}")
    show_text(f"energy drift {run.energy_drift:.1e}, momentum drift {run.momentum_drift:.1e}")
    show_text(f"{len(run.times)} saved times, {run.evaluations} force evaluations")
    if run._unfinished:
        show_text(
            f"{run._unfinished}; to see the velocities after the impact, give a later "
            "time with --until"
        )
    for line in _striker_lines(run):
        show_text(line)
    unchecked = contacts_without_strength(run.chain, run.largest_overlaps)
    dented = dents_in_words(run.chain, run._furthest_overlaps)
    remarks = [each for each in (dented, remark_on_overlaps(run)) if each]
    springs = elastic_springs(run.chain)
    for line in [*pressures_below_yield(run, above=True), *unchecked, *springs, *remarks,
                 *(f"note: {note}" for note in _notes(run, yielding[0]))]:  # fmt: skip
        show_text(line)
    for wall in _walls(run):
        show_text(_wall_lines(run, wall, _wall_name(wall, sensors)))
        if run.chain.cap is not None and wall.side == "right" and wall.first_contact_end:
            time = measure(wall.first_contact_end, "s", wall.units)
            show_text(
                f"  the cap leaves the wall at t = {time}, because walls do not pull; a cap that "
                "is fixed to its cell then oscillates"
            )
    sensors = [_sensor_line(run, bead) for bead in beads]
    at_end = [*free_end_lines(run, beads), *_if_yielding(run, yielding)]
    at_end += second_hit_lines(run) if second else []
    for line in [*at_end, *final_velocities(run), *sensors, *range_lines(run, other, beads)]:
        show_text(line)
    transits = transits_between_walls(run.chain, run._walls, run.end_time)
    if run.known_horizon is not None:
        later = "; later values are one of many possible outcomes"
        ends = math.isfinite(run.known_horizon.time)
        show_text(f"horizon: {run.known_horizon.message}{later if ends else ''}")
    elif transits > LONG_RUN:
        show_text(
            f"the run lasts {transits:.3g} transits of the pulse: --horizon shows how long it is "
            "predictable"
        )
    if waves:
        show_table(wave_table(run.waves()))
    if reflection:
        show_text(reflection_in_words(run, reflection))
    if contacts:
        show_table(contact_table(run))
    if budget:
        click.echo(run.budget())


def peaks_if_yielding(run: Run) -> Yielding:
    """Peaks if contacts yield at the smallest and at the largest possible pressure."""
    from ..chain.materials import FULLY_PLASTIC

    if (peak := peak_with_yielding_contacts(run)) is None:
        return None, None
    return peak, peak_with_yielding_contacts(run, factor=FULLY_PLASTIC)


def _if_yielding(run: Run, yielding: Yielding) -> list[str]:
    """Lines with the peaks if contacts yield, for elastic ones beyond first yield."""
    from ..representation import measure

    peak, harder = yielding
    if peak is None:
        return []
    shown = measure(peak.value, "N", run.chain.units, 5)
    outside = f", {peak.caution}" if peak.outside else ""
    so_far = " so far" if peak.so_far else ""
    if (time := first_yield_after_peak(run, peak)) is not None:
        when = measure(time, "s", run.chain.units, 3)
        return [f"  peak{so_far} with contacts that yield: the same; contacts first yield at "
                f"{when}, after this peak"]  # fmt: skip
    lines = [f"  peak{so_far} with contacts that yield: {shown} (--loss elastic-plastic){outside}"]
    if harder is not None and not peak.outside:
        several = peak.several_pulses or harder.several_pulses
        ends = Ends("", "N", peak.value, harder.value, several)
        lines.append(f"    {range_in_words(ends, run.chain.units)}")
    return lines


def strikers_of(run: Run) -> list[dict[str, float]]:
    """Velocities of strikers at the end, and the parts of their energy.

    Of a run without a given end, they are those of a rebound under gravity only: other runs may end
    while strikers are still in contact.
    """
    first = run.chain.velocities
    if len(run.times) and run.times[-1] >= run.end_time:
        last = run.velocities[-1]
    elif run.chain.gravity and not run.state.velocities[: run.chain.strikers].max(initial=0.0) > 0:
        last = run.state.velocities
    else:
        return []
    return [
        {
            "striker": i + 1, "velocity": float(last[i]),
            "energy_kept": float((last[i] / first[i]) ** 2),
        }
        for i in range(run.chain.strikers)
        if first[i]
    ]  # fmt: skip


def _striker_lines(run: Run) -> list[str]:
    from ..representation import measure, percent

    lines = []
    for each in strikers_of(run):
        number = f" {each['striker']}" if run.chain.strikers > 1 else ""
        velocity = measure(each["velocity"], "m/s", run.chain.units)
        kept = percent(each["energy_kept"])
        lines.append(
            f"striker{number} at the end of the run: velocity {velocity}, {kept} of its energy"
        )
    return lines


def _impact(chain: Chain) -> str:
    """Speed of the impact, and whether it is that of chains without a given one."""
    from ..chain.description import impact_in_words

    found = impact_in_words(chain.velocities, chain.units)
    return f"{found} (default)" if found and "velocities" not in chain.given else found


def _walls(run: Run) -> list[WallForce]:
    from ..chain.bead_names import walls_of

    return [run.wall_force(side) for side in walls_of(run.chain)]


def _material(chain: Chain, side: Side) -> str | None:
    """Name of the material of a wall, if it is known; a stiffness hides that of the bead."""
    from ..chain.walls import material_of_wall

    wall = chain.left_wall if side == "left" else chain.right_wall
    if wall is None or wall.material is not None:
        return None if wall is None or wall.material is None else wall.material.name
    if wall.stiffness is not None or chain.materials is None:
        return None
    return material_of_wall(wall, chain.materials[0 if side == "left" else -1]).name


def _numbers(force: WallForce | SensorForce) -> dict[str, object]:
    """All public fields except the trace; null for a number that does not exist."""
    from ..simulation.sensor_passages import passages_if_saved
    from ..simulation.wall_force import WallForce
    from ..simulation.waves import DIRECTIONS
    from ..validation.json_types import finite

    arrays = ("times", "force", "velocity")
    public = {name: value for name, value in vars(force).items() if not name.startswith("_")}
    found = {name: value for name, value in public.items() if name not in arrays}
    found["reached"] = force.reached
    if isinstance(force, WallForce):
        names = ("duration", "excess_impulse", "step_dependent")
        found |= {name: getattr(force, name) for name in names}
    else:
        with ignore_warnings():  # passages that are not resolved have few samples
            found["passages"] = [
                vars(each) | {"direction": DIRECTIONS.get(each.direction)}
                for each in passages_if_saved(force)
            ]
    numbers: dict[str, object] = finite(found)
    return numbers


def _wall_name(wall: WallForce, sensors: Sequence[str]) -> str:
    """Name of a wall, with that of the load cell if it is one of the sensors."""
    from ..chain.bead_names import CELLS, usual_spelling

    cell = wall.side == "right" and any(usual_spelling(each) in CELLS for each in sensors)
    return f"{wall.side} wall{' (load cell)' * cell}"


def _wall_lines(run: Run, wall: WallForce, name: str) -> str:
    """Describe the force on a wall; an incomplete one has no peak."""
    from ..representation import measure
    from ..simulation.wall_force import largest_in_words

    if not wall.reached:
        return f"{name}: the pulse has not arrived"
    static = measure(wall.static_force, "N", wall.units)
    largest = _at(run, wall.largest_so_far, wall.largest_so_far_time)
    with_static = " with the static force" if wall.static_force else ""
    largest += f" ({with_static.strip()} of {static})" if with_static else ""
    impulse = measure(wall.impulse, "N s", wall.units)
    # Static forces never let go of the wall.
    closed = run._closed[0 if wall.side == "left" else -1]
    during = closed and not run.chain.static_state.forces.any()
    ends = ", which ends during a contact" if during else ""
    whole = f"{impulse} in the whole run{with_static}{ends}"
    # If the horizon is known, the time of the force is marked if it is later.
    caution = "" if run.known_horizon or not wall._caution else f"; {wall._caution}"
    caution = on_command_line(caution)
    if not wall.complete:
        return (
            f"{name}: peak not complete, largest so far {largest}"
            f"{largest_in_words(wall, run.end_time)}; {wall.reason}{caution}\n"
            f"  impulse {whole}"
        )
    so_far = "" if wall.proven else " so far"
    # In chains without losses, the caution states this.
    end = wall.first_contact_end or math.inf
    second = wall.peak_time > end and not wall.sensitive
    not_first = "; in a later contact with the wall than the first" if second else ""
    peak = f"{name}: peak{so_far} {largest}{not_first}; {wall._later}{caution}"
    if wall.complete_since is None:
        return f"{peak}; {wall.reason}\n  impulse {whole}"
    of_impact = measure(wall.excess_impulse, "N s", wall.units)
    above = f" above the static force of {static}" if wall.static_force else ""
    parts = [f"{of_impact} in the impact{above} ({wall._contacts})"]
    if wall.first_contact_impulse is not None and wall.touches > 1:
        first = measure(wall.first_contact_impulse, "N s", wall.units)
        parts.insert(0, f"{first} in the first contact")
    parts += [whole] * (impulse != of_impact)
    ratio = measure(wall.duration, "s", wall.units)
    impulses = ", ".join(parts)
    both = ", both above the static force" if wall.static_force else ""
    depends = "; the end of the impact depends on the steps" if wall.step_dependent else ""
    lasts = f"duration of the impact (impulse / peak{both}) {ratio}{depends}"
    return f"{peak}\n  impulse {impulses}\n  {lasts}"


def _at(run: Run, force: float, time: float) -> str:
    """A force and its time, marked if it is later than the horizon."""
    from ..representation import measure

    units, horizon = run.chain.units, run.known_horizon
    later = " (after the horizon)" if horizon is not None and time > horizon.time else ""
    return f"{measure(force, 'N', units, 5)} at t = {measure(time, 's', units, 5)}{later}"


def _sensor_line(run: Run, bead: int) -> str:
    from ..chain.bead_names import bead_label
    from ..representation import measure
    from ..simulation.sensor_force import FREE_FACE, SHOWN

    sensor = run.sensor_force(bead)
    if not sensor.reached:
        return f"sensor in {bead_label(run.chain, bead)}: the pulse has not arrived"
    first, largest = "no maximum yet", ""
    if not math.isnan(sensor.first_maximum):
        first = f"first maximum {_at(run, sensor.first_maximum, sensor.first_maximum_time)}"
    if sensor.largest_so_far_time != sensor.first_maximum_time:
        largest = _at(run, sensor.largest_so_far, sensor.largest_so_far_time)
        largest = f"; largest so far {largest}"
    elif sensor.first_maximum_time:
        largest = ", the largest so far"
    error = ""
    if sensor.error > SHOWN * sensor.largest_so_far:
        size = measure(sensor.error, "N", sensor.units, 2)
        error = f" (error at most {size}, from {len(sensor.times)} saved times)"
    static = ""
    if sensor.static_force:
        static = f", with the static force of {measure(sensor.static_force, 'N', sensor.units)}"
    free = f"\n  {FREE_FACE}" if sensor.free_face else ""
    return f"sensor in {bead_label(run.chain, bead)}: {first}{largest}{static}{error}{free}"
