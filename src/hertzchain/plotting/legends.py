"""Place legends where they cover no data."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.collections import Collection, PathCollection
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.transforms import Bbox, ScaledTranslation

from .legend_columns import NOTHING, in_whole_groups

# Corners first.
PLACES: Final = (
    "upper right", "upper left", "lower left", "lower right", "center left", "center right",
    "upper center", "lower center", "center",
)  # fmt: skip
# Distance [points] of a legend from data.
CLEARANCE: Final = 2.0
# Distance [points] of a legend from the left edge of its figure, with its own distance from axes.
EDGE: Final = 4.0
# Handles and columns of a legend above the axes, in units of the font size.
COMPACT: Final[dict[str, Any]] = {
    "handlelength": 1.6, "columnspacing": 1.2, "borderpad": 0.2, "borderaxespad": 0.3,
}  # fmt: skip
# Number of dashed curves with symbols from which handles are longer, which shows their dashes.
MANY_DASHED, LONG_HANDLE = 4, 3.0
# Width [inches] of panels below which letters are smaller, and their least size [points].
FULL_WIDTH: Final = 2.6
MIN_SIZE: Final = 5.5
# Number of labels whose letters are smaller if this makes room for two columns, and by how much.
MANY: Final = 4
SMALLER: Final = 6.0 / 7.0
# Part of the width of a panel that is certain to remain when a layout has made room for others.
ROOM: Final = 0.75
# Largest height of a legend above axes in a figure of somebody else, relative to the axes.
MAX_SHARE: Final = 0.5
# The same for a legend inside axes whose y axis becomes longer.
MAX_EXTENSION: Final = 0.6
# Distance [points] of a title from a legend, whose height varies with the resolution of a file.
TITLE_DISTANCE: Final = 8.0
ROUNDING: Final = 1.05
# Part by which the room of a legend exceeds its present size.
SPARE: Final = 1.05
# Fewest letters of a line of a legend below a narrow panel, and those as wide as its handle.
MIN_LETTERS, HANDLE_LETTERS = 12, 4
POINTS_PER_INCH: Final = 72.0


class LegendBelow(Legend):
    """A legend that may be wider than its axes without a layout that makes the axes narrower."""

    def get_tightbbox(self, renderer: Any = None) -> Bbox | None:
        """The box for which a layout makes room: no wider than the axes."""
        box, within = super().get_tightbbox(renderer), self.axes.bbox
        if box is None:
            return None
        left, right = np.clip([box.x0, box.x1], within.x0, within.x1)
        return Bbox.from_extents(left, box.y0, right, box.y1)


def place_legend(axes: Axes, *, own: bool = False, title: str = "") -> None:
    """Add a legend at a place inside the axes where it covers no data, otherwise above the axes.

    A legend above the axes is below their title, and may have its own ``title``.  A figure that was
    made for these axes becomes taller by the height of the legend, which leaves the axes their
    size.  In other figures, whose layout may change with the next panels, Matplotlib chooses the
    place again for each drawing if its choice is good; for a legend that is wider than the axes or
    has no room above them, the y axis becomes longer, unless a user set its limits or the legend
    takes most of the height: it is then where it covers least.  Legends of narrow panels have small
    letters.
    """
    if not own and axes.get_autoscaley_on():
        # A legend of curves drawn before may have made the axis longer.
        axes.autoscale_view(scalex=False)
    compact = {} if own else _compact(axes)
    if title:
        compact |= _titled(title, compact)
    if _dashed(axes) >= MANY_DASHED:
        compact["handlelength"] = LONG_HANDLE
    legend = axes.legend(loc=PLACES[0], **compact)
    # A layout would make the axes of a wide legend narrower, which remain so below it.
    legend.set_in_layout(not own)
    figure_of(axes).draw_without_rendering()
    legend.set_in_layout(True)
    width, height = legend.get_window_extent().size
    may_shrink = not own and figure_of(axes).get_layout_engine() is not None
    if width <= axes.bbox.width * (ROOM if may_shrink else 1.0) and height <= axes.bbox.height:
        for place in PLACES:
            legend.set_loc(place)
            if not covers_data(legend):
                if not own and not axes.collections and not axes.texts:
                    legend.set_loc("best")
                    if covers_data(legend):
                        legend.set_loc(place)
                return
    if not own and width > axes.bbox.width:
        compact["fontsize"] = max(compact["fontsize"] * axes.bbox.width / (SPARE * width), MIN_SIZE)
    if not _place_above(axes, compact, own=own) and not _place_in_longer_axes(axes, compact):
        # Its text stays legible on the data below it; a layout would make the axes narrower.
        axes.legend(
            loc="best",
            frameon=True,
            facecolor=axes.get_facecolor(),
            edgecolor="none",
            framealpha=0.8,
            **compact,
        ).set_in_layout(False)


def _titled(title: str, compact: dict[str, Any]) -> dict[str, Any]:
    """Settings of a title with letters of the size of the labels."""
    size = compact.get("fontsize", rcParams["legend.fontsize"])
    return {"title": title, "title_fontsize": size}


def _dashed(axes: Axes) -> int:
    """Number of dashed curves with symbols in the legend."""
    return sum(
        isinstance(each, Line2D) and each.is_dashed() and each.get_marker() not in NOTHING
        for each in axes.get_legend_handles_labels()[0]
    )


def legend_above(figure: Figure, *panels: Axes) -> None:
    """A legend of these panels above all of them."""
    found = [axes.get_legend_handles_labels() for axes in panels]
    entries = {label: handle for pair in found for handle, label in zip(*pair, strict=True)}
    for rows in range(1, len(entries) + 1):
        legend = figure.legend(entries.values(), entries.keys(), loc="outside upper right",
                               ncols=-(-len(entries) // rows), **COMPACT)  # fmt: skip
        if legend.get_window_extent().width <= figure.bbox.width:
            break
        if rows < len(entries):
            legend.remove()


def put_legend_above(axes: Axes) -> float:
    """Put the legend above axes without a title in a layout; return its height [inch]."""
    compact, present = _compact(axes), axes.get_legend()
    if present is not None and (title := present.get_title().get_text()):
        compact |= _titled(title, compact)
    _, legend = _in_columns(axes, compact, axes.bbox.width)
    return float(legend.get_window_extent().height / figure_of(axes).dpi)


def place_legend_below(axes: Axes, *, own: bool = False) -> Legend:
    """Add a legend below the label of the x axis, below the centre of the axes if there is room.

    A figure that was made for these axes becomes taller by the height of the legend.
    """
    figure = figure_of(axes)
    compact = {} if own else _compact(axes)
    figure.draw_without_rendering()
    lowest = axes.xaxis.get_tightbbox() or axes.bbox
    # In inches, because a layout or a taller figure changes the height of the axes.
    depth = (lowest.y0 - axes.bbox.y0) / figure.dpi
    below = axes.transAxes + ScaledTranslation(0.0, depth, figure.dpi_scale_trans)
    left, right = (figure.bbox.x0, figure.bbox.x1) if own else (axes.bbox.x0, axes.bbox.x1)
    place: dict[str, Any] = {
        "loc": "upper left", "bbox_transform": below,
        "bbox_to_anchor": ((left - axes.bbox.x0) / axes.bbox.width, 0.0),
    }  # fmt: skip
    handles, labels = axes.get_legend_handles_labels()
    for columns in range(len(labels), 0, -1):
        legend = axes.legend(ncols=columns, **{**COMPACT, **compact}, **place)
        width = legend.get_window_extent().width
        if width <= right - left:
            break
    else:
        # A layout would make the axes narrower.
        wrapped = _wrapped(labels, (right - left) / width)
        legend = axes.legend(handles, wrapped, **{**COMPACT, **compact}, **place)
    if own:
        width, height = legend.get_window_extent().size
        begin = np.clip(0.5 * (axes.bbox.x0 + axes.bbox.x1 - width), left, max(left, right - width))
        legend.set_bbox_to_anchor(((begin - axes.bbox.x0) / axes.bbox.width, 0.0), below)
        legend.__class__ = LegendBelow
        figure.set_figheight(figure.get_figheight() + height / figure.dpi)
    return legend


def _wrapped(labels: Sequence[str], share: float) -> list[str]:
    """Labels in lines, for a legend that has room for this share of its width."""
    room = max(MIN_LETTERS, int(max(map(len, labels)) * share) - HANDLE_LETTERS)
    return [textwrap.fill(label, room) for label in labels]


def _compact(axes: Axes) -> dict[str, Any]:
    """Short handles and, in a narrow panel, small letters."""
    size = FontProperties(size=rcParams["legend.fontsize"]).get_size_in_points()
    part = axes.bbox.width / figure_of(axes).dpi / FULL_WIDTH
    return {**COMPACT, "fontsize": max(min(1.0, part) * size, min(size, MIN_SIZE))}


def covers_data(legend: Legend) -> bool:
    """Whether curves, symbols, bars or texts of the axes are in the box of a legend."""
    axes: Axes = legend.axes
    scale = figure_of(axes).dpi / POINTS_PER_INCH
    box = legend.get_window_extent().padded(scale * CLEARANCE)
    return any(
        _meets(artist, axes, box, scale)
        for artist in axes.get_children()
        if artist.get_visible() and artist not in (legend, axes.patch)
    ) or any(
        # The swatch of a range would merge with it, and letters on it would be hard to read.
        box.overlaps(patch.get_window_extent())
        for patch in axes.patches
        if not _placed_by_data(patch, axes) and _is_explained(patch, legend)
    )


def _is_explained(patch: Patch, legend: Legend) -> bool:
    """Whether a legend has an entry for shaded ranges like this one."""
    return any(
        isinstance(handle, Patch) and handle.get_facecolor() == patch.get_facecolor()
        for handle in legend.legend_handles
    )


def _meets(artist: object, axes: Axes, box: Bbox, scale: float) -> bool:
    if isinstance(artist, Line2D):
        return _line_meets(artist, box, scale)
    if isinstance(artist, Patch):
        return _patch_meets(artist, axes, box)
    if isinstance(artist, PathCollection):
        places = artist.get_offset_transform().transform(artist.get_offsets())
        return bool(box.count_contains(places))
    if isinstance(artist, Collection):
        # Bands between two curves.
        transform = artist.get_transform()
        paths = [transform.transform_path(path) for path in artist.get_paths()]
        return any(
            path.intersects_bbox(box, filled=True) for path in paths if np.size(path.vertices)
        )
    if isinstance(artist, Text):
        return bool(artist.get_text().strip()) and bool(box.overlaps(artist.get_window_extent()))
    return False


def _line_meets(line: Line2D, box: Bbox, scale: float) -> bool:
    points = line.get_transform().transform(line.get_xydata())
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        return False
    size = line.get_markersize() if line.get_marker() not in NOTHING else 0.0
    if box.padded(0.5 * scale * size).count_contains(points):
        return True
    thick = box.padded(0.5 * scale * line.get_linewidth())
    joined = line.get_linestyle() not in NOTHING
    return joined and bool(Path(points).intersects_bbox(thick, filled=False))


def _patch_meets(patch: Patch, axes: Axes, box: Bbox) -> bool:
    """Bars and other areas; shaded ranges, which cross the whole axes, are a background."""
    return _placed_by_data(patch, axes) and bool(box.overlaps(patch.get_window_extent()))


def _placed_by_data(patch: Patch, axes: Axes) -> bool:
    return bool(patch.get_data_transform() == axes.transData)


def _place_above(axes: Axes, compact: dict[str, Any], *, own: bool) -> bool:
    """Put the legend between the axes and their title; false if these have no room for it."""
    figure = figure_of(axes)
    # In a figure of its own, a legend may also be above the labels of the y axis.
    margin = EDGE * figure.dpi / POINTS_PER_INCH
    left = figure.bbox.x0 + margin if own else axes.bbox.x0
    columns, legend = _in_columns(axes, compact, axes.bbox.x1 - left)
    if own and columns == 1 and len(legend.get_texts()) >= MANY:
        size = legend.get_texts()[0].get_fontsize()
        smaller = {**compact, "fontsize": SMALLER * float(size)}
        columns, legend = _in_columns(axes, smaller, axes.bbox.x1 - left)
        if columns > 1:
            compact = smaller
        else:
            legend = _above(axes, 1, compact)
    if own and (share := (axes.bbox.x1 - left) / legend.get_window_extent().width) < 1.0:
        # A legend of one column would begin to the left of the figure.
        handles, labels = axes.get_legend_handles_labels()
        compact = {**compact, "handles": handles, "labels": _wrapped(labels, share)}
        columns, legend = 1, _above(axes, 1, compact)
    width, height = legend.get_window_extent().size
    if not own and (width > axes.bbox.width or height > MAX_SHARE * axes.bbox.height):
        return False
    if width > axes.bbox.width:
        _above(axes, columns, compact, right=True)
    inches = height / figure.dpi
    _lift_titles(axes, TITLE_DISTANCE + ROUNDING * POINTS_PER_INCH * inches)
    if own:
        figure.set_figheight(figure.get_figheight() + inches)
    elif figure.get_layout_engine() is None and not _has_room(legend):
        _lift_titles(axes, rcParams["axes.titlepad"])
        return False
    return True


def _place_in_longer_axes(axes: Axes, compact: dict[str, Any]) -> bool:
    """Extend the y axis and put the legend there; false if users set its limits or it is large."""
    legend = axes.legend(loc="upper left", **compact)
    # A layout would make the axes narrower.
    legend.set_in_layout(False)
    pixels = figure_of(axes).dpi / POINTS_PER_INCH
    height = axes.bbox.y1 - legend.get_window_extent().y0 + SPARE * CLEARANCE * pixels
    share = SPARE * height / axes.bbox.height
    if not axes.get_autoscaley_on() or share > MAX_EXTENSION:
        return False
    limits = axes.get_ylim()
    scale = axes.yaxis.get_transform()
    low, high = scale.transform(np.array(limits))
    top = low + (high - low) / (1.0 - share)
    axes.set_ylim(top=float(scale.inverted().transform(np.array([top]))[0]), auto=True)
    if covers_data(legend):
        axes.set_ylim(limits, auto=True)
        return False
    return True


def _in_columns(axes: Axes, compact: dict[str, Any], room: float) -> tuple[int, Legend]:
    """A legend above axes in as many columns as have room."""
    for columns in range(len(axes.get_legend_handles_labels()[1]), 0, -1):
        legend = _above(axes, columns, compact)
        if legend.get_window_extent().width <= room:
            break
    return columns, legend


def _lift_titles(axes: Axes, pad: float) -> None:
    """Put the titles at this distance [points] from the axes."""
    for place in ("left", "center", "right"):
        if title := axes.get_title(place):
            axes.set_title(title, loc=place, pad=pad)


def _has_room(legend: Legend) -> bool:
    """Whether a legend above axes, and their title, are in the figure and on no other axes."""
    axes: Axes = legend.axes
    figure = figure_of(axes)
    figure.draw_without_rendering()
    box = legend.get_window_extent()
    if axes.get_title():
        box = Bbox.union([box, axes.title.get_window_extent()])
    others = (each.get_tightbbox() for each in figure.axes if each is not axes)
    covered = any(other is not None and box.overlaps(other) for other in others)
    return not covered and box.y1 <= figure.bbox.y1


def _above(axes: Axes, columns: int, compact: dict[str, Any], *, right: bool = False) -> Legend:
    place: dict[str, Any] = {
        "loc": "lower right" if right else "lower left",
        "bbox_to_anchor": (float(right), 1.0),
    }
    if "handles" not in compact:
        handles, labels = axes.get_legend_handles_labels()
        place["handles"], place["labels"] = in_whole_groups(handles, labels, columns)
    return axes.legend(ncols=columns, **{**COMPACT, **compact}, **place)


def figure_of(axes: Axes) -> Figure:
    """The figure of axes, which may be in a part of it."""
    figure = axes.figure
    return figure if isinstance(figure, Figure) else figure.figure
