"""Plot the history of a search, or the distribution of all choices of an enumeration."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ..designs.measures import USUAL, label_in
from .colours import COLOURS
from .legends import place_legend
from .style import figure_style, get_axes, label_log_axis, with_micro

if TYPE_CHECKING:
    from ..designs.result import DesignResult

# Largest over smallest value of a history, or number of a distribution, from which its axis is
# logarithmic.
WIDE: Final = 10.0
# Number of bars of a distribution.
MAX_BINS: Final = 40


def plot_history(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot the best objective over the number of simulations, or those of all choices."""
    if len(result.candidates):
        return plot_candidates(result, ax=ax)
    with figure_style():
        axes = get_axes(ax)
        runs, scores = result.history.T
        factor, unit = usual_unit(result, result.unit)
        values = factor * result._sign * scores
        if not len(runs):
            axes.text(0.5, 0.5, "no trial met the constraints", ha="center",
                      transform=axes.transAxes)  # fmt: skip
            axes.set_axis_off()
            return axes
        axes.step([*runs, result.runs], [*values, *values[-1:]], where="post", color=COLOURS[1])
        axes.set_xscale("log")
        label_log_axis(axes.xaxis)
        if values.min() > 0.0 and values.max() > WIDE * values.min():
            axes.set_yscale("log")
            label_log_axis(axes.yaxis)
        single = result.problem.objective.single
        if single is not None and single.key == "beads":
            axes.yaxis.set_major_locator(MaxNLocator("auto", integer=True, min_n_ticks=1))
        axes.set_xlabel("simulations")
        axes.set_ylabel(_objective_label(result, unit))
    return axes


def _objective_label(result: DesignResult, unit: str) -> str:
    single = result.problem.objective.single
    name = "score" if single is None else label_in(result.chain, single)
    if (scatter := result.problem.scatter) is not None:
        name = f"{scatter.statistic} of {name}"
    return f"{name} [{unit}]" if unit else name


def plot_candidates(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot the distribution of the objective of all choices, and mark the best one."""
    with figure_style():
        axes = get_axes(ax)
        factor, unit = usual_unit(result, result.unit)
        values = factor * result.candidates
        whole = bool((values == np.round(values)).all()) and np.ptp(values) < MAX_BINS
        edges: Any = np.arange(values.min() - 0.5, values.max() + 1.0) if whole else MAX_BINS
        counts, edges = np.histogram(values, edges)
        axes.stairs(counts, edges, fill=True, color=COLOURS[1])
        if counts.max() > WIDE * counts[counts > 0].min():
            axes.set_yscale("log")
            axes.set_ylim(bottom=0.5)
            label_log_axis(axes.yaxis)
        best = factor * result._sign * result.history[-1, 1]
        axes.axvline(best, color=COLOURS[2], label=f"best: {best:.4g}{' ' * bool(unit)}{unit}")
        axes.set_xlabel(_objective_label(result, unit))
        axes.set_ylabel(f"choices, of {len(values)}")
        place_legend(axes)
    return axes


def usual_unit(result: DesignResult, unit: str) -> tuple[float, str]:
    """Factor and unit of an axis: mm of lengths, g of masses, ms of times; empty without one."""
    if result.chain.units != "SI" or unit in ("", "1"):
        return 1.0, ""
    factor, shown = (1e3, "ms") if unit == "s" else USUAL.get(unit, (1.0, unit))
    return factor, with_micro(shown)
