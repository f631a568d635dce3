"""Short representations of objects: at most three lines of 100 characters."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence
from types import MappingProxyType
from typing import Any, Final

MAX_LINES: Final = 3
MAX_WIDTH: Final = 100
# Columns of summaries, which pages show without breaking their lines.
SUMMARY_WIDTH: Final = 88
# Forces [N] from which they are shown in kN.
KILONEWTONS: Final = 1e4
# Times [s] up to which they are shown in us, and in ms.
MICROSECONDS: Final = 0.001
MILLISECONDS: Final = 1.0
# Lengths [m] below which they are shown in um, and prefixes of impulses.
MILLIMETRE: Final = 1e-3
PREFIXES: Final = MappingProxyType(
    {1e3: "k", 1.0: "", 1e-3: "m", 1e-6: "u", 1e-9: "n", 1e-12: "p", 1e-15: "f"}
)
# Powers of ten of the smallest and largest values with errors that have no exponent, and the
# largest number of their digits.
SMALLEST, LARGEST, MAX_DIGITS = -4, 5, 12
BYTES: Final = ("kB", "MB", "GB", "TB")
NO_BREAK: Final = "\N{NO-BREAK SPACE}"
# Spaces around an equals sign, and between a number and its unit.
KEPT_TOGETHER: Final = re.compile(
    r" (?==)|(?<==) |(?<=\d) (?=(?:m/s|[kmun]?N s|kg|Hz|[um]s|[smNJ])\b)"
)
# The sign of a number that was rounded to zero.
NEGATIVE_ZERO: Final = re.compile(r"(?<![\w.])-(?=0(?:\.0+)?(?![\w.]*\d))")
# Units of signals without calibration and of their gains.
IN_VOLTS: Final = ("V", "V/N", "V s/m")
# Spaces around the sign between a value and its error, and before units of sensors.
WITH_ERRORS: Final = re.compile(r" (?=\+- )|(?<=\+-) |(?<=\d) (?=(?:[um]?V|[MG]Pa|[unmc]m)\b)")


def short(name: str, about: str, *facts: str) -> str:
    """``Name(about: fact; fact)`` on at most three lines, without empty facts.

    Facts at the end that have no room are replaced by an ellipsis.
    """
    told = [fact for fact in facts if fact]
    for count in range(len(told), 0, -1):
        lines = _lines(_joined(name, about, told[:count] + ["..."] * (count < len(told))))
        if len(lines) <= MAX_LINES:
            return "\n".join(lines)
    return wrapped(_joined(name, about, told))


def _joined(name: str, about: str, facts: Sequence[str]) -> str:
    told = ": ".join(part for part in (about, "; ".join(facts)) if part)
    return f"{name}({without_negative_zeros(told)})"


def without_negative_zeros(text: str) -> str:
    """A text of numbers in which those rounded to zero have no sign: 0.0000, not -0.0000."""
    return NEGATIVE_ZERO.sub("", text)


def wrapped(text: str) -> str:
    """Text on at most three lines, the rest replaced by an ellipsis."""
    return "\n".join(_lines(text, max_lines=MAX_LINES, placeholder=" ...)"))


def _lines(text: str, **limits: Any) -> list[str]:
    """Lines of a text; numbers are kept together with their units."""
    lines = textwrap.wrap(
        KEPT_TOGETHER.sub(NO_BREAK, text), MAX_WIDTH, subsequent_indent="    ",
        break_on_hyphens=False, **limits,
    )  # fmt: skip
    return [line.replace(NO_BREAK, " ") for line in lines]


def folded(text: str, width: int | None = SUMMARY_WIDTH, below: int = 0) -> str:
    """Text whose long sentences are broken, or also rows of tables, with the indent `below`.

    Rows of tables begin with a space; sentences have an indent of four columns.
    """
    if width is None:
        return text
    return "\n".join(
        "\n".join(
            [line] if line.startswith(" ") and not below else _broken(line, width, below or 4)
        )
        for line in text.split("\n")
    )


def _broken(line: str, width: int, below: int) -> list[str]:
    if len(line) <= width:
        return [line.replace(NO_BREAK, " ")]
    lines = textwrap.wrap(
        WITH_ERRORS.sub(NO_BREAK, KEPT_TOGETHER.sub(NO_BREAK, line)), width,
        subsequent_indent=below * " ", break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip
    return [each.replace(NO_BREAK, " ") for each in lines]


def without_exponent(value: float, digits: int = 4) -> str:
    """A number with so many digits, up to a million without an exponent of ten."""
    return f"{float(f'{value:.{digits}g}'):g}"


def measure(value: float, unit: str, units: str = "SI", digits: int = 4) -> str:
    """A number with four digits and, unless it is scaled, its usual unit."""
    if units != "SI":
        return f"{value:.{digits}g}"
    factor, prefixed = usual_unit(value, unit)
    # Thousands, also those that result from rounding, are written without an exponent.
    digits = max(digits, 4) if 999.5 <= abs(factor * value) < 1e4 else digits
    text = f"{factor * value:.{digits}g}"
    if digits < 3 and "e+0" in text:
        # Bounds with two digits: 520, not 5.2e+02.
        text = f"{float(text):g}"
    return f"{text} {prefixed}"


def range_and_mean(values: Sequence[float], unit: str, units: str = "SI") -> str:
    """``1.2 to 1.4, mean 1.3``: the range and mean of finite values, or the only value."""
    known = [value for value in values if math.isfinite(value)]
    if not known:
        return "not known"
    low, high, mean = (
        measure(each, unit, units if unit != "1" else "scaled")
        for each in (min(known), max(known), math.fsum(known) / len(known))
    )
    return low if low == high else f"{low} to {high}, mean {mean}"


def shown_signal(value: float, unit: str, digits: int = 3) -> str:
    """A value of a signal or a gain; small ones of sensors without calibration in mV."""
    factor, unit = usual_unit(value, unit) if unit in IN_VOLTS else (1.0, unit)
    return f"{factor * value:.{digits}g} {unit}"


def usual_unit(value: float, unit: str) -> tuple[float, str]:
    """Factor and unit in which a value is shown: us or ms for short times, kN, MPa or GPa.

    Lengths below 1 mm are shown in um, signals and gains below 1 V and 1 V/N in mV and mV/N, and
    impulses and momenta in N s with a prefix.
    """
    if unit == "N s" and 0.0 < abs(value) < math.inf:
        size = next((each for each in PREFIXES if abs(value) >= 0.99995 * each), min(PREFIXES))
        return 1.0 / size, f"{PREFIXES[size]}N s"
    if unit == "m" and 0.0 < abs(value) < MILLIMETRE:
        return 1e6, "um"
    if unit == "Pa":
        return (1e-9, "GPa") if abs(value) >= 1e9 else (1e-6, "MPa")
    if unit in IN_VOLTS and 0.0 < abs(value) < 1.0:
        return 1e3, f"m{unit}"
    if unit == "N" and abs(value) >= KILONEWTONS:
        return 1e-3, "kN"
    if unit == "s" and 0.0 < abs(value) < MICROSECONDS:
        return 1e6, "us"
    if unit == "s" and 0.0 < abs(value) < MILLISECONDS:
        return 1e3, "ms"
    return 1.0, unit


def listed(words: Sequence[str], last: str = "and") -> str:
    """``a``, ``a and b``, ``a, b and c``."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} {last} {words[-1]}"


def with_error(value: float, error: float) -> str:
    """``0.6231 +- 0.0020``: the error with two digits, the value with the same decimals."""
    if not 0.0 < error < math.inf:
        return f"{value:.5g}"
    last = _second_digit(error)
    first = math.floor(math.log10(max(abs(value), error)))
    if first - last > MAX_DIGITS:
        return f"{value:.{MAX_DIGITS}g} +- {error:.2g}"
    if first < SMALLEST or first > LARGEST:
        unit, decimals = 10.0**first, first - last
        return f"({value / unit:z.{decimals}f} +- {error / unit:.{decimals}f})e{first:+03d}"
    decimals = max(-last, 0)
    both = (round(each, -last) for each in (value, error))
    return " +- ".join(f"{each:z.{decimals}f}" for each in both)


def with_decimals(values: Sequence[float], spread: float) -> list[str]:
    """Values with the same decimals, which are those of three digits of their spread."""
    largest = max(map(abs, values))
    if not 0.0 < spread < math.inf or not largest < math.inf:
        return [f"{value:.5g}" for value in values]
    first = math.floor(math.log10(largest))
    last = max(_second_digit(spread) - 1, first - MAX_DIGITS)
    power = first if first < SMALLEST or first > LARGEST else 0
    decimals, unit = max(power - last, 0), 10.0**power
    end = f"e{power:+03d}" if power else ""
    return [f"{value / unit:z.{decimals}f}{end}" for value in values]


def _second_digit(error: float) -> int:
    """Power of ten of the second digit of a number, rounded to two digits."""
    return int(f"{error:.1e}".partition("e")[2]) - 1


def in_bytes(size: float) -> str:
    """``120 bytes``, ``1.3 kB``, ``2.5 GB``: decimal units, as in file managers."""
    if size < 1000.0:
        return f"{size:.0f} bytes"
    power = min(int(math.log10(size)) // 3, len(BYTES))
    return f"{size / 1000.0**power:.3g} {BYTES[power - 1]}"


def in_column(values: Sequence[float], digits: int) -> list[str]:
    """Numbers of a column or a legend with at most these digits: 5.800 beside 5.837.

    All have as many digits as the value that needs most of them; a dash takes the place of NaN.
    """
    texts = [f"{value:.{digits}g}" for value in values]
    most = max(map(_digits_of, texts), default=1)
    found = zip(values, texts, strict=True)
    return ["-" if math.isnan(value) else _padded(value, text, most) for value, text in found]


def _padded(value: float, text: str, digits: int) -> str:
    """The number with zeros at its end, unless it is whole or very large."""
    if value == 0.0 or not math.isfinite(value) or _digits_of(text) == digits:
        return text
    large = abs(value) >= 1.0 and ("e" in text or abs(value) >= 10.0 ** (digits - 1))
    return text if large else f"{value:#.{digits}g}"


def _digits_of(text: str) -> int:
    """Number of significant digits, without zeros at the end of whole numbers."""
    mantissa = text.lstrip("-").partition("e")[0]
    if not mantissa.replace(".", "").isdigit():
        return 1
    shown = mantissa if "." in mantissa else mantissa.rstrip("0")
    return max(len(shown.replace(".", "").lstrip("0")), 1)


def counted(count: int, noun: str) -> str:
    """``1 wave``, ``2 waves``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def size_in_words(beads: int, strikers: int) -> str:
    """``20 beads``, or ``20 beads and 1 striker`` for 21 beads with the striker."""
    words = counted(beads - strikers, "bead")
    return f"{words} and {counted(strikers, 'striker')}" if strikers else words


def percent(fraction: float) -> str:
    """``48.07%``, ``0.0022%``: two decimals, or few digits of very small and very large values."""
    value = 100.0 * fraction
    if abs(value) >= 1e4:
        return f"{value:.3g}%"
    return f"{value:z.2g}%" if abs(value) < 0.1 else f"{value:.2f}%"


def duration_in_words(seconds: float) -> str:
    """An expected duration with two digits, in seconds, minutes, hours, days or years."""
    if seconds < 60:
        return f"{seconds:.2g} s"
    minutes = round(seconds / 60)
    if minutes < 60:
        return f"{minutes} min"
    hours, minutes = divmod(minutes, 60)
    if hours < 48:
        return f"{hours} h {minutes} min"
    days = seconds / 86400
    return f"{days:.2g} days" if days < 730 else f"{days / 365.25:.2g} years"
