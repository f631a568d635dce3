"""Axes of plots of sweeps: scales, places and edges of cells, and free ends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from matplotlib.axes import Axes

from ..errors import InputError
from ..pulse.free_end import jumps_at_end
from .style import INCHES_PER_LETTER, BeadLocator, label_log_axis, literal
from .sweep_labels import axis_label

if TYPE_CHECKING:
    import xarray as xr

# Attribute of a coordinate whose scale a user has chosen.
SCALE: Final = "scale"


def set_axis(axes: Axes, which: Literal["x", "y"], coordinate: xr.DataArray) -> None:
    """Set the scale, ticks and label of the x or y axis."""
    values = coordinate.to_numpy()
    axes.set(**{f"{which}scale": scale_of(coordinate), f"{which}label": axis_label(coordinate)})
    axis = axes.xaxis if which == "x" else axes.yaxis
    # Setting a scale resets the ticks, so ticks are set afterwards.
    if axis.get_scale() == "log":
        label_log_axis(axis)
    if values.dtype.kind not in "if":
        names = [str(value) for value in values]
        axis.set_ticks(range(values.size), labels=[*map(literal, names)])
        width = axes.get_window_extent().width / axes.figure.dpi
        if which == "x" and INCHES_PER_LETTER * max(map(len, names)) > width / values.size:
            axes.tick_params("x", labelrotation=30.0)
            for label in axis.get_ticklabels():
                label.set(horizontalalignment="right", rotation_mode="anchor")
    elif values.dtype.kind == "i" and axis.get_scale() == "linear":
        axis.set_major_locator(BeadLocator(int(values.min())))


def show_all_places(axes: Axes, coordinate: xr.DataArray) -> None:
    """Let the x axis reach all points of the sweep, also those without a value."""
    ends = np.array([places_of(coordinate).min(), places_of(coordinate).max()], dtype=float)
    axes.update_datalim(np.column_stack([ends, ends]), updatey=False)
    axes.autoscale_view(scaley=False)


def with_scales(
    drawn: xr.DataArray, logarithmic: Sequence[bool | None], *, curves: str | None
) -> xr.DataArray:
    """Values whose axes have the attribute ``scale`` where a user has chosen it.

    ``curves`` is the dimension with one curve for each value; of a map, it is `None`.
    """
    along = [name for name in drawn.dims if name not in (curves, "approach")]
    for name, log in zip(along, logarithmic, strict=False):
        if log is None:
            continue
        coordinate = drawn[name]
        values = coordinate.to_numpy()
        if log and not (values.dtype.kind in "if" and values.min() > 0.0):
            raise InputError(f"{name} has values that are not above 0, which a logarithmic axis "
                             "cannot show")  # fmt: skip
        attributes = {**coordinate.attrs, SCALE: "log" if log else "linear"}
        drawn = drawn.assign_coords({name: coordinate.assign_attrs(attributes)})
    return drawn


def scale_of(coordinate: xr.DataArray) -> str:
    """Name of the scale of an axis: that of a user, or one that suits the values."""
    return str(coordinate.attrs.get(SCALE) or scale(coordinate.to_numpy()))


def scale(values: np.ndarray[Any, Any]) -> str:
    """Name of the scale: logarithmic over a decade or more, if the steps are then more even."""
    if values.dtype.kind not in "if" or values.size < 3 or values.min() <= 0.0:
        return "linear"
    if values.max() < 10.0 * values.min():
        return "linear"
    linear, logarithmic = (np.diff(np.sort(each)) for each in (values, np.log(values)))
    more_even = logarithmic.max() * linear.min() < linear.max() * logarithmic.min()
    return "log" if more_even else "linear"


def edges_of(coordinate: xr.DataArray) -> np.ndarray[Any, Any]:
    """Edges of map cells: halfway between neighbouring values, on the scale of the axis."""
    places = places_of(coordinate)
    if scale_of(coordinate) == "log":
        return np.asarray(np.exp(_edges(np.log(places))))
    return _edges(places)


def _edges(places: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    halves = np.diff(places) / 2.0
    inner = places[:-1] + halves
    return np.concatenate(([places[0] - halves[0]], inner, [places[-1] + halves[-1]]))


def places_of(coordinate: xr.DataArray) -> Any:
    """Values of a coordinate along an axis: numbers, or 0, 1, ... for names."""
    values = coordinate.to_numpy()
    return values if values.dtype.kind in "if" else np.arange(values.size)


def free_end(curve: xr.DataArray) -> int | None:
    """Index of the last bead if its value is above the curve of the beads before it."""
    if curve.dims != ("bead",):
        return None
    # Shorter chains of a sweep have no values at the last places.
    known = np.flatnonzero(np.isfinite(curve.to_numpy()))[-3:]
    beads = curve["bead"].to_numpy()[known]
    if len(known) < 3 or beads[-1] - beads[0] != 2:
        return None
    return int(known[-1]) if jumps_at_end(curve.to_numpy()[known], str(curve.name)) else None
