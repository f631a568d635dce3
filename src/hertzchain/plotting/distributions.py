"""Plot the distribution of a quantity over random chains."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from matplotlib.axes import Axes

from ..chain.scattered_radii import scatter_in_words
from ..representation import usual_unit
from .colours import COLOURS, grey
from .legends import place_legend
from .style import figure_style, get_axes, label_narrow_axis, set_title, with_micro
from .titles import chain_title

if TYPE_CHECKING:
    from ..designs.distribution import Distribution


def plot_distribution(found: Distribution, *, ax: Axes | None = None) -> Axes:
    """Plot a histogram of a `hertzchain.Distribution`, with the nominal value and the mean."""
    with figure_style():
        axes = get_axes(ax)
        factor, unit = usual_unit(found.nominal, found.unit)
        axes.hist(factor * found.values, bins="auto", color=COLOURS[5],
                  edgecolor=axes.get_facecolor(), linewidth=0.5)  # fmt: skip
        elastic = "" if math.isnan(found.yielding) else ", elastic contacts"
        axes.axvline(factor * found.nominal, color=grey(axes), label=f"nominal chain{elastic}")
        axes.axvline(factor * found.mean, color=COLOURS[2], linestyle="--", label="mean")
        label_narrow_axis(axes)
        axes.set_xlabel(found.label + (f" [{with_micro(unit)}]" if unit != "1" else ""))
        axes.set_ylabel("number of chains")
        deviations = scatter_in_words(found.scatter.radius, found.scatter.grade)
        set_title(axes, f"{chain_title(found.chain)}, {deviations}")
        place_legend(axes, own=ax is None)
    return axes
