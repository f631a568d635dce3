"""Sensors of a sweep in beads at free ends, which have half of the force on these beads."""

from __future__ import annotations

from collections.abc import Sequence

from ..simulation.sensor_force import free_face_note
from .placed import Placed, placed
from .plan import Plan, tried_chains

FORCES = ("sensor_first_maximum", "sensor_largest_so_far", "sensor_impulse")


def note_on_free_faces(plan: Plan, names: Sequence[str]) -> str:
    """That sensors among these variables have half of the force; empty without any."""
    sensors = [
        each for name in names if (each := placed(name)) is not None and each.column in FORCES
    ]
    for chain in tried_chains(plan) if sensors else ():
        there = {each.name: each.numbers(chain)[0] for each in sensors if each.numbers(chain)}
        if note := free_face_note(chain, there):
            return note
    return ""


def has_free_face(plan: Plan, at: Placed) -> bool:
    """Whether a kept quantity is that of a sensor in a bead at a free end."""
    return bool(note_on_free_faces(plan, ["_".join((at.column, at.place)).replace(" ", "_")]))
