"""The paper's four velocity formulas: as printed, mended, and as we calibrate them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure as MatplotlibFigure

from hertzchain.calibration import RATES, WINDOW, Window
from hertzchain.chain.chain import Taper, rate_symbol
from hertzchain.contacts import Array
from hertzchain.paper.published import published_correction, published_ratio
from hertzchain.paper.tables import Pulses
from hertzchain.plotting.style import COLOURS, house_style
from hertzchain.pulse.pulse import Pulse
from hertzchain.theory.bca import backward_linear_prefactor, bca
from hertzchain.theory.modified_bca import (
    PowerLawCorrection,
    calibrated_corrections,
    printed_velocity,
)

Formula = Callable[[Pulse], Array]

PRINTED: Final = "as printed"
WITH_PREFACTOR: Final = "with the prefactor of Eq. (28)"
EXACT_PRODUCT: Final = "with the exact product, Eq. (5)"
PAIRS_EXCHANGED: Final = "with (c0, x) exchanged"
CALIBRATED: Final = "our calibration of the same form"


def velocity_formulas(taper: Taper) -> dict[str, Formula]:
    """The paper's velocity formula for a taper: as printed, mended, and as we calibrate it.

    Parameters
    ----------
    taper : str
        One of the four tapers.

    Returns
    -------
    dict of str to callable
        Each takes a pulse and returns velocities for its chain, shape (N,).

    Examples
    --------
    >>> list(velocity_formulas("forward-linear"))[0]
    'as printed'
    """
    calibrated = calibrated_corrections()[taper]

    def printed(pulse: Pulse) -> Array:
        assert pulse.chain.rate is not None
        return printed_velocity(taper, pulse.chain.rate, pulse.bead.astype(float))

    formulas: dict[str, Formula] = {PRINTED: printed}
    if taper == "backward-linear":
        ratio = published_ratio(taper).value
        formulas[WITH_PREFACTOR] = lambda p: (
            ratio * backward_linear_prefactor(p.chain.rate or 0.0) * p.bead**-1.5
        )
        formulas[EXACT_PRODUCT] = lambda p: ratio * bca(p.chain).velocity
    elif taper == "forward-linear":
        ratio = published_ratio(taper).value
        formulas["with the exponent -3/2 of Eq. (22)"] = lambda p: (
            ratio * (1.0 - p.bead / (1.0 + 1.0 / (p.chain.rate or 0.0))) ** -1.5
        )
        formulas[EXACT_PRODUCT] = lambda p: ratio * bca(p.chain).velocity
    else:
        exchanged = _exchanged(taper)
        formulas[PAIRS_EXCHANGED] = lambda p: exchanged.velocity(
            bca(p.chain).velocity, p.chain.rate, p.bead
        )
    formulas[CALIBRATED] = lambda p: calibrated.velocity(
        bca(p.chain).velocity, p.chain.rate, p.bead
    )
    return formulas


def _exchanged(taper: Taper) -> PowerLawCorrection:
    """The constants as they fit: (c0, x) of the other taper, x negative if backward."""
    other: Taper = (
        "forward-exponential" if taper == "backward-exponential" else "backward-exponential"
    )
    pair, own = published_correction(other), published_correction(taper)
    x = -pair.x if taper == "backward-exponential" else pair.x
    return PowerLawCorrection(c0=pair.c0, x=x, d0=own.d0, y=own.y)


def worst_errors(
    formula: Formula, taper: Taper, pulses: Pulses, *, window: Window = WINDOW
) -> list[float]:
    """Largest relative error of a velocity formula over a window of beads, for each rate.

    Parameters
    ----------
    formula : callable
        From `velocity_formulas`.
    taper : str
        The taper it is for.
    pulses : mapping of (taper, rate) to Pulse
        Integrated chains.
    window : tuple of int
        First and last bead.

    Returns
    -------
    list of float

    Examples
    --------
    >>> from hertzchain.paper.errata import errata_chains
    >>> from hertzchain.paper.reproduction import integrate_chains
    >>> pulses = integrate_chains(errata_chains())
    >>> errors = worst_errors(velocity_formulas("forward-linear")["as printed"],
    ...                       "forward-linear", pulses)
    >>> 0.2 < errors[0] < 0.25 and 0.9 < errors[-1] < 1.0
    True
    """
    first, last = window
    exact = [pulses[taper, rate] for rate in RATES[taper]]
    return [
        float(np.abs(formula(pulse) / pulse.velocity - 1.0)[first - 1 : last].max())
        for pulse in exact
    ]


def printed_and_mended_errors(pulses: Pulses) -> tuple[float, float]:
    """Largest error of the four velocity formulas as printed, and as mended.

    Parameters
    ----------
    pulses : mapping of (taper, rate) to Pulse
        Integrated chains, at the rates of `hertzchain.calibration.RATES`.

    Returns
    -------
    tuple of float
        Largest relative errors over all tapers, rates and beads 5..80.

    Examples
    --------
    >>> from hertzchain.paper.errata import errata_chains
    >>> from hertzchain.paper.reproduction import integrate_chains
    >>> printed, mended = printed_and_mended_errors(integrate_chains(errata_chains()))
    >>> printed > 1.0 > 0.15 > mended
    True
    """
    printed, mended = [], []
    for taper in RATES:
        formulas = velocity_formulas(taper)
        best = EXACT_PRODUCT if rate_symbol(taper) == "S" else PAIRS_EXCHANGED
        printed += worst_errors(formulas[PRINTED], taper, pulses)
        mended += worst_errors(formulas[best], taper, pulses)
    return max(printed), max(mended)


def draw_formula_errors(pulses: Pulses) -> MatplotlibFigure:
    """Error of each velocity formula along the chain, at the largest rate of each taper.

    Parameters
    ----------
    pulses : mapping of (taper, rate) to Pulse
        Integrated chains, at the rates of `hertzchain.calibration.RATES`.

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> from hertzchain.paper.errata import errata_chains
    >>> from hertzchain.paper.reproduction import integrate_chains
    >>> len(draw_formula_errors(integrate_chains(errata_chains())).axes)
    4
    """
    fixed = {PRINTED: (COLOURS[2], "-"), CALIBRATED: (COLOURS[0], ":")}
    with house_style():
        canvas, grid = plt.subplots(2, 2, figsize=(7.6, 5.8), sharex=True)
        for axes, taper in zip(grid.flat, RATES, strict=True):
            rate = RATES[taper][-1]
            pulse = pulses[taper, rate]
            mended = iter(((COLOURS[1], "--"), (COLOURS[3], "-.")))
            for name, formula in velocity_formulas(taper).items():
                colour, dashes = fixed.get(name) or next(mended)
                error = 100.0 * (formula(pulse) / pulse.velocity - 1.0)
                axes.plot(pulse.bead[4:90], error[4:90], color=colour, linestyle=dashes, label=name)
            axes.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
            axes.set_title(f"{taper}, ${rate_symbol(taper)} = {rate:g}$")
            if rate_symbol(taper) == "q":
                axes.set_ylim(-40.0, 60.0)
            axes.legend(fontsize=7.5, loc="best")
        for axes in grid[1]:
            axes.set_xlabel("bead $k$")
        for axes in grid[:, 0]:
            axes.set_ylabel("error of velocity [%]")
    return canvas
