"""Draw pulses and runs: data to axes, no computing.

Every function takes data and optional axes, and returns the axes.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import resources
from typing import Final, Literal

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hertzchain.errors import InputError, unknown_name
from hertzchain.pulse import PER_CONTACT, Pulse, Quantity
from hertzchain.run import Run
from hertzchain.scoreboard import Scoreboard, Statistic
from hertzchain.scoreboard_cases import GROUPS

# Colours of Okabe and Ito, told apart by colour-blind readers; markers say it again in grey.
COLOURS: Final = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
MARKERS: Final = ("o", "+", "x", "s", "^", "v", "D")
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


@contextmanager
def house_style() -> Iterator[None]:
    """The package's matplotlib style, for the figures made inside a ``with`` block.

    Examples
    --------
    >>> with house_style():
    ...     figure, axes = plt.subplots()
    """
    style = resources.files("hertzchain").joinpath("hertzchain.mplstyle")
    with resources.as_file(style) as path, plt.style.context(path):
        yield


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """A figure as the content of a file; two runs give the same bytes.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure to save.
    kind : str
        ``"png"``, ``"svg"`` or ``"pdf"``.

    Returns
    -------
    bytes

    Examples
    --------
    >>> figure, axes = plt.subplots()
    >>> figure_bytes(figure, "png")[1:4]
    b'PNG'
    """
    undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    content = io.BytesIO()
    with house_style():
        figure.savefig(content, format=kind, metadata=undated)
    return content.getvalue()


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
        axes = ax if ax is not None else plt.subplots()[1]
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
                label=pulse.method,
            )
        axes.set_xlabel("contact $k$" if quantity in PER_CONTACT else "bead $k$")
        unit = "" if pulses[0].chain.units == "scaled" else f" [{pulses[0].unit(quantity)}]"
        axes.set_ylabel(LABELS[quantity] + unit)
        axes.set_yscale("log" if log else "linear")
        axes.set_title("; ".join(dict.fromkeys(pulse.chain.description for pulse in pulses)))
        axes.legend()
    return axes


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
    if quantity not in ("velocity", "force"):
        raise unknown_name("quantity of a map", quantity, ("velocity", "force"))
    real = run.chain.units == "SI"
    # One colour for at rest: white, red forwards, blue backwards.
    values, label, low, colours = run.velocities, "velocity $v_k(t)$", -1.0, "RdBu_r"
    numbers = np.arange(1, run.chain.beads + 1)
    if quantity == "force":
        values, label, low, colours = run.forces, "force $F_k(t)$", 0.0, "afmhot_r"
        numbers = np.arange(run.chain.beads + 1)
    unit = {"velocity": "m/s", "force": "N"}[quantity]
    with house_style():
        axes = ax if ax is not None else plt.subplots()[1]
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
        axes.set_title(run.chain.description)
    return axes


def plot_scoreboard(
    board: Scoreboard,
    quantity: Quantity = "velocity",
    *,
    first_bead: int = 10,
    statistic: Statistic = "worst",
    ax: Axes | None = None,
) -> Axes:
    """Draw a scoreboard: a row for each family of chains, a symbol for each theory.

    Parameters
    ----------
    board : Scoreboard
        What to draw.
    quantity, first_bead, statistic
        As of `Scoreboard.table`.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; a new figure's if not given.

    Returns
    -------
    matplotlib.axes.Axes
        Abscissa: error, logarithmic.  A pale symbol: the theory itself warns that it is
        outside its range.  No symbol: not covered.

    Examples
    --------
    >>> from hertzchain.scoreboard import scoreboard
    >>> plot_scoreboard(scoreboard(theories=["bca"])).get_xscale()
    'log'
    """
    errors = board.table(quantity, first_bead=first_bead, statistic=statistic)
    outside = board.outside()
    heights, headings = _scoreboard_rows(board)
    with house_style():
        axes = ax if ax is not None else plt.subplots(figsize=(8.0, 0.23 * max(heights) + 1.1))[1]
        for t, theory in enumerate(board.theories):
            if errors[theory].isna().all():
                continue
            for warned, strength in ((False, 1.0), (True, 0.35)):
                rows = outside[theory].to_numpy() == warned
                axes.plot(
                    100.0 * errors[theory].to_numpy()[rows],
                    np.array(heights)[rows],
                    MARKERS[t % len(MARKERS)],
                    color=COLOURS[t % len(COLOURS)],
                    markerfacecolor="none",
                    markeredgewidth=1.3,
                    markersize=6.5,
                    alpha=strength,
                    label=None if warned else theory,
                )
        if (outside & errors.notna()).to_numpy().any():
            axes.plot([], [], "o", color="0.7", markerfacecolor="none", markersize=6.5,
                      label="pale: outside its range, it warns")  # fmt: skip
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter(lambda percent, _: f"{percent:g} %")
        axes.set_yticks(heights, list(errors.index))
        axes.set_ylim(max(heights) + 0.7, -0.7)
        axes.tick_params(axis="y", length=0)
        axes.grid(color="0.88", linewidth=0.6)
        axes.set_axisbelow(True)
        for height, text in headings:
            axes.text(-0.01, height, text, transform=axes.get_yaxis_transform(), ha="right",
                      va="center", fontweight="bold", fontsize="small")  # fmt: skip
        axes.set_xlabel(
            f"{statistic} relative error of {quantity.replace('_', ' ')}, "
            f"$k = {first_bead} \\dots {board.last_bead}$"
        )
        axes.legend(loc="lower center", bbox_to_anchor=(0.4, 1.0), ncols=3, frameon=False)
    return axes


def _scoreboard_rows(board: Scoreboard) -> tuple[list[float], list[tuple[float, str]]]:
    """Height of each family and of each group's heading, from above."""
    heights: list[float] = []
    headings: list[tuple[float, str]] = []
    at, group = 0.0, None
    for members in board.rows("family").values():
        if board.cases[members[0]].group != group:
            group = board.cases[members[0]].group
            at += 0.4 if heights else 0.0
            headings.append((at, GROUPS[group]))
            at += 1.0
        heights.append(at)
        at += 1.0
    return heights, headings


def label_right_ends(axes: Axes, labels: Sequence[tuple[float, float, str, str]]) -> None:
    """Name curves at their right ends, moved apart where they would overlap.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Axes whose limits and scales are final.
    labels : sequence of (x, y, text, colour)
        Right ends of the curves.

    Examples
    --------
    >>> figure, axes = plt.subplots()
    >>> label_right_ends(axes, [(1.0, 0.5, "a", "black"), (1.0, 0.5, "b", "black")])
    >>> [text.get_text() for text in axes.texts]
    ['a', 'b']
    """
    to_axes = axes.transData + axes.transAxes.inverted()
    ends = sorted((*to_axes.transform((x, y)), text, colour) for x, y, text, colour in labels)
    ends.sort(key=lambda end: end[1])
    spacing = 0.052
    heights = np.array([end[1] for end in ends])
    # Push apart from below, then give half of the total shift back: stays near the curves.
    spread = heights.copy()
    for i in range(1, len(spread)):
        spread[i] = max(spread[i], spread[i - 1] + spacing)
    spread -= (spread - heights).mean()
    for (x, y, text, colour), height in zip(ends, spread, strict=True):
        axes.annotate(
            text,
            xy=(x, y),
            xytext=(1.03, height),
            xycoords="axes fraction",
            textcoords="axes fraction",
            color=colour,
            va="center",
            fontsize=8.5,
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.5, "shrinkB": 1.0},
        )
