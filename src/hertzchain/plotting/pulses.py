"""Plot quantities of pulses against the bead number."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from ..errors import InputError
from ..pulse.pulse import Pulse
from ..pulse.quantities import QUANTITIES
from ..validation.objects import check_bool, check_choice, check_list, check_type
from .style import COLOURS, MARKERS, figure_style, get_axes, literal, set_title


def plot_pulses(
    pulses: Sequence[Pulse],
    quantity: str = "velocity",
    *,
    log: bool = False,
    ax: Axes | None = None,
) -> Axes:
    """Plot one quantity of several pulses against the bead number.

    Parameters
    ----------
    pulses : sequence of Pulse
        Pulses to compare.
    quantity : str
        Name of the quantity.
    log : bool
        Whether the y axis is logarithmic.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into.  By default, a new figure is created.

    Raises
    ------
    InputError
        If a method does not predict the quantity.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(20)
    >>> axes = plot_pulses([hc.propagate(chain), hc.bca(chain)], "momentum")
    >>> len(axes.lines)
    2
    """
    pulses = check_list("pulses", pulses, "pulses")
    if not pulses:
        raise InputError("plot_pulses requires at least one pulse")
    for pulse in pulses:
        check_type("pulse", pulse, Pulse, "propagate and the theories return one")
    check_choice("quantity", quantity, QUANTITIES)
    log = check_bool("log", log)
    missing = [pulse.method for pulse in pulses if pulse.column(quantity) is None]
    if missing:
        raise InputError(f"{missing[0]} does not predict {quantity}")
    with figure_style():
        axes = get_axes(ax)
        for i, pulse in enumerate(pulses):
            values = pulse.columns()[quantity]
            axes.plot(
                pulse.bead[: len(values)],
                values,
                color=COLOURS[i % len(COLOURS)],
                marker=MARKERS[i % len(MARKERS)],
                markerfacecolor="none",
                markevery=max(1, len(values) // 40),
                linewidth=0.6,
                label=literal(pulse.method),
            )
        axes.set_xlabel(f"{QUANTITIES[quantity].per} $k$")
        axes.set_ylabel(QUANTITIES[quantity].label_in(pulses[0].chain.units))
        axes.set_yscale("log" if log else "linear")
        chains = dict.fromkeys(pulse.chain.description for pulse in pulses)
        set_title(axes, literal("; ".join(chains)))
        axes.legend()
    return axes
