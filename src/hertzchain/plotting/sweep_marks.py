"""Mark points of sweeps whose values are subject to a reservation, or that have none."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import ListedColormap
from matplotlib.patheffects import withStroke

from ..collision import Array
from .colours import grey
from .legends import place_legend_below
from .sweep_axes import edges_of, places_of
from .widths import NARROW, figure_size

if TYPE_CHECKING:
    import xarray as xr

# Total area of the markers of all cells of a map, in square points.
MARKED_AREA: Final = 9000.0
# Largest area of one of them, which those of the legend have, in square points.
LEGEND_AREA: Final = 24.0
# Area of the frame of a cell, inside which another marker is visible, relative to that of others.
FRAME: Final = 3.0
# Number of marked cells of a kind from which they are hatched and outlined, and the two widths of
# their lines: white on black, which is visible on each colour.
MANY: Final = 50
# Part of the background in the grey of filled cells.
FILLING: Final = 0.75
STROKES: Final = (("black", 2.4), ("white", 1.0))
# The kinds that may cover much of a map: one with values, and its hatching, and one without, whose
# cells are grey, since small marks beside each other would be lines.
HATCHED, HATCH, FILLED = "outside_range", "///", "missing"
# Longest line of the legend of a narrow figure.
LEGEND_LINE: Final = 32


@dataclass(frozen=True)
class _Look:
    """Label and markers of one kind of points, in maps and, if they have values, on curves."""

    label: str
    cell: dict[str, Any]
    curve: dict[str, Any] = field(default_factory=dict)
    frame: bool = False


_RING: Final[dict[str, Any]] = {"markersize": 8.0, "markerfacecolor": "none", "linestyle": "none"}
# In the order of the legend.
LOOKS: Final = MappingProxyType({
    "failed": _Look("failed", {"marker": "x", "linewidths": 1.0}),
    "missing": _Look("missing, not computed yet", {"marker": "_", "linewidths": 1.0}),
    "incomplete": _Look(
        "not complete", {"marker": "+", "linewidths": 1.0}, {**_RING, "marker": "D"}
    ),
    "outside_range": _Look(
        "outside the range of the method",
        {"marker": "o", "c": "white", "edgecolors": "black", "linewidths": 0.5},
        {"marker": "o", "alpha": 0.3, "markersize": 8.0, "markeredgecolor": "none",
         "linestyle": "none"},
    ),
    # White on black, which is visible on each colour, and open, since other markers may be inside.
    "sensitive": _Look(
        "may be sensitive to small changes",
        {"marker": "s", "facecolors": "none", "edgecolors": "white", "linewidths": 1.0,
         "path_effects": [withStroke(linewidth=2.4, foreground="black")]},
        {**_RING, "marker": "s"}, frame=True,
    ),
})  # fmt: skip


def mark_label(kind: str, *, law: bool) -> str:
    """Label of a kind of marks; scaled chains have no range of Hertz's law."""
    text = LOOKS[kind].label
    if kind == "outside_range" and law:
        text += " or of Hertz's law"
    return textwrap.fill(text, LEGEND_LINE) if figure_size(NARROW, 1.0)[0] < NARROW else text


def mark_cells(
    axes: Axes, drawn: xr.DataArray, flags: Mapping[str, xr.DataArray], *, law: bool, own: bool
) -> None:
    """Mark the flagged cells of a map, and explain the markers below the axes."""
    down, across = drawn.dims[1], drawn.dims[0]
    x, y = np.meshgrid(places_of(drawn[across]), places_of(drawn[down]))
    size = min(LEGEND_AREA, MARKED_AREA / drawn.size)
    for kind, look in LOOKS.items():
        if kind not in flags:
            continue
        there = flags[kind].transpose(down, across).to_numpy().astype(bool)
        colour: dict[str, Any] = (
            {} if {"c", "edgecolors"} & look.cell.keys() else {"c": grey(axes, 0.1)}
        )
        if kind == HATCHED and there.sum() > MANY:
            edges = edges_of(drawn[across]), edges_of(drawn[down])
            _outline(axes, *edges, there, mark_label(kind, law=law))
        elif kind == FILLED and there.sum() > MANY:
            edges = edges_of(drawn[across]), edges_of(drawn[down])
            _fill(axes, *edges, there, mark_label(kind, law=law))
        elif there.any():
            axes.scatter(x[there], y[there], size * (FRAME if look.frame else 1.0), zorder=3.0,
                         label=mark_label(kind, law=law), **look.cell, **colour)  # fmt: skip
    if axes.get_legend_handles_labels()[1]:
        legend = place_legend_below(axes, own=own)
        # Markers of many cells are small; those of the legend are legible.
        for handle in legend.legend_handles:
            if isinstance(handle, PathCollection):
                handle.set_sizes([LEGEND_AREA])


def _fill(axes: Axes, x: Array, y: Array, there: Array, label: str) -> None:
    """Fill marked cells, with given edges of cells, in grey, which no value has."""
    shown = np.ma.masked_where(~there, np.zeros(there.shape))
    colour = grey(axes, FILLING)
    axes.pcolormesh(x, y, shown, cmap=ListedColormap([colour]), zorder=2.5, rasterized=True)
    # For the legend.
    axes.fill([], [], facecolor=colour, edgecolor="none", label=label)


def _outline(axes: Axes, x: Array, y: Array, there: Array, label: str) -> None:
    """Outline the region of marked cells, with given edges of cells, and hatch it."""
    shown = np.ma.masked_where(~there, np.zeros(there.shape))
    axes.pcolor(x, y, shown, facecolor="none", edgecolor=grey(axes, 0.6), linewidth=0.0,
                hatch=HATCH, zorder=2.5)  # fmt: skip
    padded = np.pad(there, 1).astype(int)
    lines = [
        ((x[i], y[j]), (x[i], y[j + 1])) for j, i in np.argwhere(np.diff(padded[1:-1], axis=1))
    ] + [((x[i], y[j]), (x[i + 1], y[j])) for j, i in np.argwhere(np.diff(padded[:, 1:-1], axis=0))]
    for colour, width in STROKES:
        axes.add_collection(
            LineCollection(lines, colors=colour, linewidths=width, capstyle="round", zorder=3.0),
            autolim=False,
        )
    # For the legend.
    axes.fill([], [], facecolor="none", edgecolor=grey(axes, 0.6), hatch=HATCH, label=label)


def mark_curve(
    axes: Axes, places: Any, curve: xr.DataArray, flags: Mapping[str, xr.DataArray], colour: str,
    every: int = 1,
) -> list[str]:  # fmt: skip
    """Mark the flagged points of a curve in its colour, and return the kinds of marks.

    Of long rows of flagged points, only the ends and those with a symbol, ``every`` so many, are
    marked: pale markers that overlap would be black.
    """
    known = curve.notnull().to_numpy()
    shown = {
        kind: flags[kind].to_numpy().astype(bool) & known
        for kind, look in LOOKS.items() if look.curve and kind in flags
    }  # fmt: skip
    found = [kind for kind, flagged in shown.items() if flagged.any()]
    for kind in found:
        there = _thinned(shown[kind], every)
        axes.plot(places[there], curve[there], color=colour, **LOOKS[kind].curve)
    return found


def _thinned(flagged: Array, every: int) -> Array:
    """Flagged points with a symbol, and the ends of each row of flagged points."""
    padded = np.concatenate(([False], flagged, [False]))
    ends = ~(padded[:-2] & padded[2:])
    found: Array = flagged & (ends | (np.arange(flagged.size) % every == 0))
    return found


def label_marks(axes: Axes, marked: Mapping[str, set[str]], *, law: bool) -> None:
    """One entry of the legend for each kind: in the colour of the marked curve, or in grey."""
    for kind, look in LOOKS.items():
        if colours := marked.get(kind, set()):
            label = mark_label(kind, law=law)
            # That of curves which the axes already had.
            others = remove_labelled(axes, label)
            one = grey(axes, 0.4) if others or len(colours) > 1 else next(iter(colours))
            axes.plot([], [], color=one, label=label, **look.curve)


def remove_labelled(axes: Axes, label: str) -> bool:
    """Remove entries of the legend with this label and without data; whether there were any."""
    found = [
        line for line in axes.lines if line.get_label() == label and not np.size(line.get_xdata())
    ]
    for line in found:
        line.remove()
    return bool(found)
