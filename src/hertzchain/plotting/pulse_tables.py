"""Plot a quantity of many pulses: median and band over the chains."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.axes import Axes

from ..errors import InputError
from ..pulse.quantities import QUANTITIES
from ..validation.objects import check_choice
from .colours import curve_colour
from .legends import place_legend
from .style import BeadLocator, figure_style, get_axes, set_title

if TYPE_CHECKING:
    from ..pulse.pulse_table import PulseTable

# Percentiles of the band, and its opacity.
LOW: Final = 5
HIGH: Final = 95
BAND: Final = 0.25


def plot_pulse_table(table: PulseTable, quantity: str, *, ax: Axes | None = None) -> Axes:
    """Plot the median of a quantity along the chains, with a band that has 90% of them."""
    columns = table.columns()
    check_choice("quantity", quantity, columns)
    values, row = columns[quantity], QUANTITIES[quantity]
    known = np.isfinite(values).any(axis=0)
    if not known.any():
        raise InputError(f"no chain of the table has a {quantity}; see its reasons")
    low, middle, high = np.nanpercentile(values[:, known], (LOW, 50, HIGH), axis=0)
    place = np.arange(1, values.shape[1] + 1)[known]
    with figure_style():
        axes = get_axes(ax)
        colour = curve_colour(axes, len(axes.lines))
        axes.fill_between(place, low, high, color=colour, alpha=BAND, linewidth=0.0,
                          label=f"{LOW}% to {HIGH}% of the chains")  # fmt: skip
        axes.plot(place, middle, color=colour, label="median")
        axes.set_xlabel(f"{row.per} $k$")
        axes.set_ylabel(row.label_in(table.units))
        axes.xaxis.set_major_locator(BeadLocator())
        good = len(table) - len(table.reasons)
        up_to = "" if len(set(table.beads.tolist())) == 1 else "up to "
        set_title(axes, f"{good} chains of {up_to}{table.velocity.shape[1]} beads")
        place_legend(axes, own=ax is None)
    return axes
