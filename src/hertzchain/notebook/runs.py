"""HTML representations of runs, budgets and wall forces: curves and key numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from ..chain.bead_names import CAP, walls_of
from ..simulation.body_force import body_force
from ..simulation.body_peak import BodyForce
from ..simulation.budget import COLOURS as LOCATION_COLOURS
from ..simulation.budget import Budget
from ..simulation.horizon import Horizon
from ..simulation.run import Run
from ..simulation.sensor_force import FREE_FACE, SHOWN, SensorForce
from ..simulation.wall_force import WallForce
from ..theory.decoration import small_beads
from .drawing import (
    COLOURS,
    Curve,
    Mark,
    axis_unit,
    chart,
    engineering,
    legend,
    note,
    numbers,
    page,
    sentence,
    table,
)

# Beads whose velocities are drawn.
MAX_CURVES: Final = 5


def run_html(run: Run) -> str:
    """Velocities of some beads over time, and how the run ended."""
    units = run.chain.units
    found = {
        "status": run.status,
        "end time": engineering(run.end_time, "s", units),
        "beads passed": f"{run.beads_passed} of {run.chain.beads - run.chain.strikers}",
        "saved times": f"{len(run.times)}",
        "steps": f"{run.steps}",
        "energy drift": f"{run.energy_drift:.1e}",
        "momentum drift": f"{run.momentum_drift:.1e}",
    } | _largest_forces(run)
    parts = [numbers(found)]
    if len(run.times) > 1:
        parts = [*_velocities(run), *parts]
    else:
        parts.append(note("No times were saved, so there are no curves to draw."))
    parts += [note(sentence(each)) for each in run.notes]
    if run.prediction:
        parts.append(note(sentence(run.prediction)))
    if not run.success:
        parts.append(note(f"The run failed: {run.message}."))
    return page("Run", run.chain.description, *parts)


def _largest_forces(run: Run) -> dict[str, str]:
    """The largest force on walls and on a cap without a wall."""
    units, found = run.chain.units, {}
    for side in walls_of(run.chain):
        wall = run._wall_force(side)
        so_far = "" if wall.complete and wall.proven else " so far"
        largest = engineering(wall.largest_so_far, "N", units)
        found[f"{side} wall, largest force{so_far}"] = largest if wall.reached else "none yet"
    if run.chain._free_cap and (body := body_force(run)) is not None:
        so_far = "" if body.complete else " so far"
        found[f"cap, largest force{so_far}"] = engineering(body.force, "N", units)
        found[f"cap, acceleration{so_far}"] = engineering(body.acceleration, "m/s^2", units)
    return found


def _velocities(run: Run) -> tuple[str, str]:
    units = run.chain.units
    # The velocities of small beads between large ones cannot be compared with the others.
    beads = np.flatnonzero(~small_beads(run.chain.radii)) + 1
    places = np.linspace(0, len(beads) - 1, min(MAX_CURVES, len(beads)))
    chosen = np.unique(beads[places.round().astype(int)])
    slow, second = axis_unit(run.times, "s", units)
    fast, speed = axis_unit(run.velocities, "m/s", units)
    curves = [
        Curve(slow * run.times, fast * run.velocity(int(k)), _name(run, int(k)), COLOURS[i])
        for i, k in enumerate(chosen)
    ]
    entries = ((curve.label, curve.colour) for curve in curves)
    return legend(entries), chart(curves, f"time{second}", f"velocity{speed}")


def _name(run: Run, bead: int) -> str:
    """A bead, or the cap behind the row."""
    return CAP if bead == run.chain.beads and run.chain.cap is not None else f"bead {bead}"


def body_force_html(body: BodyForce) -> str:
    """The largest force on the last body, and its acceleration."""
    units, so_far = body.units, "" if body.complete else " so far"
    found = {
        f"largest force{so_far}": engineering(body.force, "N", units),
        "its time": engineering(body.time, "s", units),
        f"acceleration{so_far}": engineering(body.acceleration, "m/s^2", units),
        "duration": engineering(body.duration, "s", units),
    }
    if math.isnan(body.force):
        found = {"largest force": "none yet"}
    elif math.isnan(body.duration):
        found["duration"] = "not known"
    parts = [numbers(found)]
    if body.error > SHOWN * abs(body.force):
        error = engineering(float(f"{body.error:.1e}"), "N", units)
        parts.append(note(f"The force has an error of at most {error}."))
    mass = engineering(body.mass, "kg", units)
    return page("BodyForce", f"last body, mass {mass}", *parts)


def budget_html(budget: Budget) -> str:
    """Energy by location over time, stacked, and both balances at the last saved time."""
    units = budget.chain.units
    slow, second = axis_unit(budget.times, "s", units)
    there = {name: values for name, values in budget.energy.items() if np.any(values > 0.0)}
    energy = budget._name("energy")
    factor, joule = axis_unit(np.sum([*there.values()], axis=0), "J", units)
    curves, base = [], np.zeros(len(budget.times))
    for name, values in there.items():
        top, colour = base + values, LOCATION_COLOURS[name]
        curves.append(Curve(slow * budget.times, factor * top, name, colour, factor * base))
        base = top
    rows = [*_balances(budget, factor)]
    worst = max(float(np.abs(budget.residual(of)).max()) for of in ("energy", "momentum"))
    impulse = " [N s]" if units == "SI" else ""
    end = engineering(float(budget.times[-1]), "s", units)
    return page(
        "Budget",
        budget.chain.description,
        legend((curve.label, curve.colour) for curve in curves),
        chart(curves, f"time{second}", f"{energy}{joule}"),
        table(
            (f"at t = {end}", f"{energy}{joule}", "", f"momentum{impulse}", ""), rows, numeric=True
        ),
        note(f"Energy and momentum add up within {worst:.0e} of the largest amount in motion."),
    )


def _balances(budget: Budget, factor: float) -> Iterator[list[str]]:
    """Rows of amounts of energy and momentum, also as parts of the total input."""
    sides = [(budget._shown(of), unit) for of, unit in (("energy", factor), ("momentum", 1.0))]
    for name in dict.fromkeys((*budget.energy, *budget.momentum)):
        cells = [name]
        for (there, _, total), unit in sides:
            value = there.get(name, 0.0)
            cells.append(f"{unit * value:.4g}" if value else "")
            cells.append(f"{value / total:z.1%}" if value and total else "")
        if any(cells[1:]):
            yield cells


def wall_force_html(wall: WallForce) -> str:
    """The force on a wall over time with its peak, and its impulses."""
    units = wall.units
    parts = []
    if not wall.reached:
        texts = ("the pulse has not arrived", wall.reason)
        return page("WallForce", f"{wall.side} wall", *(note(sentence(each)) for each in texts))
    if len(wall.times) > 1:
        slow, second = axis_unit(wall.times, "s", units)
        strong, newton = axis_unit(np.array([wall.largest_so_far]), "N", units)
        largest = engineering(wall.largest_so_far, "N", units)
        mark = Mark(
            slow * wall.largest_so_far_time, strong * wall.largest_so_far,
            f"peak {largest}" if wall.complete and wall.proven else f"{largest} so far",
            open=not wall.complete,
        )  # fmt: skip
        marks = [mark] if wall.largest_so_far > 0.0 else []
        curve = Curve(slow * wall.times, strong * wall.force)
        parts.append(chart(
            [curve], f"time{second}", f"force{newton}", marks=marks, zero=not wall.static_force
        ))  # fmt: skip
    complete, ended = wall.complete, wall.complete_since is not None
    found = {
        "peak so far" if complete and not wall.proven else "peak":
        engineering(wall.peak, "N", units) if complete else "not complete",
        "peak time": engineering(wall.peak_time, "s", units) if complete else "",
        "impulse of the impact" + " above the static force" * bool(wall.static_force):
        engineering(wall.excess_impulse, "N s", units) if ended else "",
        "impulse of the run": engineering(wall.impulse, "N s", units),
        f"contacts with the wall {'in the impact' if ended else 'so far'}": f"{wall.touches}",
        "static force, included":
        engineering(wall.static_force, "N", units) if wall.static_force else "",
    }  # fmt: skip
    parts.append(numbers({name: value for name, value in found.items() if value}))
    if wall.step_dependent:
        parts.append(note("The end of the impact depends on the steps."))
    if not complete:
        parts.append(note(f"The run ended too early: {wall.reason}."))
    else:
        reasons = [wall._later] if ended else [wall._later, wall.reason]
        parts.extend(note(sentence(each)) for each in reasons)
    if wall._caution:
        parts.append(note(sentence(wall._caution)))
    return page("WallForce", f"{wall.side} wall", *parts)


def horizon_html(horizon: Horizon) -> str:
    """Estimated error of the velocities over time."""
    factor, second = axis_unit(horizon.times, "s", horizon.chain.units)
    curve = Curve(factor * horizon.times, 100.0 * horizon.error)
    return page(
        "Horizon", horizon.chain.description,
        chart([curve], f"time{second}", "estimated error [%]", log=True),
        note(sentence(horizon.message)),
    )  # fmt: skip


def sensor_force_html(sensor: SensorForce) -> str:
    """The force in a sensor over time, with its first maximum and its largest value."""
    units = sensor.units
    if not sensor.reached:
        return page("SensorForce", f"bead {sensor.bead}", note("The pulse has not arrived."))
    found = {
        "first maximum": engineering(sensor.first_maximum, "N", units),
        "its time": engineering(sensor.first_maximum_time, "s", units),
        "largest so far": engineering(sensor.largest_so_far, "N", units),
        "time of the largest": engineering(sensor.largest_so_far_time, "s", units),
    }
    if math.isnan(sensor.first_maximum):
        found |= {"first maximum": "none yet", "its time": ""}
    if sensor.static_force:
        found["static force, included"] = engineering(sensor.static_force, "N", units)
        above = sensor.first_maximum - sensor.static_force
        if not math.isnan(above):
            found["first maximum above it"] = engineering(above, "N", units)
    parts = [numbers(found)]
    if len(sensor.times) > 1:
        slow, second = axis_unit(sensor.times, "s", units)
        strong, newton = axis_unit(np.array([sensor.largest_so_far]), "N", units)
        first = slow * sensor.first_maximum_time, strong * sensor.first_maximum
        marks = [] if math.isnan(sensor.first_maximum) else [Mark(*first, "first maximum")]
        curve = Curve(slow * sensor.times, strong * sensor.force)
        parts.insert(0, chart(
            [curve], f"time{second}", f"force{newton}", marks=marks, zero=not sensor.static_force
        ))  # fmt: skip
    if sensor.error > SHOWN * abs(sensor.largest_so_far):
        error = engineering(float(f"{sensor.error:.1e}"), "N", units)
        parts.append(note(f"The maxima have errors of at most {error}."))
    if sensor.free_face:
        parts.append(note(sentence(FREE_FACE)))
    return page("SensorForce", f"bead {sensor.bead}", *parts)
