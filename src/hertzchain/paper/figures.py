"""The paper's fourteen figures, recomputed, each with a statement that is checked."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.lines import Line2D

from ..calibration import fit_line
from ..chain.tapers import rate_symbol
from ..collision import Array
from ..plotting.style import figure_style, label_log_axis, label_right_ends
from ..pulse.pulse import Pulse
from ..pulse.quantities import QUANTITIES
from ..representation import short
from ..theory.bca import bca, forward_linear_momentum_slope
from ..theory.modified_bca import modified_bca, printed_velocity
from ..validation.keywords import checked_arguments
from ..validation.objects import check_choice
from .published import FigureQuantity, PublishedFigure, published_figures
from .simulated_chains import Pulses, integrate_chains

# Last bead in the figures; chains have 100 beads, and the last ten are affected by the free end.
LAST_BEAD: Final = 90
# Width of figures in inches for which the numbers of symbols were chosen.
WIDTH: Final = 5.4
# Number of characters of a legend that fit in a row of a narrower figure.
LONG: Final = 30

# With its printed constants, the modified BCA does not describe the simulation; see the errata.
RECALIBRATED: Final = "modified BCA (recalibrated)"

RATIO_LABEL: Final = "$v_k$ of the BCA / $v_k$ of the simulation"


@dataclass(frozen=True, eq=False)
class Curve:
    """Simulation and theory of one chain of a figure, beads 1..90."""

    rate: float
    integration: Pulse
    unmodified: Pulse
    theory: Pulse

    @property
    def k(self) -> Array:
        """Bead numbers in the figure."""
        return self.integration.bead[:LAST_BEAD]

    def values(self, pulse: Pulse, quantity: FigureQuantity) -> Array:
        """Values of the figure's quantity for one of the pulses."""
        if quantity == "ratio":
            return (self.unmodified.velocity / pulse.velocity)[:LAST_BEAD]
        column = pulse.column(quantity)
        assert column is not None
        return column[:LAST_BEAD]

    def over(self, first: int, last: int, values: Array) -> tuple[Array, Array]:
        """Bead numbers first..last and the values at these beads."""
        return self.k[first - 1 : last].astype(float), values[first - 1 : last]


@dataclass(frozen=True)
class Statement:
    """A claim about a figure, with numbers that must be between bounds."""

    claim: str
    measured: dict[str, float]
    low: float
    high: float

    @property
    def holds(self) -> bool:
        """Whether all numbers are between the bounds."""
        return all(self.low <= value <= self.high for value in self.measured.values())


@dataclass(frozen=True, eq=False)
class Figure:
    """A figure of the paper with recomputed data."""

    published: PublishedFigure
    curves: tuple[Curve, ...]
    statement: Statement

    def __repr__(self) -> str:
        outcome = "holds" if self.statement.holds else "does not hold"
        return short(
            "Figure", f"{self.published.name}, {self.published.quantity} of {self.published.taper}",
            f"{len(self.curves)} curves", f"the statement {outcome}: {self.statement.claim}",
        )  # fmt: skip

    @property
    def order_as_captioned(self) -> bool:
        """Whether the right ends of the curves are in the order stated in the caption."""
        quantity = self.published.quantity
        ends = [curve.values(curve.integration, quantity)[-1] for curve in self.curves]
        if self.published.order == "falling":
            ends.reverse()
        return bool(np.all(np.diff(ends) > 0.0))


@dataclass(frozen=True)
class Layout:
    """Scales, theory and lines of a figure.

    Symbols and lines are those of the captions.  Scales follow the paper's text and the labels
    in its source; if these do not determine a scale, it is chosen to show the data clearly.
    """

    theory: Literal["BCA", "modified BCA (recalibrated)", "none"]
    xscale: Literal["linear", "log"] = "linear"
    yscale: Literal["linear", "log"] = "linear"
    first_bead: int = 1
    lines: Callable[[Axes], None] | None = field(default=None, repr=False)


def _line_of_slope_three_halves(axes: Axes) -> None:
    k = np.array([4.0, 90.0])
    axes.plot(k, 1.0 * k**1.5, color="black", linewidth=1.2, label="slope 3/2")


def _horizontal_line(axes: Axes) -> None:
    axes.axhline(0.24, xmin=0.35, color="black", linewidth=1.2, label="horizontal")


def _line_at_three_halves(axes: Axes) -> None:
    label = "3/2, inverse of the paper's ratio"
    axes.axhline(1.5, color="black", linewidth=0.9, linestyle="--", label=label)


LAYOUTS: Final[dict[int, Layout]] = {
    1: Layout("BCA", "log", "log", lines=_line_of_slope_three_halves),
    2: Layout("BCA", lines=_horizontal_line),
    3: Layout("BCA", yscale="log"),
    4: Layout("BCA", yscale="log"),
    5: Layout("BCA"),
    6: Layout("BCA"),
    7: Layout("BCA", yscale="log"),
    8: Layout("BCA", yscale="log"),
    9: Layout("none", first_bead=2, lines=_line_at_three_halves),
    10: Layout(RECALIBRATED, "log", "log"),
    11: Layout("none", first_bead=2),
    12: Layout(RECALIBRATED, yscale="log"),
    13: Layout(RECALIBRATED),
    14: Layout(RECALIBRATED, yscale="log"),
}


def figure_chains(name: str) -> set[tuple[str, float]]:
    """Chains whose simulation a figure requires."""
    published = published_figures()[name]
    return {(published.taper, rate) for rate in published.rates}


@checked_arguments("reproduce_figure")
def reproduce_figure(name: str, pulses: Pulses | None = None) -> Figure:
    """Collect the data of one figure and check the statement of the paper about it.

    Parameters
    ----------
    name : str
        ``"figure1"``, ``"figure2"``, ...
    pulses : mapping of (str, float) to Pulse, optional
        Simulated pulses by taper and rate, such as ``Reproduction.pulses``.  By default, the chains
        of the figure are simulated.

    Returns
    -------
    Figure
        Its ``curves`` have the simulation and the theory of each rate, and its ``statement`` the
        numbers that were checked.  `draw_figure` draws it.

    Raises
    ------
    InputError
        If there is no such figure.

    Examples
    --------
    >>> from hertzchain.paper import reproduce_figure
    >>> reproduce_figure("figure1").statement.holds
    True
    """
    figures = published_figures()
    published = figures[check_choice("figure of the paper", name, figures)]
    if pulses is None:
        pulses = integrate_chains(figure_chains(name))
    modified = LAYOUTS[published.number].theory == RECALIBRATED
    curves = []
    for rate in published.rates:
        pulse = pulses[published.taper, rate]
        unmodified = bca(pulse.chain)
        theory = modified_bca(pulse.chain) if modified else unmodified
        curves.append(Curve(rate, pulse, unmodified, theory))
    return Figure(published, tuple(curves), STATEMENTS[published.number](curves))


@checked_arguments("draw_figure")
def draw_figure(figure: Figure) -> MatplotlibFigure:
    """Draw one figure as described in its caption.

    Circles represent the simulation, + symbols the theory.  Each curve shows about thirty
    beads, and fewer in narrow figures, so that the symbols do not overlap.
    """
    published, layout = figure.published, LAYOUTS[figure.published.number]
    symbol = rate_symbol(published.taper)
    colours = [matplotlib.colormaps["viridis"](x) for x in np.linspace(0, 0.72, len(figure.curves))]
    with figure_style():
        canvas, axes = plt.subplots()
        axes.set_xscale(layout.xscale)
        axes.set_yscale(layout.yscale)
        shown = _shown_beads(layout, canvas.get_figwidth() / WIDTH)
        size = 1.25 * matplotlib.rcParams["lines.markersize"]
        for curve, colour in zip(figure.curves, colours, strict=True):
            ours = curve.values(curve.integration, published.quantity)
            axes.plot(curve.k[shown], ours[shown], "o", color=colour, markerfacecolor="none")
            if layout.theory != "none":
                theory = curve.values(curve.theory, published.quantity)
                axes.plot(curve.k[shown], theory[shown], "+", color=colour, markersize=size)
        if layout.lines is not None:
            layout.lines(axes)
        axes.set_xlabel("bead $k$")
        ratio = published.quantity == "ratio"
        axes.set_ylabel(RATIO_LABEL if ratio else QUANTITIES[published.quantity].label)
        axes.set_xlim(right=LAST_BEAD * (1.06 if layout.xscale == "log" else 1.01))
        if layout.yscale == "log":
            label_log_axis(axes.yaxis)
        _legend(axes, layout, narrow=canvas.get_figwidth() < WIDTH)
        label_right_ends(
            axes,
            [
                (
                    float(LAST_BEAD),
                    float(curve.values(curve.integration, published.quantity)[-1]),
                    f"${symbol}$ = {curve.rate:g}",
                    matplotlib.colors.to_hex(colour),
                )
                for curve, colour in zip(figure.curves, colours, strict=True)
            ],
        )
    return canvas


def figure_csv(figure: Figure) -> str:
    """Data of a figure as CSV, with one row per chain and bead."""
    published, theory = figure.published, LAYOUTS[figure.published.number].theory
    columns = [rate_symbol(published.taper), "k"]
    columns += ["BCA/integration"] if theory == "none" else ["integration", theory]
    rows = [",".join(columns)]
    for curve in figure.curves:
        ours = curve.values(curve.integration, published.quantity)
        beside = curve.values(curve.theory, published.quantity)
        for k, value, predicted in zip(curve.k, ours, beside, strict=True):
            row = f"{curve.rate:g},{k},{value:.12g}"
            rows.append(row if theory == "none" else f"{row},{predicted:.12g}")
    return "\n".join(rows) + "\n"


def _shown_beads(layout: Layout, width: float) -> Array:
    """Indices of the beads in a figure of a relative width, evenly spaced on the axis."""
    part = min(width, 1.0)
    if layout.xscale == "log":
        k = np.geomspace(layout.first_bead, LAST_BEAD, round(30 * part))
        return np.unique(k.round().astype(int)) - 1
    return np.arange(LAST_BEAD, layout.first_bead - 1, -math.ceil(3.0 / part))[::-1] - 1


def _legend(axes: Axes, layout: Layout, *, narrow: bool) -> None:
    def symbol(marker: str, size: float) -> Line2D:
        return Line2D([], [], color="0.25", marker=marker, ms=size, mfc="none", linestyle="none")

    handles, labels = axes.get_legend_handles_labels()
    if layout.theory == "none":
        handles, labels = [symbol("o", 4), *handles], ["BCA / simulation", *labels]
    else:
        handles = [symbol("o", 4), symbol("+", 5), *handles]
        labels = ["simulation", layout.theory, *labels]
    rows = narrow and sum(map(len, labels)) > LONG
    # Above the axes, the legend covers no curve.
    axes.legend(
        handles,
        labels,
        ncols=1 if rows else len(handles),
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
    )


def _worst_error(curve: Curve, velocity: Array) -> float:
    """Largest absolute relative error of a theory's velocity, beads 5..80."""
    return float(np.abs(velocity / curve.integration.velocity - 1.0)[4:80].max())


def _power_law_growth(curves: Sequence[Curve]) -> Statement:
    measured = {}
    for curve in curves:
        slopes = []
        for pulse in (curve.integration, curve.unmodified):
            k, values = curve.over(40, 90, pulse.momentum)
            slopes.append(fit_line(np.log(k), np.log(values))[0][1])
        measured[f"{curve.rate:g}"] = float(slopes[0] / slopes[1])
    claim = (
        "The slope of ln P as a function of ln k, k = 40..90, agrees with that of the BCA to 2% "
        f"(ratio of the two). Neither has reached 3/2: at S = {curves[-1].rate:g} the slope is "
        f"{slopes[1]:.3f} for the BCA and {slopes[0]:.3f} for the simulation"
    )
    return Statement(claim, measured, 0.98, 1.02)


def _saturation(curves: Sequence[Curve]) -> Statement:
    energies = {f"{curve.rate:g}": curve.integration.energy for curve in curves}
    measured = {rate: float(energy[89] / energy[59]) for rate, energy in energies.items()}
    return Statement("The energy saturates: E_90/E_60 is 1 to within 3%", measured, 0.97, 1.0)


def _straight_lines(curves: Sequence[Curve]) -> Statement:
    measured = {}
    for curve in curves:
        k, ratio = curve.over(5, 80, curve.values(curve.integration, "ratio"))
        (intercept, slope), _ = fit_line(k, ratio)
        measured[f"{curve.rate:g}"] = float(np.abs(ratio / (intercept + slope * k) - 1.0).max())
    claim = "The ratio grows linearly with k: it differs from a line by at most 1%, k = 5..80"
    return Statement(claim, measured, 0.0, 0.01)


def _nearly_constant_ratio(curves: Sequence[Curve]) -> Statement:
    measured = {}
    for curve in curves:
        ratio = curve.values(curve.integration, "ratio")[9:]
        measured[f"{curve.rate:g}, least"] = float(1.0 / ratio.max())
        measured[f"{curve.rate:g}, largest"] = float(1.0 / ratio.min())
    claim = "The inverse of the ratio is within 8% of the paper's value 2/3 for k = 10..90"
    return Statement(claim, measured, 2.0 / 3.0 * 0.92, 2.0 / 3.0 * 1.08)


def _energy_kept(curves: Sequence[Curve]) -> Statement:
    energy = curves[0].integration.energy
    measured = {f"{curves[0].rate:g}": float(energy[89] / energy[9])}
    claim = "For the smallest S the energy is constant: E_90/E_10 is 1 to within 1%"
    return Statement(claim, measured, 0.99, 1.01)


def _linear_decay(curves: Sequence[Curve]) -> Statement:
    measured = {}
    for curve in curves:
        slope = fit_line(*curve.over(5, 60, curve.integration.momentum))[0][1]
        measured[f"{curve.rate:g}"] = float(slope / forward_linear_momentum_slope(curve.rate))
    claim = (
        "Momentum decreases linearly, k = 5..60, with 0.55 to 0.70 times the slope of Eq. (24), "
        "the column “Binary” of table 3"
    )
    return Statement(claim, measured, 0.55, 0.70)


def _rate_statement(
    quantity: FigureQuantity, low: float, high: float, claim: str
) -> Callable[[Sequence[Curve]], Statement]:
    """Statement about the ratio of the exponential rates of simulation and BCA, beads 5..80."""

    def statement(curves: Sequence[Curve]) -> Statement:
        measured = {}
        for curve in curves:
            rates = []
            for pulse in (curve.integration, curve.unmodified):
                k, values = curve.over(5, 80, curve.values(pulse, quantity))
                rates.append(fit_line(k, np.log(values))[0][1])
            measured[f"{curve.rate:g}"] = float(rates[0] / rates[1])
        return Statement(claim, measured, low, high)

    return statement


def _error_statement(high: float) -> Callable[[Sequence[Curve]], Statement]:
    def statement(curves: Sequence[Curve]) -> Statement:
        taper = curves[0].theory.chain.taper
        assert taper is not None
        measured, printed = {}, []
        for curve in curves:
            beads = curve.integration.bead.astype(float)
            measured[f"{curve.rate:g}"] = _worst_error(curve, curve.theory.velocity)
            printed.append(_worst_error(curve, printed_velocity(taper, curve.rate, beads)))
        claim = (
            "With recalibrated constants, the velocity of the modified BCA is accurate to "
            f"{high:.0%}, k = 5..80; with the formula as printed, its largest error is "
            f"{min(printed):.0%} to {max(printed):.0%}, depending on the rate"
        )
        return Statement(claim, measured, 0.0, high)

    return statement


STATEMENTS: Final[dict[int, Callable[[Sequence[Curve]], Statement]]] = {
    1: _power_law_growth,
    2: _saturation,
    3: _rate_statement(
        "momentum", 0.985, 1.0,
        "Momentum grows exponentially, 0.985 to 1 times as fast as in the BCA, k = 5..80",
    ),
    4: _rate_statement(
        "energy", 1.1, 1.5,
        "Energy decays exponentially, 1.1 to 1.5 times as fast as in the BCA, k = 5..80",
    ),
    5: _linear_decay,
    6: _energy_kept,
    7: _rate_statement(
        "momentum", 1.0, 1.06,
        "Momentum decays exponentially, 1 to 1.06 times as fast as in the BCA, k = 5..80",
    ),
    8: _rate_statement(
        "energy", 1.8, 2.4,
        "Energy decays exponentially, 1.8 to 2.4 times as fast as in the BCA, k = 5..80",
    ),
    9: _nearly_constant_ratio,
    10: _error_statement(0.14),
    11: _straight_lines,
    12: _error_statement(0.02),
    13: _error_statement(0.05),
    14: _error_statement(0.06),
}  # fmt: skip
