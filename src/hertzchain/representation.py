"""Short representations of objects: at most three lines of 100 characters."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from typing import Final

MAX_LINES: Final = 3
MAX_WIDTH: Final = 100
# Times [s] up to which they are shown in us, and in ms.
MICROSECONDS: Final = 0.01
MILLISECONDS: Final = 1.0
NO_BREAK: Final = "\N{NO-BREAK SPACE}"
# Spaces around an equals sign, and between a number and its unit.
KEPT_TOGETHER: Final = re.compile(
    r" (?==)|(?<==) |(?<=\d) (?=(?:kg m/s|m/s|N s|kg|Hz|[um]s|[smNJ])\b)"
)


def short(name: str, about: str, *facts: str) -> str:
    """``Name(about: fact; fact)`` on at most three lines; facts that are empty are omitted."""
    told = "; ".join(fact for fact in facts if fact)
    return wrapped(f"{name}({': '.join(part for part in (about, told) if part)})")


def wrapped(text: str) -> str:
    """Text on at most three lines, the rest replaced by an ellipsis."""
    lines = textwrap.wrap(
        KEPT_TOGETHER.sub(NO_BREAK, text), MAX_WIDTH, subsequent_indent="    ",
        max_lines=MAX_LINES, placeholder=" ...)", break_on_hyphens=False,
    )  # fmt: skip
    return "\n".join(lines).replace(NO_BREAK, " ")


def measure(value: float, unit: str, units: str = "SI", digits: int = 4) -> str:
    """A number with four digits and, unless it is scaled, its unit; short times in us or ms."""
    if units != "SI":
        return f"{value:.{digits}g}"
    factor, prefix = 1.0, ""
    if unit == "s" and 0.0 < abs(value) < MICROSECONDS:
        factor, prefix = 1e6, "u"
    elif unit == "s" and 0.0 < abs(value) < MILLISECONDS:
        factor, prefix = 1e3, "m"
    return f"{factor * value:.{digits}g} {prefix}{unit}"


def listed(words: Sequence[str], last: str = "and") -> str:
    """``a``, ``a and b``, ``a, b and c``."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} {last} {words[-1]}"


def counted(count: int, noun: str) -> str:
    """``1 wave``, ``2 waves``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"
