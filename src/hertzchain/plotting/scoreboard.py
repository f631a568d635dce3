"""Plot a scoreboard: one row per family of chains, one symbol per theory."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter

from ..evaluation.cases import GROUPS
from ..evaluation.scoreboard import Scoreboard, Statistic
from ..validation.keywords import checked_arguments
from .colours import curve_colour, grey
from .methods import METHODS, OWN, name_of
from .style import MARKERS, figure_style, get_axes
from .widths import NARROW, figure_size

if TYPE_CHECKING:
    import pandas as pd

# Vertical distance between the symbols of neighbouring theories, in rows.
DODGE = 0.11
WORDS: Final = {"worst": "largest relative", "rms": "rms relative"}
# Relative difference up to which errors of two theories count as equal.
EQUAL = 1e-6


@checked_arguments("plot_scoreboard")
def plot_scoreboard(
    board: Scoreboard,
    quantity: str = "velocity",
    *,
    first_bead: int = 10,
    statistic: Statistic = "worst",
    ax: Axes | None = None,
) -> Axes:
    """Plot a scoreboard: one row per family of chains, one symbol per theory.

    Parameters
    ----------
    board : Scoreboard
        Result of `hertzchain.scoreboard`.
    quantity, first_bead, statistic
        See `Scoreboard.table`.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into.  By default, a new figure is created.

    Returns
    -------
    matplotlib.axes.Axes
        The x axis shows the error on a logarithmic scale.  A pale symbol marks a theory outside
        its range, for which it issues a warning.  Unsupported chains have no symbol.  Theories
        with equal errors share a symbol.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.plotting.plot_scoreboard(hc.scoreboard(theories=["bca"])).get_xscale()
    'log'
    """
    errors = board.table(quantity, first_bead=first_bead, statistic=statistic)
    outside = board.outside()
    heights, headings = _scoreboard_rows(board)
    with figure_style():
        size = 8.0, 0.19 * max(heights) + 1.1
        axes = get_axes(ax, size)
        narrow = figure_size(*size)[0] < NARROW
        shared = _equal_theories(errors, outside)
        looks = [METHODS.get(each, OWN) for each in board.theories]
        for t, theories in enumerate(shared):
            theory, look = theories[0], looks[board.theories.index(theories[0])]
            raised = np.array(heights) + DODGE * (t - 0.5 * (len(shared) - 1))
            for warned, strength in ((False, 1.0), (True, 0.35)):
                rows = outside[theory].to_numpy() == warned
                axes.plot(
                    100.0 * errors[theory].to_numpy()[rows],
                    raised[rows],
                    MARKERS[look.symbol],
                    color=curve_colour(axes, look.colour),
                    markerfacecolor="none",
                    markeredgewidth=1.2,
                    markersize=4.0 if narrow else 6.0,
                    alpha=strength,
                    label=None if warned else ", ".join(map(name_of, theories)),
                )
        if (outside & errors.notna()).to_numpy().any():
            axes.plot([], [], "o", color="0.7", markerfacecolor="none", markersize=6.0,
                      label="pale: outside the range")  # fmt: skip
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(numticks=3 if narrow else 6))
        axes.xaxis.set_minor_locator(LogLocator(numticks=20))
        axes.xaxis.set_major_formatter(lambda percent, _: f"{percent:g}%")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_yticks(heights, list(errors.index))
        axes.set_ylim(max(heights) + 0.7, -0.7)
        axes.tick_params(axis="y", length=0)
        axes.grid(color=grey(axes, 0.88), linewidth=0.6)
        axes.set_axisbelow(True)
        for height, text in headings:
            axes.text(-0.01, height, text, transform=axes.get_yaxis_transform(), ha="right",
                      va="center", fontweight="bold", fontsize="small")  # fmt: skip
        line = "\n" if narrow else " "
        axes.set_xlabel(
            f"{WORDS[statistic]} error{line}of {quantity.replace('_', ' ')}, "
            f"$k = {first_bead} \\dots {board.last_bead}$"
        )
        if ax is None:
            axes.figure.legend(loc="outside upper left", ncols=2 if narrow else 3)
        else:
            axes.legend(loc="lower center", bbox_to_anchor=(0.4, 1.0), ncols=3)
    return axes


def _equal_theories(errors: pd.DataFrame, outside: pd.DataFrame) -> list[list[str]]:
    """Theories with errors, those with equal errors together."""
    found: list[list[str]] = []
    for theory in errors.columns[errors.notna().any()]:
        for others in found:
            equal = np.allclose(
                errors[theory], errors[others[0]], rtol=EQUAL, atol=0.0, equal_nan=True
            )
            if equal and outside[theory].equals(outside[others[0]]):
                others.append(theory)
                break
        else:
            found.append([theory])
    return found


def _scoreboard_rows(board: Scoreboard) -> tuple[list[float], list[tuple[float, str]]]:
    """Heights of the families and of the group headings, from above."""
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
