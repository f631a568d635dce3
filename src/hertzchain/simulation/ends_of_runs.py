"""Quantities of sensors, of the last body of a free end, and of final states, for tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from ..collision import Array
from ..errors import IncompleteWarning, warn_user
from ..pulse.quantities import BODY_QUANTITIES, SENSOR_QUANTITIES
from ..representation import measure
from .body_force import ABOVE, MAY_FOLLOW, body_force
from .body_peak import body_in_words, not_on_a_wall
from .budget import budget_of
from .run import Run
from .sensor_force import sensor_maxima
from .simulate import simulate

# Why a chain with a right wall has no force on a body.
ON_WALL: Final = not_on_a_wall("body_force")
# Why a force on a body has no duration.
NO_DURATION: Final = (
    f"the force on the last body exceeds {ABOVE:.0%} of its largest value until the end of the "
    "run; give a later until"
)


def sensors_of_run(run: Run, beads: Sequence[int]) -> dict[str, Array]:
    """Quantities of sensors."""
    rows = []
    for bead in beads:
        found = sensor_maxima(run, bead)
        first = found.first_maximum, found.first_maximum_time
        largest = found.largest_so_far, found.largest_so_far_time
        rows.append((*first, *largest, float(np.trapezoid(found.force, run.times))))
    return dict(zip(SENSOR_QUANTITIES, np.array(rows).reshape(len(beads), -1).T, strict=True))


def incomplete_in_words(run: Run) -> str:
    """That a run ended before the largest force on its last body was complete."""
    end = measure(run.end_time, "s", run.chain.units, 6)
    body = body_in_words(run.chain)
    return f"the run ends at t = {end}, before the force on {body} is complete: {MAY_FOLLOW}"


def body_of_run(run: Run) -> dict[str, float]:
    """Quantities of the last body of a free end; NaN before the force has had a maximum."""
    body = body_force(run)
    if body is not None and not body.complete:
        warn_user(incomplete_in_words(run), IncompleteWarning)
    return {
        name: np.nan if body is None else getattr(body, each.attribute)
        for name, each in BODY_QUANTITIES.items()
    }


def final_of_run(run: Run, options: dict[str, Any]) -> dict[str, Any]:
    """The state at the end of a run, with the forces at that time, from a second run."""
    end = run.end_time
    last = simulate(run.chain, until=end, times=[end], **options)
    budget = budget_of(
        run.chain, last.times, last.positions, last.velocities, last.forces, last._accumulators,
        np.zeros_like(last.velocities), last.state.start,
    )  # fmt: skip
    kinetic = 0.5 * run.chain.masses * last.velocities[0] ** 2
    return {
        "final_position": last.positions[0],
        "final_velocity": last.velocities[0],
        "end_time": end,
    } | energy_parts(
        kinetic, last.velocities[0] > 0.0,
        *(budget.energy[name][0] for name in ("contacts", "walls", "lost")),
    )  # fmt: skip


def energy_parts(
    kinetic: Array, forward: Array, contacts: Array, walls: Array, lost: Array
) -> dict[str, Array]:
    """Fractions of the energy at the end of runs, from the kinetic energy of each bead."""
    parts = {
        "energy_forward": np.where(forward, kinetic, 0.0).sum(axis=-1),
        "energy_backward": np.where(forward, 0.0, kinetic).sum(axis=-1),
        "energy_in_contacts": contacts,
        "energy_in_walls": walls,
        "energy_lost": lost,
    }
    total = np.sum([*parts.values()], axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return {name: np.asarray(values / total) for name, values in parts.items()}
