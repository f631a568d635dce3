"""Curves of forces: their labels, the styles of several runs, and their ends."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ..chain.chain import Chain
from ..collision import Array
from ..representation import in_column
from ..simulation.body_force import MAY_FOLLOW
from .colours import grey
from .differences import words_of_chains
from .labels import distinguish
from .legends import figure_of
from .style import literal
from .widths import NARROW, journal_width

# Added to the labels of forces in sensors that are 0, or smaller than this part of the largest
# one, and of forces that are largest at the end.
NOT_REACHED: Final = "not reached"
STILL_RISING: Final = "still rising"
NOTHING: Final = 1e-6
THOUSAND: Final = 999.5
# A run that ends before this part of the time axis states its end in the legend; others end with
# the axis.
SHORT_RUN: Final = 0.9
# Widths and opacities of the curves of two runs in the same axes: a thin curve is in front of a
# broad, pale one, so that runs that almost coincide do not hide each other.
RUN_LINES: Final = ((2.8, 0.5), (1.3, 1.0))
# Width of the curves of more runs.
EQUAL_WIDTH: Final = 0.9
# Maxima, in a range of this part of the largest force, from which a broad curve is a band, in which
# no oscillation is visible; both curves then have the equal width.
MANY_MAXIMA, RIPPLE = 10, 0.03
# Common part of the smaller of two areas below curves, from which one curve may hide the other.
COMMON: Final = 0.1
# Largest difference, relative to the peak, of a curve that another one covers.
HIDDEN: Final = 5e-3
# Part of the times at which it does.
MOST: Final = 0.8
# Words that distinguish curves with one label.
MEASURED, SIMULATED = "measured", "simulated"


class ForceLine(Line2D):
    """A simulated force with the number of its run.

    Labels of users, ``named``, remain; others state the end of a short run and an incomplete peak,
    except in a figure for a journal.  A run without a name has its chain, by whose properties
    several of them are distinguished.
    """

    def __init__(
        self, x: Array, y: Array, run: int, words: str, *, cut_off: bool, named: bool,
        chain: Chain | None = None, static: float = 0.0, **style: Any,
    ) -> None:  # fmt: skip
        analysed = cut_off and journal_width.get() is None
        if analysed:
            style.update(marker="o", markevery=[-1], markerfacecolor="none", clip_on=False)
        super().__init__(x, y, **style)
        self.run, self.words, self.named, self.analysed = run, words, named, analysed
        self.chain, self.static = chain, static


class MeasuredLine(Line2D):
    """A measured signal and its label without further words."""

    def __init__(self, x: Array, y: Array, words: str, **style: Any) -> None:
        super().__init__(x, y, label=words, **style)
        self.words = words


def force_lines(axes: Axes) -> list[ForceLine]:
    """The simulated forces in axes."""
    return [line for line in axes.lines if isinstance(line, ForceLine)]


def label_sources(axes: Axes) -> None:
    """State which curves are measured and which are simulated, if axes have both."""
    simulated = force_lines(axes)
    measured = [line for line in axes.lines if isinstance(line, MeasuredLine)]
    if simulated and measured:
        for line in measured:
            line.set_label(f"{line.words}, {MEASURED}")
        for each in simulated:
            if not each.named:
                each.set_label(f"{each.get_label()}, {SIMULATED}")


def label_and_style(axes: Axes, *, compared: bool) -> None:
    """Label the forces in axes and the ends of shorter runs; distinguish runs."""
    lines = force_lines(axes)
    _, _, unit = axes.get_xlabel().rstrip("]").partition("[")
    longest = max(_end(line) for line in lines)
    labels = _labels(lines)[0]
    largest = max(float(np.max(line.get_ydata())) for line in lines)
    for line in lines:
        line.set_label(line.words)
        if line.named:
            continue
        remarks = [MAY_FOLLOW] if line.analysed else _unfinished(line, largest)
        if _end(line) < SHORT_RUN * longest and journal_width.get() is None:
            end = f"{_end(line):.4g}"
            remarks.append(f"run ends at {end} {unit}" if unit else f"run ends at $t$ = {end}")
        words = labels.get(line, line.words)
        line.set_label(f"{words} ({', '.join(remarks)})" if remarks else words)
    _label_circles(axes, lines)
    label_sources(axes)
    runs = {line.run for line in lines}
    if compared or len(runs) > 1:
        # In a narrow figure, wide lines would cover oscillations.
        narrower = min(1.0, figure_of(axes).get_figwidth() / NARROW)
        equal = max(runs) >= len(RUN_LINES) or any(map(oscillates, lines))
        equal |= not compared and not any(itertools.starmap(_overlap, _of_two_runs(lines)))
        for line in lines:
            width, opacity = (EQUAL_WIDTH, 1.0) if equal else RUN_LINES[line.run]
            line.set(linestyle="-", linewidth=narrower * width, alpha=opacity)
    _end_together(axes, lines)


def same_style(axes: Axes, other: Axes) -> None:
    """Draw the forces in axes with the widths and opacities of the same runs in other axes."""
    styles = {line.run: (line.get_linewidth(), line.get_alpha()) for line in force_lines(other)}
    for line in force_lines(axes):
        width, opacity = styles[line.run]
        line.set(linewidth=width, alpha=opacity)


def raise_hidden(lines: Sequence[ForceLine]) -> None:
    """Draw a curve of a run that a later one covers as dashes on top of it."""
    for one, other in itertools.combinations(lines, 2):
        (x, first), (x_other, second) = (
            np.asarray(line.get_data(), dtype=float) for line in (one, other)
        )
        # Short oscillations after the pulse may differ.
        difference = np.quantile(np.abs(np.interp(x, x_other, second) - first), MOST)
        if one.run == other.run and difference < HIDDEN * first.max(initial=0.0):
            one.set(linestyle=(0.0, (3.0, 3.0)), zorder=other.get_zorder() + 0.1)


def _unfinished(line: ForceLine, largest: float) -> list[str]:
    """A remark on a sensor that the pulse has not reached or passed when the run ends."""
    force = np.asarray(line.get_ydata(), dtype=float)
    if journal_width.get() is not None or not largest > 0.0:
        return []
    if force.max() < NOTHING * largest:
        return [NOT_REACHED]
    return [STILL_RISING] if force.argmax() == len(force) - 1 else []


def _labels(lines: Sequence[ForceLine]) -> tuple[dict[ForceLine, str], str]:
    """Labels of several runs without names by the properties in which they differ, and a title.

    As in figures of pulses, the title has the common properties, and the place if it is common.
    """
    own = [line for line in lines if not line.named and line.chain is not None]
    chains = {line.run: line.chain for line in own if line.chain is not None}
    if len(chains) < 2:
        return {}, ""
    described = words_of_chains([*chains.values()])
    names, common = distinguish([["", *each] for each in described])
    shared = [part for part in common.split(", ") if part]
    of_run = dict(zip(chains, map(literal, names), strict=True))
    places = {line.words for line in own}
    apart = len(places) > 1 or len(own) < len(lines) or not all(of_run.values())
    labels = {
        line: ", ".join(filter(None, (line.words if apart else "", of_run[line.run])))
        for line in own
    }
    if apart:
        # Curves of one chain have its own title.
        return labels, ", ".join(shared) if any(of_run.values()) else ""
    (place,) = places
    joined = "on the" if place.endswith("wall") else "in"
    parts = [f"force {joined} {place}", *(part for part in shared if part != place)]
    return labels, ", ".join(parts)


def common_title(axes: Axes) -> str:
    """The title of the forces of several runs without names; empty for other forces."""
    return literal(_labels(force_lines(axes))[1])


def oscillates(line: ForceLine) -> bool:
    """Whether a force has many maxima."""
    from scipy.signal import find_peaks

    force = np.asarray(line.get_ydata(), dtype=float)
    return len(find_peaks(force, prominence=RIPPLE * force.max())[0]) >= MANY_MAXIMA


def _of_two_runs(lines: list[ForceLine]) -> Iterator[tuple[ForceLine, ForceLine]]:
    pairs = itertools.combinations(lines, 2)
    return ((one, other) for one, other in pairs if one.run != other.run)


def _overlap(one: ForceLine, other: ForceLine) -> bool:
    """Whether a considerable part of the areas below two forces is common to both."""
    (x, first), (x_other, second) = (
        np.asarray(line.get_data(), dtype=float) for line in (one, other)
    )
    shared = np.minimum(first, np.interp(x, x_other, second, left=0.0, right=0.0))
    areas = [np.trapezoid(first, x), np.trapezoid(second, x_other)]
    return bool(np.trapezoid(shared, x) > COMMON * min(areas))


def with_peaks(axes: Axes, units: str) -> None:
    """Add the largest plotted value of each complete force to its label."""
    lines = [line for line in force_lines(axes) if not (line.named or line.analysed)]
    values = [float(np.max(line.get_ydata())) for line in lines]
    # Thousands are written without an exponent, as in tables.
    peaks = in_column(values, 4 if max(values, default=0.0) >= THOUSAND else 3)
    for line, peak in zip(lines, peaks, strict=True):
        text = f"{float(peak):g}" if "e+0" in peak else peak
        shown = f": {text}{' N' if units == 'SI' else ''}"
        line.set_label(line.words + shown + str(line.get_label()).removeprefix(line.words))


def _label_circles(axes: Axes, lines: list[ForceLine]) -> None:
    """Explain circles at the ends of curves whose labels, which are those of a user, do not."""
    for line in [*axes.lines]:
        if line.get_label() == MAY_FOLLOW:
            line.remove()
    if any(line.named and line.analysed for line in lines):
        axes.plot([], [], "o", color=grey(axes, 0.4), markerfacecolor="none", label=MAY_FOLLOW)


def _end_together(axes: Axes, lines: list[ForceLine]) -> None:
    """End the time axis where the first of several runs of almost the same length does.

    The last rise of a force would look like a drop to nothing inside the axes.
    """
    ends = [_end(line) for line in lines]
    end = min(each for each in ends if each >= SHORT_RUN * max(ends))
    crests = [float(line.get_xdata()[np.argmax(line.get_ydata())]) for line in lines]  # type: ignore[index,arg-type]
    if end < max(ends) and max(crests) <= end and axes.get_autoscalex_on():
        axes.autoscale_view()
        axes.set_xlim(right=end, auto=True)


def _end(line: ForceLine) -> float:
    return float(np.max(line.get_xdata()))
