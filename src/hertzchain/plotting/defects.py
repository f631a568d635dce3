"""Plot which defect of a chain would explain the residuals of a fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ..validation.objects import check_bool
from .colours import curve_colour, grey
from .legends import place_legend
from .style import MARKERS, figure_style, get_axes, label_log_axis

if TYPE_CHECKING:
    from ..fitting.defect_scan import DefectScan

# Name of each kind of defect in the legend.
LABELS: Final = {"gap": "gap", "bead": "odd ball", "contact": "odd contact"}


def plot_defect_scans(
    scans: Sequence[DefectScan], *, legend: bool = True, ax: Axes | None = None
) -> Axes:
    """Plot the chi-squared of a fit with one defect against its place, for each kind of defect.

    Contacts are between the numbers of their balls.  The best defect of each kind has a larger
    symbol and is named with its size in the legend.
    """
    legend = check_bool("legend", legend)
    with figure_style():
        axes = get_axes(ax)
        present = axes.get_legend_handles_labels()[1]
        for i, scan in enumerate(scans, len([each for each in present if "best" in each])):
            places, chi2 = scan.places, np.maximum(scan.chi2 - scan.improvements, 1.0)
            best, marker = int(np.argmax(scan.improvements)), MARKERS[i % len(MARKERS)]
            size = scan._size_text(best).replace("um", "µm").replace("-", "\N{MINUS SIGN}")
            doubt = "" if scan.found else " (not significant)"
            name = f"{LABELS[scan.kind]}, best: {_place(scan.best)}, {size}{doubt}"
            colour = curve_colour(axes, i)
            axes.plot(places, chi2, color=colour, marker=marker, label=name, linewidth=1.0)
            axes.plot(places[best], chi2[best], marker, color=colour, markersize=9.0)
        levels = {"no defect": (scans[0].chi2, "--"), "noise alone": (scans[0].freedom, ":")}
        for name, (level, style) in levels.items():
            if name not in present:
                axes.axhline(level, color=grey(axes), linestyle=style, linewidth=0.9, label=name)
        axes.set_yscale("log")
        label_log_axis(axes.yaxis)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel("number of the ball; a contact is between two balls")
        axes.set_ylabel(r"$\chi^2$ with one defect")
        if legend:
            place_legend(axes, own=ax is None)
    return axes


def _place(name: str) -> str:
    """The place of a defect, such as ``ball 8`` of ``radius[8]``, or ``balls 8 and 9``."""
    _, _, numbers = name.removesuffix("]").partition("[")
    first, _, second = numbers.partition("-")
    return f"balls {first} and {second}" if second else f"ball {first}"
