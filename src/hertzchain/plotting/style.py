"""Figure style: colours, markers, and reproducible files."""

from __future__ import annotations

import io
import logging
import re
import textwrap
import weakref
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from importlib import resources
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, ScalarFormatter

from ..chain.chain import Chain
from ..chain.yield_pressure import DEFINED, YIELD_ASSUMED, YIELD_STATED
from ..errors import InputError
from ..validation.keywords import checked_arguments
from ..validation.objects import check_list, check_type
from .colours import COLOURS, grey, style_is_dark
from .log_labels import PLAIN, OneNotation
from .widths import figure_size, journal_settings, journal_width, styled, width_in_inches

if TYPE_CHECKING:
    from ..simulation.horizon import Horizon

# Markers distinguish curves in prints in grey.
MARKERS: Final = ("o", "+", "x", "s", "^", "v", "D", "<", ">", "1")
# The letter of micro in units of times, lengths and impulses.
MICRO: Final = re.compile(r"\bu(?=(?:s|m|N s|J|N|V)\b)")

# Symbols of the rates of tapers in descriptions of chains.
RATE: Final = re.compile(r"(?<![\w$])([qS])(?=\s=\s-?[\d.])")

# Dates in the fonts of Matplotlib, which are before 1970, would be reported with each PDF file.
logging.getLogger("fontTools.ttLib.tables._h_e_a_d").setLevel(logging.ERROR)

# Average for a title.
INCHES_PER_LETTER: Final = 0.07

# Ratio of the limits of a logarithmic axis up to which it has plain numbers, and digits of the
# numbers for smaller ratios.
MAX_PLAIN: Final = 100.0
LOG_DIGITS: Final = (
    (3.0, (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)),
    (6.0, (1.0, 2.0, 3.0, 5.0, 7.0)),
    (MAX_PLAIN, (1.0, 2.0, 5.0)),
)
# Height of a figure of two panels in a journal relative to one panel, and least size of letters.
TALLER, MIN_LABEL = 1.25, 5.5
# Ratio of the limits of a logarithmic axis from which a low panel is higher, and its height
# relative to the panel above.
MANY_DECADES, HIGHER = 1e5, 0.7
# Times [s] above which they are in ms, and ratio above which curves need axes of their own.
LONG, MUCH = 2e-3, 5.0
# Factors of the labels of time axes in SI units.
TIME_LABELS: Final = MappingProxyType({"time [µs]": 1e6, "time [ms]": 1e3})

# Titles that `set_title` has set; others are those of a user.
_titles: weakref.WeakKeyDictionary[Axes, str] = weakref.WeakKeyDictionary()


@checked_arguments("figure_style")
def figure_style(width: str | float | None = None) -> AbstractContextManager[None]:
    """Apply hertzchain's Matplotlib style to the figures created inside a ``with`` block.

    With a width, figures have this width, text of 7 or 8 points, and no titles that describe the
    chain, because a caption does; names of sensors above panels and titles that you set remain.
    Print them without scaling.  Plotting functions of hertzchain that are called
    inside the block keep these settings, and those that you change inside it with
    ``plt.rc_context`` or ``plt.rcParams``.

    Parameters
    ----------
    width : str or float, optional
        ``"single column"`` (86 mm), ``"double column"`` (178 mm), a length such as ``"120 mm"``,
        or a number of inches from 1 to 20.  By default, figures are 5.4 inches wide.

    Raises
    ------
    InputError
        If the width is not a length, or outside this range.

    Examples
    --------
    >>> import hertzchain as hc
    >>> with hc.figure_style("single column"):
    ...     axes = hc.propagate(hc.Chain.uniform(20)).plot()
    >>> (25.4 * axes.figure.get_size_inches()).round(1)
    array([86. , 61.9])
    """
    # The width is checked here, not only when the block begins.
    return _styled(None if width is None else width_in_inches(width))


@contextmanager
def _styled(inches: float | None) -> Iterator[None]:
    """Apply the style with this width, or with that of an outer block."""
    if inches is None and styled.get():
        yield
        return
    style = resources.files("hertzchain").joinpath("figures.mplstyle")
    inches = journal_width.get() if inches is None else inches
    settings = {} if inches is None else journal_settings(inches)
    if style_is_dark():
        settings["axes.prop_cycle"] = cycler("color", [*COLOURS[1:], "#FFFFFF"])
    outer, unstyled = journal_width.set(inches), styled.set(True)
    try:
        with (
            resources.as_file(style) as path,
            plt.style.context(path),
            plt.rc_context(settings),  # type: ignore[arg-type]
        ):
            yield
    finally:
        journal_width.reset(outer)
        styled.reset(unstyled)


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """A figure as the content of a file; two runs return the same bytes."""
    undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    content = io.BytesIO()
    with figure_style():
        figure.savefig(content, format=kind, metadata=undated)
    return content.getvalue()


def svg_and_png(figure: Figure) -> tuple[bytes, bytes]:
    """A figure as SVG and PNG, which share a layout: each is drawn once.

    `Figure.savefig` lays a figure out for each file, and draws it twice for that.
    """
    svg, png = io.BytesIO(), io.BytesIO()
    with figure_style():
        dpi = plt.rcParams["savefig.dpi"]
        figure.set_dpi(dpi)
        FigureCanvasSVG(figure).print_svg(svg, metadata={"Date": None})  # type: ignore[no-untyped-call]
        figure.set_layout_engine("none")
        figure.set_dpi(dpi)
        FigureCanvasAgg(figure).print_png(png)  # type: ignore[no-untyped-call]
    return svg.getvalue(), png.getvalue()


def get_axes(ax: Axes | None, figsize: tuple[float, float] | None = None) -> Axes:
    """Return the given axes, or those of a new figure."""
    if ax is None:
        return plt.subplots(figsize=None if figsize is None else figure_size(*figsize))[1]
    check_type("ax", ax, Axes, "plt.subplots()[1] is one")
    return ax


def get_two_axes(ax: object) -> tuple[Axes, Axes]:
    """A pair of axes, or those of a new figure: for curves and, below, for their residuals."""
    if ax is None:
        upper, lower = _two_panels()
    else:
        pair = [] if isinstance(ax, Axes) else check_list("ax", ax, "two axes")
        if len(pair) != 2:
            raise InputError(
                "with residuals, ax must be a pair of axes, such as plt.subplots(2, sharex=True)[1]"
            )
        upper, lower = map(get_axes, pair)
    upper.tick_params(labelbottom=False)
    upper.figure.align_ylabels([upper, lower])
    return upper, lower


def _two_panels() -> tuple[Axes, Axes]:
    """A panel above a low one; in a journal, this is higher, so that its label fits beside it."""
    if journal_width.get() is None:
        upper, lower = plt.subplots(2, sharex=True, height_ratios=(3, 1.2))[1]
        return upper, lower
    width, height = plt.rcParams["figure.figsize"]
    upper, lower = plt.subplots(
        2, sharex=True, height_ratios=(3, 1.7), figsize=(width, TALLER * height)
    )[1]
    return upper, lower


def heighten_panel(upper: Axes, lower: Axes) -> None:
    """Make the low one of two panels higher if its logarithmic axis has many decades."""
    low, high = lower.get_ylim()
    spec = lower.get_subplotspec()
    if lower.get_yscale() != "log" or high < MANY_DECADES * low or spec is None:
        return
    figure = lower.figure if isinstance(lower.figure, Figure) else lower.figure.figure
    figure.draw_without_rendering()
    added = HIGHER * upper.bbox.height - lower.bbox.height
    spec.get_gridspec().set_height_ratios((1.0, HIGHER))
    figure.set_figheight(figure.get_figheight() + added / figure.dpi)


def show_three_ticks(axes: Axes) -> None:
    """Have at least three ticks on the linear y axis of a low panel."""
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10], min_n_ticks=3))


def shrink_to_height(axes: Axes) -> None:
    """Make the letters of the label of the y axis smaller if it is longer than the axis."""
    figure = axes.figure if isinstance(axes.figure, Figure) else axes.figure.figure
    figure.draw_without_rendering()
    label = axes.yaxis.label
    # Letters of another size are rounded to pixels.
    share = 0.93 * axes.bbox.height / label.get_window_extent().height
    if share < 1.0:
        label.set_fontsize(max(share * float(label.get_fontsize()), MIN_LABEL))


def literal(text: str) -> str:
    """Escape a text, such as a name, that Matplotlib would read as mathematics.

    The symbols of the rates of tapers, as in ``q = 0.03``, are in italics, as on axes.
    """
    return RATE.sub(r"$\1$", text.replace("$", r"\$"))


def set_title(axes: Axes, text: str, *, common: bool = False) -> None:
    """Set a title, broken into lines that fit inside the figure; none at the width of a journal.

    A title of a user remains; that of a second chain in the same axes removes the first one unless
    it is ``common`` to both.
    """
    present = axes.get_title()
    if journal_width.get() is not None:
        # Only the assumption remains.
        text = YIELD_STATED if YIELD_ASSUMED in text else ""
    if present not in ("", _titles.get(axes)):
        return
    # Labels that are drawn later make the axes narrower.
    title = broken_title(text, int(0.92 * _letters_along(axes, "width")))
    # The second chain is drawn into axes with the title of the first, or with neither.
    if axes in _titles and _titles[axes] == present != title and not common:
        title = ""
    _titles[axes] = title
    axes.set_title(title)


def broken_title(text: str, letters: int) -> str:
    """A title in lines of so many letters, which end at commas and semicolons where possible.

    A semicolon at the end of a line is omitted.
    """
    if "\n" in text:
        return "\n".join(broken_title(line, letters) for line in text.split("\n"))
    wrapper = textwrap.TextWrapper(letters, break_long_words=False, break_on_hyphens=False)
    whole = text.replace(DEFINED, DEFINED.replace(" ", "\u00a0"))
    parts = wrapper.wrap(re.sub("(?<![,;]) ", "\u00a0", whole))
    lines = "\n".join(wrapper.fill(part.replace("\u00a0", " ")) for part in parts)
    return lines.replace(";\n", "\n")


def with_line(axes: Axes, text: str) -> Axes:
    """Add a line to the title of axes."""
    lines = [line for line in (axes.get_title(), text) if line]
    axes.set_title("\n".join(lines))
    return axes


def set_figure_title(figure: Figure, text: str) -> None:
    """Set a title of a whole figure, broken into lines that fit inside it."""
    letters = int(0.92 * figure.get_figwidth() / INCHES_PER_LETTER)
    figure.suptitle(literal(broken_title(text, letters)), fontsize="medium")


def set_panel_title(axes: Axes, text: str, **settings: Any) -> None:
    """Set a title that remains at the width of a journal, broken into lines that fit above axes."""
    axes.set_title(broken_title(text, _letters_along(axes, "width")), **settings)


def broken_label(axes: Axes, side: Literal["width", "height"], label: str) -> str:
    """A label along a side of axes, broken into lines that are not longer than it."""
    # No line begins with a unit.
    whole = re.sub(r" (?=\[[^]]*\]$)", "\u00a0", label)
    lines = textwrap.wrap(whole, _letters_along(axes, side), break_long_words=False)
    return "\n".join(lines).replace("\u00a0", " ")


def _letters_along(axes: Axes, side: Literal["width", "height"]) -> int:
    inches = getattr(axes.get_window_extent(), side) / axes.figure.dpi
    return max(20, int(inches / INCHES_PER_LETTER))


class BeadLocator(MaxNLocator):
    """Ticks at whole numbers from a first one, without bead 0."""

    def __init__(self, first: int = 1) -> None:
        # One of three ticks may be at 0.
        super().__init__("auto", integer=True, steps=[1, 2, 5, 10], min_n_ticks=3)
        self._first = first

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """Ticks between two numbers."""
        ticks = np.asarray(super().tick_values(vmin, vmax))
        # An axis with one or two beads would otherwise have halves, to have three ticks.
        return ticks[(ticks >= self._first) & (ticks == np.round(ticks))]


def time_axis(chain: Chain, longest: float) -> tuple[float, str]:
    """Factor and label of a time axis: in SI units microseconds or, for long times, ms."""
    return seconds_axis(longest) if chain.units == "SI" else (1.0, "time $t$")


def seconds_axis(longest: float) -> tuple[float, str]:
    """The same for times in seconds, such as those of measured data."""
    return (1e3, "time [ms]") if longest > LONG else (1e6, "time [µs]")


def signed(value: float, digits: str = "g") -> str:
    """A number as text, with a minus sign instead of a hyphen."""
    return f"{value:{digits}}".replace("-", "\N{MINUS SIGN}")


def with_micro(text: str) -> str:
    """Text whose units have the micro sign and raised exponents, such as µs for us and m/s²."""
    return MICRO.sub("µ", text).replace("/s^2", "/s²")


def label_log_axis(axis: Axis, factor: float = 1.0) -> None:
    """Label an axis by plain numbers, such as 0.2, 0.5 and 1, or 0.1, 1 and 10 for more decades.

    If one of them is much smaller or larger, all of them have powers of ten.  Labels are values
    times a factor, such as that of a prefix of the unit.
    """
    low, high = sorted(map(float, axis.get_view_interval()))
    if low <= 0.0:
        return
    if high < MAX_PLAIN * low:
        digits = next(each for ratio, each in LOG_DIGITS if high < ratio * low)
        axis.set_major_locator(LogLocator(subs=digits))
        axis.set_minor_locator(NullLocator())
    plain = factor * low > PLAIN[0] and factor * high < PLAIN[1]
    if high < MAX_PLAIN * low or plain or factor != 1.0:
        axis.set_major_formatter(OneNotation(factor))


def label_narrow_axis(axes: Axes) -> None:
    """Label the x axis with whole values, not with differences from a number at its end."""
    formatter = ScalarFormatter(useOffset=False)
    axes.xaxis.set_major_formatter(formatter)
    letters = max(map(len, formatter.format_ticks(axes.get_xticks().tolist())))
    inches = axes.get_window_extent().width / axes.figure.dpi
    room = int(inches / (INCHES_PER_LETTER * (letters + 1)))
    axes.xaxis.set_major_locator(MaxNLocator(max(2, min(9, room)), steps=[1, 2, 2.5, 5, 10]))


def mark_horizon(axes: Axes, horizon: Horizon | None, factor: float) -> None:
    """Mark the horizon of a run, and shade the times beyond it."""
    if horizon is None or not np.isfinite(horizon.time):
        return
    begin, end = factor * horizon.time, factor * horizon.times[-1]
    axes.axvspan(begin, max(begin, end), color="0.5", alpha=0.25, linewidth=0.0)
    label = f"horizon: error {100.0 * horizon.within:g}%"
    axes.axvline(begin, color=grey(axes), linestyle=":", linewidth=1.2, label=label)


def label_right_ends(axes: Axes, labels: Sequence[tuple[float, float, str, str]]) -> None:
    """Label curves at their right ends, moved apart where labels would overlap."""
    to_axes = axes.transData + axes.transAxes.inverted()
    ends = [(*to_axes.transform((x, y)), text, colour) for x, y, text, colour in labels]
    ends.sort(key=lambda end: end[1])
    spacing = 0.052
    heights = np.array([end[1] for end in ends])
    # Push labels upwards, then lower all by the mean shift, to keep them near the curves.
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
