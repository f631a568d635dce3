"""Plot the energy or momentum of a run by location, stacked over time."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.ticker import FuncFormatter

from ..simulation.budget import BALANCED, COLOURS, MOVING, Balanced, Budget
from ..simulation.horizon import Horizon
from ..validation.keywords import checked_arguments
from ..validation.objects import check_bool, check_choice, check_type
from .colours import grey
from .legends import figure_of, place_legend
from .runs import check_times
from .shared_axes import label_below, prefixed
from .style import (
    figure_style,
    get_axes,
    mark_horizon,
    set_title,
    signed,
    time_axis,
)
from .titles import chain_title
from .widths import NARROW

# Hatching of locations, besides their colours.
HATCHES: Final = {"scattered back": "//", "left wall": "\\\\", "lost": ".."}
# Height of a line of text relative to its letters.
LINE_HEIGHT: Final = 1.5
UNITS: Final = {"energy": "J", "momentum": "N s"}


@checked_arguments("plot_budget")
def plot_budget(
    budget: Budget,
    of: Balanced = "energy",
    *,
    horizon: Horizon | None = None,
    legend: bool = True,
    ax: Axes | None = None,
) -> Axes:
    """Plot energy or momentum by location, stacked over time; backward momentum is negative.

    Parameters
    ----------
    budget : Budget
        Of a run with at least two saved times.
    of : str
        ``"energy"`` or ``"momentum"``.
    horizon : Horizon, optional
        Result of `Run.horizon`; times beyond it are shaded.
    legend : bool
        Whether there is a legend, to the right of the axes or above narrow ones.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into.  By default, a new figure is created.

    Raises
    ------
    InputError
        For another value of `of`, or a single saved time.

    Examples
    --------
    >>> import hertzchain as hc
    >>> axes = hc.plotting.plot_budget(hc.simulate(hc.Chain.uniform(9)).budget(), "momentum")
    >>> axes.get_ylabel()
    'momentum'
    """
    check_choice("balance", of, BALANCED)
    legend = check_bool("legend", legend)
    if horizon is not None:
        check_type("horizon", horizon, Horizon, "run.horizon() is one")
    check_times(budget.times, "a stacked plot")
    there = budget.energy if of == "energy" else budget.momentum
    given = budget.energy_given if of == "energy" else budget.momentum_given
    shown = {name: values for name, values in there.items() if np.abs(values).max() > 0.0}
    factor, label = time_axis(budget.chain, float(budget.times[-1]))
    times, total = factor * budget.times, np.sum([*given.values()], axis=0)
    with figure_style():
        axes = get_axes(ax)
        above, below = np.zeros(len(times)), np.zeros(len(times))
        for name, values in shown.items():
            colour, hatch = COLOURS[name], HATCHES.get(name, "")
            for base, part in ((above, np.maximum(values, 0.0)), (below, np.minimum(values, 0.0))):
                if np.any(part != 0.0):
                    axes.fill_between(
                        times, base, base + part, facecolor=colour, hatch=hatch,
                        edgecolor="white", linewidth=0.0,
                    )  # fmt: skip
                base += part
            # The pulse has energy in its contacts, too.
            kinetic = " (kinetic)" if of == "energy" and name in MOVING else ""
            axes.fill_between([], [], [], facecolor=colour, hatch=hatch, edgecolor="white",
                              label=f"{name}{kinetic}")  # fmt: skip
        axes.plot(times, total, color=grey(axes), linewidth=1.0, label="total input")
        if np.any(below < 0.0):
            _label_directions(axes)
        label_y = budget._name(of)
        axes.set_ylabel(label_y)
        if budget.chain.units == "SI":
            # The energy of an impact may be a few microjoules; a prefix avoids many zeros.
            scale, unit = prefixed(float(np.abs([above, below]).max()), UNITS[of])
            axes.yaxis.set_major_formatter(
                FuncFormatter(lambda value, _: signed(scale * value, "z.6g"))
            )
            axes.set_ylabel(f"{label_y} [{unit}]")
        label_below(axes, label)
        set_title(axes, chain_title(budget.chain))
        axes.margins(x=0.0)
        mark_horizon(axes, horizon, factor)
        if legend and ax is None and figure_of(axes).get_figwidth() < NARROW:
            # Beside narrow axes, it would take a third of the width.
            place_legend(axes, own=True)
        elif legend:
            # In the order in which the parts are stacked.
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), reverse=True)
    return axes


def _label_directions(axes: Axes) -> None:
    """Draw the line at 0, and name the directions above and below the areas."""
    axes.axhline(0.0, color=grey(axes), linewidth=0.6)
    _leave_room(axes)
    for height, text in ((0.98, "+ forward"), (0.02, "− backward")):
        axes.text(0.015, height, text, transform=axes.transAxes,
                  fontsize=rcParams["legend.fontsize"],
                  va="top" if height > 0.5 else "bottom")  # fmt: skip


def _leave_room(axes: Axes) -> None:
    """Leave room for a line of text above and below the areas."""
    size = FontProperties(size=rcParams["legend.fontsize"]).get_size_in_points()
    inches = axes.get_window_extent().height / axes.figure.dpi
    line = min(0.25, 0.03 + LINE_HEIGHT * size / 72.0 / inches)
    axes.margins(y=line / (1.0 - 2.0 * line))
