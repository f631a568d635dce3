"""Plot designs: beads, forces, history, sensitivity and Pareto fronts."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..errors import InputError
from ..simulation.simulate import simulate
from .chains import bead_centres, draw_beads, material_legend
from .style import COLOURS, figure_style, get_axes, label_log_axis, time_axis
from .widths import figure_size

if TYPE_CHECKING:
    from ..designs.result import DesignResult

# Saved times of the forces.
TIMES: Final = 2000
RTOL: Final = 1e-8


def plot_beads(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot the beads of the chain that was found, above those of the chain it began with."""
    with figure_style():
        axes = get_axes(ax, figsize=(7.0, 2.2))
        chains = {"initial": result.problem.chain, "design": result.chain}
        factor, unit = (1e3, " [mm]") if result.chain.units == "SI" else (1.0, "")
        height = -2.4 * factor * max(chain.radii.max() for chain in chains.values())
        for row, (name, chain) in enumerate(chains.items()):
            draw_beads(chain, factor, axes, height=row * height)
            if chain.right_wall is not None:
                end = factor * (bead_centres(chain)[-1] + chain.radii[-1])
                largest = factor * chain.radii.max()
                axes.plot([end] * 2, [row * height - largest, row * height + largest],
                          color="black", linewidth=3.0)  # fmt: skip
            axes.text(-0.01, row * height, f"{name} ", ha="right", va="center",
                      transform=axes.get_yaxis_transform())  # fmt: skip
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.set_yticks([])
        axes.set_xlabel(f"position{unit}")
        material_legend([*chains.values()], axes, fontsize=8, loc="upper center",
                        bbox_to_anchor=(0.5, 1.3), ncols=3)  # fmt: skip
    return axes


def plot_forces(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot the force on the wall over time, or without a wall the leading pulse by bead."""
    with figure_style(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        axes = get_axes(ax)
        for chain, label, colour in (
            (result.problem.chain, "initial", COLOURS[0]), (result.chain, "design", COLOURS[2]),
        ):  # fmt: skip
            if chain.right_wall is None:
                pulse = simulate(chain, times=0, rtol=RTOL).pulse()
                axes.plot(np.arange(1, chain.beads + 1), pulse.velocity, color=colour, label=label)
                continue
            end = simulate(chain, times=0, rtol=RTOL, until=result.problem.until).end_time
            run = simulate(chain, times=TIMES, rtol=RTOL, until=end)
            factor, axis = time_axis(chain)
            axes.plot(factor * run.times, run.wall_force().force, color=colour, label=label)
            axes.set_xlabel(axis)
        si = result.chain.units == "SI"
        if result.chain.right_wall is None:
            axes.set_xlabel("bead $k$")
            axes.set_ylabel("velocity $v_k$" + (" [m/s]" if si else ""))
        else:
            axes.set_ylabel("force on the wall" + (" [N]" if si else ""))
        axes.margins(x=0.0)
        axes.legend()
    return axes


def plot_history(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot the best objective over the number of simulations."""
    with figure_style():
        axes = get_axes(ax)
        runs, scores = result.history.T
        values = result._sign * scores
        axes.step([*runs, result.runs], [*values, *values[-1:]], where="post", color=COLOURS[1])
        axes.set_xscale("log")
        label_log_axis(axes.xaxis)
        axes.set_xlabel("simulations")
        axes.set_ylabel(_label(result))
    return axes


def plot_sensitivity(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot by how many percent the objective changes if one radius changes by +1% or -1%."""
    with figure_style():
        axes = get_axes(ax)
        larger, smaller = result.changes
        beads = np.arange(1, len(larger) + 1)
        for shift, values, colour, label in (
            (-0.2, larger, COLOURS[3], "+1%"), (0.2, smaller, COLOURS[1], "\N{MINUS SIGN}1%"),
        ):  # fmt: skip
            axes.bar(beads + shift, 100.0 * values, 0.4, color=colour, label=label)
        axes.axhline(0.0, color="black", linewidth=0.8)
        axes.set_xlabel("bead $k$")
        axes.set_ylabel("change [%] if $R_k$ changes by 1%")
        axes.legend()
    return axes


def plot_front(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot the Pareto front of two objectives."""
    with figure_style():
        if not result.front:
            raise InputError("this design has one objective and no front; give two objectives")
        axes = get_axes(ax)
        first, second = (str(each.single) for each in result.problem.objectives)
        words = {str(each): each.label for each in result.problem.measures}
        points = sorted((each.values[second], each.values[first]) for each in result.front)
        axes.plot(*zip(*points, strict=True), "o-", color=COLOURS[1])
        for label, name in ((axes.set_xlabel, second), (axes.set_ylabel, first)):
            unit = next(m.unit for m in result.problem.measures if str(m) == name)
            si = result.chain.units == "SI" and unit != "1"
            label(f"{words[name]} [{unit}]" if si else words[name])
    return axes


def plot_design(result: DesignResult) -> Figure:
    """Plot beads, forces, history, and the sensitivity or the Pareto front."""
    with figure_style():
        figure, axes = plt.subplots(2, 2, figsize=figure_size(10.0, 6.4), layout="constrained")
        plot_beads(result, ax=axes[0, 0])
        plot_forces(result, ax=axes[0, 1])
        plot_history(result, ax=axes[1, 0])
        last = axes[1, 1]
        if result.front:
            plot_front(result, ax=last)
        elif "masses" in result.chain.given:
            last.bar(np.arange(1, result.chain.beads + 1), result.chain.masses, color=COLOURS[3])
            last.set_xlabel("bead $k$")
            last.set_ylabel("mass $m_k$")
        else:
            plot_sensitivity(result, ax=last)
    return figure


def _label(result: DesignResult) -> str:
    single = result.problem.objective.single
    if single is None:
        return "score"
    return f"{single.label} [{result.unit}]" if result.unit else single.label


KINDS: Final[dict[str, Callable[..., Axes]]] = {
    "beads": plot_beads, "forces": plot_forces, "history": plot_history,
    "sensitivity": plot_sensitivity, "front": plot_front,
}  # fmt: skip
