"""Plot the tracks of waves."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes

from ..simulation.waves import DIRECTIONS, Wave, Waves
from ..validation.keywords import checked_arguments
from ..validation.objects import check_bool
from .colours import COLOURS, grey
from .legends import place_legend
from .shared_axes import label_below, prefixed
from .style import BeadLocator, figure_style, get_axes, set_title, time_axis
from .titles import chain_title

# Part of the largest energy below which the widths of lines are explained.
SAME: Final = 0.9
# Relative change of the energy at which a track has another width, and neighbours in its median.
CHANGE, NEAR = 0.1, 5
LINES = {1: (COLOURS[1], "-"), -1: (COLOURS[2], "--")}


@checked_arguments("plot_waves")
def plot_waves(waves: Waves, *, legend: bool = True, ax: Axes | None = None) -> Axes:
    """Plot the track of every wave: contact against time, coloured by direction.

    The width of a line increases with the energy of its wave, and changes where this energy does,
    such as at an odd bead; if the energies differ, the legend has lines of the largest energy and
    of a tenth of it.

    Parameters
    ----------
    waves : Waves
        The waves of a run.
    legend : bool
        Whether the axes have a legend.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into.  By default, a new figure is created.

    Examples
    --------
    >>> import hertzchain as hc
    >>> axes = hc.plotting.plot_waves(hc.simulate(hc.Chain.uniform(30), until=30.0).waves())
    >>> [text.get_text() for text in axes.get_legend().get_texts()]
    ['to the right']
    """
    legend = check_bool("legend", legend)
    last = max((float(wave.times[-1]) for wave in waves), default=0.0)
    factor, label = time_axis(waves.chain, last)
    energies = [energy for wave in waves for _, energy in _parts(wave)]
    strongest = max(energies, default=1.0)
    with figure_style():
        axes = get_axes(ax)
        for wave in waves:
            colour, style = LINES[wave.direction]
            for part, energy in _parts(wave):
                axes.plot(factor * wave.times[part], wave.contacts[part], color=colour,
                          linestyle=style, linewidth=_width(energy / strongest))  # fmt: skip
        for sign in dict.fromkeys(sorted((wave.direction for wave in waves), reverse=True)):
            axes.plot([], [], color=LINES[sign][0], linestyle=LINES[sign][1],
                      label=f"to the {DIRECTIONS[sign]}")  # fmt: skip
        if min(energies, default=strongest) < SAME * strongest:
            _label_widths(axes, strongest, si=waves.chain.units == "SI")
        label_below(axes, label)
        axes.set_ylabel("contact $k$")
        axes.yaxis.set_major_locator(BeadLocator(0))
        set_title(axes, chain_title(waves.chain))
        if legend and len(waves):
            place_legend(axes, own=ax is None)
    return axes


def _parts(wave: Wave) -> list[tuple[slice, float]]:
    """Parts of a track that have nearly the same energy, which changes at odd beads and steps."""
    counted = np.flatnonzero(wave._counted)
    if len(wave._along("energy")) < 2 or len(wave.events) < NEAR:
        return [(slice(None), wave.energy)]
    # Where the wave has not separated from others, its energy is that of the nearest contact.
    distances = np.abs(np.arange(len(wave.events))[:, np.newaxis] - counted)
    energies = wave.energies[counted[np.argmin(distances, axis=1)]]
    # Single contacts, such as those beside an odd bead, do not divide a track.
    smooth = np.median(np.lib.stride_tricks.sliding_window_view(energies, NEAR), axis=1)
    smooth = np.pad(smooth, NEAR // 2, mode="edge")
    begins = [0]
    for i, energy in enumerate(smooth):
        if abs(energy - smooth[begins[-1]]) > CHANGE * max(energy, smooth[begins[-1]]):
            begins.append(i)
    ends = [*begins[1:], len(smooth) - 1]
    return [(slice(begin, end + 1), float(np.median(smooth[begin : end + 1])))
            for begin, end in zip(begins, ends, strict=True)]  # fmt: skip


def _width(part: float) -> float:
    """Width of the line of a wave with a part of the largest energy [points]."""
    return 0.8 + 2.2 * part**0.5


def _label_widths(axes: Axes, strongest: float, *, si: bool) -> None:
    """Entries of the legend for the widths of the lines."""
    factor, unit = prefixed(strongest, "J") if si else (1.0, "")
    words = f"energy {factor * strongest:.3g} {unit}".rstrip()
    for part, label in ((1.0, words), (0.1, "a tenth of it")):
        axes.plot([], [], color=grey(axes, 0.4), linewidth=_width(part), label=label)
