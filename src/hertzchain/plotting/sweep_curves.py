"""Curves of sweeps: one for each method or value of a short axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

from matplotlib.axes import Axes
from matplotlib.container import Container
from matplotlib.legend import Legend
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D

from ..sweeps.methods import SIMULATIONS
from .colours import curve_colour
from .pulses import LINES, label_free_end
from .style import MARKERS, label_log_axis
from .sweep_axes import free_end, places_of, set_axis
from .sweep_labels import coordinate_text, quantity_label

if TYPE_CHECKING:
    import xarray as xr

# Largest number of symbols of a curve.
MAX_SYMBOLS: Final = 40


class Marks(Container):
    """Marks of several curves that share an entry of the legend, which shows all their colours."""


Legend.update_default_handler_map({Marks: HandlerTuple(ndivide=None)})


def draw_curves(
    drawn: xr.DataArray, outside: xr.DataArray, axes: Axes, *, by: str, log: bool, first: int = 0
) -> None:
    """Draw one curve for each method or value of a short axis, in colours from the first one."""
    along = next(name for name in drawn.dims if name != by)
    names = drawn[by].to_numpy().tolist() if by in drawn.dims else [None]
    methods = names if by == "approach" else [None] * len(names)
    looks = _looks(methods, first, ordered=_ordered(drawn[along]))
    free, marks = False, []
    for i, (name, look) in enumerate(zip(names, looks, strict=True)):
        chosen = {} if name is None else {by: i}
        curve, flags = drawn.isel(chosen), outside.isel(chosen)
        if log and by == "approach" and len(names) > 1 and not (curve > 0.0).any():
            # Errors that are all negative have no place on a logarithmic scale.
            continue
        colour, places = curve_colour(axes, first + i), places_of(curve[along])
        if end := free_end(curve):
            axes.plot(places[end], curve[end], color=colour, linestyle="none",
                      marker=MARKERS[(first + i) % len(MARKERS)])  # fmt: skip
            free = True
        axes.plot(
            places[:end],
            curve[:end],
            color=colour,
            markerfacecolor="none",
            markevery=max(1, curve.size // MAX_SYMBOLS),
            label=coordinate_text(curve[by], by) if by in curve.coords else None,
            **look,
        )
        if flags.any():
            marks += axes.plot(places[flags.values], curve[flags.values], "o", color=colour,
                               alpha=0.3, markersize=8.0, markeredgecolor="none")  # fmt: skip
    if free:
        label_free_end(axes)
    _label_marks(axes, marks, str(outside.name))
    axes.set_ylabel(quantity_label(drawn))
    axes.set_yscale("log" if log else "linear")
    if log:
        label_log_axis(axes.yaxis)
    set_axis(axes, "x", drawn[along])


def _looks(methods: Sequence[Any], first: int, *, ordered: bool) -> list[dict[str, Any]]:
    """Symbol and line of each curve: symbols for simulations and lines for theories if both occur.

    Lines of several methods differ, because they often coincide.
    """
    simulated = [method in SIMULATIONS for method in methods]
    both = ordered and any(simulated) and not all(simulated)
    looks: list[dict[str, Any]] = []
    lines = 0
    for i, (method, simulation) in enumerate(zip(methods, simulated, strict=True), first):
        line = LINES[lines % len(LINES)]
        if not ordered or (both and simulation):
            line = "none"
        elif method is not None:
            lines += 1
        marker = "" if both and not simulation else MARKERS[i % len(MARKERS)]
        looks.append({"linestyle": line, "marker": marker, "zorder": 2.1 if line == "none" else 2})
    return looks


def _label_marks(axes: Axes, marks: list[Line2D], label: str) -> None:
    """One entry of the legend, with a mark in the colour of each marked curve."""
    if marks:
        axes.add_container(Marks(marks, label=label))


def _ordered(coordinate: xr.DataArray) -> bool:
    """Whether a line between neighbouring values has a meaning: not for names and seeds."""
    words = f"{coordinate.name} {coordinate.attrs.get('long_name', '')}"
    return coordinate.dtype.kind in "if" and "seed" not in words
