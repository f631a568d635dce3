"""What a pulse tells of each bead or contact: names, symbols, units."""

from __future__ import annotations

from typing import Final, Literal

Quantity = Literal[
    "velocity",
    "momentum",
    "energy",
    "peak_time",
    "arrival",
    "residence",
    "peak_overlap",
    "peak_force",
    "velocity_error",
]

# Name, the paper's symbol, description. Order: as in tables.
QUANTITIES: Final[dict[Quantity, tuple[str, str]]] = {
    "velocity": ("v", "first maximum of the bead's velocity"),
    "momentum": ("P", "momentum m v of the bead at that maximum"),
    "energy": ("E", "kinetic energy m v^2 / 2 of the bead at that maximum"),
    "peak_time": ("t_v", "time of that maximum"),
    "arrival": ("t", "time at which the bead becomes faster than the one behind it"),
    "residence": ("T", "time from the arrival at this bead to that at the next bead"),
    "peak_overlap": ("d", "largest overlap with the next bead"),
    "peak_force": ("F", "largest force on the next bead"),
    "velocity_error": ("e_v", "estimated relative error of the velocity"),
}

# Units of a chain in SI units; "1" stands for scaled numbers.
SI_UNITS: Final[dict[Quantity, str]] = {
    "velocity": "m/s",
    "momentum": "kg m/s",
    "energy": "J",
    "peak_time": "s",
    "arrival": "s",
    "residence": "s",
    "peak_overlap": "m",
    "peak_force": "N",
    "velocity_error": "1",
}

PER_CONTACT: Final = frozenset({"residence", "peak_overlap", "peak_force"})
