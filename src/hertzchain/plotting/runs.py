"""Draw runs: maps over time and bead, forces as sensors see them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from hertzchain.arguments import listed, one_of
from hertzchain.checks import whole_number
from hertzchain.errors import InputError
from hertzchain.plotting.style import (
    COLOURS,
    axes_in,
    house_style,
    literal,
    mark_horizon,
    time_axis,
    titled,
)
from hertzchain.simulation.run import Run
from hertzchain.simulation.wall_force import Side

# What the legend adds to a wall whose force may still exceed what is drawn.
CUT_OFF = " (peak not complete)"


def plot_run(
    run: Run, quantity: Literal["velocity", "force"] = "velocity", *, ax: Axes | None = None
) -> Axes:
    """Draw velocities or contact forces over time as a map, bead 1 at the bottom.

    Parameters
    ----------
    run : Run
        A run with saved times.
    quantity : str
        ``"velocity"`` of every bead or ``"force"`` in every contact.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; a new figure's if not given.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        If fewer than two times were saved, or for another quantity.

    Examples
    --------
    >>> import hertzchain as hc
    >>> plot_run(hc.simulate(hc.Chain.uniform(9))).get_xlabel()
    'time $t$'
    """
    if len(run.times) < 2:
        raise InputError(f"a map needs at least 2 saved times, the run has {len(run.times)}")
    one_of("quantity of a map", quantity, ("velocity", "force"))
    real = run.chain.units == "SI"
    # One colour for at rest: white, red forwards, blue backwards.
    values, label, low, colours = run.velocities, "velocity $v_k(t)$", -1.0, "RdBu_r"
    numbers = np.arange(1, run.chain.beads + 1)
    if quantity == "force":
        values, label, low, colours = run.forces, "force $F_k(t)$", 0.0, "afmhot_r"
        numbers = np.arange(run.chain.beads + 1)
    unit = {"velocity": "m/s", "force": "N"}[quantity]
    with house_style():
        axes = axes_in(ax)
        largest = float(np.abs(values).max())
        mesh = axes.pcolormesh(
            run.times * (1e6 if real else 1.0),
            numbers,
            values.T,
            cmap=colours,
            vmin=low * largest,
            vmax=largest,
            shading="nearest",
            rasterized=True,
        )
        axes.figure.colorbar(mesh, ax=axes, label=f"{quantity} [{unit}]" if real else label)
        axes.set_xlabel("time [µs]" if real else "time $t$")
        axes.set_ylabel("bead $k$" if quantity == "velocity" else "contact $k$")
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))
        mark_horizon(axes, run.known_horizon)
        titled(axes, literal(run.chain.description))
    return axes


def plot_forces(run: Run, beads: Sequence[int], *, ax: Axes | None = None) -> Axes:
    """Draw the force in sensors in some beads, and on the walls, over time.

    The curve of a wall whose peak is not complete ends in an open circle, and the legend says so.

    Parameters
    ----------
    run : Run
        A run with saved times.
    beads : sequence of int
        Numbers of the beads with a sensor; N + 1 is the right wall, 0 the left one.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; a new figure's if not given.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        If there is no such bead, or fewer than two times were saved.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    >>> axes = plot_forces(hc.simulate(chain), [5, 10, 21])
    >>> [text.get_text() for text in axes.get_legend().get_texts()]
    ['bead 5', 'bead 10', 'right wall']
    """
    check_times(run)
    numbers = [whole_number("bead", k, least=0) for k in listed("beads", beads, "bead numbers")]
    if not numbers:
        raise InputError("name the beads whose forces to draw, such as [3, 6]")
    factor, label = time_axis(run.chain)
    walls: dict[int, Side] = {0: "left", run.chain.beads + 1: "right"}
    with house_style():
        axes = axes_in(ax)
        for i, k in enumerate(numbers):
            wall = run.wall_force(walls[k]) if k in walls else None
            cut_off = wall is not None and not wall.complete
            axes.plot(
                factor * run.times,
                run.sensor(k) if wall is None else wall.force,
                color=COLOURS[i % len(COLOURS)],
                linestyle=("-", "--", "-.", ":")[i // len(COLOURS) % 4],
                marker="o" if cut_off else None,
                markevery=[-1],
                markerfacecolor="none",
                clip_on=not cut_off,
                label=f"bead {k}" if wall is None else f"{wall.side} wall{CUT_OFF * cut_off}",
            )
        axes.set_xlabel(label)
        axes.set_ylabel("force [N]" if run.chain.units == "SI" else "force $F$")
        titled(axes, literal(run.chain.description))
        axes.margins(x=0.0)
        mark_horizon(axes, run.known_horizon)
        axes.legend()
    return axes


def check_times(run: Run) -> None:
    """Refuse a run without saved times to draw.

    Parameters
    ----------
    run : Run
        Any run.

    Raises
    ------
    InputError
        If fewer than two times were saved.

    Examples
    --------
    >>> import hertzchain as hc
    >>> check_times(hc.simulate(hc.Chain.uniform(9), until=1.0))
    """
    if len(run.times) < 2:
        raise InputError(f"a picture needs at least 2 saved times, the run has {len(run.times)}")
