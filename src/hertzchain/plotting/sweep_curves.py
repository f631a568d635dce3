"""Curves of sweeps: one for each method or value of a short axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from matplotlib.axes import Axes

from ..sweeps.methods import SIMULATIONS
from .colours import curve_colour, grey
from .free_ends import FREE_END, label_free_end
from .looks import LINES
from .methods import looks_of_methods
from .shared_axes import use_power_of_ten
from .style import MARKERS, broken_label, label_log_axis
from .sweep_axes import free_end, places_of, set_axis, show_all_places
from .sweep_labels import coordinate_text, quantity_label
from .sweep_marks import label_marks, mark_curve, remove_labelled
from .sweep_sharing import Group, first_free_colour, has_curves, note_curve

if TYPE_CHECKING:
    import xarray as xr

# Largest number of symbols of a curve.
MAX_SYMBOLS: Final = 40
# Opacity of the band between quantiles, through which other curves are visible.
BAND_ALPHA: Final = 0.2
# Width [points] of the bar at a free end.
BAR: Final = 3.0


def draw_curves(
    drawn: xr.DataArray, flags: Mapping[str, xr.DataArray], axes: Axes, *, by: str, log: bool,
    law: bool, group: Group, first: int = 0, ends: Sequence[xr.DataArray] = (), band: str = "",
) -> None:  # fmt: skip
    """Draw one curve for each method or value of a short axis, in colours from the first one.

    Colours that other curves in the axes have are not used again.

    Of several methods for each value, the colour shows the value, and line and symbol the method.
    Flagged points are marked; with ``law``, Hertz's law has a range, too.  Values of ``ends`` limit
    a band around each curve, with the label ``band``.
    """
    # A line to a value without a place would end at the edge of the axes.
    drawn = drawn.where(drawn > 0.0) if log else drawn
    grouped = by != "approach" and "approach" in drawn.dims
    along = next(name for name in drawn.dims if name not in (by, "approach"))
    names = drawn[by].to_numpy().tolist() if by in drawn.dims else [None]
    own = drawn["approach"].to_numpy().tolist() if grouped else names if by == "approach" else []
    methods = own or [None] * len(names)
    counts = len(names), len(methods)
    first, colours, symbols, lines = _numbers(axes, own, first, counts, grouped=grouped)
    # A line of one point would be invisible.
    looks = _looks(methods, symbols, lines,
                   ordered=_ordered(drawn[along]) and drawn.sizes[along] > 1)  # fmt: skip
    one = len(names) == len(methods) == 1
    free, marked = False, dict[str, set[str]]()
    for i in range(len(names)):
        for j in range(len(methods)) if grouped else [i]:
            chosen = {} if names[i] is None else {by: i} | ({"approach": j} if grouped else {})
            curve = drawn.isel(chosen)
            if log and by == "approach" and len(names) > 1 and not (curve > 0.0).any():
                # Errors that are all negative have no place on a logarithmic scale.
                continue
            colour = curve_colour(axes, colours[i])
            places = places_of(curve[along])
            every = max(1, curve.size // MAX_SYMBOLS)
            if end := free_end(curve):
                axes.plot(places[end], curve[end], color=colour, linestyle="none",
                          marker=MARKERS[symbols[j] % len(MARKERS)])  # fmt: skip
                free = True
            label = coordinate_text(curve[by], by) if by in curve.coords else ""
            if ends:
                _draw_band(axes, places, [each.isel(chosen) for each in ends], end, colour)
                if one:
                    label = ", ".join(filter(None, ("median", label)))
            (line,) = axes.plot(places[:end], curve[:end], color=colour, markerfacecolor="none",
                                markevery=every, label=None if grouped else label or None,
                                **looks[j])  # fmt: skip
            if not grouped:
                note_curve(line, group, label, colours[i])
            flagged = {kind: each.isel(chosen) for kind, each in flags.items()}
            for kind in mark_curve(axes, places, curve, flagged, colour, every):
                marked.setdefault(kind, set()).add(colour)
    if grouped:
        _label_groups(drawn, axes, by, looks, group, first)
    if ends:
        _label_band(axes, band, curve_colour(axes, colours[0]) if one else grey(axes, 0.4), one=one)
    if free:
        remove_labelled(axes, FREE_END)
        label_free_end(axes)
    label_marks(axes, marked, law=law)
    _set_axes(axes, drawn, along, log=log)


def _numbers(
    axes: Axes, own: Sequence[Any], first: int, counts: tuple[int, int], *, grouped: bool
) -> tuple[int, list[int], list[int], list[int]]:
    """Numbers of the first colour, of all colours, symbols and, of methods, lines."""
    # Methods of a legend that several quantities share have the same symbol in each.
    symbol, begin = first, 0 if grouped else first
    first = first_free_colour(axes, begin, counts[0])
    symbol = symbol if grouped else first
    colours = list(range(first, first + counts[0]))
    # Methods of a second quantity in the same axes have other colours.
    keep = grouped or (first == begin and not has_curves(axes))
    known = looks_of_methods([*map(str, own)]) if any(own) and keep else None
    if known is None:
        return first, colours, list(range(symbol, symbol + counts[1])), []
    colours = colours if grouped else [each.colour for each in known]
    return first, colours, [each.symbol for each in known], [each.line for each in known]


def _draw_band(
    axes: Axes, places: Any, ends: Sequence[xr.DataArray], end: int | None, colour: str
) -> None:
    """A band around a median, and a bar of this height at a free end."""
    low, high = (each.to_numpy() for each in ends)
    axes.fill_between(places[:end], low[:end], high[:end], color=colour, alpha=BAND_ALPHA, lw=0.0)
    if end is not None:
        axes.vlines(places[end], low[end], high[end], color=colour, alpha=BAND_ALPHA, lw=BAR)


def _label_band(axes: Axes, label: str, colour: str, *, one: bool) -> None:
    """One entry of the legend for all bands; that of a single curve is beside its median."""
    label = label if one else f"median, {label}"
    if label not in axes.get_legend_handles_labels()[1]:
        axes.fill([], [], facecolor=colour, alpha=BAND_ALPHA, linewidth=0.0, label=label)


def _set_axes(axes: Axes, drawn: xr.DataArray, along: Any, *, log: bool) -> None:
    """Labels and scales of both axes."""
    axes.set_ylabel(broken_label(axes, "height", quantity_label(drawn)))
    _scale_quantity(axes, log=log)
    # Before the ticks of a logarithmic axis are chosen.
    show_all_places(axes, drawn[along])
    set_axis(axes, "x", drawn[along])


def _scale_quantity(axes: Axes, *, log: bool) -> None:
    axes.set_yscale("log" if log else "linear")
    if log:
        label_log_axis(axes.yaxis)
    else:
        use_power_of_ten(axes.yaxis)


def _label_groups(
    drawn: xr.DataArray, axes: Axes, by: str, looks: Sequence[Mapping[str, Any]], group: Group,
    first: int,
) -> None:  # fmt: skip
    """Entries of the legend for each value, in its colour, and for each method, in grey."""
    for i, value in enumerate(drawn[by], first):
        label = coordinate_text(value, by)
        (line,) = axes.plot([], [], color=curve_colour(axes, i), label=label)
        note_curve(line, group, label, i)
    for method, look in zip(drawn["approach"], looks, strict=True):
        remove_labelled(axes, coordinate_text(method, "approach"))
        axes.plot([], [], color=grey(axes, 0.4), markerfacecolor="none", **look,
                  label=coordinate_text(method, "approach"))  # fmt: skip


def _looks(
    methods: Sequence[Any], symbols: Sequence[int], known: Sequence[int], *, ordered: bool
) -> list[dict[str, Any]]:
    """Symbol and line of each curve: symbols for simulations and lines for theories if both occur.

    Lines of several methods differ, because they often coincide.
    """
    simulated = [method in SIMULATIONS for method in methods]
    both = ordered and any(simulated) and not all(simulated)
    looks: list[dict[str, Any]] = []
    lines = 0
    for i, (method, simulation) in enumerate(zip(methods, simulated, strict=True)):
        line = LINES[(known[i] if known else lines) % len(LINES)]
        if not ordered or (both and simulation):
            line = "none"
        elif method is not None:
            lines += 1
        marker = "" if both and not simulation else MARKERS[symbols[i] % len(MARKERS)]
        looks.append({"linestyle": line, "marker": marker, "zorder": 2.1 if line == "none" else 2})
    return looks


def _ordered(coordinate: xr.DataArray) -> bool:
    """Whether a line between neighbouring values has a meaning: not for names and seeds."""
    words = f"{coordinate.name} {coordinate.attrs.get('long_name', '')}"
    return coordinate.dtype.kind in "if" and "seed" not in words
