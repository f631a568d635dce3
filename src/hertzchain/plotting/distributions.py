"""Plot the distribution of a quantity over random chains."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ..chain.yield_pressure import DEFINED, YIELD_ASSUMED, YIELD_STATED
from ..collision import Array
from ..representation import in_column, usual_unit, with_decimals
from .colours import COLOURS, grey
from .legends import place_legend
from .style import figure_style, get_axes, label_narrow_axis, set_title, with_micro
from .titles import chain_title

if TYPE_CHECKING:
    from ..designs.distribution import Distribution


# Percentiles that are marked.
MARKED: Final = {5.0: "5%", 50.0: "median", 95.0: "95%"}
# Largest number of bins of two histograms, which can be narrow and far apart.
MAX_BINS: Final = 200


def plot_distribution(found: Distribution, *, ax: Axes | None = None) -> Axes:
    """Plot a histogram of a `hertzchain.Distribution`, with its mean and three percentiles."""
    with figure_style():
        axes = get_axes(ax)
        factor, unit = usual_unit(found.nominal, found.unit)
        axes.hist(factor * found.values, bins="auto", color=COLOURS[5],
                  edgecolor=axes.get_facecolor(), linewidth=0.5)  # fmt: skip
        shown = f" {with_micro(unit)}" if unit != "1" else ""
        marked = [percent for percent in MARKED if not found._few_values_note([percent])]
        nominal, mean, *places = _in_words(found, factor, marked)
        beyond = "" if math.isnan(found.yielding) else _if_yielding(found, factor, shown)
        axes.axvline(factor * found.nominal, color=grey(axes),
                     label=f"nominal chain{', elastic contacts' * bool(beyond)}: {nominal}{shown}"
                           f"{beyond}")  # fmt: skip
        axes.axvline(factor * found.mean, color=COLOURS[2], linestyle="--",
                     label=f"mean: {mean}{shown}")  # fmt: skip
        label = f"{', '.join(MARKED[each] for each in marked)}: {', '.join(places)}{shown}"
        _mark_percentiles(axes, [factor * found.percentile(each) for each in marked], label)
        _finish(axes, found, unit, own=ax is None)
    return axes


def plot_at_both_pressures(low: Distribution, high: Distribution, names: tuple[str, str]) -> Axes:
    """Plot histograms of the same random chains at the ends of the range of the yield pressure.

    Dotted lines mark the 95% percentiles, if enough chains determine them.
    """
    with figure_style():
        axes = get_axes(None)
        factor, unit = usual_unit(low.nominal, low.unit)
        shown = f" {with_micro(unit)}" if unit != "1" else ""
        bins = _common_bins(factor * low.values, factor * high.values)
        for name, each, colour in zip(names, (low, high), (COLOURS[5], COLOURS[1]), strict=True):
            marked = [] if each._few_values_note([95.0]) else [95.0]
            nominal, mean, *places = _in_words(each, factor, marked)
            most = "".join(f", 95% below {place}{shown}" for place in places)
            label = f"{name}: nominal {nominal}{shown}, mean {mean}{shown}{most}"
            axes.hist(factor * each.values, bins=bins, color=colour, alpha=0.6, label=label,
                      edgecolor=axes.get_facecolor(), linewidth=0.5)  # fmt: skip
            for percent in marked:
                axes.axvline(factor * each.percentile(percent), color=colour, linestyle=":")
        # The legend has the pressures.
        title = chain_title(low.chain).replace(f", {YIELD_STATED}", "")
        _finish(axes, low, unit, own=True, title=title, legend=f"contacts yield {DEFINED}")
    return axes


def _common_bins(one: Array, other: Array) -> list[float]:
    """Edges of bins for two histograms, as narrow as those of the narrower one alone."""
    both = np.concatenate([one, other])
    widths = [np.diff(np.histogram_bin_edges(each, "auto"))[0] for each in (one, other)
              if np.ptp(each) > 0.0]  # fmt: skip
    if not widths:
        return list(np.histogram_bin_edges(both, "auto"))
    count = min(int(np.ceil(np.ptp(both) / min(widths) - 1e-9)), MAX_BINS)
    return list(np.linspace(both.min(), both.max(), max(count, 1) + 1))


def _finish(
    axes: Axes, found: Distribution, unit: str, *, own: bool, title: str = "", legend: str = ""
) -> None:
    """Label the axes, and name the chain and its deviations."""
    label_narrow_axis(axes)
    axes.set_xlabel(found.label + (f" [{with_micro(unit)}]" if unit != "1" else ""))
    axes.yaxis.set_major_locator(MaxNLocator("auto", integer=True))
    axes.set_ylabel(f"number of chains, of {len(found.values)}")
    deviations = with_micro(found.scatter._in_words(found.chain.units))
    set_title(axes, f"{title or chain_title(found.chain)}, {deviations}".replace("+-", "±"))
    place_legend(axes, own=own, title=legend)


def _if_yielding(found: Distribution, factor: float, unit: str) -> str:
    """The nominal value if contacts yield, unless it is outside the range of the law."""
    if found._with_yield.outside:
        return ", beyond yield"
    (value,) = in_column([factor * found.yielding], 4)
    return f"\n({value}{unit} if {YIELD_ASSUMED}; Y: yield strength)"


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
