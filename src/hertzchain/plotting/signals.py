"""Draw signals with the curves that describe them, and residuals over the noise."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes

from ..collision import Array
from ..traces.signals import Signal
from .colours import COLOURS, grey
from .legends import POINTS_PER_INCH
from .shared_axes import use_prefix
from .style import literal, set_panel_title
from .widths import NARROW, figure_size

# Distance of samples [points] below which symbols would hide each other.
APART: Final = 1.2
# Widths of lines [points]: of crowded data, and of the curve in front of them.
BROAD, THIN = 2.4, 0.9
# Crowded data above this number per point of width are a band of noise, drawn by a thinner line.
CROWDED: Final = 10.0
# Residuals of crowded samples are so transparent that their density is visible.
SOLID, FAINTEST = 1500, 0.08
# Residuals per point of width from which their symbols are smaller.
CLOSE: Final = 3.0
# Fewest samples of a crest that is shown enlarged.
CREST: Final = 5
# Least half height of panels of residuals, the largest at which a band of twice the noise is wider
# than a line, both in standard deviations, and name of the band in the legend.
MIN_LIMIT, MAX_LIMIT = 4.0, 20.0
BAND: Final = "±2σ of the noise"
RESIDUAL: Final = "residual\n/ noise"
# Sensors up to which these are below each other, the widths [inches] of figures of one and of two
# columns, and the range of the height [inches] of one sensor.
ONE_COLUMN: Final = 4
WIDTHS: Final = (6.4, 9.6)
ROW_HEIGHTS: Final = (1.35, 1.9)


def sensor_grid(count: int) -> tuple[int, tuple[float, float]]:
    """Number of columns of panels for this number of sensors, and the size of the figure."""
    columns = 1 if count <= ONE_COLUMN or figure_size(WIDTHS[1], 1.0)[0] < NARROW else 2
    width = figure_size(WIDTHS[columns - 1], 1.0)[0]
    height = float(np.clip(0.4 * width / columns, *ROW_HEIGHTS))
    return columns, (width, 0.6 + height * -(-count // columns))


def draw_signal(axes: Axes, times: Array, signal: Signal, curve: Array, name: str) -> None:
    """Draw the samples of a signal, crosses at those that are not used, and a curve."""
    draw_data_and_curve(axes, times, np.where(signal.valid, signal.values, np.nan), curve, name)
    unused = ~signal.valid & np.isfinite(signal.values)
    axes.plot(times[unused], signal.values[unused], "x", color=grey(axes, 0.55), markersize=3.0)
    set_panel_title(axes, literal(signal.name))
    axes.margins(x=0.0)
    label_signal(axes, signal)


def label_signal(axes: Axes, signal: Signal) -> None:
    """Label the axis of a signal, with a prefix of its unit that suits the limits."""
    axes.set_ylabel(signal_label(signal))
    use_prefix(axes)


def signal_label(signal: Signal) -> str:
    """Quantity and unit of a signal; only calibrated ones are forces or velocities."""
    what = "force" if signal.place.quantity == "force" else "velocity"
    return f"{what if signal.calibrated else 'signal'} [{signal.unit}]"


def draw_data_and_curve(axes: Axes, times: Array, data: Array, curve: Array, name: str) -> None:
    """Draw a thin line in front of data that are wider, so that neither hides the other.

    Samples with enough room have symbols; others are joined by a broad, pale line.
    """
    per_point = len(times) / _points_across(axes)
    if per_point > 1.0 / APART:
        width = BROAD if per_point < CROWDED else THIN
        pale = grey(axes, 0.65)
        axes.plot(times, data, color=pale, linewidth=width, label="data", zorder=1.5)
        # No line joins samples between missing ones.
        there = np.pad(np.isfinite(data), 1)
        alone = there[1:-1] & ~there[:-2] & ~there[2:]
        if alone.any():
            axes.plot(times[alone], data[alone], "o", color=pale, markersize=BROAD,
                      markeredgewidth=0.0, zorder=1.5)  # fmt: skip
    else:
        axes.plot(times, data, "o", color=grey(axes, 0.4), markersize=3.0, markeredgewidth=0.0,
                  label="data", zorder=1.5)  # fmt: skip
    axes.plot(times, curve, color=COLOURS[2], linewidth=THIN, label=name, zorder=3.0)


def draw_residuals(axes: Axes, times: Array, residuals: Array, limit: float | None = None) -> None:
    """Draw residuals over the noise, with a band of two standard deviations if it is visible."""
    limit = residual_limit([residuals]) if limit is None else limit
    if limit <= MAX_LIMIT:
        axes.axhspan(-2.0, 2.0, color=grey(axes, 0.87), linewidth=0.0, label=BAND)
    axes.axhline(0.0, color=grey(axes), linewidth=0.6)
    seen = int(np.isfinite(residuals).sum())
    axes.plot(times, residuals, ".", color=grey(axes, 0.25), markeredgewidth=0.0,
              markersize=1.3 if seen > CLOSE * _points_across(axes) else 2.0,
              alpha=float(np.clip(SOLID / max(seen, 1), FAINTEST, 1.0)), rasterized=seen > SOLID,
              zorder=3.0)  # fmt: skip
    axes.set_ylabel(RESIDUAL)
    axes.set_ylim(-limit, limit)
    # More than three ticks do not fit a low panel.
    power = 10.0 ** np.floor(np.log10(limit))
    tick = power * max(digit for digit in (1.0, 2.0, 4.0, 5.0, 8.0) if digit * power <= limit)
    axes.set_yticks([-tick, 0.0, tick])
    axes.margins(x=0.0)


def residual_limit(residuals: list[Array]) -> float:
    """Limit of the axes of residuals, which has room for all of them."""
    largest = [float(np.nanmax(np.abs(each), initial=0.0)) for each in residuals]
    return 1.1 * max(MIN_LIMIT, *largest)


def _points_across(axes: Axes) -> float:
    """Width of axes [points]; that of a grid, since layouts change the others between two plots."""
    figure, grid = axes.get_figure(root=True), axes.get_subplotspec()
    assert figure is not None
    box = axes.get_position() if grid is None else grid.get_position(figure)
    return POINTS_PER_INCH * box.width * figure.get_figwidth()


def draw_crest(axes: Axes, times: Array, signal: Signal, curve: Array, name: str) -> None:
    """Draw the crest of the signal, enlarged."""
    sign = np.sign(curve[np.argmax(np.abs(curve - curve[0]))] - curve[0])
    values = np.where(signal.valid, sign * signal.values, -np.inf)
    begin, end = _crest(values, sign * curve)
    if end == len(times) - 1 and begin > 1:
        # The record ends before this wave has passed: show the one before it.
        begin, end = _crest(values[:begin], sign * curve[:begin])
    if end - begin < CREST:
        # In two lines, the words fit a panel of a narrow figure.
        axes.text(0.5, 0.5, "too few\nsamples", ha="center", va="center", transform=axes.transAxes)
        axes.set_xticks([])
        axes.set_yticks([])
        return
    shown = slice(begin, end + 1)
    data = np.where(signal.valid, signal.values, np.nan)[shown]
    draw_data_and_curve(axes, times[shown], data, curve[shown], name)
    narrow = axes.get_figure(root=True).get_figwidth() < NARROW  # type: ignore[union-attr]
    axes.locator_params(axis="x", nbins=1 if narrow else 3, min_n_ticks=2)
    if narrow:
        # Numbers of three digits would touch each other.
        left, right = axes.get_xlim()
        inside = [each for each in axes.get_xticks() if left <= each <= right]
        axes.set_xticks([*inside[:1], *inside[1:][-1:]])
        axes.set_xlim(left, right)
    axes.locator_params(axis="y", nbins=3, min_n_ticks=2)


def _crest(values: Any, curve: Any) -> tuple[int, int]:
    """Indices of both ends of the crest around the largest value."""
    crest = int(np.argmax(values))
    high = np.abs(curve - curve[0]) > 0.7 * abs(curve[crest] - curve[0])
    begin, end = crest, crest
    while begin > 0 and high[begin - 1]:
        begin -= 1
    while end < len(curve) - 1 and high[end + 1]:
        end += 1
    return begin, end
