"""The paper's four velocity formulas: as printed, corrected and recalibrated."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure as MatplotlibFigure

from ..calibration import RATES, WINDOW, Window
from ..chain.tapers import rate_symbol
from ..collision import Array
from ..plotting.looks import method_style
from ..plotting.style import figure_style
from ..pulse.pulse import Pulse
from ..theory.bca import backward_linear_prefactor, bca
from ..theory.modified_bca import (
    PowerLawCorrection,
    calibrated_corrections,
    printed_velocity,
)
from .published import published_correction, published_ratio
from .simulated_chains import Pulses

Formula = Callable[[Pulse], Array]

PRINTED: Final = "as printed"
WITH_PREFACTOR: Final = "with the prefactor of Eq. (28)"
EXACT_PRODUCT: Final = "with the exact product, Eq. (5)"
CONSTANTS_SWAPPED: Final = "with (c0, x) exchanged"
CALIBRATED: Final = "same form, recalibrated"


def velocity_formulas(taper: str) -> dict[str, Formula]:
    """Velocity formula of the paper for a taper: as printed, corrected and recalibrated."""
    calibrated = calibrated_corrections()[taper]

    formulas: dict[str, Formula] = {
        PRINTED: lambda p: printed_velocity(taper, _rate(p), p.bead.astype(float))
    }
    if taper == "backward-linear":
        ratio = published_ratio(taper).value
        formulas[WITH_PREFACTOR] = lambda p: (
            ratio * backward_linear_prefactor(_rate(p)) * p.bead**-1.5
        )
        formulas[EXACT_PRODUCT] = lambda p: ratio * bca(p.chain).velocity
    elif taper == "forward-linear":
        ratio = published_ratio(taper).value
        formulas["with the exponent -3/2 of Eq. (22)"] = lambda p: (
            ratio * (1.0 - p.bead / (1.0 + 1.0 / _rate(p))) ** -1.5
        )
        formulas[EXACT_PRODUCT] = lambda p: ratio * bca(p.chain).velocity
    else:
        exchanged = _exchanged(taper)
        formulas[CONSTANTS_SWAPPED] = lambda p: exchanged.velocity(
            bca(p.chain).velocity, _rate(p), p.bead
        )
    formulas[CALIBRATED] = lambda p: calibrated.velocity(bca(p.chain).velocity, _rate(p), p.bead)
    return formulas


def _rate(pulse: Pulse) -> float:
    """Tapering parameter of the chain of a pulse."""
    rate = pulse.chain.rate
    assert rate is not None
    return rate


def _exchanged(taper: str) -> PowerLawCorrection:
    """Corrected constants: (c0, x) of the other taper, with negative x for the backward taper."""
    other = "forward-exponential" if taper == "backward-exponential" else "backward-exponential"
    pair, own = published_correction(other), published_correction(taper)
    x = -pair.x if taper == "backward-exponential" else pair.x
    return PowerLawCorrection(c0=pair.c0, x=x, d0=own.d0, y=own.y)


def worst_errors(
    formula: Formula, taper: str, pulses: Pulses, *, window: Window = WINDOW
) -> list[float]:
    """Largest relative error of a velocity formula over a window of beads, for each rate."""
    first, last = window
    exact = [pulses[taper, rate] for rate in RATES[taper]]
    return [
        float(np.abs(formula(pulse) / pulse.velocity - 1.0)[first - 1 : last].max())
        for pulse in exact
    ]


def printed_and_corrected_errors(pulses: Pulses) -> tuple[float, float]:
    """Largest error of the four velocity formulas as printed, and as corrected."""
    printed, corrected = [], []
    for taper in RATES:
        formulas = velocity_formulas(taper)
        best = EXACT_PRODUCT if rate_symbol(taper) == "S" else CONSTANTS_SWAPPED
        printed += worst_errors(formulas[PRINTED], taper, pulses)
        corrected += worst_errors(formulas[best], taper, pulses)
    return max(printed), max(corrected)


def draw_formula_errors(pulses: Pulses) -> MatplotlibFigure:
    """Plot the error of each velocity formula along the chain, at the largest rate per taper."""
    styles = {PRINTED: "modified-bca-printed", CALIBRATED: "modified-bca"}
    with figure_style():
        canvas, grid = plt.subplots(2, 2, figsize=(7.6, 5.8), sharex=True)
        for axes, taper in zip(grid.flat, RATES, strict=True):
            rate = RATES[taper][-1]
            pulse = pulses[taper, rate]
            others = iter((("black", "-"), ("0.5", "--")))
            for name, formula in velocity_formulas(taper).items():
                if name in styles:
                    style = method_style(styles[name])
                else:
                    style = dict(zip(("color", "linestyle"), next(others), strict=True))
                error = 100.0 * (formula(pulse) / pulse.velocity - 1.0)
                label = name.replace("(c0, x)", "$(c_0, x)$")
                axes.plot(pulse.bead[4:90], error[4:90], **{**style, "label": label})
            axes.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
            axes.set_title(f"{taper}, ${rate_symbol(taper)}$ = {rate:g}")
            if rate_symbol(taper) == "q":
                axes.set_ylim((-16.0, 16.0) if taper.startswith("backward") else (-6.0, 44.0))
            axes.legend(fontsize=7.5, loc="best")
        for axes in grid[1]:
            axes.set_xlabel("bead $k$")
        for axes in grid[:, 0]:
            axes.set_ylabel("velocity error [%]")
    return canvas
