"""Checks of the quantities and options of plots of sweeps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..validation.objects import check_bool, check_list

if TYPE_CHECKING:
    import xarray as xr


def wanted_quantities(quantity: Any) -> list[Any]:
    """Names of the quantities to plot; ``None`` is the first one of the sweep."""
    if quantity is None or isinstance(quantity, str):
        return [quantity]
    found = check_list("quantities", quantity, "names of quantities, or one name")
    if not found:
        raise InputError("quantities must contain at least one name, such as 'velocity'")
    return found


def check_scales(
    log: bool, log_x: bool | None, log_y: bool | None, *, curves: bool
) -> tuple[bool, list[bool | None]]:
    """Whether the quantity is on a logarithmic scale, and those of the axes."""
    log, given = check_bool("log", log), (("log_x", log_x), ("log_y", log_y))
    scales = [each if each is None else check_bool(name, each) for name, each in given]
    return (scales[1] if curves and scales[1] is not None else log), scales


def check_options(name: str, slopes: Sequence[Any], band: str | None, *, curves: bool) -> None:
    """Reject options that a map does not have."""
    if curves:
        return
    if name:
        raise InputError("a map has no legend; omit label")
    if slopes:
        raise InputError("a map has no slopes; omit slope, or plot one value of an axis")
    if band is not None:
        raise InputError("a map has no band; omit band, or plot one value of an axis")


def check_together(drawn: Sequence[xr.DataArray], *, curves: bool) -> None:
    """Require that several quantities have one unit and the same axes, and are not a map."""
    names = " and ".join(str(each.name) for each in drawn)
    if len(drawn) > 1 and not curves:
        raise InputError(f"a map has one quantity, got {names}; call plot_sweep once for each")
    units = [each.attrs.get("units", "1") for each in drawn]
    if len({*units}) > 1:
        raise InputError(
            f"{names} have the units {', '.join(units)}; call plot_sweep once for each, with "
            "ax=... to draw into the same figure"
        )
    if len({each.dims for each in drawn}) > 1:
        raise InputError(
            f"{names} have different dimensions; call plot_sweep once for each, with ax=... to "
            "draw into the same figure"
        )


def check_values(selected: Sequence[xr.DataArray]) -> None:
    """Reject a plot of points that are done but have no value."""
    for drawn in selected:
        values = drawn.to_numpy()
        if values.dtype.kind == "f" and not np.isfinite(values).any():
            unfinished = str(drawn.name).startswith("wall_")
            advice = "; set until, or keep wall_largest_so_far" if unfinished else ""
            points = "the point" if values.size == 1 else f"any of the {values.size} points"
            raise InputError(f"there is no value of {drawn.name} at {points} to plot{advice}")
