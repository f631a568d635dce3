"""Plot peaks of forces of several chains over the speed of the impact or the height of fall."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ..chain.hertz_ratios import NO_PREDICTION
from .colours import curve_colour, grey
from .legends import place_legend
from .style import figure_style, get_axes, literal

# Closed markers, which can be hollow.
MARKERS: Final = ("o", "s", "^", "D", "v", "P", "X")
LINES: Final = ("-", "--", ":")


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
) -> Axes:
    """Plot the peaks of each chain, and a band of those with contacts that yield.

    The ``impacts`` are speeds, or ``heights`` of fall [m].  ``yielding`` has the peaks at both
    possible yield pressures, the ``factors`` times the yield strength.  Those of the three peaks
    that are ``outside`` have hollow markers.  Peaks that are not known are infinite, and left out.
    """
    si = units == "SI"
    with figure_style():
        axes = get_axes(None)
        for i, (name, own) in enumerate(peaks.items()):
            order = np.argsort(impacts[name])
            x = np.array(impacts[name])[order] * (1e3 if heights else 1.0)
            values = [own, *zip(*yielding.get(name, ()), strict=True)]
            known = [np.where(np.isfinite(each), each, np.nan)[order] for each in values]
            _draw_chain(axes, i, name, x, known, np.array(outside[name])[order].T)
        _name_lines(axes, factors, yields=bool(yielding),
                    hollow=any(np.any(each) for each in outside.values()))  # fmt: skip
        over = "height of fall [mm]" if heights else f"velocity of the impact{' [m/s]' * si}"
        axes.set_xlabel(over)
        axes.set_ylabel(f"peak force on {where}{' [N]' * si}")
        axes.set_ylim(bottom=0.0)
        if len(axes.get_legend_handles_labels()[1]) > 1:
            place_legend(axes, own=True)
    return axes


def _draw_chain(
    axes: Axes, i: int, name: str, x: NDArray[np.float64], values: list[NDArray[np.float64]],
    outside: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Draw the peaks of a chain with elastic contacts and at both yield pressures."""
    colour, marker = curve_colour(axes, i), MARKERS[i % len(MARKERS)]
    if len(values) > 1:
        axes.fill_between(x, values[1], values[2], color=colour, alpha=0.12, linewidth=0.0)
    for line, y, flags in zip(LINES, values, outside, strict=False):
        label = (literal(name) or "elastic") if line == "-" else None
        axes.plot(x, y, line, label=label, color=colour, marker=marker,
                  markevery=np.flatnonzero(~flags).tolist())  # fmt: skip
        axes.plot(x[flags], y[flags], linestyle="none", color=colour, marker=marker,
                  markerfacecolor=axes.get_facecolor(), zorder=3.0)  # fmt: skip


def _name_lines(axes: Axes, factors: tuple[str, str], *, yields: bool, hollow: bool) -> None:
    """Add the kinds of lines and of markers to the legend."""
    neutral = grey(axes, 0.4)
    for line, factor in zip(LINES[1:], factors, strict=True):
        if yields:
            axes.plot([], [], line, color=neutral, label=f"with yield, {factor} $Y$")
    if hollow:
        label = f"no prediction: overlap / radius > {NO_PREDICTION:g}"
        axes.plot([], [], "o", color=neutral, markerfacecolor=axes.get_facecolor(), label=label)
