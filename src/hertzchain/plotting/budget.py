"""Draw where energy and momentum are, stacked over time."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter

from hertzchain.arguments import instance, one_of
from hertzchain.errors import InputError
from hertzchain.plotting.style import (
    axes_in,
    house_style,
    literal,
    mark_horizon,
    time_axis,
    titled,
)
from hertzchain.simulation.budget import BALANCED, Balanced, Budget
from hertzchain.simulation.horizon import Horizon

# Where energy and momentum are, from light to dark as they are lost to the pulse.
PARTS: Final[dict[str, tuple[str, str]]] = {
    "leading pulse": ("#0072B2", ""),
    "lagging": ("#56B4E9", ""),
    "scattered back": ("#E69F00", "//"),
    "contacts": ("#D9D9D9", ""),
    "walls": ("#666666", ""),
    "left wall": ("#999999", "\\\\"),
    "right wall": ("#666666", ""),
    "lost": ("#D55E00", ".."),
}


TICK: Final = {"energy": ("energy", "J"), "momentum": ("momentum", "N s")}


def plot_budget(
    budget: Budget,
    of: Balanced = "energy",
    *,
    horizon: Horizon | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw where energy or momentum is over time, stacked; momentum backwards below zero.

    Parameters
    ----------
    budget : Budget
        Of a run with at least two saved times.
    of : str
        ``"energy"`` or ``"momentum"``.
    horizon : Horizon, optional
        What `Run.horizon` found; times beyond it are shaded.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; a new figure's if not given.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        For another word, or a single time.

    Examples
    --------
    >>> import hertzchain as hc
    >>> axes = plot_budget(hc.simulate(hc.Chain.uniform(9)).budget(), "momentum")
    >>> axes.get_ylabel()
    'momentum'
    """
    one_of("balance", of, BALANCED)
    if horizon is not None:
        instance("horizon", horizon, Horizon, "run.horizon() is one")
    if len(budget.times) < 2:
        raise InputError("a stacked plot needs at least 2 saved times, the run has 1")
    there = budget.energy if of == "energy" else budget.momentum
    given = budget.energy_given if of == "energy" else budget.momentum_given
    shown = {name: values for name, values in there.items() if np.abs(values).max() > 0.0}
    factor, label = time_axis(budget.chain)
    times, total = factor * budget.times, np.sum([*given.values()], axis=0)
    with house_style():
        axes = axes_in(ax)
        above, below = np.zeros(len(times)), np.zeros(len(times))
        for name, values in shown.items():
            colour, hatch = PARTS[name]
            for base, part in ((above, np.maximum(values, 0.0)), (below, np.minimum(values, 0.0))):
                if np.any(part != 0.0):
                    axes.fill_between(
                        times, base, base + part, facecolor=colour, hatch=hatch,
                        edgecolor="white", linewidth=0.0,
                    )  # fmt: skip
                base += part
            axes.fill_between([], [], [], facecolor=colour, hatch=hatch, edgecolor="white",
                              label=name)  # fmt: skip
        axes.plot(times, total, color="black", linewidth=1.0, label="given in total")
        quantity, unit = TICK[of]
        axes.set_ylabel(quantity)
        if budget.chain.units == "SI":
            # An impact of balls has some microjoules: a prefix instead of many zeros.
            scale, prefix = _prefix(float(np.abs([above, below]).max()))
            axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / scale:g}"))
            axes.set_ylabel(f"{quantity} [{prefix}{unit}]")
        axes.set_xlabel(label)
        titled(axes, literal(budget.chain.description))
        axes.margins(x=0.0)
        mark_horizon(axes, horizon)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return axes


def _prefix(largest: float) -> tuple[float, str]:
    """Unit prefix with which a number is between 1 and 1000, if there is one."""
    prefixes = {0: "", -3: "m", -6: "µ", -9: "n"}
    power = 3 * math.floor(math.log10(largest) / 3) if largest > 0.0 else 0
    power = min(0, max(-9, power))
    return 10.0**power, prefixes[power]
