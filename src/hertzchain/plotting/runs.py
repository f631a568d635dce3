"""Plot runs: maps over time and bead, forces in sensors and on walls."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Final, Literal

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from ..chain.bead_names import bead_label, bead_number, wall_number, walls_of
from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError
from ..pulse.quantities import RUN_QUANTITIES
from ..simulation.body_force import body_curve, body_force
from ..simulation.body_peak import body_in_words
from ..simulation.run import Run
from ..simulation.sensor_force import sensor_maxima, warn_if_coarse
from ..simulation.wall_force import WallForce
from ..validation.keywords import checked_arguments
from ..validation.numbers import whole_number
from ..validation.objects import check_bool, check_choice, check_list, text
from .acting_times import limit_to_forces
from .colours import curve_colour, free_numbers, grey, signed_map
from .enlarged import finish_enlarged, small_groups
from .force_lines import (
    ForceLine,
    common_title,
    force_lines,
    label_and_style,
    raise_hidden,
    same_style,
    with_peaks,
)
from .legends import place_legend
from .shared_axes import label_below, numbers_are_below, use_prefix
from .static_forces import change_label, show_changes, small_change, static_force, static_forces
from .style import (
    TIME_LABELS,
    BeadLocator,
    figure_style,
    get_axes,
    literal,
    mark_horizon,
    set_title,
    time_axis,
)
from .titles import chain_title
from .widths import figure_size

# Fewest equal beads of a section, and largest number of sections with boundaries in a map.
SECTION, MAX_SECTIONS = 2, 8
# Place of the whole force on the last body of a free end.
BODY: Final = "body"
# Fewest times of a map.
MAP_TIMES: Final = 1000
# Sensors of a single run differ also in print without colours; a dashed wall would look like a
# line for reference.
SENSOR_LINES: Final = ("-", "--", "-.", ":")
WALL_WIDTH: Final = 1.8


@checked_arguments("plot_run")
def plot_run(
    run: Run,
    quantity: Literal["velocity", "force"] = "velocity",
    *,
    relative: bool = False,
    ax: Axes | None = None,
) -> Axes:
    """Plot velocities or contact forces over time as a map, bead 1 at the bottom.

    Dashed lines separate sections of equal beads.

    Parameters
    ----------
    run : Run
        A run with saved times.
    quantity : str
        ``"velocity"`` of every bead or ``"force"`` in every contact.
    relative : bool
        Whether to divide the values of each bead or contact by the largest absolute one there, so
        that waves in light beads or soft materials are visible.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into.  By default, a new figure is created.

    Raises
    ------
    InputError
        If fewer than two times were saved, or for another quantity.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.plotting.plot_run(hc.simulate(hc.Chain.uniform(9))).get_xlabel()
    'time $t$'
    """
    check_times(run.times, "a map")
    check_choice("quantity of a map", quantity, ("velocity", "force"))
    values = run.forces if quantity == "force" else run.velocities
    if check_bool("relative", relative):
        largest = np.abs(values).max(axis=0)
        values = values / np.where(largest > 0.0, largest, 1.0)
    factor, time_label = time_axis(run.chain, float(run.times[-1]))
    if quantity == "force":
        numbers = np.arange(run.chain.beads + 1)
        colours, low, high = "afmhot_r", 0.0, float(np.abs(values).max())
    else:
        # White is at rest, red forwards, blue backwards; motion in one direction uses one half.
        numbers = np.arange(1, run.chain.beads + 1)
        colours, low, high = signed_map(values)
    drawn = RUN_QUANTITIES[quantity]
    label = f"{quantity} [{drawn.unit}]" if run.chain.units == "SI" else drawn.label
    if quantity == "force" and not relative and (found := _small_change(run)) is not None:
        size, label = change_label(*found, run.chain)
        values = size * (values - static_forces(run.chain))
        colours, low, high = signed_map(values)
    if relative:
        label = f"{quantity} / largest of the {drawn.per}"
    with figure_style():
        axes = get_axes(ax)
        times, values = _with_many_times(run.times, values)
        mesh = axes.pcolormesh(
            factor * times,
            numbers,
            values.T,
            cmap=colours,
            vmin=low,
            vmax=high,
            shading="nearest",
            rasterized=True,
        )
        bar = axes.figure.colorbar(mesh, ax=axes, label=label)
        use_prefix(bar.ax)
        label_below(axes, time_label)
        axes.set_ylabel(f"{drawn.per} $k$")
        axes.yaxis.set_major_locator(BeadLocator(int(numbers[0])))
        for k in section_ends(run.chain):
            at = k if quantity == "force" else k + 0.5
            axes.axhline(at, color=grey(axes, 0.25), linewidth=0.7, linestyle="--")
        mark_horizon(axes, run.known_horizon, factor)
        set_title(axes, chain_title(run.chain))
    return axes


def _small_change(run: Run) -> tuple[float, float] | None:
    """A static force and the largest change, if all loaded contacts have this static force."""
    resting = static_forces(run.chain)
    loaded = resting > 0.0
    if not loaded.any() or run.forces[:, ~loaded].any():
        return None
    return small_change([*run.forces[:, loaded].T], resting[loaded].tolist())


def _with_many_times(times: Array, values: Array) -> tuple[Array, Array]:
    """Values between few saved times, by linear interpolation, for a map without coarse steps."""
    if len(times) >= MAP_TIMES:
        return times, values
    fine = np.linspace(times[0], times[-1], MAP_TIMES)
    return fine, np.column_stack([np.interp(fine, times, column) for column in values.T])


def section_ends(chain: Chain) -> list[int]:
    """Last bead k of each section of equal beads but the last; empty if there are no sections."""
    kinds = chain.materials or (None,) * chain.beads
    beads = zip(chain.radii.tolist(), chain.masses.tolist(), kinds, strict=True)
    lengths = [len(list(group)) for _, group in itertools.groupby([*beads][chain._balls])]
    if not 1 < len(lengths) <= MAX_SECTIONS or min(lengths) < SECTION:
        return []
    return (chain.strikers + np.cumsum(lengths[:-1])).tolist()


@checked_arguments("plot_forces")
def plot_forces(
    run: Run,
    beads: Sequence[int | str],
    *,
    label: str = "",
    legend: bool = True,
    ax: Axes | None = None,
) -> Axes:
    """Plot the force in sensors in beads, and on walls, over time.

    Curves contain the maxima, which are located between the saved times.  If the peak force on a
    wall is not complete, its curve ends in an open circle, and the legend states that a larger
    force may follow.  If one of several runs in the same axes is much shorter, the legend states
    where it ends; runs of almost the same length are shown up to the end of the first.  Your own
    labels, and figures in a `figure_style` for a journal, have none of these remarks.

    Parameters
    ----------
    run : Run
        A run with saved times.
    beads : sequence of int or str
        Numbers of the beads with a sensor; N + 1 is the right wall, 0 the left one.  Or names such
        as ``"ball 11"``, counted without the strikers, and ``"wall"``, or ``"left wall"`` and
        ``"right wall"`` if there are two; ``"body"`` is the whole force on the last body of a free
        right end, such as a cap, in which a sensor has half of it.
    label : str
        Name of the run in the legend, if several runs are plotted into the same axes; followed by
        the names of the beads if there are several.  By default, labels name the properties in
        which the chains of these runs differ, and the title has the parts that they share.
    legend : bool
        Whether the axes have a legend.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into.  By default, a new figure is created.

    Raises
    ------
    InputError
        If there is no such bead, or fewer than two times were saved.

    Warns
    -----
    IncompleteWarning
        If saved times are so few that the largest force in a sensor is uncertain by more than 1%.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    >>> axes = hc.plotting.plot_forces(hc.simulate(chain), [5, 10, 21])
    >>> [text.get_text() for text in axes.get_legend().get_texts()]
    ['bead 5', 'bead 10', 'right wall']
    """
    check_times(run.times, "a plot")
    legend = check_bool("legend", legend)
    name = "" if isinstance(label, str) and not label else text("label", label)
    if isinstance(beads, int | np.integer | str):
        beads = [beads]
    given = check_list("beads", beads, "beads or walls, such as [3, 'ball 6', 'wall']")
    if not given:
        raise InputError("beads must contain at least one bead number, such as [3, 6]")
    with figure_style():
        axes = get_axes(ax)
        # Curves of several runs in the same axes have different colours.
        places = not name or len(given) > 1
        _draw_forces(axes, run, given, name, len(axes.lines), places=places, named=bool(name))
        title = common_title(axes)
        set_title(axes, title or chain_title(run.chain), common=bool(title))
        if len(axes.get_shared_x_axes().get_siblings(axes)) == 1:
            limit_to_forces([axes])
        if legend:
            place_legend(axes, own=ax is None)
    return axes


def _draw_forces(
    axes: Axes, run: Run, beads: Sequence[int | str], name: str, first: int, *,
    compared: int | None = None, places: bool = True, named: bool = False,
) -> None:  # fmt: skip
    """Draw forces of a run, in the unit of time that the axes have, with colours from a first.

    The label has the name of the run and, with ``places``, that of the place; ``named`` if a user
    has given the name.  ``compared`` is the number of the run in a figure of several runs; by
    default, runs in these axes are counted.
    """
    curves = [force_curve(run, each) for each in beads]
    factor, time_label = time_axis(run.chain, float(run.times[-1]))
    if axes.get_xlabel() in TIME_LABELS:
        factor, time_label = TIME_LABELS[axes.get_xlabel()], axes.get_xlabel()
    number = 1 + max((line.run for line in force_lines(axes)), default=-1)
    dashes = itertools.cycle(SENSOR_LINES)
    resting = [_static(run, bead, curve[2]) for bead, curve in zip(beads, curves, strict=True)]
    numbers = free_numbers(axes, first, len(curves))
    for i, rest, (times, force, curve, cut_off) in zip(numbers, resting, curves, strict=True):
        wall = curve.endswith("wall")
        words = filter(None, (name, curve if places else ""))
        line = ForceLine(
            factor * times, force, number if compared is None else compared, ", ".join(words),
            cut_off=cut_off, named=named, chain=None if name else run.chain,
            static=rest,
            color=curve_colour(axes, i), linestyle="-" if wall else next(dashes),
            linewidth=WALL_WIDTH if wall else None,
        )  # fmt: skip
        axes.add_line(line)
    axes.autoscale_view()
    # A further run in these axes has the unit of this label, also if it is not shown.
    axes.set_xlabel(time_label, visible=not numbers_are_below(axes))
    show_changes(axes, run.chain)
    axes.margins(x=0.0)
    label_and_style(axes, compared=compared is not None)
    raise_hidden(force_lines(axes))
    mark_horizon(axes, run.known_horizon, factor)


def plot_forces_of_runs(runs: Mapping[str, Run], beads: Mapping[str, Sequence[int | str]]) -> Axes:
    """Plot forces of several runs in the same axes, and weak or short ones also enlarged.

    Each of several places has a panel, unless forces or durations of the runs differ much.  Runs in
    different units have a panel each.

    Parameters
    ----------
    runs : mapping of str to Run
        Runs with saved times, by name.
    beads : mapping of str to sequence of int or str
        Beads of each run, as for `plot_forces`.

    Returns
    -------
    matplotlib.axes.Axes
        The first panel.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.plotting.runs import plot_forces_of_runs
    >>> chain = hc.Chain.uniform(9).replace(right_wall=hc.Wall())
    >>> runs = {"short": hc.simulate(chain), "long": hc.simulate(chain, until=300.0)}
    >>> first = plot_forces_of_runs(runs, {"short": [10], "long": [10]})
    >>> [axes.get_title(loc="left") for axes in first.figure.axes]
    ['right wall', 'short: time axis enlarged 16 times']
    """
    names = [*runs]
    tops = [
        max(float(force_curve(run, bead)[1].max()) for bead in beads[name])
        for name, run in runs.items()
    ]
    ends = [float(run.times[-1]) for run in runs.values()]
    common = len({run.chain.units for run in runs.values()}) == 1
    everything = [*range(len(names))]
    groups = small_groups(tops, ends) if common else []
    if common and not groups and len({len(beads[name]) for name in names}) == 1:
        return _draw_places(runs, beads)
    panels = [[i] for i in everything]
    if common:
        panels = [everything, *(each.curves for each in groups)]
    label = time_axis(runs[names[0]].chain, max(ends))[1] if common and len(panels) > 1 else ""
    places = {force_curve(run, bead)[2] for name, run in runs.items() for bead in beads[name]}
    colours = np.cumsum([0, *(len(beads[name]) for name in names)])
    with figure_style():
        size = figure_size(6.0, 2.6 * len(panels)) if len(panels) > 1 else None
        grid = plt.subplots(len(panels), 1, squeeze=False, figsize=size)[1]
        for axes, shown in zip(grid[:, 0], panels, strict=True):
            axes.set_xlabel(label)
            for i in shown:
                name = names[i]
                _draw_forces(
                    axes, runs[name], beads[name], literal(name), int(colours[i]),
                    compared=i if common else None, places=len(places) > 1,
                )  # fmt: skip
        first: Axes = grid[0, 0]
        if len(places) == 1:
            first.set_title(places.pop(), loc="left")
        with_peaks(first, runs[names[0]].chain.units)
        place_legend(first, own=len(panels) == 1)
        for axes, group in zip(grid[1:, 0], groups, strict=False):
            # Lines of the title end between names.
            own = [literal(names[i]).replace(", ", ",\u00a0") for i in group.curves]
            separator = "; " if "," in "".join(own) else ", "
            finish_enlarged(axes, first, separator.join(own), short=group.short)
            same_style(axes, first)
        if not common:
            for axes, name in zip(grid[1:, 0], names[1:], strict=True):
                with_peaks(axes, runs[name].chain.units)
                place_legend(axes)
    return first


def _draw_places(runs: Mapping[str, Run], beads: Mapping[str, Sequence[int | str]]) -> Axes:
    """Draw the forces at each place in a panel, with one curve per run."""
    places, labels = [*zip(*(beads[name] for name in runs), strict=True)], list[list[str]]()
    with figure_style():
        size = figure_size(6.0, 2.1 * len(places) + 0.5) if len(places) > 1 else None
        grid = plt.subplots(len(places), 1, squeeze=False, sharex=True, figsize=size)[1]
        for axes, numbers in zip(grid[:, 0], places, strict=True):
            pairs = [*zip(runs.items(), numbers, strict=True)]
            words = {force_curve(run, number)[2] for (_, run), number in pairs}
            alone = len(words) == 1
            for i, ((name, run), number) in enumerate(pairs):
                _draw_forces(axes, run, [number], literal(name), i, compared=i, places=not alone)
            if alone:
                axes.set_title(words.pop(), loc="left")
        limit_to_forces([*grid[:, 0]])
        for axes in grid[:, 0]:
            labels.append(axes.get_legend_handles_labels()[1])
            # Such as that of a wall whose peak is not complete.
            if labels[-1] != labels[0] or len(labels) == 1:
                if len(places) == 1:
                    with_peaks(axes, next(iter(runs.values())).chain.units)
                place_legend(axes, own=len(places) == 1)
    first: Axes = grid[0, 0]
    return first


def force_curve(run: Run, bead: int | str) -> tuple[Array, Array, str, bool]:
    """Times, forces and name of a curve, and whether the peak on a wall or cap is not complete."""
    walls = {number: side for side, number in walls_of(run.chain).items()}
    if (named := wall_number(run.chain, bead)) is not None:
        bead = named
    if not isinstance(bead, str) and whole_number("bead", bead, least=0) in walls:
        wall = run.wall_force(walls[bead])
        return *wall_curve(wall), f"{wall.side} wall", not wall.complete
    if bead == BODY:
        if run.chain.right_wall is not None:
            raise InputError("'body' is the last body of a free right end; use 'wall'")
        largest = body_force(run)
        cut_off = largest is None or not largest.complete
        return *body_curve(run), f"force on {body_in_words(run.chain)}", cut_off
    number = bead_number(run.chain, bead, walls=True)
    sensor = sensor_maxima(run, number)
    warn_if_coarse(run, sensor)
    maxima = [(sensor.first_maximum_time, sensor.first_maximum),
              (sensor.largest_so_far_time, sensor.largest_so_far)]  # fmt: skip
    times, force = _with_points(run.times, run.sensor(number), maxima)
    name = bead_label(run.chain, number)
    half = ", half of the force on it" if sensor.free_face else ""
    return times, force, f"{name}{half}", False


def _static(run: Run, bead: int | str, curve: str) -> float:
    """Static force of a curve; that on a body is not known."""
    if bead == BODY:
        return 0.0
    walls = {f"{side} wall": number for side, number in walls_of(run.chain).items()}
    if curve in walls:
        return static_force(run.chain, walls[curve])
    return static_force(run.chain, bead_number(run.chain, bead, walls=True))


def wall_curve(wall: WallForce) -> tuple[Array, Array]:
    """Times and forces of a wall, with the largest one."""
    largest = wall.largest_so_far_time, wall.largest_so_far
    return _with_points(wall.times, wall.force, [largest])


def _with_points(
    times: Array, values: Array, points: Sequence[tuple[float, float]]
) -> tuple[Array, Array]:
    """A curve with further points between its times."""
    new = {x: y for x, y in points if times[0] < x < times[-1] and x not in times}
    at = np.searchsorted(times, [*new])
    return np.insert(times, at, [*new]), np.insert(values, at, [*new.values()])


def check_times(times: Array, what: str) -> None:
    """Require at least two saved times for a plot."""
    if len(times) < 2:
        raise InputError(
            f"{what} needs at least 2 saved times, but the run has {len(times)}; give simulate "
            "times, such as times=400"
        )
