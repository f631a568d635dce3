"""Maps of sweeps: one quantity over two axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import LogNorm
from matplotlib.ticker import NullLocator

from ..collision import Array
from ..errors import InputError
from ..units import PERCENT
from .colours import signed_map
from .shared_axes import use_power_of_ten
from .style import broken_label, label_log_axis
from .sweep_axes import edges_of, places_of, scale_of, set_axis
from .sweep_labels import quantity_label

if TYPE_CHECKING:
    import xarray as xr

# Colour map of values of one sign.
SEQUENTIAL: Final = "viridis"
# Smallest part of an axis between two values up to which all values have a tick.
CLOSEST: Final = 0.12


def draw_map(drawn: xr.DataArray, axes: Axes, *, log: bool, levels: Sequence[float] = ()) -> None:
    """Draw one quantity over two axes, and contour lines at the levels."""
    down, across = drawn.dims[1], drawn.dims[0]
    x, y = (places_of(drawn[name]) for name in (across, down))
    values = drawn.transpose(down, across).to_numpy()
    edges = edges_of(drawn[across]), edges_of(drawn[down])
    norm, (colours, low, high) = None, _colours(values)
    if log:
        shown = values[values > 0.0]
        if not shown.size:
            raise InputError(f"{drawn.name} has no values above 0; omit log")
        norm, colours, low, high = LogNorm(shown.min(), shown.max()), SEQUENTIAL, None, None
    mesh = axes.pcolormesh(*edges, values, cmap=colours, norm=norm, vmin=low,
                           vmax=high, rasterized=True)  # fmt: skip
    label = broken_label(axes, "height", quantity_label(drawn))
    bar = axes.figure.colorbar(mesh, ax=axes, label=label)
    if norm is not None:
        label_log_axis(bar.ax.yaxis)
    else:
        use_power_of_ten(bar.ax.yaxis)
    if levels:
        lines = axes.contour(
            x, y, values, levels=sorted(set(levels)), colors="white", linewidths=1.2
        )
        unit = "%%" if drawn.attrs.get("units") == PERCENT else ""
        axes.clabel(lines, fmt=f"%g{unit}", fontsize=8)
    set_axis(axes, "x", drawn[across])
    set_axis(axes, "y", drawn[down])
    _set_ticks_at_values(axes.xaxis, drawn[across])
    _set_ticks_at_values(axes.yaxis, drawn[down])
    axes.set(xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])


def _set_ticks_at_values(axis: Axis, coordinate: xr.DataArray) -> None:
    """Have a tick at each of few values, because cells extend beyond the first and the last one."""
    values, log = coordinate.to_numpy(), scale_of(coordinate) == "log"
    if values.dtype.kind not in "if" or values.size < 2:
        return
    places = np.sort(np.log(values) if log else values)
    if np.diff(places).min() < CLOSEST * np.ptp(places):
        return
    axis.set_ticks(values, labels=[f"{value:.4g}" for value in values] if log else None)
    axis.set_minor_locator(NullLocator())


def _colours(values: Array) -> tuple[str, float | None, float | None]:
    """Colour map and limits: white at 0 if both signs occur."""
    colours, low, high = signed_map(values)
    return (colours, low, high) if low < 0.0 < high else (SEQUENTIAL, None, None)
