"""Headers of columns of traces, such as ``ball 6 [N]``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Final

from ..errors import InputError
from ..store.csv_tables import split_header
from ..units import VOLTS, converted, quantity
from ..validation.numbers import number
from .places import Place, place_named

# Unit at the end of a header.
UNIT: Final = re.compile(r"\s*[\[(][^\[(]*$")
UNITS = {"force": "N", "velocity": "m/s"}
GAIN_UNITS = {"force": "V/N", "velocity": "V s/m"}


def header_of(text: str, named: str | None = None) -> tuple[Place, str, float]:
    """Place, unit (``"N"``, ``"m/s"`` or ``"V"``) and factor of a column.

    ``named`` is the place of a column whose header does not name it; it may have the unit.
    """
    found = split_header(text) if isinstance(text, str) else None
    if found is None and named is None:
        raise InputError(f"column {text!r} must have the form 'ball 6 [N]'")
    name, unit = found or (text, None)
    if named is None:
        place = place_named(name, without_unit(text), example="wall" if unit else "wall [V]")
    else:
        place, unit = _place_and_unit(named, text, unit)
    if not unit:
        raise InputError(_without_any_unit(text, place, named))
    if unit in VOLTS:
        return place, "V", VOLTS[unit]
    si = UNITS[place.quantity]
    try:
        return place, si, converted(f"column {place.name!r}", 1.0, unit, si)
    except InputError as error:
        raise InputError(f"{error}; without calibration, write V or mV") from None


def check_header(header: Sequence[str], given: Iterable[str] | None) -> None:
    """Reject numbers instead of names of columns, unless the sensors are given by them."""
    if header and all(map(is_number, header)) and {*header}.isdisjoint(given or ()):
        raise InputError(
            "the header with the names of the columns is missing: its place has the numbers "
            f"{', '.join(header)}; add a line such as 'time [us],ball 6 [N]' above them"
        )


def is_number(text: str) -> bool:
    """Whether a cell is a number."""
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return True


def in_volts(noise: object) -> bool:
    """Whether a noise is text with a unit of volts, which only sensors without calibration have."""
    found = quantity(noise) if isinstance(noise, str) else None
    return found is not None and found[1] in VOLTS


def positive_noise(name: str, given: object, unit: str, advice: str = "") -> float:
    """Noise of a sensor in its unit; text such as ``"3 mV"`` is converted.

    The advice is for a noise in another unit, such as N, of a sensor without calibration.
    """
    what = f"noise of {name}"
    if unit != "V":
        return number(what, given, unit=unit, above=0.0)
    if isinstance(given, str):
        found = quantity(given)
        if found is None or found[1] not in VOLTS:
            raise InputError(
                f"{what} must be a number or text with a unit of its signal, such as '3 mV', got "
                f"{given!r}{advice if found is not None else ''}"
            )
        given = float(found[0]) * VOLTS[found[1]]
    return number(what, given, above=0.0)


def _place_and_unit(named: str, header: str, unit: str | None) -> tuple[Place, str | None]:
    """Place and unit of a sensor that is given as ``ball 6`` or ``ball 6 [V]``."""
    name, own = split_header(named) or (named, None)
    if own and unit and own != unit:
        raise other_unit_error(header, unit, named, "sensor is")
    return place_named(name, without_unit(named), column=without_unit(header)), own or unit


def other_unit_error(header: str, unit: str, named: str, what: str) -> InputError:
    """Error of a column that is given with another unit than that of its header."""
    return InputError(
        f"column {header!r} has the unit {unit}, but the {what} given as {named!r}; leave out "
        "the unit, or correct the header"
    )


def _without_any_unit(header: str, place: Place, named: str | None) -> str:
    si = UNITS[place.quantity]
    if named is None:
        return f"column {header!r} has no unit; write {header} [{si}], or [V] without calibration"
    return (
        f"column {header!r} has no unit; give load_traces sensors={{{header!r}: "
        f"'{place.name} [V]'}}, or [{si}] for a calibrated signal"
    )


def without_unit(header: str) -> str:
    """Name of a column without its unit, in its own letters."""
    return UNIT.sub("", header).strip()
