"""Plot measured traces, fits, residuals, correlations and posteriors."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..fitting.shown_values import factor_and_unit
from ..representation import shown_signal
from ..traces.noise import autocorrelation
from ..validation.numbers import whole_number
from ..validation.objects import check_bool, check_choice
from .colours import COLOURS, curve_colour, grey
from .force_lines import MeasuredLine, label_sources
from .legends import POINTS_PER_INCH, legend_above, place_legend
from .looks import LINES
from .parameter_labels import parameter_in_words
from .shared_axes import same_prefix, use_prefix
from .signals import (
    draw_crest,
    draw_residuals,
    draw_signal,
    residual_limit,
    sensor_grid,
    signal_label,
)
from .style import (
    MARKERS,
    TIME_LABELS,
    figure_style,
    get_axes,
    get_two_axes,
    literal,
    seconds_axis,
    set_panel_title,
    signed,
    with_micro,
)
from .widths import NARROW, figure_size, journal_width

if TYPE_CHECKING:
    from ..fitting.posterior import Posterior
    from ..fitting.result import FitResult
    from ..fitting.trace_comparison import TraceComparison
    from ..traces.traces import Traces

# Samples of a posterior that are drawn as points.
POINTS: Final = 4000
# Names in legends, the same in all figures.
DATA, SIMULATION, FIT = "data", "simulation", "fit"
# Smallest font of numbers in a map, the most letters of one, and the width of a letter relative to
# the size of the font; the correlation that would be rounded to 1.
MIN_NUMBER, MAX_LETTERS, CHARACTER = 4.5, 6, 0.6
ALMOST_ONE: Final = 0.995
# Smallest font of a corner plot, and largest number of characters of a name in one line.
SMALLEST, LONG_NAME = 6.5, 16
# Number of parameters from which on a legend has room in the empty corner of a corner plot; height
# of its remark on too few steps [inches], and the most characters of a line of it.
CORNER, CAUTION_HEIGHT, CAUTION_LINE = 3, 0.6, 34
# Powers of ten of values that are shown without a factor in the unit.
MIN_POWER, MAX_POWER = -3, 4
# Width of a panel [inches] from which its title has room.
MIN_PANEL: Final = 1.2


def plot_traces(traces: Traces, *, legend: bool = True, ax: Axes | None = None) -> Axes:
    """Plot measured signals over time; relative to their largest values if units differ."""
    legend = check_bool("legend", legend)
    with figure_style():
        axes = get_axes(ax)
        factor, label = _time_axis(traces)
        if axes.get_xlabel() in TIME_LABELS:
            factor, label = TIME_LABELS[axes.get_xlabel()], axes.get_xlabel()
        # In axes that have other curves, signals keep their units.
        several = len({signal.unit for _, signal in traces}) > 1
        relative = ax is None and several
        # Curves that the axes already have, such as simulated ones, have the first colours.
        for i, (index, signal) in enumerate(traces, len(axes.get_legend_handles_labels()[1])):
            times, values = factor * traces.shots[index].times, signal.values
            name = signal.name + (f", shot {index + 1}" if len(traces.shots) > 1 else "")
            if relative:
                largest = float(np.nanmax(np.abs(values)))
                values, name = values / largest, f"{name}: {shown_signal(largest, signal.unit)}"
            colour = curve_colour(axes, i)
            measured = np.where(signal.valid, values, np.nan)
            # A symbol at the largest value, because colours alone do not distinguish curves.
            crest = [int(np.nanargmax(np.abs(measured)))] if signal.valid.any() else []
            axes.add_line(MeasuredLine(
                times, measured, name, color=colour, marker=MARKERS[i % len(MARKERS)],
                markevery=crest, markerfacecolor="none",
            ))  # fmt: skip
            unused = ~signal.valid & np.isfinite(values)
            axes.plot(times[unused], values[unused], "x", color=colour)
        axes.set_xlabel(label)
        own = " or ".join(dict.fromkeys(signal_label(signal) for _, signal in traces))
        axes.set_ylabel("signal / largest value" if relative else own)
        axes.autoscale_view()
        if not several:
            use_prefix(axes)
        axes.margins(x=0.0)
        label_sources(axes)
        if legend:
            place_legend(axes, own=ax is None)
    return axes


def _time_axis(traces: Traces) -> tuple[float, str]:
    """Factor and label of the time axes of all shots."""
    return seconds_axis(max(float(np.ptp(shot.times)) for shot in traces.shots))


def plot_fit(result: FitResult) -> Figure:
    """Plot data, fit, residuals over noise and, enlarged, the crest of every sensor."""
    shots = result.traces.shots
    sensors = [(index, place) for index, shot in enumerate(shots)
               for place in range(len(shot.signals))]  # fmt: skip
    residuals = [values for *_, values in result.residuals()]
    limit = residual_limit(residuals)
    columns, size = sensor_grid(len(sensors))
    rows = -(-len(sensors) // columns)
    factor, label = _time_axis(result.traces)
    with figure_style():
        figure = plt.figure(figsize=size, layout="constrained")
        grid = figure.add_gridspec(2 * rows, 2 * columns, height_ratios=(2.2, 1.0) * rows,
                                   width_ratios=(2.4, 1.0) * columns)  # fmt: skip
        for i, (index, place) in enumerate(sensors):
            # Column by column, which shows the signals of a shot below each other.
            row, column = 2 * (i % rows), 2 * (i // rows)
            upper = figure.add_subplot(grid[row, column])
            lower = figure.add_subplot(grid[row + 1, column], sharex=upper)
            crest = figure.add_subplot(grid[row : row + 2, column + 1])
            signal, fitted = shots[index].signals[place], result.predicted[index][place]
            times = factor * shots[index].times
            draw_signal(upper, times, signal, fitted, FIT)
            draw_residuals(lower, times, residuals[i], limit)
            draw_crest(crest, times, signal, fitted, FIT)
            same_prefix(crest, upper)
            upper.tick_params(labelbottom=False)
            figure.align_ylabels([upper, lower])
            if len(shots) > 1:
                set_panel_title(upper, f"{literal(signal.name)}, shot {index + 1}")
            crest.set_title("crest")
            if row == 2 * rows - 2 or i == len(sensors) - 1:
                lower.set_xlabel(label)
                crest.set_xlabel(label)
        legend_above(figure, figure.axes[0], figure.axes[1])
    return figure


def plot_fitted_sensor(
    result: FitResult, sensor: str, *, shot: int = 1, legend: bool = True,
    ax: Axes | Sequence[Axes] | None = None,
) -> Axes:  # fmt: skip
    """Plot data and fit of one sensor and, unless one axes are given, its residuals over noise."""
    shots = result.traces.shots
    index = whole_number("shot", shot, least=1, most=len(shots)) - 1
    names = [signal.name for signal in shots[index].signals]
    place = names.index(check_choice("sensor", sensor, names))
    factor, label = _time_axis(result.traces)
    times = factor * shots[index].times
    with figure_style():
        upper, lower = (ax, ax) if isinstance(ax, Axes) else get_two_axes(ax)
        draw_signal(upper, times, shots[index].signals[place], result.predicted[index][place], FIT)
        if lower is not upper:
            values = next(
                each for number, name, each in result.residuals()
                if (number, name) == (index + 1, sensor)
            )  # fmt: skip
            draw_residuals(lower, times, values)
            lower.set_xlim(upper.get_xlim())
        lower.set_xlabel(label)
        if check_bool("legend", legend):
            place_legend(upper, own=ax is None)
    return upper


def plot_fit_residuals(result: FitResult) -> Figure:
    """Plot the distribution and the autocorrelation of the residuals of a fit."""
    width, height = figure_size(8.5, 3.4)
    narrow = width < NARROW
    with figure_style():
        figure, (left, right) = plt.subplots(
            *((2, 1) if narrow else (1, 2)), figsize=(width, height * (1.0 + narrow)),
            layout="constrained",
        )  # fmt: skip
        steps = [signal.step / signal.sigma for _, signal in result.traces]
        for i, (shot, name, values) in enumerate(result.residuals()):
            seen = values[np.isfinite(values)]
            label = name + (f", shot {shot}" if len(result.traces.shots) > 1 else "")
            look = {"color": curve_colour(left, i), "linestyle": LINES[i % len(LINES)]}
            left.hist(np.clip(seen, -5.0, 5.0), residual_bins(steps[i]), density=True,
                      histtype="step", **look)  # fmt: skip
            rho = autocorrelation(seen)[:41]
            right.plot(np.arange(1, len(rho)), rho[1:], **look, linewidth=1.0, label=label,
                       marker=MARKERS[i % len(MARKERS)], markersize=3.0)  # fmt: skip
        grid = np.linspace(-5.0, 5.0, 201)
        left.plot(grid, np.exp(-0.5 * grid**2) / np.sqrt(2.0 * np.pi), color=grey(left, 0.75),
                  linewidth=3.0, zorder=1.0, label="normal distribution")  # fmt: skip
        # The first and the last bin also count the values beyond them.
        left.set_xticks([-5.0, -2.5, 0.0, 2.5, 5.0], ["≤ −5", "−2.5", "0", "2.5", "≥ 5"])
        left.set_xlim(-5.5, 5.5)
        left.set_xlabel("residual / noise")
        left.set_ylabel("density")
        bound = 2.0 / np.sqrt(result.goodness.samples / max(1, len(result.residuals())))
        right.axhspan(-bound, bound, color=grey(right, 0.87), linewidth=0.0,
                      label="±2σ of white noise")  # fmt: skip
        right.axhline(0.0, color=grey(right), linewidth=0.6)
        right.set_xlabel("lag [samples]")
        right.set_ylabel("autocorrelation")
        legend_above(figure, right, left)
    return figure


def residual_bins(step: float) -> np.ndarray[Any, Any]:
    """Edges of bins from -5 to 5 that contain equally many steps of a digitiser, all in noises."""
    if not step:
        return np.linspace(-5.0, 5.0, 41)
    width = step * np.ceil(0.25 / step)
    count = int(np.ceil(5.0 / width))
    # Rounded samples without a signal are between the edges.
    return np.asarray(width * np.arange(-count, count + 2) - 0.5 * step)


def plot_correlations(result: FitResult) -> Figure:
    """Plot the correlations of the parameters of a fit as a map, without its upper half."""
    names = [literal(parameter_in_words(name)) for name in result.names]
    values = result.correlation
    lower = np.tril(np.ones(values.shape, dtype=bool))
    with figure_style():
        side = 2.6 + 0.4 * len(names)
        width, _ = figure_size(side + 0.8, side)
        figure, axes = plt.subplots(figsize=(width, width * side / (side + 0.8)))
        mesh = axes.imshow(np.where(lower, values, np.nan), cmap="RdBu_r", vmin=-1.0, vmax=1.0)
        places = np.arange(len(names))
        axes.set_xticks(places, names, rotation=90)
        axes.set_yticks(places, names)
        axes.spines[:].set_visible(False)
        axes.tick_params(length=0.0)
        # As high as the map, which an own colour bar would not be.
        bar = axes.inset_axes((1.04, 0.0, 0.05, 1.0))
        figure.colorbar(mesh, cax=bar, label="correlation", ticks=[-1.0, -0.5, 0.0, 0.5, 1.0])
        figure.draw_without_rendering()
        cell = POINTS_PER_INCH * axes.get_window_extent().width / figure.dpi / len(names)
        size = min(7.5, cell / (CHARACTER * MAX_LETTERS))
        if size >= MIN_NUMBER:
            for i, j in np.argwhere(lower):
                axes.text(j, i, _correlation_in_words(values[i, j], i == j), ha="center",
                          va="center", fontsize=size,
                          color="white" if abs(values[i, j]) > 0.6 else "black")  # fmt: skip
    return figure


def _correlation_in_words(value: float, same: bool) -> str:
    """Two digits; of parameters that are almost, but not completely, correlated, a limit."""
    if same:
        return "1"
    if abs(value) >= ALMOST_ONE:
        return f"{'>' if value > 0.0 else '<'}{signed(np.copysign(0.99, value))}"
    return signed(value, "z.2f")


def _draw_compared(axes: Axes, comparison: TraceComparison, i: int, factor: float) -> None:
    """Draw data and simulation of a sensor."""
    shot = comparison.traces.shots[0]
    draw_signal(axes, factor * shot.times, shot.signals[i], comparison.scaled[i], SIMULATION)


def _draw_differences(axes: Axes, comparison: TraceComparison, i: int, factor: float) -> None:
    """Draw data minus simulation over the noise."""
    shot = comparison.traces.shots[0]
    signal = shot.signals[i]
    values = np.where(signal.valid, signal.values - comparison.scaled[i], np.nan) / signal.sigma
    draw_residuals(axes, factor * shot.times, values)


def _title_with_peaks(axes: Axes, comparison: TraceComparison, i: int) -> None:
    """Add the peaks to the title of a figure of its own, unless it is for a journal."""
    if journal_width.get() is None:
        found = comparison.sensors[i]
        data, own = found.cells[:2]
        if found.volts:
            axes.set_ylabel(signal_label(comparison.traces.shots[0].signals[i]))
            use_prefix(axes, abs(found.measured_peak))
        set_panel_title(axes, literal(f"{found.name}, peak: {DATA} {data}, {SIMULATION} {own}"))


def plot_sensor(
    comparison: TraceComparison, sensor: str, *, legend: bool = True,
    ax: Axes | Sequence[Axes] | None = None,
) -> Axes:  # fmt: skip
    """Plot data and simulation of a sensor and, unless one axes are given, their difference."""
    names = [each.name for each in comparison.sensors]
    i = names.index(check_choice("sensor", sensor, names))
    factor, label = _time_axis(comparison.traces)
    with figure_style():
        upper, lower = (ax, ax) if isinstance(ax, Axes) else get_two_axes(ax)
        _draw_compared(upper, comparison, i, factor)
        if lower is not upper:
            _draw_differences(lower, comparison, i, factor)
            lower.set_xlim(upper.get_xlim())
        if ax is None:
            _title_with_peaks(upper, comparison, i)
        lower.set_xlabel(label)
        if check_bool("legend", legend):
            place_legend(upper, own=ax is None)
    return upper


def plot_trace_comparison(comparison: TraceComparison) -> Figure:
    """Plot data and simulation and, below them, their difference over the noise, by sensor."""
    count = len(comparison.sensors)
    columns, size = sensor_grid(count)
    rows = -(-count // columns)
    factor, label = _time_axis(comparison.traces)
    with figure_style():
        figure, panels = plt.subplots(
            2 * rows, columns, squeeze=False, sharex=True, layout="constrained", figsize=size,
            gridspec_kw={"height_ratios": (2.2, 1.0) * rows},
        )  # fmt: skip
        for i in range(rows * columns):
            upper, lower = panels[2 * (i % rows) : 2 * (i % rows) + 2, i // rows]
            if i >= count:
                upper.remove()
                lower.remove()
                continue
            _draw_compared(upper, comparison, i, factor)
            _title_with_peaks(upper, comparison, i)
            _draw_differences(lower, comparison, i, factor)
            if i % rows == rows - 1 or i == count - 1:
                lower.set_xlabel(label)
                lower.tick_params(labelbottom=True)
        figure.align_ylabels()
        legend_above(figure, *figure.axes)
    return figure


def plot_corner(posterior: Posterior) -> Figure:
    """Corner plot of a posterior: histogram of each parameter and scatter of each pair.

    Above the histograms are the medians, with the distances to the 16th and 84th percentiles.  If
    there are too few steps for reliable errors, the legend states it.
    """
    count = len(posterior.names)
    factors, names, units = _in_shown_units(posterior)
    side = max(1.7 * count + 0.6, 3.4)
    # Medians that would be wider than a panel are above all of them.
    listed = count > 1 and figure_size(side, side)[0] < MIN_PANEL * count
    labels = [f"{name}\n[{unit}]" if unit else name
              for name, unit in zip(names, units, strict=True)]  # fmt: skip
    samples, estimates = factors * posterior.samples, factors * posterior.estimates
    drawn = samples[:: max(1, len(samples) // POINTS)]
    medians = [f"{_median_in_words(each)} {unit}".rstrip()
               for each, unit in zip(samples.T, units, strict=True)]  # fmt: skip
    with figure_style():
        figure, panels = plt.subplots(
            count, count, squeeze=False, figsize=figure_size(side, side), layout="constrained"
        )  # fmt: skip
        caution = posterior._too_short()
        if caution and (listed or count < CORNER):
            figure.set_figheight(figure.get_figheight() + CAUTION_HEIGHT)
        size = _corner_font(figure.get_figwidth(), count, labels)
        for i, j in np.ndindex(count, count):
            axes: Any = panels[i, j]
            if j > i:
                axes.remove()
                continue
            if i == j:
                axes.hist(samples[:, i], 40, histtype="step", color=COLOURS[1])
                axes.axvline(estimates[i], color=COLOURS[2], linewidth=0.9)
                axes.set_yticks([])
                if not listed:
                    axes.set_title(f"{names[i]}\n{medians[i]}", fontsize=size)
            else:
                axes.plot(drawn[:, j], drawn[:, i], ".", color=COLOURS[1], markersize=1.0,
                          alpha=0.3, rasterized=True)  # fmt: skip
                axes.plot(estimates[j], estimates[i], "+", color=COLOURS[2], markersize=0.7 * size)
            axes.ticklabel_format(useOffset=False)
            axes.locator_params(nbins=2 if listed else 3)
            axes.tick_params(labelsize=0.8 * size, labelbottom=i == count - 1, labelleft=j == 0 < i)
            axes.tick_params(axis="x", labelrotation=45.0)
            axes.grid(visible=False)
            if i == count - 1:
                axes.set_xlabel(labels[j], fontsize=size)
            if j == 0 and i:
                axes.set_ylabel(labels[i], fontsize=size)
        rows = [f"{' '.join(name.split())}: {median}"
                for name, median in zip(names, medians, strict=True)]  # fmt: skip
        _corner_legend(figure, size, rows if listed else [], caution)
    return figure


def _corner_font(width: float, count: int, labels: Sequence[str]) -> float:
    """Size of a font that is legible in a figure of this width [inch], and fits its panels."""
    longest = max(len(line) for label in labels for line in label.splitlines())
    fitting = POINTS_PER_INCH * 0.75 * width / count / (0.55 * longest)
    return max(SMALLEST, min(fitting, 9.0 * max(1.0, width / 7.4)))


def _corner_legend(figure: Figure, size: float, rows: Sequence[str], caution: str) -> None:
    """Explain the colours in the empty corner or, of few panels or with further rows, above."""
    samples, value = (Line2D([], [], color=COLOURS[i]) for i in (1, 2))
    samples.set(linestyle="", marker=".", label="samples of the posterior")
    value.set(linewidth=0.9, marker="+", markersize=0.7 * size, label="value of the fit")
    place: dict[str, Any] = (
        {"loc": "outside upper left"} if rows
        else {"loc": "outside upper center"} if len(figure.axes) < CORNER * (CORNER + 1) // 2
        else {"loc": "upper right", "bbox_to_anchor": (0.98, 0.98)}
    )  # fmt: skip
    if caution:
        rows = [*rows, "\n".join(textwrap.wrap(f"not converged: {caution}", CAUTION_LINE))]
    further = [Line2D([], [], linestyle="", label=row) for row in rows]
    figure.legend(handles=[samples, value, *further], fontsize=size, **place)


def _median_in_words(values: Any) -> str:
    """Median and distances to the 16th and 84th percentiles, with two digits of the smaller."""
    low, median, high = np.percentile(values, [16.0, 50.0, 84.0])
    below, above = median - low, high - median
    least = min(below, above)
    if not least > 0.0:
        return f"{median:.4g}"
    digits = max(0, 1 - int(np.floor(np.log10(least))))
    shown = [f"{each:.{digits}f}" for each in (median, above, below)]
    return r"$\mathdefault{{{}^{{+{}}}_{{-{}}}}}$".format(*shown)


def _in_shown_units(posterior: Posterior) -> tuple[np.ndarray[Any, Any], list[str], list[str]]:
    """Factors to units in which parameters are shown, their names in words, and these units."""
    factors, units = [], []
    for samples, unit in zip(posterior.samples.T, posterior.units, strict=True):
        largest = float(np.abs(samples).max(initial=0.0))
        factor, shown = factor_and_unit(largest, unit)
        size = factor * largest
        power = int(np.floor(np.log10(size))) if size > 0.0 else 0
        shown = literal(with_micro(shown))
        if not MIN_POWER <= power <= MAX_POWER:
            factor, shown = factor * 10.0**-power, f"$10^{{{power}}}$ {shown}".rstrip()
        factors.append(factor)
        units.append(shown)
    names = ["\n".join(textwrap.wrap(literal(parameter_in_words(name)), LONG_NAME,
                                     break_long_words=False, break_on_hyphens=False))
             for name in posterior.names]  # fmt: skip
    return np.array(factors), names, units
