"""Where the paper contradicts its own equations, shown by numbers.

The errors of velocity formulas are the largest relative ones over beads 5..80 of
chains of 100, against the integration; a range is over the rates of the paper's
figures.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure as MatplotlibFigure

from hertzchain.calibration import RATES
from hertzchain.chain import Chain, Taper, rate_symbol
from hertzchain.contacts import Array
from hertzchain.paper.published import (
    published_correction,
    published_figures,
    published_ratio,
    published_tables,
)
from hertzchain.paper.tables import Pulses
from hertzchain.plotting import COLOURS, house_style
from hertzchain.pulse import Pulse
from hertzchain.simulation import propagate
from hertzchain.theory.bca import (
    backward_linear_prefactor,
    bca,
    exponential_rates,
    forward_linear_momentum_slope,
)
from hertzchain.theory.modified_bca import (
    PowerLawCorrection,
    calibrated_corrections,
    printed_velocity,
)

Formula = Callable[[Pulse], Array]

PRINTED: Final = "as printed"
EXACT_PRODUCT: Final = "with the exact product, Eq. (5)"
PAIRS_EXCHANGED: Final = "with (c0, x) exchanged"
CALIBRATED: Final = "our calibration of the same form"


@dataclass(frozen=True)
class Erratum:
    """A place where the paper's print and its own equations part.

    Attributes
    ----------
    place : str
        Where in the paper.
    printed, follows : str
        What is printed, and what follows from the paper's equations or our integration.
    evidence : tuple of (str, str)
        What was computed, and what came out.
    inference : bool
        Whether our reading is an inference, not a consequence of the paper's equations.
    """

    place: str
    printed: str
    follows: str
    evidence: tuple[tuple[str, str], ...]
    inference: bool = False


# The pairs (c0, x) as they fit the integration: exchanged between the two tapers, and
# with x negative for the backward one.
EXCHANGED: Final[dict[Taper, PowerLawCorrection]] = {
    "backward-exponential": PowerLawCorrection(c0=1.32, x=-0.0252, d0=0.211, y=1.83),
    "forward-exponential": PowerLawCorrection(c0=1.64, x=0.0259, d0=11.1, y=2.57),
}


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
        formulas["with the prefactor of Eq. (28)"] = lambda p: (
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
        exchanged = EXCHANGED[taper]
        formulas[PAIRS_EXCHANGED] = lambda p: exchanged.velocity(
            bca(p.chain).velocity, p.chain.rate, p.bead
        )
    formulas[CALIBRATED] = lambda p: calibrated.velocity(
        bca(p.chain).velocity, p.chain.rate, p.bead
    )
    return formulas


def errata(pulses: Pulses) -> list[Erratum]:
    """The paper's contradictions, with evidence.

    Parameters
    ----------
    pulses : mapping of (taper, rate) to Pulse
        Integrated chains of 100 beads at the rates of `hertzchain.calibration.RATES`.

    Returns
    -------
    list of Erratum
        The four velocity formulas first.

    Examples
    --------
    >>> from hertzchain.paper.reproduction import integrate_chains
    >>> found = errata(integrate_chains(errata_chains()))
    >>> found[0].place
    'Eqs. (38), (39), (42): backward exponential velocity'
    """
    return [
        *_velocity_formulas_misprinted(pulses),
        _ratio_upside_down(pulses),
        _table_of_another_taper(),
        _velocity_decreases(pulses),
        _captions_reversed(pulses),
        _captions_of_ratios(pulses),
        _symbols_of_theory(pulses),
        _wrong_limit(),
        Erratum(
            place="Eq. (3)",
            printed="R_k = R′_k / R_1",
            follows="R_k = R′_k / R′_1: the unscaled first radius, else the equation is circular.",
            evidence=(),
        ),
        Erratum(
            place="Below Eq. (3): the constant α",
            printed="α = M_1 V_1² / [a R′_1^(n+1/2)], with n never defined",
            follows="n = 5/2, the exponent of the Hertz potential: only then is R′_1 α^(2/5) a "
            "length for which Eq. (4) has no constant left.",
            evidence=(),
        ),
    ]


def errata_chains() -> set[tuple[Taper, float]]:
    """The chains whose integration `errata` needs.

    Returns
    -------
    set of (taper, rate)

    Examples
    --------
    >>> len(errata_chains())
    24
    """
    return {(taper, rate) for taper, rates in RATES.items() for rate in rates}


def worst_errors(formula: Formula, taper: Taper, pulses: Pulses) -> list[float]:
    """Largest relative error of a velocity formula over beads 5..80, for each rate.

    Parameters
    ----------
    formula : callable
        From `velocity_formulas`.
    taper : str
        The taper it is for.
    pulses : mapping of (taper, rate) to Pulse
        Integrated chains.

    Returns
    -------
    list of float

    Examples
    --------
    >>> from hertzchain.paper.reproduction import integrate_chains
    >>> pulses = integrate_chains(errata_chains())
    >>> errors = worst_errors(velocity_formulas("forward-linear")["as printed"],
    ...                       "forward-linear", pulses)
    >>> 0.2 < errors[0] < 0.25 and 0.9 < errors[-1] < 1.0
    True
    """
    exact = [pulses[taper, rate] for rate in RATES[taper]]
    return [float(np.abs(formula(pulse) / pulse.velocity - 1.0)[4:80].max()) for pulse in exact]


def printed_and_mended_errors(pulses: Pulses) -> tuple[float, float]:
    """Largest error of the four velocity formulas as printed, and as mended.

    Parameters
    ----------
    pulses : mapping of (taper, rate) to Pulse
        Integrated chains, as for `errata`.

    Returns
    -------
    tuple of float
        Largest relative errors over all tapers, rates and beads 5..80.

    Examples
    --------
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
        Integrated chains, as for `errata`.

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
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


def _range(values: Sequence[float]) -> str:
    return f"{min(values):.1%} to {max(values):.1%}"


def _formula_evidence(taper: Taper, pulses: Pulses) -> tuple[tuple[str, str], ...]:
    formulas = velocity_formulas(taper)
    return tuple(
        (f"largest error of v, k = 5..80, {name}", _range(worst_errors(formula, taper, pulses)))
        for name, formula in formulas.items()
    )


def _velocity_formulas_misprinted(pulses: Pulses) -> list[Erratum]:
    backward = published_correction("backward-exponential")
    forward = published_correction("forward-exponential")
    return [
        Erratum(
            place="Eqs. (38), (39), (42): backward exponential velocity",
            printed=f"c_be = {backward.c0:g} q^{backward.x:g}",
            follows=(
                "c_be = 1.32 q^(-0.0252): the pair (c0, x) seems to have been exchanged with "
                "that of the forward taper, and x to have lost its sign."
            ),
            evidence=_formula_evidence("backward-exponential", pulses),
            inference=True,
        ),
        Erratum(
            place="Eqs. (40), (44): forward exponential velocity",
            printed=f"c_fe = {forward.c0:g} q^{forward.x:g}",
            follows="c_fe = 1.64 q^0.0259: the other half of the same exchange.",
            evidence=_formula_evidence("forward-exponential", pulses),
            inference=True,
        ),
        Erratum(
            place="Eqs. (31), (41): backward linear velocity",
            printed="v_bl = (2/3) k^(-3/2), for every S",
            follows=(
                "v_bl = (2/3) a_bl(S) k^(-3/2): Eqs. (28) to (30) carry a prefactor that depends "
                f"on S, {backward_linear_prefactor(0.1):.4g} at S = 0.1 and "
                f"{backward_linear_prefactor(0.9):.3g} at S = 0.9."
            ),
            evidence=_formula_evidence("backward-linear", pulses),
        ),
        Erratum(
            place="Eq. (43): forward linear velocity",
            printed="v_fl = 0.680 [1 - k/(1+1/S)]^(+3/2)",
            follows="the exponent -3/2 of Eq. (22) and Sec. 5.3.1: the velocity grows.",
            evidence=_formula_evidence("forward-linear", pulses),
        ),
    ]


def _ratio_upside_down(pulses: Pulses) -> Erratum:
    pulse = pulses["forward-exponential", 0.06]
    ratio = pulse.velocity / bca(pulse.chain).velocity
    slopes = np.polyfit(pulse.bead[4:80], np.array([ratio, 1.0 / ratio]).T[4:80], 1)[0]
    return Erratum(
        place="Eq. (34) against Eqs. (39), (42), (44)",
        printed="v / v_u = c + d k, with d > 0",
        follows="v_u / v = c + d k: the final formulas divide, and only so is d positive.",
        evidence=(
            ("slope of v/v_u, forward q = 0.06, k = 5..80", f"{slopes[0]:+.4f}"),
            ("slope of v_u/v, forward q = 0.06, k = 5..80", f"{slopes[1]:+.4f}"),
        ),
    )


def _table_of_another_taper() -> Erratum:
    column = published_tables()["table3"].columns[0]
    linear = [forward_linear_momentum_slope(rate.value) for rate in column.rates]
    exponential = [
        np.expm1(exponential_rates("forward-exponential", rate.value)["momentum"])
        for rate in column.rates
    ]

    def matches(ours: Sequence[float]) -> str:
        pairs = zip(ours, column.bca, strict=True)
        same = sum(round(value, printed.decimals) == printed.value for value, printed in pairs)
        return f"{same} of {len(column.bca)} entries"

    return Erratum(
        place="Table 3: header and caption",
        printed="header q, caption “forward exponentially tapered chains”",
        follows="S and “linearly”: the column “Binary” is -(3/2) S (1+S)².",
        evidence=(
            ("column “Binary” read as a linear taper", matches(linear)),
            ("column “Binary” read as an exponential taper", matches(exponential)),
        ),
    )


def _velocity_decreases(pulses: Pulses) -> Erratum:
    evidence = []
    for taper, rate in (("backward-linear", 0.5), ("backward-exponential", 0.05)):
        v = pulses[taper, rate].velocity  # type: ignore[index]
        evidence.append((f"v_90 / v_10, {taper}, rate {rate:g}", f"{v[89] / v[9]:.3g}"))
    return Erratum(
        place="Secs. 5.1.1 and 5.2: backward tapers",
        printed="“the velocity of the granules increases as k^(-3/2)”, “increases exponentially”",
        follows="it decreases, as Sec. 3 says.",
        evidence=tuple(evidence),
    )


def _captions_reversed(pulses: Pulses) -> Erratum:
    evidence = []
    for name in ("figure4", "figure5"):
        figure = published_figures()[name]
        ends = [pulses[figure.taper, rate].column(figure.quantity) for rate in  # type: ignore[arg-type]
                (figure.rates[0], figure.rates[-1])]  # fmt: skip
        symbol = rate_symbol(figure.taper)
        values = [
            f"{end[89]:.3g} at {symbol} = {rate:g}"
            for end, rate in zip(ends, (figure.rates[0], figure.rates[-1]), strict=True)
            if end is not None
        ]
        evidence.append((f"Fig. {figure.number}, {figure.quantity} of bead 90", ", ".join(values)))
    return Erratum(
        place="Captions of Figs. 4 and 5",
        printed="growing rates “from bottom to top”",
        follows="from top to bottom.",
        evidence=tuple(evidence),
    )


def _captions_of_ratios(pulses: Pulses) -> Erratum:
    ends = {}
    for rate in (0.1, 0.9):
        pulse = pulses["backward-linear", rate]
        ends[rate] = bca(pulse.chain).velocity[89] / pulse.velocity[89]
    return Erratum(
        place="Captions of Figs. 9 and 11",
        printed="ratio of the modified BCA's velocity to the integration's; the text of Sec. 5.1.1 "
        "gives it the value 2/3",
        follows=(
            "the order of the curves, S growing from bottom to top at the right end, is that of "
            "the unmodified BCA over the integration (or that times 2/3); 2/3 is its inverse. "
            "In Fig. 11 the curves of q = 0.01, 0.02 and 0.03 end within 0.3 % of each other, not "
            "in the caption's order."
        ),
        evidence=(
            ("Fig. 9, BCA / integration at bead 90, S = 0.1", f"{ends[0.1]:.4f}"),
            ("Fig. 9, BCA / integration at bead 90, S = 0.9", f"{ends[0.9]:.4f}"),
        ),
        inference=True,
    )


def _symbols_of_theory(pulses: Pulses) -> Erratum:
    excess = [
        float((bca(pulse.chain).energy / pulse.energy)[49])
        for (taper, rate), pulse in pulses.items()
        if rate in RATES[taper]
    ]
    return Erratum(
        place="Captions of Figs. 1 to 8 against Secs. 5.1 to 5.3",
        printed="“the + symbols represent the BCA”; Sec. 5 sees “excellent agreement” of the "
        "rescaled theory in the same figures",
        follows="both cannot be drawn with the same symbol: the BCA of Figs. 1 to 8 lies well "
        "above the integration. We draw the BCA, as the captions say.",
        evidence=(
            ("E of the BCA / E of the integration at bead 50", f"{min(excess):.2f} to "
             f"{max(excess):.2f}"),
        ),
        inference=True,
    )  # fmt: skip


def _wrong_limit() -> Erratum:
    limit = float(1.0 / propagate(Chain.uniform(60)).velocity[49])
    small = 1e-6
    return Erratum(
        place="Eq. (35): c(q) = c0 q^x",
        printed="a power law with x ≠ 0",
        follows=(
            "cannot hold for q → 0, where it goes to 0 or infinity: c must tend to the value of "
            "equal beads. The law serves in the fitted range of q only."
        ),
        evidence=(
            ("v_u / v of equal beads", f"{limit:.6f}"),
            ("1.64 q^0.0259 at q = 1e-6", f"{1.64 * small**0.0259:.4f}"),
        ),
    )
