"""Names that users may try as attributes of runs, and those that have this meaning."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from ..errors import similar_names
from ..short_tracebacks import short_traceback
from ..validation.entries import NoEntries

_PEAK: Final = "pulse().peak_force at each contact, sensor_force(bead) or wall_force().peak"
MEANT: Final = {
    "peak": _PEAK, "peaks": _PEAK, "peak_force": _PEAK, "peak_forces": _PEAK, "max_force": _PEAK,
    "peak_velocity": "pulse().velocity", "peak_overlap": "pulse().peak_overlap",
    "arrival": "pulse().arrival", "arrivals": "pulse().arrival", "speed": "pulse().speed",
    "energy": "budget()", "displacements": "positions",
}  # fmt: skip


class OtherNames(NoEntries):
    """An `AttributeError`, or `InputError` for an entry, that gives the usual name."""

    def _instead_of_entry(self, name: object) -> str:
        meant = MEANT.get(name) if isinstance(name, str) else None
        return f"use {meant}" if meant else super()._instead_of_entry(name)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            if hasattr(type(self), name):
                # A property that raised an error of its own.
                return object.__getattribute__(self, name)
            hint = "" if name.startswith("_") else self._hint(name)
            text = f"{type(self).__name__!r} object has no attribute {name!r}{hint}"
            # Python would add a second suggestion from the names of the object.
            error = AttributeError(text, name=name, obj=None if hint else self)
            error._render_traceback_ = partial(short_traceback, error)
            raise error

    def _hint(self, name: str) -> str:
        """The usual name for an unknown one, or a similar name, as a clause."""
        if name in MEANT:
            return f"; use {MEANT[name]}"
        known = [each for each in dir(self) if not each.startswith("_")]
        near = similar_names(name, known)
        return f"; did you mean {near}?" if near else ""
