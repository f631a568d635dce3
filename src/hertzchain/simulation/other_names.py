"""Names that users may try as attributes of runs, and those that have this meaning."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

_PEAK: Final = "pulse().peak_force at each contact, sensor_force(bead) or wall_force().peak"
MEANT: Final = {
    "peak_force": _PEAK, "peak_forces": _PEAK, "max_force": _PEAK,
    "peak_velocity": "pulse().velocity", "peak_overlap": "pulse().peak_overlap",
    "arrival": "pulse().arrival", "arrivals": "pulse().arrival", "speed": "pulse().speed",
    "energy": "budget()", "displacements": "positions",
}  # fmt: skip


class OtherNames:
    """An `AttributeError` that gives the usual name."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            hint = f"; use {MEANT[name]}" if name in MEANT else ""
            text = f"{type(self).__name__!r} object has no attribute {name!r}{hint}"
            raise AttributeError(text, name=name, obj=self)
