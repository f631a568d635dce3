"""Parse units such as ``mm``, ``m/s`` or ``N/m^1.5`` and convert numbers to SI.

This module converts text with a unit (``"5 mm"``), headers of CSV files (``radius [mm]``) and
lists with a unit (``{list = [4, 5], unit = "mm"}``).  The decimal digits are multiplied by the
factor before the result is rounded once: ``"9.3 mm"`` is exactly the number 9.3e-3.  Inches may be
fractions (``"3/16 in"``), and numbers without a dimension may be percentages (``"5%"``).
"""

from __future__ import annotations

import decimal
import math
import re
from collections.abc import Mapping
from decimal import Decimal
from functools import lru_cache
from types import MappingProxyType
from typing import Final, NamedTuple

from .errors import InputError, short_repr, unknown_name_error

# Standard gravity [m/s^2].
STANDARD_GRAVITY: Final = 9.80665
# Value in SI and powers of metre, kilogram and second, by symbol.
SYMBOLS: Final[Mapping[str, tuple[str, tuple[int, int, int]]]] = MappingProxyType(
    {
        "m": ("1", (1, 0, 0)), "cm": ("1e-2", (1, 0, 0)), "mm": ("1e-3", (1, 0, 0)),
        "um": ("1e-6", (1, 0, 0)), "nm": ("1e-9", (1, 0, 0)), "in": ("25.4e-3", (1, 0, 0)),
        "km": ("1e3", (1, 0, 0)),
        "kg": ("1", (0, 1, 0)), "g": ("1e-3", (0, 1, 0)), "mg": ("1e-6", (0, 1, 0)),
        "s": ("1", (0, 0, 1)), "ms": ("1e-3", (0, 0, 1)), "us": ("1e-6", (0, 0, 1)),
        "ns": ("1e-9", (0, 0, 1)), "min": ("60", (0, 0, 1)), "h": ("3600", (0, 0, 1)),
        "N": ("1", (1, 1, -2)), "kN": ("1e3", (1, 1, -2)), "mN": ("1e-3", (1, 1, -2)),
        "MN": ("1e6", (1, 1, -2)),
        "J": ("1", (2, 1, -2)), "mJ": ("1e-3", (2, 1, -2)), "uJ": ("1e-6", (2, 1, -2)),
        "kJ": ("1e3", (2, 1, -2)),
        "Pa": ("1", (-1, 1, -2)), "kPa": ("1e3", (-1, 1, -2)), "MPa": ("1e6", (-1, 1, -2)),
        "GPa": ("1e9", (-1, 1, -2)),
        "g0": ("9.80665", (1, 0, -2)),
        "Hz": ("1", (0, 0, -1)), "kHz": ("1e3", (0, 0, -1)), "MHz": ("1e6", (0, 0, -1)),
    }
)  # fmt: skip


def _symbols(si: str) -> tuple[str, ...]:
    """Symbols of one dimension, with µ as well as u; the SI unit is the first."""
    powers = SYMBOLS[si][1]
    same = (each for each, (_, own) in SYMBOLS.items() if own == powers)
    return tuple(name for each in same for name in dict.fromkeys((each, each.replace("u", "µ"))))


# Units listed in messages, by dimension; the first is the SI unit.  Any product of powers of
# `SYMBOLS` is accepted.
UNITS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "length": _symbols("m"),
        "mass": _symbols("kg"),
        "time": _symbols("s"),
        "velocity": ("m/s", "cm/s", "mm/s", "km/h"),
        "acceleration": ("m/s^2", "cm/s^2", "mm/s^2", "g0"),
        "force": _symbols("N"),
        "energy": _symbols("J"),
        "stiffness": ("N/m^1.5", "N/um^1.5", "N/µm^1.5"),
        "frequency": _symbols("Hz"),
        "pressure": _symbols("Pa"),
        "density": ("kg/m^3", "g/cm^3"),
        "damping": ("kg/s", "g/s"),
    }
)
# Units of the stiffness of a linear spring that messages list; those of a chain are `UNITS`.
LINEAR_STIFFNESS: Final = ("N/m", "N/mm", "kN/mm")
# Units of electrical signals, in V.
VOLTS: Final[Mapping[str, float]] = MappingProxyType({"V": 1.0, "mV": 1e-3, "uV": 1e-6, "µV": 1e-6})
# Gain of a sensor with its unit, such as 20 mV/N, 0.3 V s/m and 0.3 V/(m/s).
_GAIN: Final = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([um\u00b5]?V)\s*(\W.*|s.*)"
)
_RATIO: Final = re.compile(r"/\s*\(\s*([^()/]+?)\s*/\s*([^()/]+?)\s*\)")
# Exponent of contacts by powers of the unit of their stiffness, force/length^exponent.
EXPONENTS: Final = {(0.0, 1.0, -2.0): "1", (-0.5, 1.0, -2.0): "1.5"}
# Units written in other ways.
MEANT: Final = {
    "mu": "um", "micron": "um", "microns": "um", "mum": "um", "sec": "s", "msec": "ms",
    "usec": "us", "inch": "in", "mins": "min", "minutes": "min", "hours": "h",
}  # fmt: skip
# Largest number of letters of a symbol whose spelling, apart from the case, is not corrected.
SHORT_SYMBOL: Final = 2
_FACTOR: Final = re.compile(
    r"([*/·]?)\s*(g0(?!\d)|[A-Za-zµ]+)\s*(?:(?:\^|\*\*)\s*([+-]?\d+(?:\.\d*)?))?\s*"
)
_QUANTITY: Final = re.compile(
    r"\s*([+-]?(?:(?:inf|nan)(?=\s)|\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*((?:[A-Za-zµμ°%/]|1\s*/)[^\[\]{}()=,;]*?)\s*"
)
# Sizes of balls such as "3/16 in", "1 1/2 in" and "1-1/2 in".
_FRACTION_OF_INCH: Final = re.compile(r"\s*(?:(\d+)[\s-]+)?(\d+)\s*/\s*(\d+)\s*(in)\s*")
# Two whole numbers with a comma between them, and a unit: "10,5 mm".
_DECIMAL_COMMA: Final = re.compile(r"(?<![\d.])(\d+),(\d+)(?![\d.])\s*([A-Za-zµμ%][^\s,;:]*)?")
PERCENT: Final = "%"


class Unit(NamedTuple):
    """Value in SI and powers of metre, kilogram and second."""

    factor: Decimal
    powers: tuple[float, float, float]


@lru_cache(maxsize=256)
def _parse(text: str) -> Unit | None:
    """Parse a product of powers of `SYMBOLS`, or %; return `None` for any other text."""
    if text.strip() == PERCENT:
        return Unit(Decimal("0.01"), (0.0, 0.0, 0.0))
    rest = text.strip().replace("μ", "µ").replace("µ", "u").replace("²", "^2").replace("³", "^3")
    rest = rest.removeprefix("1") if rest.startswith("1/") else rest
    factor, powers = Decimal(1), [0.0, 0.0, 0.0]
    while rest:
        found = _FACTOR.match(rest)
        if found is None or found[2] not in SYMBOLS:
            return None
        value, own = SYMBOLS[found[2]]
        power = Decimal(found[3] or 1) * (-1 if found[1] == "/" else 1)
        if abs(power) > 100:
            return None
        factor *= Decimal(value) ** power
        powers = [one + float(power) * other for one, other in zip(powers, own, strict=True)]
        rest = rest[found.end() :]
    first, second, third = (round(power, 9) for power in powers)
    return Unit(factor, (first, second, third))


def is_unit(text: str) -> bool:
    """Whether text is a unit."""
    return _parse(text) is not None


def unit_of_stiffness(exponent: float) -> str:
    """Unit of the stiffness k of F = k d^p: N/m for a linear spring."""
    return "N/m" if exponent == 1.0 else f"N/m^{exponent:.15g}"


def has_dimension(unit: str, si: str) -> bool:
    """Whether text is a unit of the dimension of an SI unit."""
    given, target = _parse(unit), _parse(si)
    return given is not None and target is not None and given.powers == target.powers


def converted(what: str, number: str | float, unit: str, si: str) -> float:
    """Convert a number to the SI unit ``si``."""
    given, target = _parse(unit), _parse(si)
    assert target is not None, si
    choices, written = _choices(target), si.replace("**", "^")
    if written not in choices:
        # A stiffness in N/m^2 has the dimension of a pressure.
        choices = (written, *choices)
    if given is None and unit.strip() in MEANT:
        raise InputError(f"unknown unit of {what} {unit!r}; did you mean {MEANT[unit.strip()]!r}?")
    if given is None and not si:
        raise InputError(f"{what} must be a plain number or a percentage, got the unit {unit!r}")
    if given is None:
        raise _unknown_unit(f"unit of {what}", unit, target, choices)
    if given.powers != target.powers:
        needed = f"a unit such as {', '.join(choices)}" if si else "no unit"
        raise InputError(
            f"{what} must have {needed}, got {short_repr(unit)}{_exponent_advice(given, target)}"
        )
    value = float(number)
    if not math.isfinite(value) or value == 0.0:
        return value
    try:
        return float(Decimal(str(number)) * given.factor / target.factor)
    except (decimal.DecimalException, OverflowError):
        return value * float(given.factor / target.factor)


def volts_per(text: str, si: str) -> float | None:
    """Gain such as ``20 mV/N`` in V per unit ``si``, N, m or m/s; `None` for any other text."""
    found = _GAIN.fullmatch(text)
    if found is None:
        return None
    inverse = _RATIO.sub(r"/\1*\2", found[3].strip())
    per_si = "s/m" if si == "m/s" else f"1/{si}"
    if not has_dimension(inverse, per_si):
        return None
    return float(found[1]) * VOLTS[found[2]] * converted("gain", 1.0, inverse, per_si)


def _unknown_unit(what: str, unit: str, target: Unit, choices: tuple[str, ...]) -> InputError:
    """Error for an unknown unit, with those of the right dimension that it may mean."""
    asked = unit.strip()
    meant = [
        repr(each) for each in dict.fromkeys((*choices, *SYMBOLS))
        if each.lower() == asked.lower() and (found := _parse(each))
        and found.powers == target.powers
    ]  # fmt: skip
    # Any two short symbols are similar: "mn" is neither more nor less like "m" than like "nm".
    if not meant and len(asked) > SHORT_SYMBOL:
        return unknown_name_error(what, unit, choices)
    hint = f" (did you mean {' or '.join(meant)}?)" if meant else ""
    return InputError(f"unknown {what} {short_repr(unit)}{hint}: choose from {', '.join(choices)}")


def _exponent_advice(given: Unit, target: Unit) -> str:
    """End of a message about a stiffness in the unit of another exponent, such as N/mm."""
    if not {given.powers, target.powers} <= EXPONENTS.keys():
        return ""
    return f"; contacts with this unit have exponent = {EXPONENTS[given.powers]}"


def quantity(text: str) -> tuple[str, str] | None:
    """Split text such as ``"5 mm"`` into number and unit; return `None` for any other text."""
    if len(text) >= 100:
        return None
    inches = _FRACTION_OF_INCH.fullmatch(text)
    if inches is not None and int(inches[3]) > 0:
        value = int(inches[1] or 0) + Decimal(inches[2]) / Decimal(inches[3])
        return str(value), inches[4]
    found = _QUANTITY.fullmatch(text)
    return None if found is None or _is_number(text) else (found[1], found[2])


def comma_advice(value: object, *, several: bool = False, si: str = "") -> str:
    """End of a message about text such as "10,5 mm", which in a list may mean two values.

    A unit of another dimension than that of ``si``, if given, is not repeated.
    """
    found = _DECIMAL_COMMA.search(value) if isinstance(value, str) else None
    if found is None:
        return ""
    target = _parse(si) if si else None
    if found[3] and target is not None and not has_dimension(found[3], si):
        units = ", ".join(_choices(target)[:3] or (si.replace("**", "^"),))
        return f"; write {found[1]}.{found[2]} with a decimal point and a unit such as {units}"
    unit = f" {found[3]}" if found[3] else ""
    two = f", or {found[1]}{unit}, {found[2]}{unit} for two values" if several else ""
    if two and str(value).count(",") > 1:
        two = ", or a list in brackets"
    return f"; write {found[1]}.{found[2]}{unit} with a decimal point{two}"


def _is_number(text: str) -> bool:
    """Whether the text is a number alone, such as "1e-3", not 1 and the unit "e-3"."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def _choices(unit: Unit) -> tuple[str, ...]:
    """Units of the same dimension that are listed in messages."""
    for names in (*UNITS.values(), LINEAR_STIFFNESS):
        first = _parse(names[0])
        if first is not None and first.powers == unit.powers:
            return names
    return ()
