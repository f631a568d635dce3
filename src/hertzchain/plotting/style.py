"""The package's style of figures: colours, markers, files that are the same every time."""

from __future__ import annotations

import io
import re
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import resources
from typing import TYPE_CHECKING, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hertzchain.arguments import instance
from hertzchain.chain.chain import Chain

if TYPE_CHECKING:
    from hertzchain.simulation.horizon import Horizon

# Colours of Okabe and Ito, told apart by colour-blind readers; markers say it again in grey.
COLOURS: Final = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
MARKERS: Final = ("o", "+", "x", "s", "^", "v", "D")

# Of a title, on average.
INCHES_PER_LETTER: Final = 0.07


@contextmanager
def house_style() -> Iterator[None]:
    """The package's matplotlib style, for the figures made inside a ``with`` block.

    Examples
    --------
    >>> with house_style():
    ...     figure, axes = plt.subplots()
    """
    style = resources.files("hertzchain.plotting").joinpath("hertzchain.mplstyle")
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


def axes_in(ax: Axes | None, figsize: tuple[float, float] | None = None) -> Axes:
    """The axes to draw into: those given, or a new figure's.

    Parameters
    ----------
    ax : matplotlib.axes.Axes or None
        Axes, if any are given.
    figsize : tuple of float, optional
        Size of a new figure [inches].

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        If something else was given.

    Examples
    --------
    >>> axes = axes_in(None)
    >>> axes_in(axes) is axes
    True
    """
    if ax is None:
        return plt.subplots(figsize=figsize)[1]
    instance("ax", ax, Axes, "plt.subplots()[1] is one")
    return ax


def literal(text: str) -> str:
    """Text as it is, such as a name, in which matplotlib must find no mathematics.

    Parameters
    ----------
    text : str
        Any text.

    Returns
    -------
    str

    Examples
    --------
    >>> print(literal("glass, $3 each"))
    glass, \\$3 each
    """
    return text.replace("$", r"\$")


def titled(axes: Axes, text: str) -> None:
    """Give axes a title, on as many lines as keep it inside the figure.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Axes to name.
    text : str
        The title; broken after commas and semicolons.

    Examples
    --------
    >>> axes = axes_in(None)
    >>> titled(axes, "steel-52100, R = 1.8625 .. 4.7625 mm, 31 beads, strikers, right wall, loss")
    >>> print(axes.get_title())
    steel-52100, R = 1.8625 .. 4.7625 mm, 31 beads, strikers,
    right wall, loss
    """
    inches = axes.get_window_extent().width / axes.figure.dpi
    whole = re.sub("(?<![,;]) ", "\u00a0", text)
    lines = textwrap.wrap(whole, max(20, int(inches / INCHES_PER_LETTER)), break_long_words=False)
    axes.set_title("\n".join(lines).replace("\u00a0", " "))


def time_axis(chain: Chain) -> tuple[float, str]:
    """Factor and label of times: microseconds for a chain in SI units.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    tuple of float and str

    Examples
    --------
    >>> time_axis(Chain.uniform(2))
    (1.0, 'time $t$')
    """
    return (1e6, "time [µs]") if chain.units == "SI" else (1.0, "time $t$")


def mark_horizon(axes: Axes, horizon: Horizon | None) -> None:
    """Shade the times beyond which a run cannot be predicted, and mark where they begin.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Axes with times along x.
    horizon : Horizon or None
        The horizon of the run, if it is known.

    Examples
    --------
    >>> axes = axes_in(None)
    >>> mark_horizon(axes, None)
    """
    if horizon is None or not np.isfinite(horizon.time):
        return
    factor = time_axis(horizon.chain)[0]
    begin, end = factor * horizon.time, factor * horizon.times[-1]
    axes.axvspan(begin, max(begin, end), color="0.5", alpha=0.25, linewidth=0.0)
    label = f"error above {100.0 * horizon.within:g}%"
    axes.axvline(begin, color="black", linestyle=":", linewidth=1.2, label=label)


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
