"""Plot measured traces, fits, residuals, correlations and posteriors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..fitting.goodness import autocorrelation
from ..fitting.shown_values import SHOWN
from ..validation.numbers import whole_number
from ..validation.objects import check_bool, check_choice
from .colours import COLOURS, curve_colour, grey
from .legends import POINTS_PER_INCH, place_legend
from .style import (
    TIME_LABELS,
    figure_style,
    get_axes,
    get_two_axes,
    literal,
    seconds_axis,
    with_micro,
)
from .widths import figure_size, journal_width

if TYPE_CHECKING:
    from ..fitting.posterior import Posterior
    from ..fitting.result import FitResult
    from ..fitting.signals import Signal
    from ..fitting.trace_comparison import TraceComparison
    from ..fitting.traces import Traces

# Samples of a posterior that are drawn as points.
POINTS: Final = 4000
# Fewest samples of a crest that is shown enlarged.
CREST: Final = 5
# More sensors than this are in two columns, which keeps text legible on a page.
MAX_COLUMNS: Final = 3
# Smallest font of a corner plot, and largest number of characters of a name in one line.
SMALLEST, LONG_NAME = 6.5, 14
# Width of panels [inches] below which points are smaller and there are fewer ticks.
NARROW: Final = 2.0


def plot_traces(traces: Traces, *, legend: bool = True, ax: Axes | None = None) -> Axes:
    """Plot measured signals over time; relative to their largest values if units differ."""
    legend = check_bool("legend", legend)
    with figure_style():
        axes = get_axes(ax)
        factor, label = _time_axis(traces)
        if axes.get_xlabel() in TIME_LABELS:
            factor, label = TIME_LABELS[axes.get_xlabel()], axes.get_xlabel()
        # In axes that have other curves, signals keep their units.
        relative = ax is None and len({signal.unit for _, signal in traces}) > 1
        # Curves that the axes already have, such as simulated ones, have the first colours.
        for i, (index, signal) in enumerate(traces, len(axes.get_legend_handles_labels()[1])):
            times, values = factor * traces.shots[index].times, signal.values
            name = signal.name + (f", shot {index + 1}" if len(traces.shots) > 1 else "")
            if relative:
                largest = float(np.nanmax(np.abs(values)))
                values, name = values / largest, f"{name}: {largest:.3g} {signal.unit}"
            colour = curve_colour(axes, i)
            axes.plot(times, np.where(signal.valid, values, np.nan), color=colour, label=name)
            unused = ~signal.valid & np.isfinite(values)
            axes.plot(times[unused], values[unused], "x", color=colour)
        axes.set_xlabel(label)
        own = " or ".join(dict.fromkeys(_signal_label(signal) for _, signal in traces))
        axes.set_ylabel("signal / largest value" if relative else own)
        axes.margins(x=0.0)
        if legend:
            place_legend(axes, own=ax is None)
    return axes


def _signal_label(signal: Signal) -> str:
    """Quantity and unit of a signal; only calibrated ones are forces or velocities."""
    what = "force" if signal.place.quantity == "force" else "velocity"
    return f"{what if signal.calibrated else 'signal'} [{signal.unit}]"


def _time_axis(traces: Traces) -> tuple[float, str]:
    """Factor and label of the time axes of all shots."""
    return seconds_axis(max(float(np.ptp(shot.times)) for shot in traces.shots))


def plot_fit(result: FitResult) -> Figure:
    """Plot data, fit, residuals over noise and, enlarged, the crest of every sensor."""
    shots, residuals = result.traces.shots, result.residuals()
    most = max(len(shot.signals) for shot in shots)
    columns = most if most <= MAX_COLUMNS else 2
    blocks = -(-most // columns)  # of three rows of panels, for each shot
    factor, label = _time_axis(result.traces)
    with figure_style():
        figure, grid = plt.subplots(
            3 * blocks * len(shots), columns, squeeze=False, layout="constrained",
            figsize=figure_size(3.2 * columns, 4.8 * blocks * len(shots)),
            gridspec_kw={"height_ratios": [2.0, 1.0, 1.5] * (blocks * len(shots))},
        )  # fmt: skip
        # In narrow panels, points of the usual size hide each other.
        size = 0.4 if figure.get_figwidth() < NARROW * columns else 1.0
        rest = iter(residuals)
        limit = 1.1 * max(4.0, *(float(np.nanmax(np.abs(values))) for *_, values in residuals))
        for index, shot in enumerate(shots):
            for place in range(blocks * columns):
                row, column = 3 * (index * blocks + place // columns), place % columns
                panels = grid[row : row + 3, column]
                if place >= len(shot.signals):
                    for axes in panels:
                        axes.remove()
                    continue
                signal, model = shot.signals[place], result.predicted[index][place]
                times = factor * shot.times
                _draw_signal(panels[0], times, signal, model, size)
                _draw_residuals(panels[1], times, next(rest)[2], limit, size)
                _draw_crest(panels[2], times, signal, model, size)
                panels[0].tick_params(labelbottom=False)
                panels[1].set_xlim(panels[0].get_xlim())
                panels[2].set_xlabel(label)
                panels[2].set_ylabel(f"crest [{signal.unit}]")
                if column == 0:
                    panels[1].set_ylabel("residual\n/ noise")
                if len(shots) > 1:
                    panels[0].set_title(f"{signal.name}, shot {index + 1}")
        figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return figure


def plot_fitted_sensor(
    result: FitResult, sensor: str, *, shot: int = 1, ax: Axes | Sequence[Axes] | None = None
) -> Axes:
    """Plot data and fit of one sensor and, unless one axes are given, its residuals over noise."""
    shots = result.traces.shots
    index = whole_number("shot", shot, least=1, most=len(shots)) - 1
    names = [signal.name for signal in shots[index].signals]
    place = names.index(check_choice("sensor", sensor, names))
    factor, label = _time_axis(result.traces)
    times = factor * shots[index].times
    with figure_style():
        upper, lower = (ax, ax) if isinstance(ax, Axes) else get_two_axes(ax)
        signal, model = shots[index].signals[place], result.predicted[index][place]
        _draw_signal(upper, times, signal, model, name="fit")
        if lower is not upper:
            values = next(
                each for number, name, each in result.residuals()
                if (number, name) == (index + 1, sensor)
            )  # fmt: skip
            _draw_residuals(lower, times, values, 1.1 * max(4.0, float(np.nanmax(np.abs(values)))))
            lower.set_ylabel("residual\n/ noise")
            lower.margins(x=0.0)
            lower.set_xlim(upper.get_xlim())
        lower.set_xlabel(label)
        place_legend(upper, own=ax is None)
    return upper


def _draw_residuals(
    axes: Axes, times: Any, residuals: Any, limit: float, size: float = 1.0
) -> None:
    axes.plot(
        times, residuals, ".", color=grey(axes, 0.35), markersize=2.0 * size, markeredgewidth=0.0
    )
    axes.axhline(0.0, color=grey(axes), linewidth=0.6)
    axes.set_ylim(-limit, limit)


def _draw_signal(
    axes: Axes, times: Any, signal: Signal, model: Any, size: float = 1.0, *, name: str = "model"
) -> None:
    shown = np.where(signal.valid, signal.values, np.nan)
    _draw_data_and_model(axes, times, shown, model, point=2.5 * size, line=0.6 + 0.4 * size,
                         name=name)  # fmt: skip
    unused = ~signal.valid & np.isfinite(signal.values)
    axes.plot(times[unused], signal.values[unused], "x", color=grey(axes, 0.55), markersize=3.0)
    axes.set_ylabel(_signal_label(signal))
    axes.set_title(literal(signal.name))
    axes.margins(x=0.0)


def _draw_data_and_model(
    axes: Axes, times: Any, data: Any, model: Any, *, point: float, line: float,
    name: str = "model",
) -> None:  # fmt: skip
    """Draw a line in front of points that are wider, which hides neither."""
    axes.plot(times, data, "o", color=grey(axes, 0.25), markersize=point, markeredgewidth=0.0,
              label="data", zorder=3.0)  # fmt: skip
    axes.plot(times, model, color=COLOURS[6], linewidth=line, label=name, zorder=4.0)


def _draw_crest(axes: Axes, times: Any, signal: Signal, model: Any, size: float = 1.0) -> None:
    """Draw the crest of the signal, enlarged."""
    sign = np.sign(model[np.argmax(np.abs(model - model[0]))] - model[0])
    values = np.where(signal.valid, sign * signal.values, -np.inf)
    begin, end = _crest(values, sign * model)
    if end == len(times) - 1 and begin > 1:
        # The record ends before this wave has passed: show the one before it.
        begin, end = _crest(values[:begin], sign * model[:begin])
    if end - begin < CREST:
        axes.text(0.5, 0.5, "too few samples", ha="center", va="center", transform=axes.transAxes)
        axes.set_xticks([])
        axes.set_yticks([])
        return
    shown = slice(begin, end + 1)
    data = np.where(signal.valid, signal.values, np.nan)[shown]
    _draw_data_and_model(axes, times[shown], data, model[shown], point=4.5 * size, line=1.5 * size)
    axes.locator_params(axis="y", nbins=4)
    if size == 1.0:
        axes.locator_params(axis="x", nbins=4)
    else:
        axes.locator_params(axis="x", nbins=2, min_n_ticks=1)


def _crest(values: Any, model: Any) -> tuple[int, int]:
    """Indices of both ends of the crest around the largest value."""
    crest = int(np.argmax(values))
    high = np.abs(model - model[0]) > 0.7 * abs(model[crest] - model[0])
    begin, end = crest, crest
    while begin > 0 and high[begin - 1]:
        begin -= 1
    while end < len(model) - 1 and high[end + 1]:
        end += 1
    return begin, end


def plot_fit_residuals(result: FitResult) -> Figure:
    """Plot the distribution and the autocorrelation of the residuals of a fit."""
    with figure_style():
        figure, (left, right) = plt.subplots(
            1, 2, figsize=figure_size(8.5, 3.4), layout="constrained"
        )
        edges = np.linspace(-5.0, 5.0, 41)
        for i, (shot, name, values) in enumerate(result.residuals()):
            seen = values[np.isfinite(values)]
            label = name + (f", shot {shot}" if len(result.traces.shots) > 1 else "")
            colour = curve_colour(left, i)
            left.hist(np.clip(seen, -5.0, 5.0), edges, density=True, histtype="step", color=colour,
                      label=label)  # fmt: skip
            rho = autocorrelation(seen, 40)
            right.plot(np.arange(1, len(rho)), rho[1:], color=colour, linewidth=1.0)
        grid = np.linspace(-5.0, 5.0, 201)
        left.plot(grid, np.exp(-0.5 * grid**2) / np.sqrt(2.0 * np.pi), "--", color=grey(left),
                  linewidth=0.9, label="normal")  # fmt: skip
        # The first and the last bin also count the values beyond them.
        left.set_xticks([-5.0, -2.5, 0.0, 2.5, 5.0], ["≤ −5", "−2.5", "0", "2.5", "≥ 5"])
        left.set_xlabel("residual / noise")
        left.set_ylabel("density")
        place_legend(left)
        bound = 2.0 / np.sqrt(result.goodness.samples / max(1, len(result.residuals())))
        right.axhspan(-bound, bound, color=grey(right, 0.85))
        right.axhline(0.0, color=grey(right), linewidth=0.6)
        right.set_xlabel("lag [samples]")
        right.set_ylabel("autocorrelation")
    return figure


def plot_correlations(result: FitResult) -> Figure:
    """Plot the correlations of the parameters of a fit as a map."""
    names, values = result.names, result.correlation
    with figure_style():
        side = 2.6 + 0.4 * len(names)
        figure, axes = plt.subplots(figsize=figure_size(side + 0.8, side), layout="constrained")
        mesh = axes.imshow(values, cmap="RdBu_r", vmin=-1.0, vmax=1.0)
        places = np.arange(len(names))
        axes.set_xticks(places, names, rotation=90)
        axes.set_yticks(places, names)
        axes.grid(visible=False)
        if len(names) <= 12:
            for i, j in np.ndindex(values.shape):
                axes.text(j, i, f"{values[i, j]:z.2f}", ha="center", va="center", fontsize=6.5,
                          color="white" if abs(values[i, j]) > 0.6 else "black")  # fmt: skip
        figure.colorbar(mesh, ax=axes, label="correlation", shrink=0.8)
    return figure


def _draw_compared(
    axes: Axes, comparison: TraceComparison, i: int, factor: float, *, own: bool = True
) -> None:
    """Draw data and simulation of a sensor, with the peaks in the title of a figure of its own."""
    shot, found = comparison.traces.shots[0], comparison.sensors[i]
    model = comparison.scaled[i]
    _draw_signal(axes, factor * shot.times, shot.signals[i], model, name="simulation")
    if own and journal_width.get() is None:
        peak, simulated = found.cells[:2]
        axes.set_title(f"{literal(found.name)}\npeak {peak}, simulated {simulated}")


def plot_sensor(comparison: TraceComparison, sensor: str, *, ax: Axes | None = None) -> Axes:
    """Plot data and simulation of one sensor."""
    names = [each.name for each in comparison.sensors]
    i = names.index(check_choice("sensor", sensor, names))
    factor, label = _time_axis(comparison.traces)
    with figure_style():
        axes = get_axes(ax)
        _draw_compared(axes, comparison, i, factor, own=ax is None)
        axes.set_xlabel(label)
        place_legend(axes, own=ax is None)
    return axes


def plot_comparison(comparison: TraceComparison) -> Figure:
    """Plot data and simulation, one panel per sensor."""
    count = len(comparison.sensors)
    # Up to three panels are below each other, which leaves no place empty.
    columns = 1 if count < 4 else 2
    rows = -(-count // columns)
    factor, label = _time_axis(comparison.traces)
    with figure_style():
        figure, panels = plt.subplots(
            rows, columns, squeeze=False, sharex=True, layout="constrained",
            figsize=figure_size(*((6.0, 2.0 * rows) if columns == 1 else (8.4, 2.5 * rows))),
        )  # fmt: skip
        for i, axes in enumerate(panels.flat):
            if i >= count:
                axes.remove()
                continue
            _draw_compared(axes, comparison, i, factor)
            if i >= count - columns:
                axes.set_xlabel(label)
                axes.tick_params(labelbottom=True)
        figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return figure


def plot_corner(posterior: Posterior) -> Figure:
    """Corner plot of a posterior: histogram of each parameter and scatter of each pair.

    Above the histograms are the medians, with the distances to the 16th and 84th percentiles.
    """
    count = len(posterior.names)
    factors, names, units = _in_shown_units(posterior)
    # Long names and their units do not fit one line of a panel.
    labels = [f"{name}\n[{unit}]" if unit else name
              for name, unit in zip(names, units, strict=True)]  # fmt: skip
    samples, estimates = factors * posterior.samples, factors * posterior.estimates
    drawn = samples[:: max(1, len(samples) // POINTS)]
    side = max(1.7 * count + 0.6, 3.4)
    with figure_style():
        figure, panels = plt.subplots(
            count, count, squeeze=False, figsize=figure_size(side, side), layout="constrained"
        )  # fmt: skip
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
                axes.set_title(f"{names[i]}\n{_median_in_words(samples[:, i])} {units[i]}".rstrip(),
                               fontsize=size)  # fmt: skip
            else:
                axes.plot(drawn[:, j], drawn[:, i], ".", color=COLOURS[1], markersize=1.0,
                          alpha=0.3, rasterized=True)  # fmt: skip
                axes.plot(estimates[j], estimates[i], "+", color=COLOURS[2], markersize=0.7 * size)
            axes.locator_params(nbins=3)
            axes.tick_params(labelsize=0.8 * size, labelbottom=i == count - 1, labelleft=j == 0 < i)
            axes.tick_params(axis="x", labelrotation=45.0)
            axes.grid(visible=False)
            if i == count - 1:
                axes.set_xlabel(labels[j], fontsize=size)
            if j == 0 and i:
                axes.set_ylabel(labels[i], fontsize=size)
        _corner_legend(figure, size)
    return figure


def _corner_font(width: float, count: int, labels: Sequence[str]) -> float:
    """Size of a font that is legible in a figure of this width [inch], and fits its panels."""
    longest = max(len(line) for label in labels for line in label.splitlines())
    fitting = POINTS_PER_INCH * 0.75 * width / count / (0.55 * longest)
    return max(SMALLEST, min(fitting, 9.0 * max(1.0, width / 7.4)))


def _corner_legend(figure: Figure, size: float) -> None:
    """Explain the colours in the empty corner, or above the only panel."""
    samples, value = (Line2D([], [], color=COLOURS[i]) for i in (1, 2))
    samples.set(linestyle="", marker=".", label="samples of the posterior")
    value.set(linewidth=0.9, marker="+", markersize=0.7 * size, label="value of the fit")
    place: dict[str, Any] = (
        {"loc": "outside upper center"} if len(figure.axes) == 1
        else {"loc": "upper right", "bbox_to_anchor": (0.98, 0.98)}
    )  # fmt: skip
    figure.legend(handles=[samples, value], fontsize=size, **place)


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
    """Factors to units in which parameters are shown, their names, and these units."""
    factors, shown = zip(*(SHOWN.get(unit, (1.0, unit)) for unit in posterior.units), strict=True)
    names = [name.replace(".", ".\n") if len(name) > LONG_NAME else name
             for name in posterior.names]  # fmt: skip
    return np.array(factors), [*map(literal, names)], [literal(with_micro(unit)) for unit in shown]
