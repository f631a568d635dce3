"""Symbols of last beads at free ends, which no line joins to those of the other beads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.markers import MarkerStyle
from matplotlib.path import Path

from .alternating_beads import END_SYMBOL
from .colours import grey
from .style import MARKERS

# Label of the symbols, and that of symbols beyond the axes, which the legend does not list; the
# largest number of symbols beside it.
FREE_END: Final = "last bead (free end)"
UNLISTED: Final = f"_{FREE_END}"
# Label of a symbol of a method that neglects the free end.
CONTINUED: Final = "_last bead, as if the chain continued"
MOST_SYMBOLS: Final = 3
# Distance of their centres, in units of their size.
DISTANCE: Final = 1.6
# Free ends that would make an axis of differences longer by this factor are not on it.
LONGER: Final = 1.5
# Size of a star, relative to other symbols, and growth of those of later curves, which are behind
# those of earlier ones, up to a largest size.
STAR: Final = 1.5
GROWTH, MAX_SIZE = 0.8, 2.6
FILLED: Final = tuple(each for each in MARKERS if each in Line2D.filled_markers)
# Width [points] of the edge around a symbol.
PALE_EDGE: Final = 0.6
# A symbol of a bead beyond the axis is named this far [points] from the edge.
EDGE: Final = 2.0


def label_free_end(axes: Axes) -> None:
    """Explain the symbols at free ends in the legend, beside those that are drawn."""
    drawn = [line.get_marker() for line in _symbols(axes) if line.get_label() != CONTINUED]
    known = [each for each in (*MARKERS, END_SYMBOL) if each in drawn]
    shown = known[:MOST_SYMBOLS] or [MARKERS[0]]
    style: dict[str, Any] = {"color": grey(axes, 0.4), "label": FREE_END}
    if len(shown) == 1:
        axes.plot([], [], **style, **end_style(shown[0]))
        return
    axes.plot([], [], **style, **row_style(shown), linestyle="none")


def unlist_hidden_ends(axes: Axes) -> None:
    """Remove the label from the legend if all symbols of free ends are beyond the limits."""
    low, high = sorted(axes.get_ylim())
    values = [value for line in _symbols(axes) for value in np.ravel(line.get_ydata())]
    if values and not any(low <= value <= high for value in values):
        for line in axes.lines:
            if line.get_label() == FREE_END:
                line.set_label(UNLISTED)


def _symbols(axes: Axes) -> list[Line2D]:
    return [
        line for line in axes.lines
        if line.get_linestyle() == "None" and np.size(line.get_xdata()) == 1
    ]  # fmt: skip


def end_style(marker: str, symbol: int = 0) -> dict[str, Any]:
    """Filled symbol of a free end, as arguments of `Axes.plot`; ``symbol`` counts stars from 0.

    At nearly the same value, the filled symbol of a later curve surrounds that of an earlier one.
    """
    rank = symbol if marker == END_SYMBOL else FILLED.index(marker) if marker in FILLED else -1
    size = (STAR if marker == END_SYMBOL else 1.0) * min(1.0 + GROWTH * max(rank, 0), MAX_SIZE)
    style = {
        "marker": marker, "linestyle": "none", "zorder": 2.5 - 0.01 * rank,
        "markersize": rcParams["lines.markersize"] * size,
    }  # fmt: skip
    if rank < 0:
        return style
    # A pale edge separates symbols of one colour.
    return {
        **style,
        "markeredgecolor": rcParams["axes.facecolor"],
        "markeredgewidth": PALE_EDGE,
    }


def open_style(marker: str) -> dict[str, Any]:
    """Symbol of a method that neglects the free end, as arguments of `Axes.plot`."""
    return {"marker": marker, "linestyle": "none", "markerfacecolor": "none", "zorder": 2.51}


def row_style(markers: Sequence[str]) -> dict[str, Any]:
    """Several symbols beside each other, as arguments of `Axes.plot`."""
    size = rcParams["lines.markersize"] * (1.0 + DISTANCE * (len(markers) - 1))
    return {"marker": _row(markers), "markersize": size}


def _row(markers: Sequence[str]) -> Path:
    """Several symbols beside each other, as one symbol."""
    paths = []
    for i, marker in enumerate(markers):
        style = MarkerStyle(marker)
        path = style.get_path().transformed(style.get_transform())
        shift = [DISTANCE * (i - 0.5 * (len(markers) - 1)), 0.0]
        paths.append(Path(np.asarray(path.vertices, float) + shift, path.codes))
    return Path.make_compound_path(*paths)


def draw_end_outside_limits(
    axes: Axes, bead: int, value: float, style: Mapping[str, Any], colour: Any
) -> tuple[int, float]:
    """A symbol of a difference [%], which does not yet determine the limits."""
    limits = axes.dataLim.get_points().copy()
    axes.plot([bead], [value], color=colour, **style)
    axes.dataLim.set_points(limits)
    return bead, value


def include_ends(axes: Axes, ends: Sequence[tuple[int, float]], *, linear: bool) -> None:
    """Include the beads and differences of free ends in the limits, or name distant ones.

    On a linear axis, a large difference of the last bead would hide those of the others.
    """
    if not ends:
        return
    beads, values = (np.array(each) for each in zip(*ends, strict=True))
    (left, low), (right, high) = axes.dataLim.get_points()
    right, lowest, highest = max(right, *beads), min(low, *values), max(high, *values)
    beyond = linear and 0.0 < LONGER * (high - low) < highest - lowest
    if not beyond:
        low, high = lowest, highest
    axes.dataLim.set_points(np.array([[left, low], [right, high]]))
    axes.autoscale_view()
    bottom, top = axes.get_ylim()
    hidden = [round(value) for value in values if not bottom <= value <= top]
    if beyond and hidden:
        _name(axes, min(hidden), max(hidden), below=min(hidden) < bottom)


def _name(axes: Axes, least: int, most: int, *, below: bool) -> None:
    span = f"{least}%" if least == most else f"{least} to {most}%"
    axes.annotate(
        f"free end: {span}".replace("-", "\N{MINUS SIGN}"),
        (1.0, 0.0 if below else 1.0), (-EDGE, EDGE if below else -EDGE),
        xycoords="axes fraction", textcoords="offset points", fontsize="small",
        ha="right", va="bottom" if below else "top", color=grey(axes, 0.4),
    )  # fmt: skip
