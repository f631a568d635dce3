"""A sketch of the row of a laboratory sheet, to be printed: balls to scale, sensors in grey."""

from __future__ import annotations

from html import escape
from typing import Final

import numpy as np

from ..chain.bead_names import bead_number
from ..chain.chain import Chain
from ..chain.drawn_bodies import body_centres, flat_bodies, half_heights, half_widths
from .kinds import is_column
from .row import place_in_words
from .sheet import WALL, LabSheet

# Sizes in units of the SVG figure, which is as wide as the page.
WIDTH: Final = 640.0
LARGEST_RADIUS: Final = 20.0
TEXT: Final = 13.0
# Room for the arrow of the striker on the left, and for the wall and its name on the right.
LEFT, RIGHT, WALL_WIDTH = 34.0, 40.0, 12.0
# Length of a column with its margins, and width of the names beside it.
COLUMN, NAMES = 330.0, 80.0
# Longer rows would be a line.
MAX_BODIES: Final = 120


def sketch(sheet: LabSheet) -> str:
    """The row as an SVG figure, a column from top to bottom; empty for a row that is too long."""
    chain = sheet.chain
    if chain.beads > MAX_BODIES:
        return ""
    if is_column(chain):
        return _column(sheet)
    places, widths, heights = body_centres(chain), half_widths(chain), half_heights(chain)
    length = float(places[-1] + widths[-1])
    scale = min((WIDTH - LEFT - RIGHT) / length, LARGEST_RADIUS / float(heights.max()))
    begin = LEFT + 0.5 * (WIDTH - LEFT - RIGHT - scale * length)
    centres, tall = begin + scale * places, scale * float(heights.max())
    middle = TEXT + tall + 6.0
    names = _names(sheet, centres, begin + scale * length)
    content = "".join([
        _arrow(chain, centres, scale * widths, middle),
        _bodies(sheet, centres, (scale * widths, scale * heights), middle),
        _wall(chain, begin + scale * length, tall, middle),
        *(_text(name, x, middle + (tall + TEXT + 1.0 if i % 2 == 0 else -tall - 5.0))
          for i, (x, name) in enumerate(names)),
    ])  # fmt: skip
    return _figure(sheet, "row", WIDTH, middle + tall + TEXT + 6.0, content)


def _figure(sheet: LabSheet, kind: str, width: float, height: float, content: str) -> str:
    """A figure with its title."""
    chain = sheet.chain
    words = f"The {kind} with {chain.strikers or 'no'} striker{'s' * (chain.strikers != 1)}; "
    places = ", ".join(place_in_words(chain, place) for place in sheet.places)
    return (
        f'<svg class="{kind}" viewBox="0 0 {width:g} {height:.1f}" role="img" '
        f'font-size="{TEXT:g}"><title>{escape(f"{words}sensors: {places}")}</title>{content}</svg>'
    )


def _column(sheet: LabSheet) -> str:
    """A column that is struck from above: the row turned by 90 degrees, with names beside it."""
    chain = sheet.chain
    places, widths, heights = body_centres(chain), half_widths(chain), half_heights(chain)
    length = float(places[-1] + widths[-1])
    scale = min((COLUMN - LEFT - RIGHT) / length, LARGEST_RADIUS / float(heights.max()))
    centres, tall, end = LEFT + scale * places, scale * float(heights.max()), LEFT + scale * length
    # The axis of the row is turned to x = 0, and its beginning to the top.
    drawn = "".join([
        _arrow(chain, centres, scale * widths, 0.0),
        _bodies(sheet, centres, (scale * widths, scale * heights), 0.0),
        _wall(chain, end, tall, 0.0),
    ])  # fmt: skip
    axis = tall + 6.0
    names = "".join(
        f'<text x="{axis + tall + 6.0:.1f}" y="{y + 0.35 * TEXT:.1f}">{escape(name)}</text>'
        for y, name in _names(sheet, centres, end)
    )
    content = f'<g transform="translate({axis:.1f} 0) matrix(0 1 1 0 0 0)">{drawn}</g>{names}'
    return _figure(sheet, "column", axis + tall + NAMES, end + WALL_WIDTH + 4.0, content)


def _bodies(
    sheet: LabSheet, centres: np.ndarray, sizes: tuple[np.ndarray, np.ndarray], middle: float
) -> str:
    """Circles, and plates for flat bodies; those with sensors are grey."""
    chain = sheet.chain
    sensors = {bead_number(chain, place) - 1 for place in sheet.places if place != WALL}
    flat, found = flat_bodies(chain), []
    for k, (x, r, h) in enumerate(zip(centres, *sizes, strict=True)):
        style = f'fill="{"#999" if k in sensors else "#fff"}" stroke="#1a1a1a"/>'
        plate = f'x="{x - r:.1f}" y="{middle - h:.1f}" width="{2 * r:.1f}" height="{2 * h:.1f}"'
        circle = f'cx="{x:.1f}" cy="{middle:.1f}" r="{max(r - 0.5, 0.5):.2f}"'
        found.append(f"<rect {plate} {style}" if flat[k] else f"<circle {circle} {style}")
    return "".join(found)


def _arrow(chain: Chain, centres: np.ndarray, widths: np.ndarray, middle: float) -> str:
    """The direction of the striker, in front of it."""
    moving = np.flatnonzero(chain.velocities > 0.0)
    if not len(moving) or moving[0] > 0:
        return ""
    end = float(centres[0] - widths[0]) - 4.0
    return (
        f'<path d="M{end - 24.0:.1f} {middle:.1f}H{end:.1f}m-7 -4l7 4l-7 4" fill="none" '
        'stroke="#1a1a1a"/>'
    )


def _wall(chain: Chain, at: float, tall: float, middle: float) -> str:
    """The wall or load cell behind the row."""
    if chain.right_wall is None:
        return ""
    return (
        f'<rect x="{at + 1.0:.1f}" y="{middle - tall - 2.0:.1f}" width="{WALL_WIDTH:g}" '
        f'height="{2.0 * tall + 4.0:.1f}" fill="#555"/>'
    )


def _names(sheet: LabSheet, centres: np.ndarray, end: float) -> list[tuple[float, str]]:
    """Positions and names of the striker, of the sensors and of the wall, from left to right."""
    chain, found = sheet.chain, []
    first = [(float(centres[0]), "striker")] if chain.strikers == 1 else []
    for place in sheet.places:
        if place != WALL:
            x = float(centres[bead_number(chain, place) - 1])
            found.append((x, place_in_words(chain, place)))
    if chain.right_wall is not None:
        found.append((end + 1.0 + 0.5 * WALL_WIDTH, place_in_words(chain, WALL)))
    return first + [(x, name.removeprefix("the ")) for x, name in sorted(found)]


def _text(text: str, x: float, y: float) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="middle">{escape(text)}</text>'
