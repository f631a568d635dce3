"""Plot which defect of a chain would explain the residuals of a fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final, cast

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..collision import Array
from ..representation import counted
from ..validation.objects import check_bool
from .colours import curve_colour, grey
from .legends import place_legend
from .signals import draw_signal, label_signal
from .style import (
    MARKERS,
    BeadLocator,
    figure_style,
    get_axes,
    label_log_axis,
    literal,
    seconds_axis,
    set_panel_title,
    with_micro,
)
from .widths import figure_size

if TYPE_CHECKING:
    from ..fitting.defect_scan import DefectScan
    from ..fitting.result import FitResult

# Name of each kind of defect in the legend.
LABELS: Final = {"gap": "gap", "bead": "odd ball", "contact": "odd contact"}
# The times are shown around the largest change of a signal by a defect, until the change is this
# fraction of it, and at least this number of samples before and after.
SMALL_CHANGE, MIN_SAMPLES = 0.2, 40
# Percentiles of the data at this change between which they are shown, the room above and below as a
# part of their range, and around the fits in standard deviations of the noise.
USUAL: Final = (1.0, 99.0)
ROOM, NOISE = 0.1, 3.0


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
        axes.xaxis.set_major_locator(BeadLocator())
        axes.set_xlabel("number of the ball; a contact is between two balls")
        axes.set_ylabel(r"$\chi^2$ with one defect")
        if legend:
            place_legend(axes, own=ax is None)
    return axes


def plot_fitted_defects(scans: Sequence[DefectScan], fits: Mapping[str, FitResult]) -> Figure:
    """Plot scans with the fitted defects and, below, the signal that the best one improves most.

    ``fits`` have the best fit of each kind for which the scan has found a defect; without any, the
    figure has the scans only.
    """
    if not fits:
        return cast(Figure, plot_defect_scans(scans).figure)
    best = min(fits.values(), key=lambda each: each.chi2 + each._penalty)
    width, height = figure_size(6.4, 7.0)
    with figure_style():
        figure, (upper, lower) = plt.subplots(
            2, figsize=(width, height), height_ratios=(1.2, 1.0), layout="constrained"
        )
        plot_defect_scans(scans, legend=False, ax=upper)
        for i, scan in enumerate(scans):
            if (fit := fits.get(scan.kind)) is not None:
                # The fit may have another mass of a ball instead of another radius.
                places = [_place(each) for each in scan.names]
                place = scan.places[places.index(_place(fit.names[-1]))]
                label = f"fitted: {_place(fit.names[-1])}, {_fitted_value(fit)}"
                upper.plot(place, fit.chi2, "*", color=curve_colour(upper, i), markersize=13.0,
                           markeredgecolor=grey(upper, 0.0), label=literal(label),
                           zorder=4.0)  # fmt: skip
        place_legend(upper, own=True)
        _draw_improved(lower, scans[0].result, best)
        place_legend(lower, own=True)
    return figure


def _fitted_value(fit: FitResult) -> str:
    """Value and error of a fitted gap, or of the diameter or mass of a fitted ball."""
    text = dict(fit.rows())[fit.names[-1]]
    _, _, usual = text.partition(": ")
    own = usual.removeprefix("diameter ").partition(",")[0] or text
    return with_micro(own.replace("+-", "±"))


def _draw_improved(axes: Axes, without: FitResult, best: FitResult) -> None:
    """Draw the signal whose residuals a defect reduces most, with the fits without and with it."""
    pairs = zip(without.residuals(), best.residuals(), strict=True)
    gains = [float(np.nansum(old**2) - np.nansum(new**2)) for (*_, old), (*_, new) in pairs]
    index = int(np.argmax(gains))
    shot, name, _ = best.residuals()[index]
    shots = best.traces.shots
    place = [signal.name for signal in shots[shot - 1].signals].index(name)
    factor, label = seconds_axis(max(float(np.ptp(each.times)) for each in shots))
    times = factor * shots[shot - 1].times
    signal, curves = shots[shot - 1].signals[place], (without, best)
    old, new = (each.predicted[shot - 1][place] for each in curves)
    draw_signal(axes, times, signal, new, f"fit with {_place(best.names[-1])}")
    axes.plot(times, old, "--", color=grey(axes, 0.2), linewidth=1.0, label="fit without a defect",
              zorder=2.5)  # fmt: skip
    of_shot = f", shot {shot}" if len(shots) > 1 else ""
    title = f"{literal(name)}{of_shot}, the signal that the defect improves most"
    set_panel_title(axes, title)
    axes.set_xlabel(label)
    seen = np.where(signal.valid, signal.values, np.nan)
    core, shown = _around_largest_change(np.abs(new - old))
    axes.set_xlim(times[shown][0], times[shown][-1])
    both = np.concatenate((new[core], old[core]))
    fits = both.min() - NOISE * signal.sigma, both.max() + NOISE * signal.sigma
    _limit_to_change(axes, seen[core], fits, seen[shown])
    label_signal(axes, signal)


def _around_largest_change(change: Array) -> tuple[slice, slice]:
    """The samples at which a defect changes a signal most, and those that are shown around them."""
    middle, small = int(np.argmax(change)), np.flatnonzero(change < SMALL_CHANGE * change.max())
    first = int(small[small < middle].max(initial=0))
    last = int(small[small > middle].min(initial=len(change) - 1))
    room = max(last - first, MIN_SAMPLES)
    return slice(first, last + 1), slice(max(first - room, 0), last + room + 1)


def _limit_to_change(axes: Axes, data: Array, fits: tuple[float, float], shown: Array) -> None:
    """Limit the axis to the fits and most data at the change; count the shown data beyond it.

    The pulse itself may be beside the change, and much higher.
    """
    usual = np.nanpercentile(data, USUAL) if np.isfinite(data).any() else fits
    low, high = min(fits[0], usual[0]), max(fits[1], usual[1])
    room = ROOM * (high - low)
    axes.set_ylim(low - room, high + room)
    beyond = int(np.sum((shown < low - room) | (shown > high + room)))
    if beyond:
        line = next(each for each in axes.lines if each.get_label() == "data")
        line.set_label(f"data ({counted(beyond, 'sample')} beyond the axes)")


def _place(name: str) -> str:
    """The place of a defect, such as ``ball 8`` of ``radius[8]``, or ``balls 8 and 9``."""
    _, _, numbers = name.removesuffix("]").partition("[")
    first, _, second = numbers.partition("-")
    return f"balls {first} and {second}" if second else f"ball {first}"
