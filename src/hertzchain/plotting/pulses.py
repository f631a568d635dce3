"""Draw quantities of pulses against the bead."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from matplotlib.axes import Axes

from hertzchain.errors import InputError
from hertzchain.plotting.style import COLOURS, MARKERS, axes_in, house_style, literal, titled
from hertzchain.pulse.pulse import Pulse
from hertzchain.pulse.quantities import PER_CONTACT, Quantity

LABELS: Final[dict[Quantity, str]] = {
    "velocity": "velocity $v_k$",
    "momentum": "momentum $P_k$",
    "energy": "kinetic energy $E_k$",
    "peak_time": "time of the velocity maximum",
    "arrival": "arrival time $t_k$",
    "residence": "residence time $T_k$",
    "peak_overlap": "largest overlap",
    "peak_force": "largest force $F_k$",
}


def plot_pulses(
    pulses: Sequence[Pulse],
    quantity: Quantity = "velocity",
    *,
    log: bool = False,
    ax: Axes | None = None,
) -> Axes:
    """Draw one quantity of several pulses against the bead number.

    Parameters
    ----------
    pulses : sequence of Pulse
        Pulses to compare.
    quantity : str
        Name of the quantity.
    log : bool
        Logarithmic ordinate.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; a new figure's if not given.

    Returns
    -------
    matplotlib.axes.Axes

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
    missing = [pulse.method for pulse in pulses if pulse.column(quantity) is None]
    if missing:
        raise InputError(f"{missing[0]} does not predict {quantity}")
    with house_style():
        axes = axes_in(ax)
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
        axes.set_xlabel("contact $k$" if quantity in PER_CONTACT else "bead $k$")
        unit = "" if pulses[0].chain.units == "scaled" else f" [{pulses[0].unit(quantity)}]"
        axes.set_ylabel(LABELS[quantity] + unit)
        axes.set_yscale("log" if log else "linear")
        chains = dict.fromkeys(pulse.chain.description for pulse in pulses)
        titled(axes, literal("; ".join(chains)))
        axes.legend()
    return axes
