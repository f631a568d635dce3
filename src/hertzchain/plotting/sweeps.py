"""Draw sweeps: curves over one axis, a map over two."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm

from hertzchain.errors import InputError, unknown_name
from hertzchain.plotting.style import COLOURS, MARKERS, house_style

if TYPE_CHECKING:
    import xarray as xr


def plot_sweep(
    dataset: xr.Dataset,
    quantity: str | None = None,
    *,
    log: bool = False,
    levels: list[float] | None = None,
    ax: Axes | None = None,
    **at: Any,
) -> Axes:
    """Draw one quantity of a sweep: curves over one axis, or a map over two.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of `hertzchain.sweep` or `hertzchain.open_sweep`.
    quantity : str, optional
        What to draw; the first that was kept if not given.
    log : bool
        Logarithmic scale of the quantity.
    levels : list of float, optional
        Values at which a line is drawn into a map, such as 0.01 for an error of one per cent.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; a new figure's if not given.
    **at
        Where along the other dimensions: ``bead=20``, ``by="bca"``, or values of an axis, the
        nearest if it is a number.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        If the quantity or a dimension does not exist, or more or fewer than one or two
        dimensions are left.

    Examples
    --------
    >>> import hertzchain as hc
    >>> found = hc.sweep({
    ...     "chain": {"taper": "forward-exponential"},
    ...     "axes": {"rate": [0.02, 0.04, 0.06], "beads": [20, 30]},
    ...     "sweep": {"keep": ["momentum"], "at": "last"},
    ... })
    >>> plot_sweep(found).get_ylabel()
    'beads'
    """
    drawn = _selected(dataset, quantity, at)
    with house_style():
        axes = ax if ax is not None else plt.subplots()[1]
        if drawn.ndim == 1 or (drawn.ndim == 2 and "by" in drawn.dims):
            _curves(drawn, axes, log=log)
        elif drawn.ndim == 2:
            _map(drawn, axes, log=log, levels=levels)
        else:
            left = ", ".join(f"{name} ({size})" for name, size in drawn.sizes.items())
            raise InputError(
                f"{drawn.name} has {drawn.ndim} dimensions left, {left}, and 1 or 2 can be drawn: "
                "choose a value of the others, such as bead=20"
            )
        told = [dataset.attrs.get("title", "")]
        told += [f"{name} = {_short(value.item())}" for name, value in drawn.coords.items()
                 if value.ndim == 0]  # fmt: skip
        axes.set_title("; ".join(part for part in told if part))
    return axes


def _selected(dataset: xr.Dataset, quantity: str | None, at: Mapping[str, Any]) -> xr.DataArray:
    names = [
        str(name) for name, values in dataset.data_vars.items()
        if name not in ("status", "reason", "outside_range", "beads")
    ]  # fmt: skip
    if quantity is not None and quantity not in dataset:
        raise unknown_name("quantity of this sweep", quantity, names)
    values = dataset[names[0] if quantity is None else quantity]
    for name, value in at.items():
        if name not in values.dims:
            raise unknown_name(f"dimension of {values.name}", name, map(str, values.dims))
        coordinate = values[name]
        if coordinate.dtype.kind in "if":
            values = values.sel({name: value}, method="nearest")
        elif value in coordinate.values:
            values = values.sel({name: value})
        else:
            raise unknown_name(name, value, map(str, coordinate.values))
    return values.squeeze(drop=False)


def _curves(drawn: xr.DataArray, axes: Axes, *, log: bool) -> None:
    along = next(name for name in drawn.dims if name != "by")
    curves = [drawn.sel(by=name) for name in drawn.by.values] if "by" in drawn.dims else [drawn]
    if log:
        # The reference has no error, and no place on a logarithmic scale.
        curves = [curve for curve in curves if (curve > 0.0).any()]
    for i, curve in enumerate(curves):
        axes.plot(
            np.arange(curve.size) if curve[along].dtype.kind == "U" else curve[along],
            curve,
            color=COLOURS[i % len(COLOURS)],
            marker=MARKERS[i % len(MARKERS)],
            markerfacecolor="none",
            markevery=max(1, curve.size // 40),
            label=str(curve.by.item()) if "by" in curve.coords else None,
        )
    if drawn[along].dtype.kind == "U":
        axes.set_xticks(range(drawn[along].size), drawn[along].values)
    axes.set_xlabel(_label(drawn[along], str(along)))
    axes.set_ylabel(_label(drawn, str(drawn.name)))
    axes.set_yscale("log" if log else "linear")
    axes.set_xscale(_scale(drawn[along]))
    if len(curves) > 1:
        axes.legend()


def _map(drawn: xr.DataArray, axes: Axes, *, log: bool, levels: list[float] | None) -> None:
    down, across = drawn.dims[1], drawn.dims[0]
    x, y = (_places(drawn[name]) for name in (across, down))
    values = drawn.transpose(down, across).to_numpy()
    norm = None
    if log:
        shown = values[values > 0.0]
        if not shown.size:
            raise InputError(f"{drawn.name} has no values above 0: leave log out")
        norm = LogNorm(shown.min(), shown.max())
    mesh = axes.pcolormesh(
        x, y, values, cmap="viridis", norm=norm, shading="nearest", rasterized=True
    )
    axes.figure.colorbar(mesh, ax=axes, label=_label(drawn, str(drawn.name)))
    if levels:
        lines = axes.contour(x, y, values, levels=sorted(levels), colors="white", linewidths=1.2)
        axes.clabel(lines, fmt="%g", fontsize=8)
    for name, axis in ((across, axes.xaxis), (down, axes.yaxis)):
        if drawn[name].dtype.kind == "U":
            axis.set_ticks(range(drawn[name].size), labels=drawn[name].values)
    axes.set_xscale(_scale(drawn[across]))
    axes.set_yscale(_scale(drawn[down]))
    axes.set_xlabel(_label(drawn[across], str(across)))
    axes.set_ylabel(_label(drawn[down], str(down)))


def _scale(coordinate: xr.DataArray) -> str:
    """Logarithmic for values in geometric progression."""
    values = coordinate.to_numpy()
    if values.dtype.kind not in "if" or values.size < 3 or values.min() <= 0.0:
        return "linear"
    steps = np.diff(np.log(values))
    return "log" if np.ptp(steps) < 1e-6 * abs(steps[0]) else "linear"


def _places(coordinate: xr.DataArray) -> Any:
    return np.arange(coordinate.size) if coordinate.dtype.kind == "U" else coordinate.to_numpy()


def _label(values: xr.DataArray, name: str) -> str:
    unit = values.attrs.get("units", "1")
    text = {"bead": "bead $k$", "contact": "contact $k$"}.get(name, name.replace("_", " "))
    return text if unit == "1" else f"{text} [{unit}]"


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
