"""Lines of power laws, with which curves of a sweep are compared."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ..collision import Array
from ..errors import InputError, short_repr
from ..validation.numbers import number
from .colours import grey

# Factor of a line over the curve at its middle, so that the curve does not hide it.
ABOVE: Final = 1.25
# Number of points: on linear axes, power laws are curved.
POINTS: Final = 101
# Lines of several slopes differ.
DASHES: Final = ((0, (5, 3)), (0, (1, 2)), (0, (7, 2, 1, 2)))


def slopes_from(given: Any) -> list[tuple[float, str]]:
    """Exponents and their texts from a number, a fraction as text, or a list of these."""
    items = [given] if isinstance(given, str | int | float) or not hasattr(given, "__iter__") else [
        *given]  # fmt: skip
    return [_slope(each) for each in items]


def _slope(given: Any) -> tuple[float, str]:
    if isinstance(given, str) and "/" in given:
        try:
            return float(Fraction(given.replace(" ", ""))), given.replace(" ", "")
        except (ValueError, ZeroDivisionError):
            raise InputError(
                f"slope must be a number or a fraction such as '6/5', got {short_repr(given)}"
            ) from None
    value = number("slope", given)
    return value, f"{value:g}"


def draw_slopes(axes: Axes, curves: Sequence[Line2D], slopes: Sequence[tuple[float, str]]) -> None:
    """Draw dashed lines of power laws above the middle of the first curve with positive values."""
    for i, (slope, words) in enumerate(slopes):
        x, y = _first_curve(curves)
        places = np.geomspace(x.min(), x.max(), POINTS)
        middle = np.exp(np.log(y).mean() - slope * np.log(x).mean())
        axes.plot(places, ABOVE * middle * places**slope, color=grey(axes, 0.45), linewidth=0.8,
                  linestyle=DASHES[i % len(DASHES)], zorder=1.5, label=f"slope {words}",
                  scalex=False)  # fmt: skip


def _first_curve(curves: Sequence[Line2D]) -> tuple[Array, Array]:
    """Positive points of the first curve that has at least two of them."""
    for line in curves:
        x, y = (np.asarray(each, dtype=float) for each in (line.get_xdata(), line.get_ydata()))
        good = (x > 0.0) & (y > 0.0) & np.isfinite(y)
        if good.sum() > 1:
            return x[good], y[good]
    raise InputError(
        "a slope requires a curve with positive values over a positive parameter; omit slope"
    )
