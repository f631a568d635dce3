"""Names that users may try as attributes of runs, and those that have this meaning."""

from __future__ import annotations

import dataclasses
import difflib
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Final

from .short_tracebacks import short_traceback

_PEAK: Final = "pulse().peak_force at each contact, sensor_force(bead) or wall_force().peak"
MEANT: Final = {
    "Run": {
        "peak": _PEAK, "peaks": _PEAK, "peak_force": _PEAK, "peak_forces": _PEAK,
        "max_force": _PEAK,
        "peak_velocity": "pulse().velocity", "peak_overlap": "pulse().peak_overlap",
        "arrival": "pulse().arrival", "arrivals": "pulse().arrival", "speed": "pulse().speed",
        "energy": "budget()", "displacements": "positions",
    },
}  # fmt: skip
LIKENESS: Final = 0.75


class OtherNames:
    """An `AttributeError` that gives the usual name, with a short traceback in IPython."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            if hasattr(type(self), name):
                # A property that raised an error of its own.
                return object.__getattribute__(self, name)
            hint = "" if name.startswith("_") else _hint(type(self), name)
            text = f"{type(self).__name__!r} object has no attribute {name!r}{hint}"
            # Python would add a second suggestion from the names of the object.
            error = AttributeError(text, name=name, obj=None if hint else self)
            error._render_traceback_ = partial(short_traceback, error)
            raise error


@lru_cache
def _hint(kind: type, name: str) -> str:
    """The usual name for an unknown one, or a similar name, as a clause."""
    meant = MEANT.get(kind.__name__, {})
    if name in meant:
        return f"; use {meant[name]}"
    fields = {each.name for each in dataclasses.fields(kind)}
    known = [each for each in fields.union(dir(kind)) if not each.startswith("_")]
    near = difflib.get_close_matches(name, known, n=1, cutoff=LIKENESS)
    return f"; did you mean {near[0]!r}?" if near else ""
