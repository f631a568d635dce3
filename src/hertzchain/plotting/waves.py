"""Plot the tracks of waves."""

from __future__ import annotations

from matplotlib.axes import Axes

from ..simulation.waves import DIRECTIONS, Waves
from ..validation.keywords import checked_arguments
from ..validation.objects import check_bool
from .colours import COLOURS
from .legends import place_legend
from .shared_axes import label_below
from .style import BeadLocator, figure_style, get_axes, set_title, time_axis
from .titles import chain_title

LINES = {1: (COLOURS[1], "-"), -1: (COLOURS[2], "--")}


@checked_arguments("plot_waves")
def plot_waves(waves: Waves, *, legend: bool = True, ax: Axes | None = None) -> Axes:
    """Plot the track of every wave: contact against time, coloured by direction.

    The width of a line increases with the energy of its wave.

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
    strongest = max((wave.energy for wave in waves), default=1.0)
    with figure_style():
        axes = get_axes(ax)
        for wave in waves:
            colour, style = LINES[wave.direction]
            thick = 0.8 + 2.2 * (wave.energy / strongest) ** 0.5
            axes.plot(
                factor * wave.times, wave.contacts, color=colour, linestyle=style, linewidth=thick
            )
        for sign in dict.fromkeys(sorted((wave.direction for wave in waves), reverse=True)):
            axes.plot([], [], color=LINES[sign][0], linestyle=LINES[sign][1],
                      label=f"to the {DIRECTIONS[sign]}")  # fmt: skip
        label_below(axes, label)
        axes.set_ylabel("contact $k$")
        axes.yaxis.set_major_locator(BeadLocator(0))
        set_title(axes, chain_title(waves.chain))
        if legend and len(waves):
            place_legend(axes, own=ax is None)
    return axes
