"""HTML for notebooks: small SVG figures and tables, without any plotting library.

Text and axes have the colour of the surrounding text, and curves have colours of medium
brightness, so that figures are readable on light and on dark backgrounds.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape as escaped
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from ..collision import Array
from ..representation import without_exponent, without_negative_zeros

COLOURS: Final = ("#3d85c6", "#d46a12", "#3a9d6e", "#9b6bc4", "#d2504c", "#8a8a8a")
WIDTH: Final = 640
# Points of a curve after thinning: at most two per column of this many; of an area, one.
COLUMNS: Final = 240
AREA_COLUMNS: Final = 160
# Points up to which each has a dot.
MAX_DOTS: Final = 60
# Powers of ten on a logarithmic axis up to which it shows their multiples.
FEW_POWERS: Final = 2
# Margins of a chart: left, right, top, bottom.
MARGINS: Final = (64, 12, 10, 34)
# No prefix: accelerations are compared with standard gravity.
ACCELERATION: Final = "m/s^2"
# Prefixes of units after a number, a slash or a bracket, or at the beginning of a text; and
# numbers that are neither parts of words and ranges nor code.
MICRO: Final = re.compile(r"(?:(?<=\d[ \xa0])|(?<=[\d/\[(])|(?<=\bin )|^)u(?=(?:[JNgmsV]|Pa)\b)")
NUMBER: Final = re.compile(r"(?<![\w.=\"'-])-?(?:\d[\d.]*(?:e-?\d+)?|inf\b)(?![\w-])")
PREFIXES: Final = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}

FONT = "font-family:system-ui,-apple-system,'Segoe UI',sans-serif"
CELL = "padding:2px 16px 2px 0;border:0;background:none;color:inherit;white-space:nowrap"
FAINT = "font-weight:normal;opacity:0.65;font-size:11px"


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve of a chart; a filled area if it has a lower edge, or separate points.

    A broad curve is pale, and remains visible behind a thin one that agrees with it, as is an area.
    """

    x: Array
    y: Array
    label: str = ""
    colour: str = COLOURS[0]
    base: Array | None = None
    broad: bool = False
    separate: bool = False


@dataclass(frozen=True)
class Mark:
    """A point of a chart with a text next to it; an open circle if it is not final."""

    x: float
    y: float
    text: str
    colour: str = COLOURS[0]
    open: bool = False


def page(name: str, description: str, *parts: str) -> str:
    """A figure and tables under a heading."""
    about = escape(description)
    heading = f'<div style="margin-bottom:4px"><b>{escape(name)}</b> {about}</div>'
    return (
        f'<div class="hertzchain" style="{FONT};font-size:13px;line-height:1.4;max-width:{WIDTH}px;'
        f'color:inherit">{heading}{"".join(parts)}</div>'
    )


def note(text: str) -> str:
    """A sentence below a figure."""
    shown = escape(text)
    return f'<div style="opacity:0.75;font-size:12px;margin-top:4px">{shown}</div>'


def escape(text: str) -> str:
    """Text for HTML with the signs of figures: 3 µs, 2 ± 1 and a minus sign, for ASCII ones."""
    text = MICRO.sub("µ", text.replace("+-", "±"))
    return escaped(NUMBER.sub(lambda each: each[0].replace("-", "\N{MINUS SIGN}"), text))


def sentence(text: str, names: Collection[str] = ()) -> str:
    """A text with a capital letter and a full stop; nothing if it is empty.

    Names of parameters remain as they are typed: those that are given, and words such as
    ``cap.mass``.
    """
    first = text.split(maxsplit=1)[0].rstrip(".,:;") if text.strip() else ""
    typed = first in names or any(each in first for each in ".[_")
    return f"{text if typed else text[:1].upper() + text[1:]}." if text else ""


def _shown(number: str) -> str:
    return escape(without_negative_zeros(number))


def numbers(values: Mapping[str, str]) -> str:
    """Numbers in rows, each below its name."""
    items = "".join(
        f'<div><dt style="{FAINT};margin:0">{escape(name)}</dt>'
        f'<dd style="margin:0;font-variant-numeric:tabular-nums">{_shown(value)}</dd></div>'
        for name, value in values.items()
    )
    return f'<dl style="display:flex;flex-wrap:wrap;gap:4px 16px;margin:4px 0">{items}</dl>'


def table(head: Iterable[str], rows: Iterable[Iterable[str]], *, numeric: bool = False) -> str:
    """A small table with a heading; numeric columns, all but the first, are aligned right."""

    def cell(tag: str, column: int, text: str, style: str) -> str:
        side = "right" if numeric and column else "left"
        return f'<{tag} style="{CELL};text-align:{side};{style}">{_shown(text)}</{tag}>'

    top = "".join(cell("th", i, text, FAINT) for i, text in enumerate(head))
    cells = (
        "".join(cell("td", i, text, "font-variant-numeric:tabular-nums")
                for i, text in enumerate(row))
        for row in rows
    )  # fmt: skip
    lines = "".join(f'<tr style="background:none">{row}</tr>' for row in cells)
    return (
        '<div style="overflow-x:auto"><table style="border-collapse:collapse;border:0;'
        f'margin:4px 0;font-size:13px"><tr style="background:none">{top}</tr>{lines}</table></div>'
    )


def legend(entries: Iterable[tuple[str, str]]) -> str:
    """Coloured squares, each with its text."""
    spans = (
        f'<span style="white-space:nowrap;margin-right:14px"><span style="display:inline-block;'
        f'width:10px;height:10px;border-radius:2px;background:{colour};margin-right:5px"></span>'
        f"{escape(text)}</span>"
        for text, colour in entries
    )
    return f'<div style="font-size:12px;margin:2px 0 2px {MARGINS[0]}px">{"".join(spans)}</div>'


def engineering(value: float, unit: str, units: str = "SI") -> str:
    """A number with four digits; in SI units with its unit and a prefix."""
    if units != "SI":
        return f"{value:.4g}"
    if unit == ACCELERATION:
        return f"{without_exponent(value)} {unit}"
    value, unit = 1e3 ** _kilos(unit) * value, unit.removeprefix("k" * _kilos(unit))
    power = _power_of(abs(value))
    return f"{value / 10.0**power:.4g} {PREFIXES[power]}{unit}"


def axis_unit(values: Array, unit: str, units: str) -> tuple[float, str]:
    """Factor and unit, in brackets, of the values on an axis."""
    if units != "SI":
        return 1.0, ""
    if unit == ACCELERATION:
        return 1.0, f" [{unit}]"
    thousand, unit = 1e3 ** _kilos(unit), unit.removeprefix("k" * _kilos(unit))
    power = _power_of(thousand * float(np.nanmax(np.abs(values), initial=0.0)))
    return thousand * 10.0**-power, f" [{PREFIXES[power]}{unit}]"


def _kilos(unit: str) -> int:
    """1 for units of mass, such as kg/s, whose prefixes are those of the gram; otherwise 0."""
    return int(unit.startswith("kg"))


def _power_of(size: float) -> int:
    if not 0.0 < size < math.inf:
        return 0
    return int(np.clip(3 * math.floor(math.log10(size) / 3.0 + 1e-9), -12, 9))


def svg(content: str, height: float, title: str) -> str:
    """An SVG figure as wide as the text."""
    return (
        f'<svg viewBox="0 0 {WIDTH} {height:g}" width="{WIDTH}" role="img" '
        f'style="max-width:100%;height:auto;display:block" font-size="11" fill="currentColor">'
        f"<title>{escape(title)}</title>{content}</svg>"
    )


@dataclass(frozen=True)
class _Frame:
    """Ranges of a chart, and the conversion of values to positions."""

    begin: float
    end: float
    low: float
    high: float
    height: int
    log: bool
    whole: bool

    @property
    def floor(self) -> int:
        return self.height - MARGINS[3]

    def across(self, x: ArrayLike) -> Array:
        left, right, _, _ = MARGINS
        part = (np.asarray(x, float) - self.begin) / (self.end - self.begin)
        return np.asarray(left + (WIDTH - left - right) * part)

    def up(self, y: ArrayLike) -> Array:
        values = np.asarray(y, float)
        if self.log:
            with np.errstate(divide="ignore", invalid="ignore"):
                values = np.where(values > 0.0, np.log10(values), np.nan)
        part = (values - self.low) / (self.high - self.low)
        return np.asarray(self.floor - (self.floor - MARGINS[2]) * part)


def chart(
    curves: Sequence[Curve],
    x_label: str,
    y_label: str,
    *,
    marks: Sequence[Mark] = (),
    log: bool = False,
    whole: bool = False,
    zero: bool = True,
    height: int = 190,
) -> str:
    """Curves over one axis, with whole numbers if ``whole``, as an SVG figure.

    The vertical axis begins at 0 unless ``zero`` is false.
    """
    edges = [edge for curve in curves for edge in (curve.y, curve.base) if edge is not None]
    values = np.concatenate([*edges, [mark.y for mark in marks]])
    values = values[np.isfinite(values) & ((values > 0.0) | (not log))]
    if not len(values):
        return note("There is nothing to draw.")
    begin = min(curve.x[0] for curve in curves)
    end = max(*(curve.x[-1] for curve in curves), *(mark.x for mark in marks), begin)
    low, high = _limits(values, log=log, zero=zero)
    end = float(end) if end > begin else float(begin) + 1.0
    frame = _Frame(float(begin), end, low, high, height, log, whole)
    parts = [
        _axes(frame, x_label, y_label),
        *(_curve(curve, frame) for curve in curves),
        *(_mark(mark, frame) for mark in marks),
    ]
    return svg("".join(parts), height, f"{y_label} over {x_label}")


def _limits(values: Array, *, log: bool, zero: bool = True) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    if log:
        low, high = math.floor(math.log10(low)), math.ceil(math.log10(high))
        return low, max(high, low + 1.0)
    if zero or low <= 0.0:
        low, high = min(low, 0.0), max(high, 0.0)
    room = 0.06 * (high - low) or 1.0
    return (low if low == 0.0 else low - room), high + room


def ticks(low: float, high: float, most: int = 6, *, whole: bool = False) -> list[float]:
    """Round numbers between two others, with at most ``most`` steps and more than half as many."""
    raw = max((high - low) / most, 1.0 if whole else 0.0)
    power = 10.0 ** math.floor(math.log10(raw))
    steps = (each * power for each in (1.0, 2.0, 2.5, 5.0, 10.0))
    step = next(s for s in steps if s >= 0.999 * raw and not (whole and s % 1.0))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [step * i for i in range(first, last + 1)]


def _axes(frame: _Frame, x_label: str, y_label: str) -> str:
    left, right, _, _ = MARGINS
    parts = []
    for level, name in _levels(frame):
        y = float(frame.up(level))
        parts.append(
            f'<path d="M{left} {y:.1f}H{WIDTH - right}" stroke="currentColor" opacity="0.13"/>'
            f'<text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end">{escape(name)}</text>'
        )
    for x in ticks(frame.begin, frame.end, 8, whole=frame.whole):
        place, value = float(frame.across(x)), escape(f"{x:.4g}")
        parts.append(
            f'<path d="M{place:.1f} {frame.floor}v4" stroke="currentColor" opacity="0.5"/>'
            f'<text x="{place:.1f}" y="{frame.floor + 15}" text-anchor="middle">{value}</text>'
        )
    middle = (left + WIDTH - right) // 2
    parts.append(
        f'<path d="M{left} {frame.floor}H{WIDTH - right}" stroke="currentColor" opacity="0.5"/>'
        f'<text x="{middle}" y="{frame.height - 4}" text-anchor="middle">{escape(x_label)}</text>'
        f'<text transform="translate(10 {frame.floor // 2}) rotate(-90)" text-anchor="middle">'
        f"{escape(y_label)}</text>"
    )
    return "".join(parts)


def _levels(frame: _Frame) -> list[tuple[float, str]]:
    """Values at which the vertical axis has a line, and their names."""
    if not frame.log:
        # Numbers need 13 px each.
        levels = ticks(frame.low, frame.high, min(6, (frame.floor - MARGINS[2]) // 13))
        return [(level, re.sub(r"e\+?(-?)0*", r"e\1", f"{level:.4g}")) for level in levels]
    step = max(1, math.ceil((frame.high - frame.low) / 5.0))
    powers = range(int(frame.low), int(frame.high) + 1, step)
    # Few powers of ten: their multiples have numbers, too.
    multiples = (1, 2, 5) if frame.high - frame.low <= FEW_POWERS else (1,)
    shown = [(each, p) for p in powers for each in multiples if each == 1 or p < frame.high]
    return [
        (each * 10.0**p, f"{each * 10.0**p:g}" if -4 < p < 5 else f"{each}e{p}")
        for each, p in shown
    ]


def _curve(curve: Curve, frame: _Frame) -> str:
    if curve.base is not None:
        kept = np.unique(np.linspace(0, len(curve.x) - 1, AREA_COLUMNS).astype(int))
        x = frame.across(curve.x[kept])
        upper = _points(x, frame.up(curve.y[kept]))
        lower = _points(x[::-1], frame.up(curve.base[kept][::-1]))
        opacity = 0.25 if curve.broad else 0.8
        return f'<path d="M{upper}L{lower}Z" fill="{curve.colour}" fill-opacity="{opacity}"/>'
    if curve.separate:
        x, y = frame.across(curve.x), frame.up(curve.y)
        points = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(x, y, strict=True) if np.isfinite(b))
        return (
            f'<path d="{points}" fill="none" stroke="{curve.colour}" stroke-width="2.4" '
            'stroke-linecap="round"/>'
        )
    x, y = thinned(frame.across(curve.x), frame.up(curve.y))
    pieces = np.split(np.arange(len(x)), np.flatnonzero(~np.isfinite(y)))
    runs = [piece[np.isfinite(y[piece])] for piece in pieces]
    dots = ""
    if len(x) <= MAX_DOTS:
        dots = "".join(
            f'<circle cx="{a:.1f}" cy="{b:.1f}" r="2.4" fill="{curve.colour}"/>'
            for a, b in zip(x, y, strict=True) if np.isfinite(b)
        )  # fmt: skip
    # A single point is a line of no length, with round ends.
    path = "".join(
        f"M{_points(x[run], y[run])}" + "h0" * (len(run) == 1) for run in runs if len(run)
    )
    width = 'stroke-width="4" stroke-opacity="0.5"' if curve.broad else 'stroke-width="1.6"'
    return (
        f'<path d="{path}" fill="none" stroke="{curve.colour}" {width} '
        f'stroke-linejoin="round" stroke-linecap="round"/>{dots}'
    )


def thinned(x: Array, y: Array, columns: int = COLUMNS) -> tuple[Array, Array]:
    """Lowest and highest point of each column of a figure, in their order."""
    if len(x) <= 2 * columns:
        return x, y
    kept = {0, len(x) - 1}
    for part in np.array_split(np.arange(len(x)), columns):
        known = part[np.isfinite(y[part])]
        if len(known):
            kept |= {int(known[np.argmin(y[known])]), int(known[np.argmax(y[known])])}
        if len(known) < len(part):
            kept.add(int(part[np.argmin(np.isfinite(y[part]))]))
    order = sorted(kept)
    return x[order], y[order]


def _points(x: Array, y: Array) -> str:
    return "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y, strict=True))


def _mark(mark: Mark, frame: _Frame) -> str:
    x, y = float(frame.across(mark.x)), float(frame.up(mark.y))
    fill = "none" if mark.open else mark.colour
    side, anchor = (-8, "end") if x > 0.7 * WIDTH else (8, "start")
    # Above the curve, unless the mark is at the top.
    down = 4 if y < MARGINS[2] + 16 else -6
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{fill}" stroke="{mark.colour}" '
        f'stroke-width="1.6"/><text x="{x + side:.1f}" y="{y + down:.1f}" text-anchor="{anchor}">'
        f"{escape(mark.text)}</text>"
    )
