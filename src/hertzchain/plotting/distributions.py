"""Plot the distribution of a quantity over random chains."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from matplotlib.axes import Axes

from ..representation import usual_unit, with_decimals
from .colours import COLOURS, grey
from .legends import place_legend
from .style import figure_style, get_axes, label_narrow_axis, set_title, with_micro
from .titles import chain_title

if TYPE_CHECKING:
    from ..designs.distribution import Distribution


# Percentiles that are marked.
MARKED: Final = {5.0: "5%", 50.0: "median", 95.0: "95%"}


def plot_distribution(found: Distribution, *, ax: Axes | None = None) -> Axes:
    """Plot a histogram of a `hertzchain.Distribution`, with its mean and three percentiles."""
    with figure_style():
        axes = get_axes(ax)
        factor, unit = usual_unit(found.nominal, found.unit)
        axes.hist(factor * found.values, bins="auto", color=COLOURS[5],
                  edgecolor=axes.get_facecolor(), linewidth=0.5)  # fmt: skip
        elastic = "" if math.isnan(found.yielding) else ", elastic contacts"
        shown = f" {with_micro(unit)}" if unit != "1" else ""
        marked = [percent for percent in MARKED if not found._few_values_note([percent])]
        nominal, mean, *places = _in_words(found, factor, marked)
        axes.axvline(factor * found.nominal, color=grey(axes),
                     label=f"nominal chain{elastic}: {nominal}{shown}")  # fmt: skip
        axes.axvline(factor * found.mean, color=COLOURS[2], linestyle="--",
                     label=f"mean: {mean}{shown}")  # fmt: skip
        label = f"{', '.join(MARKED[each] for each in marked)}: {', '.join(places)}{shown}"
        _mark_percentiles(axes, [factor * found.percentile(each) for each in marked], label)
        label_narrow_axis(axes)
        axes.set_xlabel(found.label + (f" [{with_micro(unit)}]" if unit != "1" else ""))
        axes.set_ylabel("number of chains")
        deviations = with_micro(found.scatter._in_words(found.chain.units))
        set_title(axes, f"{chain_title(found.chain)}, {deviations}".replace("+-", "±"))
        place_legend(axes, own=ax is None)
    return axes


def _in_words(found: Distribution, factor: float, marked: list[float]) -> list[str]:
    """Nominal value, mean and percentiles, with the decimals of the command."""
    values = [found.nominal, found.mean, *map(found.percentile, marked)]
    return with_decimals([factor * value for value in values], factor * found.standard_deviation)


def _mark_percentiles(axes: Axes, places: list[float], label: str) -> None:
    """Lines at the percentiles that the values determine; their values are in the legend.

    Labels at the lines would overlap in a narrow distribution far from the nominal value.
    """
    for place in places:
        axes.axvline(place, color=grey(axes, 0.2), linestyle=":", label=label)
        label = "_nolegend_"
