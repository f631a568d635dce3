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

from ..chain.hertz_ratios import OUTSIDE_LAW
from ..chain.materials import FIRST_YIELD
from ..chain.yield_pressure import YIELD_STATED, assumes_pressure
from ..collision import Array
from ..designs.comparison import DESIGN, GIVEN, compared_chains, same_as, shown_chains
from ..designs.curves import Curve, compared_curves, plotted_quantity, shows_forces
from ..designs.exact_gradients import PEAK
from ..designs.measures import BODY_PEAK, label_in, without_in_words
from ..designs.objective import Objective
from ..designs.pareto import beaten_if_yielding
from ..designs.sensitivity import changes
from ..designs.verified import WITH_YIELD
from ..errors import InputError
from ..pulse.quantities import QUANTITIES
from ..representation import in_column
from ..simulation.body_peak import body_in_words
from .colours import COLOURS, grey
from .compared_rows import draw_compared_rows
from .design_beads import CHARACTER, height_of_beads, plot_beads, violations
from .design_history import plot_history, usual_unit
from .enlarged import finish_enlarged, small_groups
from .gradients import bars_of_changes, shade_other_bodies
from .legends import POINTS_PER_INCH, covers_data, place_legend, put_legend_above
from .style import (
    MUCH,
    BeadLocator,
    broken_label,
    figure_style,
    get_axes,
    set_title,
    time_axis,
)
from .widths import NARROW, figure_size

if TYPE_CHECKING:
    from ..designs.problem import Design
    from ..designs.result import DesignResult

# Longest lines of the labels of y axes in narrow and in wide figures; height [inch] of a panel,
# that of an enlarged panel of forces, in panels, and that of the labels of beads [inch].
NARROW_LABEL, LABEL = 18, 27
PANEL, ENLARGED, LABELS_OF_BEADS = 1.7, 0.7, 0.9
# Largest height of both rows of beads [inch], and their part of the width of a figure.
MAX_BEADS, PART = 2.4, 0.8
PLUS_MINUS: Final = "\N{PLUS-MINUS SIGN}"
# Largest limit of a force that is drawn, relative to the largest force of the axes.
NEAR: Final = 1.5
# Width of the handle of a legend in characters.
HANDLE: Final = 6
# Least difference of two curves that is visible, relative to the largest value.
VISIBLE: Final = 0.01


def plot_forces(result: DesignResult, *, ax: Axes | None = None) -> Axes:
    """Plot the force on the wall or cap over time, or without any the leading pulse by bead.

    The force on a cap without a wall is plotted if it is the objective.  Dashed curves are those
    of contacts that yield, if elastic ones leave the range of Hertz's law.  If forces or durations
    differ much, further panels have the weak and the short curve, enlarged, unless axes are given.
    """
    with figure_style():
        curves = compared_curves(result, MUCH)
        small = _small(result, curves)
        if ax is not None or not small:
            return _draw_curves(result, curves, get_axes(ax), own=ax is None)
        size = None if len(small) == 1 else figure_size(5.4, 1.9 * (1 + len(small)))
        grid = plt.figure(figsize=size).add_gridspec(1 + len(small), 1)
        return _draw_panels(result, curves, small, grid)


def _small(result: DesignResult, curves: Sequence[Curve]) -> list[tuple[str, bool]]:
    """Chains whose forces on a wall are weak or short beside the others, and whether short."""
    if not shows_forces(result):
        return []
    names = list(dict.fromkeys(each.name for each in curves))
    chains = [[each for each in curves if each.name == name] for name in names]
    tops = [max(float(curve.y.max()) for curve in own) for own in chains]
    groups = small_groups(tops, [float(own[0].x[-1]) for own in chains])
    return [(names[i], group.short) for group in groups for i in group.curves]


def _draw_panels(
    result: DesignResult, curves: Sequence[Curve], small: Sequence[tuple[str, bool]],
    grid: GridSpecBase,
) -> Axes:  # fmt: skip
    """Draw all chains in one panel and, below it, the weak and the short ones enlarged."""
    panels: list[Axes] = [
        grid.figure.add_subplot(grid[i])  # type: ignore[attr-defined]
        for i in range(1 + len(small))
    ]
    first = panels[0]
    longest = max(float(each.x[-1]) for each in curves)
    _draw_curves(result, curves, first)
    for axes, (name, short) in zip(panels[1:], small, strict=True):
        _draw_curves(result, [each for each in curves if each.name == name], axes, longest)
        axes.get_legend().remove()  # type: ignore[union-attr]
        finish_enlarged(axes, first, name, short=short)
    if panels[1].get_xlim() == first.get_xlim():
        first.set_xlabel("")
        first.tick_params(labelbottom=False)
    for axes in panels:
        # Panels are low.
        axes.set_ylabel("force [N]" if result.chain.units == "SI" else "force $F$")
    return first


def _draw_curves(
    result: DesignResult, curves: Sequence[Curve], axes: Axes, longest: float = 0.0, *,
    own: bool = False,
) -> Axes:  # fmt: skip
    """Draw curves, with times in the unit for the longest one or for a longer time.

    The figure of ``own`` axes becomes taller for their legend.
    """
    si, walled = result.chain.units == "SI", shows_forces(result)
    factor, label = 1.0, "bead $k$"
    if walled:
        factor, label = time_axis(result.chain, max(longest, *(each.x[-1] for each in curves)))
    for each in curves:
        words = None if each.yields else _label(result, each.name, curves, axes)
        found = each.name == DESIGN
        # Another chain to compare with is grey, too.
        solid = ":" if each.name == GIVEN else "-"
        axes.plot(factor * each.x, each.y, "--" if each.yields else solid, label=words,
                  color=COLOURS[2] if found else grey(axes, 0.55),
                  linewidth=1.0 if found else 2.0)  # fmt: skip
    if walled:
        _draw_limits(result, axes)
    axes.set_xlabel(label)
    if not walled:
        axes.xaxis.set_major_locator(BeadLocator())
    quantity = QUANTITIES[plotted_quantity(result)]
    label = quantity.label_in(result.chain.units, damped=result.chain._damped)
    if walled:
        where = "the wall"
        if result.chain.right_wall is None:
            where = body_in_words(result.chain)
        label = f"force on {where}{' [N]' * si}"
    axes.set_ylabel(label)
    axes.margins(x=0.0)
    if walled:
        _name_given_chain(result, {each.name for each in curves}, axes)
    place_legend(axes, own=own, title=_assumed(result))
    return axes


def _assumed(result: DesignResult) -> str:
    """The yield pressure that contacts of the design assume; empty without one."""
    return YIELD_STATED if assumes_pressure(result.chain) else ""


def _name_given_chain(result: DesignResult, drawn: set[str], axes: Axes) -> None:
    """Add the peak of a given chain that is not drawn to the legend."""
    given = compared_chains(result).get(GIVEN)
    key = PEAK.key if result.chain.right_wall is not None else BODY_PEAK
    if given is None or GIVEN in drawn or key not in given.values:
        return
    unit = " N" if result.chain.units == "SI" else ""
    peak, yielding = (in_column([own.get(key, np.nan)], 4)[0] + unit
                      for own in (given.values, given.yielding))  # fmt: skip
    parts = [f"not drawn: {GIVEN}, peak {peak}"]
    if key in given.yielding:
        caution = f", {OUTSIDE_LAW}" * given.yielding_outside_range
        parts += ["(with yield,", f"{FIRST_YIELD:g} Y: {yielding}{caution})"]
    axes.plot([], [], " ", label=_wrapped(axes, parts))


def _label(result: DesignResult, name: str, curves: Sequence[Curve], axes: Axes) -> str:
    """Label of both curves of a chain, with the peaks of forces, in lines that fit the axes."""
    unit = " N" if result.chain.units == "SI" else ""
    walled = shows_forces(result)
    texts = in_column([each.peak for each in curves], 4)
    peaks = {
        each.yields: f"{text}{unit}"
        for each, text in zip(curves, texts, strict=True)
        if each.name == name
    }
    title = f"{name} = {same}" if name == DESIGN and (same := same_as(result)) else name
    parts = [f"{title}, peak {peaks[False]}" if walled else title]
    if True in peaks:
        outside = any(each.outside for each in curves if each.name == name)
        caution = [f"{OUTSIDE_LAW})"] if outside else []
        dashed = _differ([each for each in curves if each.name == name])
        if walled:
            parts += [f"({'dashed, ' * dashed}with yield,"]
            shown = f"{FIRST_YIELD:g} Y: {peaks[True]}"
        else:
            shown = "(with yield: the same curve"
            if dashed:
                shown = f"(dashed: with yield, {FIRST_YIELD:g} Y"
        parts += [f"{shown}{',' if outside else ')'}", *caution]
    violated = violations(result, shown_chains(result)[name], at_fully_plastic=True)
    parts[-1] += "," * bool(violated)
    return _wrapped(axes, parts + violated)


def _wrapped(axes: Axes, parts: Sequence[str]) -> str:
    """Parts of a label, in lines that fit a legend of the width of axes."""
    letter = CHARACTER * FontProperties(size=rcParams["legend.fontsize"]).get_size_in_points()
    inches = axes.get_window_extent().width / axes.figure.dpi
    letters = int(POINTS_PER_INCH * inches / letter) - HANDLE
    text = " ".join(part.replace(" ", "\u00a0") for part in parts)
    return textwrap.fill(text, max(letters, 1), break_long_words=False).replace("\u00a0", " ")


def _differ(curves: Sequence[Curve]) -> bool:
    """Whether the curves of a chain with and without yield are distinguishable in a plot."""
    elastic, dented = sorted(curves, key=lambda each: each.yields)
    change = np.interp(elastic.x, dented.x, dented.y) - elastic.y
    return bool(np.nanmax(np.abs(change)) > VISIBLE * np.nanmax(np.abs(elastic.y)))


def _draw_limits(result: DesignResult, axes: Axes) -> None:
    """Draw limits of the peak force on the wall or cap that are not far above the curves."""
    top = NEAR * axes.get_ylim()[1]
    for each in result.problem.requirements:
        if each.measure.key in (PEAK.key, BODY_PEAK) and each.limit < top:
            axes.axhline(each.limit, color=grey(axes, 0.4), linestyle="--", linewidth=1.0,
                         label=f"limit {each.shown(each.limit)}")  # fmt: skip


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
            else changes(result.problem._with(objectives=(objective,)), result.chain, 0.01)
        )  # fmt: skip
        shaded = shade_other_bodies(axes, result.chain)
        both = bars_of_changes(axes, *found)
        # A legend, which may be above the axes, names the shaded beads.
        if shaded and not both:
            _name_given(result, axes)
        axes.set_xlabel("bead $k$")
        axes.xaxis.set_major_locator(BeadLocator())
        single = objective.single
        name = "score" if single is None else label_in(result.chain, single)
        size = "diameter" if result.chain.units == "SI" else "$R_k$"
        change = f"change [%], {size} {PLUS_MINUS if both else '+'}1%"
        axes.set_ylabel(
            f"{broken_label(axes, 'height', f'{name}:')}\n{broken_label(axes, 'height', change)}"
        )
    return axes


def _name_given(result: DesignResult, axes: Axes) -> None:
    """Name the shaded strikers and cap above the axes, where no bar is."""
    chain = result.chain
    words = {"va": "bottom", "fontsize": rcParams["legend.fontsize"],
             "transform": axes.get_xaxis_transform()}  # fmt: skip
    if count := chain.strikers:
        axes.text(0.5, 1.0, f"striker{'s' if count > 1 else ''}", **words)
    if chain.cap is not None:
        axes.text(chain.beads + 0.5, 1.0, "cap", ha="right", **words)


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
            raise InputError(
                "this design has one objective and no Pareto front; give two objectives"
            )
        axes = get_axes(ax)
        first, second = (str(each.single) for each in result.problem.objectives)
        words = {str(each): label_in(result.chain, each) for each in result.problem.measures}
        points = sorted(
            (each.values[second], each.values[first], each.verified.outside_range)
            for each in result.front
        )
        units = {str(each): each.unit for each in result.problem.measures}
        (across, x_unit), (up, y_unit) = (
            usual_unit(result, units[name]) for name in (second, first)
        )
        x, y, outside = np.array(points).T
        x, y, outside = across * x, up * y, outside.astype(bool)
        _join_points(result, x, y, axes)
        law = "their law" if assumes_pressure(result.chain) else "Hertz's law"
        for flags, face, where in ((~outside, COLOURS[1], "within"), (outside, "none", "outside")):
            if flags.any():
                axes.plot(x[flags], y[flags], "o", color=COLOURS[1], markerfacecolor=face,
                          label=f"{where} the range of {law}")  # fmt: skip
        _draw_yielding_points(result, (second, across), (first, up), axes)
        draw_compared_rows(result, (second, across, x_unit), (first, up, y_unit), axes)
        place_legend(axes, title=_assumed(result))
        if without := without_in_words(result.chain):
            # The row is drawn with them.
            words |= {str(each): f"{each.label}{without}" for each in result.problem.measures
                      if each.key in ("length", "mass", "beads")}  # fmt: skip
        x_label = f"{words[second]} [{x_unit}]" if x_unit else words[second]
        y_label = f"{words[first]} [{y_unit}]" if y_unit else words[first]
        axes.set_xlabel(broken_label(axes, "width", x_label))
        axes.set_ylabel(broken_label(axes, "height", y_label))
    return axes


def _draw_yielding_points(
    result: DesignResult, across: tuple[str, float], up: tuple[str, float], axes: Axes
) -> None:
    """Draw points outside the range of Hertz's law also with contacts that yield, joined to them.

    Both axes are given as the name of an objective and the factor to its unit.
    """
    ends: dict[str, list[list[float]]] = {}
    for point in result.front:
        elastic, yielding = point.values, point.values | point.verified.yielding
        if point.verified.yielding:
            begin, end = ([factor * values[name] for name, factor in (across, up)]
                          for values in (elastic, yielding))  # fmt: skip
            axes.plot(*zip(begin, end, strict=True), ":", color=grey(axes, 0.6), linewidth=0.8)
            ends.setdefault(point.verified.yielding_words, []).append(end)
    for words, places in sorted(ends.items()):
        mark = "x" if words == WITH_YIELD else "+"
        label = _wrapped(axes, words.replace(", ", ",\n").split("\n"))
        axes.plot(*np.array(places).T, mark, color=COLOURS[2], label=label)
    if beaten := beaten_if_yielding(result.front, result.problem):
        values = [result.front[i].values | result.front[i].verified.yielding for i in beaten]
        x, y = ([factor * row[name] for row in values] for name, factor in (across, up))
        # Circles around points that are close would overlap.
        axes.plot(x, y, "x", color=grey(axes, 0.6), label="beaten by others if contacts yield")


def _join_points(result: DesignResult, x: Array, y: Array, axes: Axes) -> None:
    """Join points of sizes; there is nothing between rows of balls, whose front has steps."""
    colour = COLOURS[1]
    if result.problem.discrete:
        least = result.problem.objectives[1].weights[0] > 0.0
        axes.step(x, y, color=colour, linewidth=0.8, alpha=0.5, where="post" if least else "pre")
    else:
        axes.plot(x, y, color=colour)


def plot_design(result: DesignResult) -> Figure:
    """Plot beads, forces, history, and the sensitivity or the Pareto front.

    Beads and forces have the whole width; the others are side by side or, at the width of a column
    of a journal, below each other.
    """
    with figure_style():
        curves = compared_curves(result, MUCH)
        small = _small(result, curves)
        width, _ = figure_size(8.0, 1.0)
        narrow = width < NARROW
        most = MAX_BEADS if len(shown_chains(result)) > 1 else 0.5 * MAX_BEADS
        beads = LABELS_OF_BEADS + min(most, height_of_beads(result, PART * width))
        # Long legends are above the forces of a narrow figure.
        room = 0.5 if narrow and any(each.yields for each in curves) else 0.0
        panel = PANEL if narrow else 1.5 * PANEL
        heights = [beads, panel * (1.0 + ENLARGED * len(small)) + room, panel, panel]
        heights = heights if narrow else heights[:3]
        figure = plt.figure(figsize=(width, sum(heights)), layout="constrained")
        grid = figure.add_gridspec(len(heights), 1 if narrow else 2, height_ratios=heights)
        plot_beads(result, ax=figure.add_subplot(grid[0, :]))
        if small:
            parts = grid[1, :].subgridspec(1 + len(small), 1)
            forces = _draw_panels(result, curves, small, parts)
        else:
            forces = _draw_curves(result, curves, figure.add_subplot(grid[1, :]))
        plot_history(result, ax=figure.add_subplot(grid[2, 0]))
        last = figure.add_subplot(grid[-1, -1])
        _draw_last(result, last)
        for axes in figure.axes:
            # No line begins with a unit.
            lines = axes.get_ylabel().replace(" [", "\u00a0[").split("\n")
            width = NARROW_LABEL if narrow else LABEL
            axes.set_ylabel("\n".join(textwrap.fill(line, width) for line in lines))
        # The panel is lower than this line.
        label = last.get_ylabel()
        if narrow:
            label = textwrap.fill(label.replace("\n", " "), NARROW_LABEL)
        else:
            label = label.replace("change\u00a0[%], ", "change\u00a0[%],\n")
        last.set_ylabel(label)
        figure.draw_without_rendering()
        for row, axes in ((1, forces), (-1, last)):
            legend = axes.get_legend()
            if legend is not None and covers_data(legend):
                # The row becomes taller by the height of the legend.
                heights[row] += put_legend_above(axes)
        grid.set_height_ratios(heights)
        figure.set_figheight(sum(heights))
    return figure


def _draw_last(result: DesignResult, axes: Axes) -> None:
    """Draw the Pareto front or the sensitivity or, if masses were given, the masses."""
    if result.front:
        plot_front(result, ax=axes)
    elif "masses" in result.chain.given:
        axes.bar(np.arange(1, result.chain.beads + 1), result.chain.masses, color=COLOURS[3])
        axes.set_xlim(0.3, result.chain.beads + 0.7)
        axes.set_xlabel("bead $k$")
        axes.xaxis.set_major_locator(BeadLocator())
        axes.set_ylabel("mass $m_k$")
    else:
        plot_sensitivity(result, ax=axes)


def _stating_yield(draw: Callable[..., Axes]) -> Callable[..., Axes]:
    """State the yield pressure that contacts assume above a figure of one panel."""

    def drawn(result: DesignResult, *, ax: Axes | None = None) -> Axes:
        axes = draw(result, ax=ax)
        if words := _assumed(result):
            with figure_style():
                set_title(axes, words)
        return axes

    return drawn


KINDS: Final[dict[str, Callable[..., Axes]]] = {
    "beads": plot_beads, "forces": plot_forces, "history": _stating_yield(plot_history),
    "sensitivity": _stating_yield(plot_sensitivity), "front": plot_front,
}  # fmt: skip
