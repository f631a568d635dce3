"""Plot sweeps: curves over one axis, or over the longer of two; a map over two long ones."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.axes import Axes

from ..errors import IncompleteWarning, InputError, InputWarning, unknown_name_error, warn_user
from ..representation import counted
from ..store.sweep_export import FLAGS, check_sweep
from ..store.sweep_store import FAILED, MISSING
from ..sweeps.kept import variable_name
from ..validation.keywords import checked_arguments
from ..validation.numbers import FRACTION, number
from ..validation.objects import check_bool, check_choice, check_list, text
from .legends import place_legend
from .reference_slopes import draw_slopes, slopes_from
from .style import figure_style, get_axes, set_title
from .sweep_axes import with_scales
from .sweep_bands import Band, label_of, warn_incomplete_in_band, with_band, words_of
from .sweep_captions import SO_FAR, caption_of, words_of_flags
from .sweep_checks import (
    check_options,
    check_scales,
    check_together,
    check_values,
    wanted_quantities,
)
from .sweep_curves import draw_curves
from .sweep_labels import (
    ERRORS,
    quantity_label,
    reference_of,
    short_value,
    with_damping,
    with_symbols,
)
from .sweep_maps import draw_map
from .sweep_marks import mark_cells
from .sweep_points import over_first_quantity
from .sweep_sharing import Group, Unit, in_unit, label_shared, shared_unit

if TYPE_CHECKING:
    import xarray as xr

# Dimensions and parameters without nearest values, and the relative difference of numbers that are
# regarded as the same.
EXACT: Final = frozenset((
    "bead", "contact", "point", "beads", "between", "cells", "count", "grade", "seed", "strikers",
))  # fmt: skip
SAME: Final = 1e-9
# Dimensions that are not axes of a sweep.
RESERVED: Final = ("approach", "bead", "contact")
# Largest number of values of an axis for one curve per value.
MAX_CURVES: Final = 6


@checked_arguments("plot_sweep")
def plot_sweep(
    dataset: xr.Dataset,
    quantity: str | Sequence[str] | None = None,
    *,
    log: bool = False,
    log_x: bool | None = None,
    log_y: bool | None = None,
    levels: list[float] | None = None,
    slope: float | str | Sequence[float | str] | None = None,
    band: str | None = None,
    label: str = "",
    legend: bool = True,
    ax: Axes | None = None,
    **at: Any,
) -> Axes:
    """Plot quantities of a sweep: curves over one axis, or a map of one quantity over two.

    Markers show points outside the range of a method or of Hertz's law, points whose largest force
    on a wall is not complete or may be sensitive to small changes and, in maps, points that have
    failed or are missing.  If all points are outside the range, the title states this instead.

    If one of two axes has at most six values, the plot has one curve per value of the shorter axis
    instead of a map; with several methods, the colour of a curve shows the value, and its line and
    symbol show the method.  Over one axis, there is one curve per method: if simulations and
    theories are plotted, simulations have symbols and theories have lines, so that curves that
    agree do not hide each other.  Errors are those of the other methods relative to the reference
    of the sweep.

    Parameters
    ----------
    dataset : xarray.Dataset
        Result of `hertzchain.sweep` or `hertzchain.open_sweep`.
    quantity : str or sequence of str, optional
        Name of the quantity to plot, among those in ``dataset.data_vars``, or names of several
        quantities with the same unit; by default, the first that was kept.
    log : bool
        Whether the scale of the quantity is logarithmic.  Values that are not positive then have
        no place; the title states their number.
    log_x, log_y : bool, optional
        Whether the scales of the axes are logarithmic.  By default, that of a parameter is if its
        values extend over a decade or more and their ratios are more even than their differences.
        The y axis of curves is that of the quantity, so that ``log_y`` is ``log``.
    levels : list of float, optional
        Values of contour lines in a map, such as 0.01 for an error of 1%.  With levels, two axes
        of any length give a map.
    slope : float, str or sequence of these, optional
        Exponents of power laws, as numbers or fractions such as ``"6/5"``: thin dashed lines, whose
        level has no meaning, are drawn for comparison above the first curve.  On two logarithmic
        axes they are straight.
    band : str, optional
        An axis, such as ``"with_scatter.seed"``: the curves are medians over its values, with the
        band between their 5% and 95% quantiles.
    label : str
        Name of the curves in the legend, followed by the method or value if there are several.  By
        default, curves of several sweeps or quantities in the same axes are named by the
        properties in which they differ.
    legend : bool
        Whether curves have a legend; that of markers in a map remains.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into.  By default, a new figure is created.  The colours and markers continue
        those of sweeps that the axes already have.
    **at
        Values along the other dimensions: ``bead=20``, ``approach="bca"``, or a value of an axis,
        by its dimension or, in a mapping, by its name in the specification
        (``"loss.coefficient"``).
        Numbers are in the unit of the axis, as in ``dataset[...].units``, or have a unit, such as
        ``"5 mm"``.  The nearest value of an axis is used and shown in the title; numbers of beads,
        seeds and points must be among those of the sweep.

    Raises
    ------
    InputError
        If the quantity, a dimension or a value does not exist, if the number of remaining
        dimensions, apart from the methods, is not 1 or 2, if a map would have several methods or
        quantities, if several quantities have different units, or if none of the points to plot is
        done or has a value.

    Warns
    -----
    InputWarning
        If the nearest value of an axis differs from the given one.
    IncompleteWarning
        If some of the points to plot are missing or have failed; they remain blank, in maps with a
        marker.

    Examples
    --------
    >>> import hertzchain as hc
    >>> found = hc.sweep({
    ...     "chain": {"taper": "forward-exponential"},
    ...     "axes": {"rate": [0.02, 0.04, 0.06], "beads": [20, 30]},
    ...     "sweep": {"keep": ["momentum"], "at": "last"},
    ... })
    >>> [curve.get_label() for curve in hc.plot_sweep(found).lines]
    ['beads = 20', 'beads = 30']
    >>> axes = hc.plot_sweep(found, label="$s = 0.02$", rate=0.02)
    >>> axes = hc.plot_sweep(found, label="$s = 0.06$", rate=0.06, ax=axes)
    >>> [curve.get_label() for curve in axes.lines]
    ['$s = 0.02$', '$s = 0.06$']
    """
    legend = check_bool("legend", legend)
    levels = [number("level", each) for each in _listed(levels)]
    slopes = [] if slope is None else slopes_from(slope)
    name = "" if isinstance(label, str) and not label else text("label", label)
    check_sweep(dataset)
    dataset = over_first_quantity(dataset, at)
    complete, (dataset, within) = dataset, with_band(dataset, band)
    wanted = wanted_quantities(quantity)
    selected = [_to_plot(dataset, each, at, several=bool(levels)) for each in wanted]
    along = [each for each in selected[0][0].dims if each != "approach"]
    short = _short_axis(selected[0][0], along) if len(along) == 2 and not levels else None
    by = "approach" if len(along) == 1 else short
    curves, together = by is not None, [drawn for drawn, _ in selected]
    check_options(name, slopes, band, curves=curves)
    check_together(together, curves=curves)
    log, scales = check_scales(log, log_x, log_y, curves=curves)
    _check_done(complete, at, within)
    check_values(together)
    with figure_style():
        axes = get_axes(ax)
        unit = shared_unit(axes, together)
        present = len(axes.lines)
        law = dataset.attrs.get("units") == "SI"  # scaled chains have no range of Hertz's law
        for drawn, reference in selected:
            shown = with_damping(with_symbols(in_unit(drawn, unit), dataset), dataset)
            shown = with_scales(shown, scales, curves=by)
            flagged = _flagged(dataset, shown, at)
            caption = caption_of(dataset, shown, reference) + words_of(within)
            ends = _band_ends(complete, within, drawn, at, unit)
            flags = words_of_flags(shown, flagged, law=law, log=log, curves=curves)
            if by is None:
                draw_map(shown, axes, log=log, levels=[unit.factor * level for level in levels])
                set_title(axes, "; ".join((*caption, *flags)))
                mark_cells(axes, shown, flagged, law=law, own=ax is None)
                return axes
            draw_curves(shown, flagged, axes, by=by, log=log, law=law, ends=ends,
                        group=Group(unit, quantity_label(shown), tuple(caption), name),
                        first=_first_colour(dataset, shown), band=label_of(within))  # fmt: skip
            parts = caption if (common := label_shared(axes)) is None else common
            set_title(axes, "; ".join((*parts, *flags)), common=common is not None)
        draw_slopes(axes, axes.lines[present:], slopes)
        several = by in shown.dims or slopes or len(axes.get_legend_handles_labels()[1]) > 1
        if legend and (several or name):
            place_legend(axes, own=ax is None)
    return axes


def _listed(levels: Any) -> list[Any]:
    return [] if levels is None else check_list("levels", levels, "numbers")


def _band_ends(
    complete: xr.Dataset, within: Band | None, drawn: xr.DataArray, at: Mapping[str, Any],
    unit: Unit,
) -> list[xr.DataArray]:  # fmt: skip
    """Lower and upper end of a band around plotted medians."""
    if within is None:
        return []
    name = str(drawn.name)
    values, status = _selected_at(complete[name], at), _flags(complete, "status", at)
    warn_incomplete_in_band(values, status, within)
    ends = (_selected_at(each[name], at) for each in (within.low, within.high))
    return [in_unit(each.reindex_like(drawn), unit) for each in ends]


def _to_plot(
    dataset: xr.Dataset, quantity: str | None, at: Mapping[str, Any], *, several: bool
) -> tuple[xr.DataArray, str | None]:
    """Values of a quantity along the remaining dimensions, and the reference of errors."""
    drawn = _selected(dataset, quantity, at)
    along = [name for name in drawn.dims if name != "approach"]
    short = _short_axis(drawn, along) if len(along) == 2 and not several else None
    if not along or len(along) > 2 or (drawn.ndim == 3 and short is None):
        raise InputError(_undrawable(drawn, at))
    return _without_reference(dataset, drawn)


def _without_reference(dataset: xr.Dataset, drawn: xr.DataArray) -> tuple[xr.DataArray, str | None]:
    """Errors without those of the reference, which are 0, and its name."""
    reference = reference_of(dataset)
    if "approach" not in drawn.dims or not str(drawn.name).startswith((*ERRORS,)):
        return drawn, None
    others = drawn["approach"].to_numpy() != reference
    if others.all():
        return drawn, None
    return drawn.isel(approach=others), reference


def _first_colour(dataset: xr.Dataset, drawn: xr.DataArray) -> int:
    """Number of methods before the first curve, which keeps the colour it has beside them."""
    if "approach" not in drawn.dims:
        return 0
    return dataset["approach"].to_numpy().tolist().index(drawn["approach"][0].item())


def _selected(dataset: xr.Dataset, quantity: str | None, at: Mapping[str, Any]) -> xr.DataArray:
    names = [
        str(name) for name in dataset.data_vars
        if name not in ("status", "reason", *FLAGS, "beads")
    ]  # fmt: skip
    known = [*names, *(name for name in (*FLAGS, "beads") if name in dataset.data_vars)]
    chosen = names[0] if quantity is None else _variable(quantity, known)
    return _selected_at(dataset[chosen], at, warn=warn_user)


def _variable(quantity: Any, known: list[str]) -> str:
    """The variable of a quantity, which may have its name in designs, as ``wall_force.peak``."""
    if not isinstance(quantity, str):
        return check_choice("quantity of this sweep", quantity, known)
    name = variable_name(quantity)
    own, at, bead = quantity.partition("@")
    if at and name not in known and (own := variable_name(own)) in known:
        raise InputError(
            f"{quantity!r} is {own} of one bead: plot the quantity {own} at bead={bead}, if the "
            "sweep has kept several beads"
        )
    return check_choice(
        "quantity of this sweep", name if name in known else quantity, known
    )  # fmt: skip


def _selected_at(
    values: xr.DataArray, at: Mapping[str, Any], warn: Any = lambda *_: None
) -> xr.DataArray:
    """Values along the remaining dimensions, in ascending order of each axis."""
    long_names = {values[name].attrs.get("long_name"): str(name) for name in values.dims}
    for given, value in at.items():
        name = long_names.get(given, given)
        if name not in values.dims:
            raise unknown_name_error(f"dimension of {values.name}", given, map(str, values.dims))
        values = values.isel({name: _index(values[name], given, value, warn)})
    numbers = [name for name in values.dims if values[name].dtype.kind in "if"]
    single = [name for name in values.dims if values.sizes[name] == 1]
    along = [name for name in single if name not in RESERVED]
    if along and {*values.dims} <= {*single, "approach"}:
        # A sweep of one point is shown over its first axis.
        single.remove(along[0])
    return values.squeeze(single, drop=False).sortby(
        [name for name in numbers if values.sizes[name] > 1]
    )


def _flags(dataset: xr.Dataset, name: str, at: Mapping[str, Any]) -> xr.DataArray:
    """A variable without beads or contacts, at the chosen values along its dimensions."""
    flags = dataset[name]
    known = {*flags.dims, *(flags[each].attrs.get("long_name") for each in flags.dims)}
    return _selected_at(flags, {each: at[each] for each in at if each in known})


def _flagged(
    dataset: xr.Dataset, drawn: xr.DataArray, at: Mapping[str, Any]
) -> dict[str, xr.DataArray]:
    """Whether each plotted value failed, is missing, or is subject to a reservation, by kind."""
    status = _flags(dataset, "status", at).broadcast_like(drawn)
    flagged = {"failed": status == FAILED, "missing": status == MISSING}
    for name in FLAGS:
        if name not in dataset or "approach" not in drawn.coords:
            continue
        flags = _flags(dataset, name, at).astype(bool)
        if "approach" in flags.dims:
            flags = flags.sel(approach=drawn["approach"])
        flagged[name] = flags.broadcast_like(drawn) & ~flagged["failed"] & ~flagged["missing"]
    if "incomplete" in flagged and SO_FAR not in str(drawn.name):
        # The flag is that of a point; its other quantities may be complete.
        flagged["incomplete"] &= drawn.isnull()
    return flagged


def _check_done(complete: xr.Dataset, at: Mapping[str, Any], within: Band | None) -> None:
    """Reject a plot of no finished point; warn if points are missing or failed.

    They are counted as by the command `sweep status`: for at least one of the methods.
    """
    status = _flags(complete, "status", at)
    if "approach" in status.dims:
        missing_somewhere = (status == MISSING).any("approach")
        status = status.max("approach").where(~missing_somewhere, MISSING)
    missing, failed = (int((status == value).sum()) for value in (MISSING, FAILED))
    parts = [f"{n} {word}" for n, word in ((missing, "missing"), (failed, "failed")) if n]
    if missing + failed == status.size:
        what = "is done" if missing else "has a result"
        advice = "run the sweep first, or resume it" if missing else "the variable reason says why"
        raise InputError(
            f"none of the {counted(status.size, 'point')} to plot {what} ({', '.join(parts)}); "
            f"{advice}"
        )
    if parts:
        warn_user(
            f"of the {counted(status.size, 'point')} to plot, {' and '.join(parts)}: "
            + ("left blank" if within is None else "the band does not include them"),
            IncompleteWarning,
        )


def _short_axis(drawn: xr.DataArray, along: Sequence[Hashable]) -> str | None:
    """The shorter of two axes, if one curve per value is clearer than a map."""
    short = min(reversed(along), key=lambda name: drawn.sizes[name])
    return str(short) if drawn.sizes[short] <= MAX_CURVES else None


def _index(coordinate: xr.DataArray, name: str, value: Any, warn: Any) -> int:
    """Index of a value: exact for text, numbers of beads and seeds, the nearest for others."""
    there = coordinate.to_numpy()
    if there.dtype.kind not in "if":
        return int(np.flatnonzero(there == check_choice(name, value, map(str, there)))[0])
    unit = coordinate.attrs.get("units", "1")
    what = name if unit == "1" else f"{name} [{unit}]"
    low, high = float(there.min()), float(there.max())
    slack = SAME * max(abs(low), abs(high))
    # Whole numbers, such as those of beads, are not percentages.
    plain = FRACTION if there.dtype.kind == "f" else None
    known = plain if unit == "1" else unit
    place = number(what, value, unit=known, least=low - slack, most=high + slack)
    nearest = int(np.abs(there - place).argmin())
    exact = abs(there[nearest] - place) <= slack
    parameter = str(coordinate.attrs.get("long_name", name)).rpartition(".")[2]
    if not exact and not EXACT.isdisjoint((name, parameter)):
        raise InputError(
            f"{what} is {place:g}, which is not a value of this sweep; the nearest is "
            f"{there[nearest]}"
        )
    if not exact:
        wrong = f"{what} = {short_value(place)} is not a value of this sweep"
        warn(
            f"{wrong}; the nearest, {short_value(there[nearest].item())}, is plotted", InputWarning
        )
    return nearest


def _undrawable(drawn: xr.DataArray, at: Mapping[str, Any]) -> str:
    """Why values cannot be plotted, and which dimension to fix, apart from the methods."""
    axes = {name: size for name, size in drawn.sizes.items() if name != "approach"}
    if not axes:
        hint = f"; omit {' or '.join(map(str, at))}" if at else ""
        return f"{drawn.name} has no remaining axis to plot along{hint}"
    left = ", ".join(f"{name} ({size})" for name, size in axes.items())
    # Selecting from a long axis would be an odd choice.
    shortest = min(axes, key=lambda name: axes[name])
    fixed = f"{shortest}={short_value(drawn[shortest].values[0])}"
    if len(axes) > 2:
        return (
            f"{drawn.name} has {len(axes)} remaining dimensions, {left}, but only 1 or 2 can be "
            f"plotted; choose a value of the others, such as {fixed}"
        )
    return (
        f"{drawn.name} has 2 remaining dimensions, {left}, and {drawn.sizes['approach']} methods, "
        "but a map has one method; choose a method, such as "
        f"approach={drawn['approach'].values[0].item()!r}, or a value, such as {fixed}"
    )
