"""Plot peaks of forces of several chains over the speed of the impact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes

from .colours import curve_colour
from .legends import place_legend
from .style import MARKERS, figure_style, get_axes, literal


def plot_peaks(
    speeds: Mapping[str, Sequence[float]],
    peaks: Mapping[str, Sequence[float]],
    yielding: Mapping[str, Sequence[float]],
    *,
    where: str,
    units: str,
) -> Axes:
    """Plot the peaks of each chain, and dashed those with contacts that yield.

    Peaks that are not known are infinite, and left out.
    """
    si = units == "SI"
    with figure_style():
        axes = get_axes(None)
        for i, (name, own) in enumerate(peaks.items()):
            order = np.argsort(speeds[name])
            x, colour = np.array(speeds[name])[order], curve_colour(axes, i)
            marker = MARKERS[i % len(MARKERS)]
            for values, line in ((own, "-"), (yielding.get(name), "--")):
                if values is not None:
                    y = np.where(np.isfinite(values), values, np.nan)[order]
                    words = [literal(name)] * bool(name) + ["with yield"] * (line == "--")
                    axes.plot(x, y, line, label=", ".join(words) or "elastic",
                              color=colour, marker=marker)  # fmt: skip
        axes.set_xlabel(f"velocity of the impact{' [m/s]' * si}")
        axes.set_ylabel(f"peak force on {where}{' [N]' * si}")
        axes.set_ylim(bottom=0.0)
        if len(axes.lines) > 1:
            place_legend(axes, own=True)
    return axes
