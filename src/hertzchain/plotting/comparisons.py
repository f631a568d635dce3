"""Plot relative errors of one pulse with respect to another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from ..chain.chain_words import described_loss
from ..chain.laws.elastic import Elastic
from ..pulse.free_end import ends_free
from ..pulse.quantities import COLUMN_QUANTITIES
from .colours import curve_colour, grey
from .differences import loss_in_words, words_of_chains, words_of_loss
from .free_ends import draw_end_outside_limits, end_style, include_ends, label_free_end
from .labels import distinguish
from .legends import place_legend
from .shared_axes import label_below
from .style import MARKERS, BeadLocator, figure_style, get_axes, label_log_axis, set_title

if TYPE_CHECKING:
    from ..pulse.comparison import Comparison
    from ..pulse.pulse import Pulse


def plot_comparison(
    comparison: Comparison, quantities: Sequence[str], *, log: bool, legend: bool,
    ax: Axes | None,
) -> Axes:  # fmt: skip
    """Plot relative errors in percent against the bead number; their sizes if ``log``."""
    with figure_style():
        axes = get_axes(ax)
        ends = []
        for i, name in enumerate(quantities):
            errors = 100.0 * comparison.errors(name)
            beads = np.arange(1, len(errors) + 1)
            shown, marker = np.abs(errors) if log else errors, MARKERS[i % len(MARKERS)]
            free = any(ends_free(each, name) for each in (comparison.pulse, comparison.reference))
            end = len(shown) - free
            # The reference of bead 1 may be 0, and its error a difference.
            axes.plot(
                beads[1:end], shown[1:end], color=curve_colour(axes, i), marker=marker,
                markerfacecolor="none", markevery=max(1, len(beads) // 10),
                label=name.replace("_", " "),
            )  # fmt: skip
            if free:
                style, colour = end_style(marker), curve_colour(axes, i)
                ends.append((int(beads[-1]), float(shown[-1]), style, colour))
        # No line joins a free end, which moves unlike the other beads.
        include_ends(axes, [draw_end_outside_limits(axes, *end) for end in ends], linear=not log)
        if ends:
            label_free_end(axes)
        if log:
            axes.set_yscale("log")
            label_log_axis(axes.yaxis)
        else:
            axes.axhline(0.0, color=grey(axes), linewidth=0.8)
        contacts = {COLUMN_QUANTITIES[name].per == "contact" for name in quantities}
        label_below(axes, "bead or contact $k$" if len(contacts) > 1 else
                    "contact $k$" if contacts == {True} else "bead $k$")  # fmt: skip
        axes.set_ylabel("|error| [%]" if log else "error [%]")
        axes.xaxis.set_major_locator(BeadLocator())
        ours, theirs = comparison.pulse, comparison.reference
        set_title(axes, _title(ours, theirs))
        if legend:
            place_legend(axes)
    return axes


def _title(ours: Pulse, theirs: Pulse) -> str:
    """Both methods and the chain, or the properties in which the chains of the pulses differ."""
    chains = words_of_chains([ours.chain, theirs.chain])
    if chains[0] == chains[1]:
        about, loss = ours.chain.description, loss_in_words(ours.chain)
        # Losses of walls alone have no other words.
        if loss != words_of_loss(Elastic(), ours.chain.units):
            about = about.replace(described_loss(ours.chain), loss)
        return f"{ours.method} against {theirs.method}, {about}"
    words = [[each.method, *own] for each, own in zip((ours, theirs), chains, strict=True)]
    names, common = distinguish(words)
    return f"{' against '.join(names)}, {common}"
