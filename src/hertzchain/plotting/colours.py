"""Colours of curves and maps, also on the dark background of a style of the user."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba

from ..collision import Array

# Colours of Okabe and Ito, which colour-blind readers can distinguish; markers repeat the
# distinction for prints in grey.
COLOURS: Final = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
# Colour of curves with the number -1.
GREY: Final = "#808080"
# Brightness of red, green and blue.
WEIGHTS: Final = (0.299, 0.587, 0.114)
# Values of the other sign that are at most this part of the largest are not given colours.
ONE_SIGN: Final = 0.01


def is_dark(axes: Axes) -> bool:
    """Whether the background is dark, on which black lines would be invisible."""
    patches = [axes.patch, axes.figure.patch]
    return _dark([each.get_facecolor() for each in patches if each.get_visible()])


def style_is_dark() -> bool:
    """Whether the background of new axes is dark."""
    return _dark([rcParams["axes.facecolor"], rcParams["figure.facecolor"]])


def _dark(backgrounds: list[Any]) -> bool:
    for colour in backgrounds:
        if to_rgba(colour)[3] > 0.5:
            return _brightness(colour) < 0.5
    # Text is visible on what is behind transparent figures.
    return _brightness(rcParams["text.color"]) > 0.5


def _brightness(colour: Any) -> float:
    return float(np.dot(WEIGHTS, to_rgba(colour)[:3]))


def grey(axes: Axes, level: float = 0.0) -> str:
    """A grey from 0, black, to 1; on a dark background, the opposite one."""
    return f"{1.0 - level if is_dark(axes) else level:g}"


def colour_of(i: int) -> str:
    """Colour of curve i on a light background."""
    return GREY if i < 0 else COLOURS[i % len(COLOURS)]


def curve_colour(axes: Axes, i: int) -> str:
    """Colour of curve i; number 0 is white on a dark background."""
    colour = colour_of(i)
    return "#FFFFFF" if colour == COLOURS[0] and is_dark(axes) else colour


def number_of_curves(axes: Axes) -> int:
    """Number of labelled curves that the axes already have; symbols without a line are none."""
    return sum(
        line.get_linestyle() != "None" and not str(line.get_label()).startswith("_")
        for line in axes.lines
    )


def free_numbers(axes: Axes, begin: int, count: int) -> list[int]:
    """Numbers of further curves from a first one: first those whose colour no curve has."""
    taken = {to_rgba(line.get_color()) for line in axes.lines if line.get_linestyle() != "None"}
    numbers = range(begin, begin + len(COLOURS) + count)
    free = [i for i in numbers[: len(COLOURS)] if to_rgba(curve_colour(axes, i)) not in taken]
    return [*free, *(i for i in numbers if i not in free)][:count]


def signed_map(values: Array) -> tuple[str, float, float]:
    """Colour map and limits for values around 0: diverging only if both signs occur."""
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    largest = max(abs(low), abs(high))
    if low >= -ONE_SIGN * largest:
        return "Reds", 0.0, largest
    if high <= ONE_SIGN * largest:
        return "Blues_r", -largest, 0.0
    return "RdBu_r", -largest, largest
