"""Plot designs: beads, forces, history, sensitivity and Pareto fronts."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.gridspec import GridSpecBase

from ..chain.chain import Chain
from ..chain.description import sizes_in_words
from ..collision import Array
from ..designs.curves import Curve, initial_and_final, plotted_quantity
from ..designs.exact_gradients import PEAK
from ..designs.measures import USUAL
from ..designs.objective import Objective
from ..designs.pareto import beaten_if_yielding
from ..designs.sensitivity import changes
from ..designs.verified import violated
from ..errors import InputError
from ..pulse.quantities import QUANTITIES
from .chains import bead_centres, draw_beads, material_legend
from .colours import COLOURS, curve_colour, grey
from .enlarged import finish_enlarged, small_groups
from .gradients import bars_of_changes
from .legends import POINTS_PER_INCH, figure_of, place_legend
from .style import (
    MUCH,
    BeadLocator,
    figure_style,
    get_axes,
    label_log_axis,
    time_axis,
)
from .widths import figure_size

if TYPE_CHECKING:
    from ..designs.problem import Design
    from ..designs.result import DesignResult

# Numbers of the colours of both chains.
CURVE_COLOURS: Final = {"initial": 0, "design": 2}
# Width of a figure [inch] below which its panels are below each other, the height of a panel
# [inch], and the longest line of the label of its y axis.
NARROW, NARROW_HEIGHT, MAX_CHARACTERS = 5.0, 1.7, 18
# Largest number of rows of diameters below beads, and the distance of upright ones in several rows,
# relative to the size of the font.
MOST_ROWS, ROOM = 3, 1.3
PLUS_MINUS: Final = "\N{PLUS-MINUS SIGN}"
GROWS: Final = "if diameter grows by 1%"
# Width of a character, relative to the size of the font, and width of the handle of a legend in
# characters.
CHARACTER, HANDLE = 0.6, 6


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
                          color=grey(axes), linewidth=3.0)  # fmt: skip
            lines = [name, *_violations(result, name)]
            axes.text(-0.01, row * height, " \n".join(lines) + " ", ha="right", va="center",
                      fontsize=rcParams["font.size"] * (1.0 if len(lines) == 1 else 0.8),
                      transform=axes.get_yaxis_transform())  # fmt: skip
        axes.set_aspect("equal")
        axes.autoscale_view()
        if result.chain.units == "SI":
            _write_diameters(result.chain, axes, height - result.chain.radii.max() * factor)
        axes.set_yticks([])
        axes.set_xlabel(f"position{unit}")
        # Above the axes, which are low if the chain is long.
        material_legend([*chains.values()], axes, fontsize=8, loc="lower center",
                        bbox_to_anchor=(0.5, 1.0), borderaxespad=0.2, ncols=3)  # fmt: skip
    return axes


def _violations(result: DesignResult, name: str) -> list[str]:
    """Statement that the initial chain or the design violates constraints; empty if not."""
    found = result._initial if name == "initial" else result.verified
    names = violated(result.problem, found.values)
    if not names:
        return []
    return [f"violates {names[0] if len(names) == 1 else f'{len(names)} constraints'}"]


def _write_diameters(chain: Chain, axes: Axes, height: float) -> None:
    """Write the diameters [mm] below the beads, or their range if there is no room.

    They are upright if the beads are narrow, and in several rows if one has no room.
    """
    figure = figure_of(axes)
    size = 0.8 * float(FontProperties(size=rcParams["font.size"]).get_size_in_points())
    low, high = axes.get_xlim()
    # The layout of the figure may change, but hardly its width.
    point = (high - low) / (POINTS_PER_INCH * figure.get_figwidth() * axes.get_position().width)
    texts = [f"{2e3 * radius:.4g}" for radius in chain.radii]
    centres = 1e3 * bead_centres(chain)
    rows = _rows(centres / (point * size))
    label = "diameter [mm]"
    if rows == 0:
        texts, centres, rows = [sizes_in_words(chain.radii)], np.array([0.5 * (low + high)]), 1
        label = "diameters"
    lengths = CHARACTER * np.array([len(text) for text in texts])
    apart = np.diff(centres) / (point * size)
    crowded = (apart < 0.5 * (lengths[1:] + lengths[:-1]) + 0.5 * CHARACTER).any()
    upright = rows > 1 or bool(crowded)
    tall = lengths.max() + CHARACTER if upright else 1.0
    for i, (text, centre) in enumerate(zip(texts, centres, strict=True)):
        below = height - (0.3 + i % rows * tall) * size * point
        axes.text(centre, below, text, fontsize=size, ha="center", va="top",
                  rotation=90.0 * upright)  # fmt: skip
    axes.text(-0.01, height - 0.3 * size * point, f"{label} ", fontsize=size, ha="right",
              va="top", transform=axes.get_yaxis_transform())  # fmt: skip
    axes.set_ylim(bottom=height - size * point * (0.6 + rows * tall))


def _rows(centres: Array) -> int:
    """Number of rows of upright texts at places in units of their size; 0 if there are too many."""
    for rows in range(1, MOST_ROWS + 1):
        if (centres[rows:] - centres[:-rows]).min(initial=np.inf) >= (ROOM if rows > 1 else 1.0):
            return rows
    return 0


def plot_forces(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot the force on the wall over time, or without a wall the leading pulse by bead.

    Dashed curves are those of contacts that yield, if elastic ones leave the range of Hertz's law.
    If forces or durations differ much, a second panel has the weak or the short curve, enlarged,
    unless axes are given.
    """
    with figure_style():
        curves = initial_and_final(result, MUCH)
        if ax is not None or not _differ(result, curves):
            return _draw_curves(result, curves, get_axes(ax))
        figure = plt.figure()
        return _draw_panels(result, curves, figure.add_gridspec(2, 1))


def _differ(result: DesignResult, curves: Sequence[Curve]) -> bool:
    """Whether durations or forces of both chains differ by so much that one is to be enlarged."""
    return result.chain.right_wall is not None and bool(_small(curves))


def _small(curves: Sequence[Curve]) -> list[list[str]]:
    """Names of chains whose forces are weak beside those of the other chain, or short."""
    names = list(dict.fromkeys(each.name for each in curves))
    both = [[each for each in curves if each.name == name] for name in names]
    tops = [max(float(curve.y.max()) for curve in own) for own in both]
    groups = small_groups(tops, [float(own[0].x[-1]) for own in both])
    return [[names[i] for i in group] for group in groups]


def _draw_panels(result: DesignResult, curves: Sequence[Curve], grid: GridSpecBase) -> Axes:
    """Draw both chains in one panel and, below it, the weak or the short one enlarged."""
    first: Axes = grid.figure.add_subplot(grid[0])  # type: ignore[attr-defined]
    second: Axes = grid.figure.add_subplot(grid[1])  # type: ignore[attr-defined]
    ((name, *_), *_) = _small(curves)
    longest = max(float(each.x[-1]) for each in curves)
    _draw_curves(result, curves, first)
    _draw_curves(result, [each for each in curves if each.name == name], second, longest)
    second.get_legend().remove()  # type: ignore[union-attr]
    finish_enlarged(second, first, name)
    if second.get_xlim() == first.get_xlim():
        first.set_xlabel("")
        first.tick_params(labelbottom=False)
    for axes in (first, second):
        # Panels are low.
        axes.set_ylabel("force [N]" if result.chain.units == "SI" else "force $F$")
    return first


def _draw_curves(
    result: DesignResult, curves: Sequence[Curve], axes: Axes, longest: float = 0.0
) -> Axes:
    """Draw curves, with times in the unit for the longest one or for a longer time."""
    si, walled = result.chain.units == "SI", result.chain.right_wall is not None
    factor, label = 1.0, "bead $k$"
    if walled:
        factor, label = time_axis(result.chain, max(longest, *(each.x[-1] for each in curves)))
    for each in curves:
        words = None if each.yields else _label(result, each.name, curves, axes)
        axes.plot(factor * each.x, each.y, "--" if each.yields else "-", label=words,
                  color=curve_colour(axes, CURVE_COLOURS[each.name]))  # fmt: skip
    if walled:
        _draw_limits(result, axes)
    axes.set_xlabel(label)
    if not walled:
        axes.xaxis.set_major_locator(BeadLocator())
    quantity = QUANTITIES[plotted_quantity(result)]
    name, unit = ("force on the wall", "N") if walled else (quantity.label, quantity.unit)
    axes.set_ylabel(f"{name} [{unit}]" if si and unit != "1" else name)
    axes.margins(x=0.0)
    place_legend(axes)
    return axes


def _label(result: DesignResult, name: str, curves: Sequence[Curve], axes: Axes) -> str:
    """Label of both curves of a chain, with the peaks of forces, in lines that fit the axes."""
    unit = " N" if result.chain.units == "SI" else ""
    walled = result.chain.right_wall is not None
    peaks = {each.yields: f"{each.peak:.4g}{unit}" for each in curves if each.name == name}
    parts = [f"{name}, peak {peaks[False]}" if walled else name]
    if True in peaks:
        parts.append(f"(dashed, with yield: {peaks[True]})" if walled else "(dashed: with yield)")
    violations = _violations(result, name)
    parts[-1] += "," * len(violations)
    letter = CHARACTER * FontProperties(size=rcParams["legend.fontsize"]).get_size_in_points()
    inches = axes.get_window_extent().width / axes.figure.dpi
    letters = int(POINTS_PER_INCH * inches / letter) - HANDLE
    text = " ".join(part.replace(" ", "\u00a0") for part in parts + violations)
    return textwrap.fill(text, max(letters, 1), break_long_words=False).replace("\u00a0", " ")


def _draw_limits(result: DesignResult, axes: Axes) -> None:
    """Draw limits of the peak force on the wall that the axes include."""
    top = axes.get_ylim()[1]
    for each in result.problem.requirements:
        if each.measure == PEAK and each.limit < top:
            axes.axhline(each.limit, color=grey(axes, 0.4), linestyle="--", linewidth=1.0,
                         label=f"limit {each.shown(each.limit)}")  # fmt: skip


def plot_history(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot the best objective over the number of simulations."""
    with figure_style():
        axes = get_axes(ax)
        runs, scores = result.history.T
        factor, unit = _usual_unit(result, result.unit)
        values = factor * result._sign * scores
        if not len(runs):
            axes.text(0.5, 0.5, "no trial met the constraints", ha="center",
                      transform=axes.transAxes)  # fmt: skip
            axes.set_axis_off()
            return axes
        axes.step([*runs, result.runs], [*values, *values[-1:]], where="post", color=COLOURS[1])
        axes.set_xscale("log")
        label_log_axis(axes.xaxis)
        axes.set_xlabel("simulations")
        single = result.problem.objective.single
        name = "score" if single is None else single.label
        if (scatter := result.problem.scatter) is not None:
            name = f"{scatter.statistic} of {name}"
        axes.set_ylabel(f"{name} [{unit}]" if unit else name)
    return axes


def plot_sensitivity(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot by how many percent the objective changes if one radius grows by 1%.

    Where it does not shrink by as much if the radius shrinks by 1%, both changes are drawn.
    If the objective is a size, a mass or a price, the first other quantity with a limit is plotted.
    """
    with figure_style():
        axes = get_axes(ax)
        objective = _of_motion(result.problem)
        own = objective is result.problem.objective
        found = (
            result.changes if own
            else changes(result.problem._with_objective(objective), result.chain, 0.01)
        )  # fmt: skip
        _shade_arriving(result, axes)
        both = bars_of_changes(axes, *found)
        axes.set_xlabel("bead $k$")
        axes.xaxis.set_major_locator(BeadLocator())
        name = "score" if objective.single is None else objective.single.label
        change = f"change [%] if $R_k$ {'changes' if both else 'grows'} by 1%"
        if result.chain.units == "SI":
            change = f"change [%] {f'for {PLUS_MINUS}1% in diameter' if both else GROWS}"
        axes.set_ylabel(f"{name}:\n{change}")
    return axes


def _shade_arriving(result: DesignResult, axes: Axes) -> None:
    """Shade the strikers, whose sizes are given, as in the plot of a gradient."""
    if count := result.chain.strikers:
        axes.axvspan(0.5, count + 0.5, color="0.9", linewidth=0.0)
        axes.text(0.5 * (1 + count), 0.98, f"striker{'s' if count > 1 else ''}", ha="center",
                  va="top", rotation=90.0, fontsize=rcParams["legend.fontsize"],
                  transform=axes.get_xaxis_transform())  # fmt: skip


def _of_motion(problem: Design) -> Objective:
    """The objective; if it does not depend on the motion, the first limited quantity that does."""
    if all(each.of_chain for each in problem.objective.measures):
        for each in problem.requirements:
            if not each.measure.of_chain:
                return Objective((each.measure,), np.ones(1))
    return problem.objective


def plot_front(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot the Pareto front of two objectives."""
    with figure_style():
        if not result.front:
            raise InputError("this design has one objective and no front; give two objectives")
        axes = get_axes(ax)
        first, second = (str(each.single) for each in result.problem.objectives)
        words = {str(each): each.label for each in result.problem.measures}
        points = sorted(
            (each.values[second], each.values[first], each.verified.outside_range)
            for each in result.front
        )
        units = {str(each): each.unit for each in result.problem.measures}
        (across, x_unit), (up, y_unit) = (
            _usual_unit(result, units[name]) for name in (second, first)
        )
        x, y, outside = np.array(points).T
        x, y, outside = across * x, up * y, outside.astype(bool)
        _join_points(result, x, y, axes)
        for flags, face, where in ((~outside, COLOURS[1], "within"), (outside, "none", "outside")):
            if flags.any():
                axes.plot(x[flags], y[flags], "o", color=COLOURS[1], markerfacecolor=face,
                          label=f"{where} the range of Hertz's law")  # fmt: skip
        _draw_yielding_points(result, (second, across), (first, up), axes)
        if outside.any():
            place_legend(axes)
        if count := result.chain.strikers:
            # The row is drawn with them.
            without = f" without the striker{'s' if count > 1 else ''}"
            words |= {str(each): f"{each.label}{without}" for each in result.problem.measures
                      if each.key in ("length", "mass", "beads")}  # fmt: skip
        axes.set_xlabel(f"{words[second]} [{x_unit}]" if x_unit else words[second])
        axes.set_ylabel(f"{words[first]} [{y_unit}]" if y_unit else words[first])
    return axes


def _draw_yielding_points(
    result: DesignResult, across: tuple[str, float], up: tuple[str, float], axes: Axes
) -> None:
    """Draw points outside the range of Hertz's law also with contacts that yield, joined to them.

    Both axes are given as the name of an objective and the factor to its unit.
    """
    shifts = []
    for point in result.front:
        elastic, yielding = point.values, point.values | point.verified.yielding
        if point.verified.yielding:
            shifts.append([[factor * values[name] for name, factor in (across, up)]
                           for values in (elastic, yielding)])  # fmt: skip
    if not shifts:
        return
    for begin, end in shifts:
        axes.plot(*zip(begin, end, strict=True), ":", color=grey(axes, 0.6), linewidth=0.8)
    axes.plot(*np.array(shifts)[:, 1].T, "x", color=COLOURS[2], label="with contacts that yield")
    if beaten := beaten_if_yielding(result.front, result.problem):
        values = [result.front[i].values | result.front[i].verified.yielding for i in beaten]
        x, y = ([factor * row[name] for row in values] for name, factor in (across, up))
        axes.scatter(x, y, s=70.0, facecolors="none", edgecolors=[grey(axes)], linewidths=0.8,
                     label="beaten by others if contacts yield")  # fmt: skip


def _join_points(result: DesignResult, x: Array, y: Array, axes: Axes) -> None:
    """Join points of sizes; there is nothing between rows of balls, whose front has steps."""
    colour = COLOURS[1]
    if result.discrete:
        least = result.problem.objectives[1].weights[0] > 0.0
        axes.step(x, y, color=colour, linewidth=0.8, alpha=0.5, where="post" if least else "pre")
    else:
        axes.plot(x, y, color=colour)


def plot_design(result: DesignResult) -> Figure:
    """Plot beads, forces, history, and the sensitivity or the Pareto front.

    The panels are in two columns or, at the width of a column of a journal, below each other.
    """
    with figure_style():
        curves = initial_and_final(result, MUCH)
        apart = _differ(result, curves)
        # Two panels of forces need more height, also for a legend above them.
        size = figure_size(10.0, 8.0 if apart else 6.4)
        figure = plt.figure(figsize=size, layout="constrained")
        narrow = figure.get_figwidth() < NARROW
        if narrow:
            # Long legends are above the forces.
            single = 1.8 if any(each.yields for each in curves) else 1.0
            heights = [0.8, 2.5 if apart else single, 1.0, 1.0]
            figure.set_figheight(NARROW_HEIGHT * sum(heights))
            grid = figure.add_gridspec(4, 1, height_ratios=heights)
        else:
            grid = figure.add_gridspec(2, 2, height_ratios=[1.6 if apart else 1.0, 1.0])
        panels = [grid[i] for i in range(4)]
        plot_beads(result, ax=figure.add_subplot(panels[0]))
        if apart:
            _draw_panels(result, curves, panels[1].subgridspec(2, 1))
        else:
            _draw_curves(result, curves, figure.add_subplot(panels[1]))
        plot_history(result, ax=figure.add_subplot(panels[2]))
        last = figure.add_subplot(panels[3])
        if result.front:
            plot_front(result, ax=last)
        elif "masses" in result.chain.given:
            last.bar(np.arange(1, result.chain.beads + 1), result.chain.masses, color=COLOURS[3])
            last.set_xlim(0.3, result.chain.beads + 0.7)
            last.set_xlabel("bead $k$")
            last.xaxis.set_major_locator(BeadLocator())
            last.set_ylabel("mass $m_k$")
        else:
            plot_sensitivity(result, ax=last)
        if narrow:
            for axes in figure.axes:
                axes.set_ylabel(textwrap.fill(axes.get_ylabel(), MAX_CHARACTERS))
    return figure


def _usual_unit(result: DesignResult, unit: str) -> tuple[float, str]:
    """Factor and unit of an axis, mm of lengths and g of masses; empty if there is no unit."""
    if result.chain.units != "SI" or unit in ("", "1"):
        return 1.0, ""
    return USUAL.get(unit, (1.0, unit))


KINDS: Final[dict[str, Callable[..., Axes]]] = {
    "beads": plot_beads, "forces": plot_forces, "history": plot_history,
    "sensitivity": plot_sensitivity, "front": plot_front,
}  # fmt: skip
