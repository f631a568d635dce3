"""Plot the distribution of a quantity over random chains."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from matplotlib.axes import Axes

from ..representation import usual_unit
from .colours import COLOURS, grey
from .legends import place_legend
from .style import figure_style, get_axes, label_narrow_axis, set_title, with_micro
from .titles import chain_title

if TYPE_CHECKING:
    from ..designs.distribution import Distribution


# Percentiles that are marked, and the height of their lines relative to the axes; labels are above.
MARKED: Final = {5.0: "5%", 50.0: "median", 95.0: "95%"}
HEIGHT: Final = 0.9


def plot_distribution(found: Distribution, *, ax: Axes | None = None) -> Axes:
    """Plot a histogram of a `hertzchain.Distribution`, with its mean and three percentiles."""
    with figure_style():
        axes = get_axes(ax)
        factor, unit = usual_unit(found.nominal, found.unit)
        axes.hist(factor * found.values, bins="auto", color=COLOURS[5],
                  edgecolor=axes.get_facecolor(), linewidth=0.5)  # fmt: skip
        elastic = "" if math.isnan(found.yielding) else ", elastic contacts"
        axes.set_ylim(top=axes.get_ylim()[1] / HEIGHT)
        axes.axvline(factor * found.nominal, ymax=HEIGHT, color=grey(axes),
                     label=f"nominal chain{elastic}")  # fmt: skip
        axes.axvline(factor * found.mean, ymax=HEIGHT, color=COLOURS[2], linestyle="--",
                     label="mean")  # fmt: skip
        _mark_percentiles(axes, found, factor)
        label_narrow_axis(axes)
        axes.set_xlabel(found.label + (f" [{with_micro(unit)}]" if unit != "1" else ""))
        axes.set_ylabel("number of chains")
        deviations = with_micro(found.scatter._in_words(found.chain.units))
        set_title(axes, f"{chain_title(found.chain)}, {deviations}")
        place_legend(axes, own=ax is None)
    return axes


def _mark_percentiles(axes: Axes, found: Distribution, factor: float) -> None:
    """Lines with labels at the percentiles that the values determine."""
    colour, upwards = grey(axes, 0.2), axes.get_xaxis_transform()
    for percent, label in MARKED.items():
        if found._few_values_note([percent]):
            continue
        place = factor * found.percentile(percent)
        axes.axvline(place, ymax=HEIGHT, color=colour, linestyle=":")
        axes.text(place, HEIGHT, label, color=colour, transform=upwards, ha="center", va="bottom")
