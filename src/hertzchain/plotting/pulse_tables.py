"""Plot a quantity of many pulses: median and band over the chains."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.axes import Axes

from ..errors import InputError
from ..pulse.free_end import split_free_ends
from ..pulse.quantities import COLUMN_QUANTITIES
from ..validation.objects import check_choice
from .colours import curve_colour, free_numbers, number_of_curves
from .free_ends import FREE_END, label_free_end
from .legends import place_legend
from .shared_axes import label_below
from .style import MARKERS, BeadLocator, figure_style, get_axes, set_title

if TYPE_CHECKING:
    from ..pulse.pulse_table import PulseTable

# Percentiles of the band, and its opacity.
LOW: Final = 5
HIGH: Final = 95
BAND: Final = 0.25


def plot_pulse_table(table: PulseTable, quantity: str, *, ax: Axes | None = None) -> Axes:
    """Plot the median of a quantity along the chains, with a band that has 90% of them.

    At free ends, the median has a symbol and the range a bar, which no line joins to the others.
    """
    check_choice("quantity", quantity, COLUMN_QUANTITIES)
    values, row = table.column(quantity), COLUMN_QUANTITIES[quantity]
    if values is None:
        raise InputError(f"propagate_many does not predict {quantity}")
    if not np.isfinite(values).any():
        raise InputError(f"no chain of the table has a {quantity}; see its reasons")
    values, ends = split_free_ends(values, table.beads, quantity, (LOW, 50, HIGH))
    known = np.isfinite(values).any(axis=0)
    low, middle, high = np.nanpercentile(values[:, known], (LOW, 50, HIGH), axis=0)
    place = np.arange(1, values.shape[1] + 1)[known]
    with figure_style():
        axes = get_axes(ax)
        colour = curve_colour(axes, *free_numbers(axes, number_of_curves(axes), 1))
        axes.fill_between(place, low, high, color=colour, alpha=BAND, linewidth=0.0,
                          label=f"{LOW}% to {HIGH}% of the chains")  # fmt: skip
        axes.plot(place, middle, color=colour, label="median")
        for bead, (lowest, median, highest) in ends.items():
            axes.plot([bead], [median], color=colour, marker=MARKERS[0], linestyle="none")
            axes.vlines(bead, lowest, highest, color=colour, alpha=BAND, linewidth=3.0)
        if ends and FREE_END not in axes.get_legend_handles_labels()[1]:
            label_free_end(axes)
        label_below(axes, f"{row.per} $k$")
        damped = any(chain is not None and chain._damped for chain in table.chains)
        axes.set_ylabel(row.label_in(table.units, damped=damped))
        axes.xaxis.set_major_locator(BeadLocator())
        good = len(table) - len(table.reasons)
        up_to = "" if len(set(table.beads.tolist())) == 1 else "up to "
        set_title(axes, f"{good} chains of {up_to}{table._longest}")
        place_legend(axes, own=ax is None)
    return axes
