"""Headers of columns of traces, such as ``ball 6 [N]``."""

from __future__ import annotations

import re
from typing import Final

from ..errors import InputError
from ..store.csv_tables import split_header
from ..units import converted, quantity
from ..validation.numbers import number
from .places import Place, place_named

# Unit at the end of a header.
UNIT: Final = re.compile(r"\s*[\[(][^\[(]*$")
VOLTS = {"V": 1.0, "mV": 1e-3, "uV": 1e-6, "µV": 1e-6}
UNITS = {"force": "N", "velocity": "m/s"}


def header_of(text: str, named: str | None = None) -> tuple[Place, str, float]:
    """Place, unit (``"N"``, ``"m/s"`` or ``"V"``) and factor of a column, or of one with a name."""
    found = split_header(text) if isinstance(text, str) else None
    if found is None:
        raise InputError(f"column {text!r} must have the form 'ball 6 [N]'")
    name, unit = found
    place = place_named(name, _as_written(text)) if named is None else place_named(named)
    if not unit:
        raise InputError(
            f"column {text!r} has no unit; write {name if named else place.name} "
            f"[{UNITS[place.quantity]}]"
        )
    if unit in VOLTS:
        return place, "V", VOLTS[unit]
    si = UNITS[place.quantity]
    try:
        return place, si, converted(f"column {place.name!r}", 1.0, unit, si)
    except InputError as error:
        raise InputError(f"{error}, or V or mV for a sensor without calibration") from None


def positive_noise(name: str, given: object, unit: str) -> float:
    """Noise of a sensor in its unit; text such as ``"3 mV"`` is converted."""
    what = f"noise of {name}"
    if unit != "V":
        return number(what, given, unit=unit, above=0.0)
    if isinstance(given, str):
        found = quantity(given)
        if found is None or found[1] not in VOLTS:
            raise InputError(
                f"{what} must be a number or text with a unit of its signal, such as '3 mV', got "
                f"{given!r}"
            )
        given = float(found[0]) * VOLTS[found[1]]
    return number(what, given, above=0.0)


def _as_written(header: str) -> str:
    """Name of a column without its unit, in its own letters."""
    return UNIT.sub("", header).strip()
