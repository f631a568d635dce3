"""Plot peaks of forces of several chains over the speed of the impact or the height of fall."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ..chain.hertz_ratios import NO_PREDICTION
from .colours import curve_colour, grey
from .legends import place_legend
from .log_labels import ROUNDING
from .style import figure_style, get_axes, label_log_axis, literal
from .widths import figure_size

# Closed markers, which can be hollow.
MARKERS: Final = ("o", "s", "^", "D", "v", "P", "X")
LINES: Final = ("-", "--", ":")
# Difference, relative to the largest value, of curves that cannot be distinguished.
SAME: Final = 3e-3
# Impacts, and the factor between their extremes or those of the forces, from which axes are
# logarithmic.
FEWEST: Final = 3
FACTOR: Final = 4.0
FORCE_FACTOR: Final = 10.0
# Speeds or heights, and the peaks with elastic contacts and at both yield pressures.
Curve = tuple[NDArray[np.float64], list[NDArray[np.float64]]]
NO_SENSORS: Final[Mapping[str, Mapping[str, Sequence[float]]]] = MappingProxyType({})


def plot_peaks(
    impacts: Mapping[str, Sequence[float]],
    peaks: Mapping[str, Sequence[float]],
    yielding: Mapping[str, Sequence[tuple[float, float]]],
    outside: Mapping[str, Sequence[tuple[bool, bool, bool]]],
    *,
    factors: tuple[str, str],
    where: str,
    units: str,
    heights: bool = False,
    sensors: Mapping[str, Mapping[str, Sequence[float]]] = NO_SENSORS,
    lawful: Collection[str] = (),
    given_pressure: bool = False,
) -> Axes:
    """Plot the peaks of each chain, and a band of those with contacts that yield.

    The ``impacts`` are speeds, or ``heights`` of fall [m].  ``yielding`` has the peaks at both
    possible yield pressures, the ``factors`` times the yield strength.  Those of the three peaks
    that are ``outside`` have hollow markers.  Peaks that are not known are infinite, and left out.
    Contacts of the ``lawful`` chains yield at an assumed pressure: their own peaks are those at the
    smaller one, and no elastic ones are drawn.  With ``given_pressure``, contacts of other chains
    yield at a pressure of their own.  First maxima in ``sensors``, by the names of sensors and
    chains, are in panels below.  Of three or more impacts with a wide range of them or of the
    peaks, both axes are logarithmic, so that exponents are visible.
    """
    unit = " [N]" if units == "SI" else ""
    with figure_style():
        axes, *others = _panels(1 + len(sensors))
        values = {name: [_elastic(own, name in lawful), *zip(*yielding.get(name, ()), strict=True)]
                  for name, own in peaks.items()}  # fmt: skip
        _draw_chains(axes, impacts, values, outside, heights=heights)
        names = {line: _name_with_yield(factor, values, i)
                 for i, (line, factor) in enumerate(zip(LINES[1:], factors, strict=True), 1)
                 if yielding}  # fmt: skip
        solid = "elastic, or its own yield pressure" if given_pressure else "elastic"
        solid *= any(np.isfinite(each[0]).any() for each in values.values())
        _name_lines(axes, names, solid=solid * any(peaks),
                    hollow=any(np.any(each) for each in outside.values()))  # fmt: skip
        between = "\n" if others else " "
        axes.set_ylabel(f"peak force on{between}{where}{unit}")
        for panel, (sensor, forces) in zip(others, sensors.items(), strict=True):
            values = {name: [_elastic(own, True), own] if name in lawful else [own]
                      for name, own in forces.items()}  # fmt: skip
            _draw_chains(panel, impacts, values, outside, heights=heights)
            panel.set_ylabel(f"first maximum in\n{sensor}{unit}")
        over = "height of fall [mm]" if heights else "velocity of the impact"
        over += " [m/s]" if units == "SI" and not heights else ""
        (axes, *others)[-1].set_xlabel(over)
        drawn: list[Sequence[Any]] = [*peaks.values(), *yielding.values()]
        drawn += [own for at_sensor in sensors.values() for own in at_sensor.values()]
        _scale([axes, *others], logarithmic=_shows_exponents(impacts, drawn))
        if len(axes.get_legend_handles_labels()[1]) > 1:
            place_legend(axes, own=not others)
    return axes


def _elastic(own: Sequence[float], lawful: bool) -> Sequence[float]:
    """Peaks with elastic contacts, which are not known if contacts have a law of yield."""
    return [np.inf] * len(own) if lawful else own


def _shows_exponents(
    impacts: Mapping[str, Sequence[float]], forces: Sequence[Sequence[Any]]
) -> bool:
    """Whether the impacts have a wide range and all values have a logarithm."""
    x = np.concatenate([np.asarray(each, float) for each in impacts.values()])
    y = np.concatenate([np.ravel(np.asarray(each, float)) for each in forces])
    # Exactly four times, such as 1 mm to 4 mm, is wide enough despite rounding errors.
    wide = x.max() >= FACTOR * (1.0 - ROUNDING) * x.min()
    y = y[np.isfinite(y)]
    # Peaks with yield would be a line at the lower edge of a linear axis.
    wide |= y.size > 0 and y.max() >= FORCE_FACTOR * y.min()
    # Heights of different chains may differ by rounding errors.
    several = max(len(np.unique(each)) for each in impacts.values()) >= FEWEST
    return bool(wide and several and y.size and x.min() > 0.0 and (y > 0.0).all())


def _scale(panels: Sequence[Axes], *, logarithmic: bool) -> None:
    """Logarithmic axes, or forces from zero; a panel without any force says so."""
    for panel in panels:
        if not any(np.isfinite(line.get_ydata()).any() for line in panel.lines):
            panel.text(0.5, 0.5, "no force is known", transform=panel.transAxes, ha="center",
                       va="center", color=grey(panel, 0.4))  # fmt: skip
            panel.set_yticks([])
        elif logarithmic:
            panel.set_xscale("log")
            panel.set_yscale("log")
            label_log_axis(panel.yaxis)
        else:
            panel.set_ylim(bottom=0.0)
    if logarithmic:
        label_log_axis(panels[-1].xaxis)


def _draw_chains(
    axes: Axes,
    impacts: Mapping[str, Sequence[float]],
    values: Mapping[str, Sequence[Sequence[float]]],
    outside: Mapping[str, Sequence[tuple[bool, bool, bool]]],
    *,
    heights: bool,
) -> None:
    """Draw one or three curves of each chain."""
    drawn: dict[str, Curve] = {}
    for i, (name, own) in enumerate(values.items()):
        x, known, flags = _in_order(impacts[name], own, outside[name], heights=heights)
        same = next((other for other, curve in drawn.items() if _same(curve, (x, known))), "")
        drawn[name] = x, known
        _draw_chain(axes, i, name, x, known, flags, same)


def _same(one: Curve, other: Curve) -> bool:
    """Whether two elastic curves cannot be distinguished in a figure."""
    (x, values), (other_x, others) = one, other
    if not np.array_equal(x, other_x) or np.isnan(values[0]).all():
        return False
    top = max(float(np.nanmax(values[0], initial=0.0)), float(np.nanmax(others[0], initial=0.0)))
    return np.allclose(values[0], others[0], rtol=0.0, atol=SAME * top, equal_nan=True)


def _name_with_yield(
    factor: str, values: Mapping[str, Sequence[Sequence[float]]], kind: int
) -> str:
    """Name of the curves with yield, which states if elastic ones cover them in all chains."""
    pairs = [(each[0], each[kind]) for each in values.values() if len(each) > kind]
    covered = all(np.allclose(own, other, rtol=SAME, atol=0.0) for own, other in pairs)
    if not covered:
        return f"with yield, {factor} $Y$"
    # After the name of another line with yield, a short name leaves the legend narrow.
    return f"{factor} $Y$: as elastic" if kind > 1 else f"with yield, {factor} $Y$: as elastic"


def _panels(count: int) -> list[Axes]:
    """One axes, or panels below each other with a common x axis."""
    if count == 1:
        return [get_axes(None)]
    width, height = plt.rcParams["figure.figsize"]
    size = figure_size(width, 0.55 * count * height)
    figure, panels = plt.subplots(count, 1, sharex=True, figsize=size)
    figure.align_ylabels(panels)
    return list(panels)


def _in_order(
    impacts: Sequence[float], values: Sequence[Sequence[float]],
    outside: Sequence[tuple[bool, bool, bool]], *, heights: bool,
) -> tuple[NDArray[np.float64], list[NDArray[np.float64]], NDArray[np.bool_]]:  # fmt: skip
    """Impacts in ascending order [mm, m/s or scaled], known values and flags in the same order."""
    order = np.argsort(impacts)
    x = np.array(impacts)[order] * (1e3 if heights else 1.0)
    known = [np.where(np.isfinite(each), each, np.nan)[order] for each in values]
    return x, known, np.array(outside)[order].T


def _draw_chain(
    axes: Axes, i: int, name: str, x: NDArray[np.float64], values: list[NDArray[np.float64]],
    outside: NDArray[np.bool_], same: str,
) -> None:  # fmt: skip
    """Draw the peaks of a chain with elastic contacts and at both yield pressures.

    The elastic curve of ``same``, an earlier chain with the same values, stays visible below it.
    """
    colour, marker = curve_colour(axes, i), MARKERS[i % len(MARKERS)]
    if len(values) > 2:
        axes.fill_between(x, values[1], values[2], color=colour, alpha=0.12, linewidth=0.0)
    # The name of a chain without elastic peaks is that of its first curve with yield.
    elastic = len(values) == 1 or not np.isnan(values[0]).all()
    for line, y, flags in zip(LINES, values, outside, strict=False):
        if line == "-" and not elastic:
            continue
        named = line == ("-" if elastic else "--")
        label = (literal(name) or ("elastic" if elastic else None)) if named else None
        if label and same:
            label += f" (elastic: the same curve as {literal(same)})"
        # A thinner line with smaller markers leaves the other one visible.
        size = plt.rcParams["lines.markersize"]
        covered = bool(same) and line == "-"
        width = plt.rcParams["lines.linewidth"] * (0.4 if covered else 1.0)
        axes.plot(x, y, line, label=label, color=colour, marker=marker, linewidth=width,
                  markersize=size * (0.5 if covered else 1.0),
                  markevery=np.flatnonzero(~flags).tolist())  # fmt: skip
        axes.plot(x[flags], y[flags], linestyle="none", color=colour, marker=marker,
                  markerfacecolor=axes.get_facecolor(), zorder=3.0)  # fmt: skip


def _name_lines(axes: Axes, names: Mapping[str, str], *, solid: str, hollow: bool) -> None:
    """Add the kinds of lines and of markers to the legend."""
    neutral = grey(axes, 0.4)
    if names and solid:
        axes.plot([], [], LINES[0], color=neutral, label=solid)
    for line, name in names.items():
        axes.plot([], [], line, color=neutral, label=name)
    if hollow:
        label = f"no prediction: overlap / radius > {NO_PREDICTION:g}"
        axes.plot([], [], "o", color=neutral, markerfacecolor=axes.get_facecolor(), label=label)
