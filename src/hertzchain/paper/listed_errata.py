"""Errata: contradictions within the paper, each with numerical evidence.

Errors of velocity formulas are the largest relative errors over beads 5..80 of chains of
100 beads, compared with the simulation; ranges are over the rates of the paper's figures.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Final

import numpy as np

from ..calibration import RATES
from ..chain.chain import Chain
from ..chain.tapers import rate_symbol
from ..chain.walls import Wall
from ..propagation.propagate import propagate
from ..simulation.simulate import simulate
from ..theory.bca import (
    backward_linear_prefactor,
    bca,
    exponential_rates,
    forward_linear_momentum_slope,
)
from ..validation.keywords import checked_arguments
from .erratum import Erratum, Evidence
from .published import (
    published_correction,
    published_figures,
    published_tables,
)
from .simulated_chains import Pulses, integrate_chains
from .velocity_formulas import (
    EXACT_PRODUCT,
    WITH_PREFACTOR,
    velocity_formulas,
    worst_errors,
)

# Tables and figures that an erratum concerns.
CONCERNED: Final = frozenset({"table3", *(f"figure{number}" for number in range(1, 15))})


def errata_chains() -> set[tuple[str, float]]:
    """Chains whose simulation `errata` requires."""
    return {(taper, rate) for taper, rates in RATES.items() for rate in rates}


@checked_arguments("errata")
def errata(pulses: Pulses | None = None, parts: Collection[str] | None = None) -> list[Erratum]:
    """All errata of the paper, with evidence, or those that concern some tables and figures.

    Parameters
    ----------
    pulses : mapping of (str, float) to Pulse, optional
        Simulated pulses by taper and rate, such as ``Reproduction.pulses``.  By default, the chains
        of `errata_chains` are simulated.
    parts : collection of str, optional
        Names of tables and figures, such as ``{"table1", "figure14"}``.

    Examples
    --------
    >>> from hertzchain.paper import errata
    >>> errata()[0].place
    'Eqs. (38), (39), (42): backward exponential velocity'
    """
    if pulses is None:
        pulses = integrate_chains(errata_chains())
    found = [
        *_velocity_formulas_misprinted(pulses),
        _ratio_upside_down(pulses),
        _expansion_not_small(pulses),
        _wrong_limit(),
        _prefactor_of_forward_linear(),
        _table_of_another_taper(),
        _velocity_decreases(pulses),
        _captions_reversed(pulses),
        _captions_of_ratios(pulses),
        _symbols_of_theory(pulses),
        *_slips(),
    ]
    if parts is None:
        return [*found, _derivative_of_velocity(pulses), _elastic_wall()]
    return [erratum for erratum in found if not set(parts).isdisjoint(erratum.concerns)]


def _range(values: Sequence[float]) -> str:
    return f"{min(values):.1%} to {max(values):.1%}"


def _formula_evidence(taper: str, pulses: Pulses) -> Evidence:
    return tuple(
        (f"largest error of v, k = 5..80, {name}", _range(worst_errors(formula, taper, pulses)))
        for name, formula in velocity_formulas(taper).items()
    )


def _velocity_formulas_misprinted(pulses: Pulses) -> list[Erratum]:
    backward = published_correction("backward-exponential")
    forward = published_correction("forward-exponential")
    linear = velocity_formulas("backward-linear")
    far = tuple(
        (
            f"the same, k = 60..90, {name}",
            _range(worst_errors(linear[name], "backward-linear", pulses, window=(60, 90))),
        )
        for name in (WITH_PREFACTOR, EXACT_PRODUCT)
    )
    return [
        Erratum(
            place="Eqs. (38), (39), (42): backward exponential velocity",
            concerns=("figure12",),
            printed=f"$c_be = {backward.c0:g} q^{backward.x:g}$",
            follows=(
                f"$c_be = {forward.c0:g} q^(-{forward.x:g})$: the pair $(c_0, x)$ was apparently "
                "exchanged with that of the forward taper, and x lost its sign."
            ),
            evidence=_formula_evidence("backward-exponential", pulses),
            inference=True,
        ),
        Erratum(
            place="Eqs. (40), (44): forward exponential velocity",
            concerns=("figure14",),
            printed=f"$c_fe = {forward.c0:g} q^{forward.x:g}$",
            follows=f"$c_fe = {backward.c0:g} q^{backward.x:g}$: the other half of this exchange.",
            evidence=_formula_evidence("forward-exponential", pulses),
            inference=True,
        ),
        Erratum(
            place="Eqs. (31), (41): backward linear velocity",
            concerns=("figure10",),
            printed="$v_bl = (2/3) k^(-3/2)$, for every S",
            follows=(
                "$v_bl = (2/3) a^u k^(-3/2)$: Eqs. (28) to (30) contain a prefactor a^u that "
                f"depends on S, {backward_linear_prefactor(0.1):.4g} at S = 0.1 and "
                f"{backward_linear_prefactor(0.9):.3g} at S = 0.9. The power law holds only for "
                "k ≫ 1/S, far from k = 5 at S = 0.1; the exact product of the BCA, which "
                "according to the paper is plotted, is valid for every k."
            ),
            evidence=_formula_evidence("backward-linear", pulses) + far,
        ),
        Erratum(
            place="Eq. (43): forward linear velocity",
            concerns=("figure13",),
            printed="$v_fl = 0.680 [1 - k/(1+1/S)]^(+3/2)$",
            follows="the exponent is $-3/2$, as in Eq. (22) and Sec. 5.3.1: the velocity grows.",
            evidence=_formula_evidence("forward-linear", pulses),
        ),
    ]


def _ratio_upside_down(pulses: Pulses) -> Erratum:
    pulse = pulses["forward-exponential", 0.06]
    ratio = pulse.velocity / bca(pulse.chain).velocity
    slopes = np.polyfit(pulse.bead[4:80], np.array([ratio, 1.0 / ratio]).T[4:80], 1)[0]
    return Erratum(
        place="Eq. (34) compared with Eqs. (39), (42), (44)",
        concerns=("figure11",),
        printed="$v / v^u = c + d k$, with $d > 0$ and $|α - α^u|$ in the exponent before it",
        follows="$v^u / v = c + d k$: the final formulas divide, $α - α^u$ is negative, and d is "
        "positive only in this form.",
        evidence=(
            ("slope of v/v^u, forward q = 0.06, k = 5..80", f"{slopes[0]:+.4f}"),
            ("slope of v^u/v, forward q = 0.06, k = 5..80", f"{slopes[1]:+.4f}"),
        ),
    )


def _expansion_not_small(pulses: Pulses) -> Erratum:
    evidence = []
    for taper, rate in (("backward-exponential", 0.08), ("forward-exponential", 0.06)):
        v = pulses[taper, rate].velocity
        exact = float(np.log(v[79] / v[59]) / 20.0)
        theory = exponential_rates(taper, rate)["velocity"]
        what = f"|α - α^u| k at k = 80, {taper}, q = {rate:g}"
        evidence.append((what, f"{80.0 * abs(exact - theory):.2f}"))
    return Erratum(
        place="Above Eq. (34): the condition $|α - α^u| k ≪ 1$",
        concerns=(
            "figure11",
            "figure14",
        ),
        printed="“we assume $|α - α^u| k ≪ 1$”, for the straight line $c + d k$",
        follows="the condition is not satisfied at the end of the forward chains shown.",
        evidence=tuple(evidence),
    )


def _wrong_limit() -> Erratum:
    limit = float(1.0 / propagate(Chain.uniform(60)).velocity[49])
    printed, small = published_correction("backward-exponential"), 1e-6
    return Erratum(
        place="Eq. (35): $c(q) = c_0 q^x$",
        concerns=(
            "figure12",
            "figure14",
        ),
        printed="a power law with x ≠ 0",
        follows=(
            "the power law cannot hold for q → 0, where it tends to 0 or infinity: c must tend to "
            "the value of equal beads. The law is valid only in the fitted range of q."
        ),
        evidence=(
            ("v^u / v of equal beads", f"{limit:.6f}"),
            (f"c at q = {small:g} as printed", f"{printed.c0 * small**printed.x:.4f}"),
        ),
    )


def _prefactor_of_forward_linear() -> Erratum:
    column = published_tables()["table3"].columns[0]
    exact = [
        float(np.diff(bca(Chain.tapered("forward-linear", rate.value, beads=2)).momentum)[0])
        for rate in column.rates
    ]
    pairs = zip(exact, column.bca, strict=True)
    same = sum(round(value, printed.decimals) == printed.value for value, printed in pairs)
    return Erratum(
        place="Eqs. (22), (24) and the column “Binary” of Table 3",
        concerns=("table3",),
        printed="$v^u = [1 - k/(1+1/S)]^(-3/2)$, which is $(1+S)^(3/2)$ at k = 1; “all the BCA "
        "data … was obtained using the full analytic predictions” (Sec. 3.1)",
        follows=(
            "$v_1 = 1$ requires a factor $(1+S)^(-3/2)$. Without it the slope of Eq. (24), which "
            "is printed in Table 3, exceeds that of the exact product by a factor $(1+S)^(3/2)$."
        ),
        evidence=(
            ("slope at S = 0.01, Eq. (24)", f"{forward_linear_momentum_slope(0.01):.5f}"),
            ("P_2 - P_1 at S = 0.01, exact product", f"{exact[-1]:.5f}"),
            ("entries reproduced by the exact product", f"{same} of {len(exact)}"),
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
        concerns=("table3",),
        printed="header q, caption “forward exponentially tapered chains”",
        follows="S and “linearly”: the column “Binary” is $-(3/2) S (1+S)^2$.",
        evidence=(
            ("column “Binary” read as a linear taper", matches(linear)),
            ("column “Binary” read as an exponential taper", matches(exponential)),
        ),
    )


def _velocity_decreases(pulses: Pulses) -> Erratum:
    evidence = []
    for taper, rate in (("backward-linear", 0.5), ("backward-exponential", 0.05)):
        v = pulses[taper, rate].velocity
        what = f"v_90 / v_10, {taper}, {rate_symbol(taper)} = {rate:g}"
        evidence.append((what, f"{v[89] / v[9]:.3g}"))
    return Erratum(
        place="Secs. 5.1.1 and 5.2: backward tapers",
        concerns=(
            "figure10",
            "figure12",
        ),
        printed="“the velocity of the granules increases as”, and $k^(-3/2)$ in Eq. (28); “the "
        "velocity increases exponentially”",
        follows="the velocity decreases, as stated in Sec. 3.",
        evidence=tuple(evidence),
    )


def _captions_reversed(pulses: Pulses) -> Erratum:
    evidence = []
    for name in ("figure4", "figure5"):
        figure = published_figures()[name]
        symbol = rate_symbol(figure.taper)
        values = []
        for rate in (figure.rates[0], figure.rates[-1]):
            column = pulses[figure.taper, rate].columns()[figure.quantity]
            values.append(f"{column[89]:.3g} at {symbol} = {rate:g}")
        evidence.append((f"Fig. {figure.number}, {figure.quantity} of bead 90", ", ".join(values)))
    return Erratum(
        place="Captions of Figs. 4 and 5",
        concerns=(
            "figure4",
            "figure5",
        ),
        printed="growing rates “from bottom to top”",
        follows="from top to bottom: according to Sec. 3 the energy decreases with q, and "
        "according to Table 3 the momentum decreases faster for larger S.",
        evidence=tuple(evidence),
    )


def _captions_of_ratios(pulses: Pulses) -> Erratum:
    def ends(name: str, count: int) -> str:
        figure = published_figures()[name]
        values = []
        for rate in figure.rates[:: 1 if count > 2 else len(figure.rates) - 1][:count]:
            pulse = pulses[figure.taper, rate]
            ratio = bca(pulse.chain).velocity[89] / pulse.velocity[89]
            values.append(f"{ratio:.4f} at {rate_symbol(figure.taper)} = {rate:g}")
        return ", ".join(values)

    return Erratum(
        place="Captions of Figs. 9 and 11",
        concerns=(
            "figure9",
            "figure11",
        ),
        printed="ratio of the modified BCA's velocity to that of the simulation, rates growing "
        "“from bottom to top”; the text of Sec. 5.1.1 gives the value 2/3 for Fig. 9",
        follows=(
            "the order of the curves is that of the unmodified BCA divided by the simulation (or "
            "2/3 of this ratio), and 2/3 is the inverse ratio. In Fig. 11 the curves of the three "
            "smallest q end too close to each other to be in the caption's order."
        ),
        evidence=(
            ("Fig. 9, BCA / simulation at bead 90", ends("figure9", 2)),
            ("Fig. 11, BCA / simulation at bead 90", ends("figure11", 3)),
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
        place="Captions of Figs. 1 to 8 compared with Secs. 5.1 to 5.3",
        concerns=tuple(f"figure{number}" for number in range(1, 9)),
        printed="“the + symbols represent the BCA”; Sec. 5 finds “excellent agreement” of the "
        "rescaled theory in the same figures (for Figs. 5 and 6, “the agreement … improves "
        "greatly”)",
        follows="the symbols cannot represent both theories: the BCA is well above the "
        "simulation. The BCA is plotted here, as stated in the captions.",
        evidence=(
            (
                "E of the BCA / E of the simulation at bead 50",
                f"{min(excess):.2f} to {max(excess):.2f}",
            ),
        ),
        inference=True,
    )


def _derivative_of_velocity(pulses: Pulses) -> Erratum:
    slopes, rates = [], []
    for (taper, rate), pulse in pulses.items():
        if rate in RATES[taper]:
            both = np.array([bca(pulse.chain).velocity, pulse.velocity])[:, [48, 50]]
            slopes.append(float(np.divide(*np.diff(both)[:, 0])))
            rates.append(float(np.divide(*np.diff(np.log(both))[:, 0])))
    return Erratum(
        place="Introduction: the change of the velocity along the chain",
        printed="“the change of the velocity of the particles, $dv_k/dk$, … is predicted extremely "
        "accurately”, although the BCA overestimates $v_k$",
        follows="$d(ln v_k)/dk$ is predicted accurately: a velocity that is too large by a nearly "
        "constant factor has a derivative that is too large by this factor.",
        evidence=(
            ("dv/dk at k = 50, BCA / simulation", f"{min(slopes):.2f} to {max(slopes):.2f}"),
            ("d(ln v)/dk at k = 50, BCA / simulation", f"{min(rates):.3f} to {max(rates):.3f}"),
        ),
    )


def _elastic_wall() -> Erratum:
    chain = Chain.uniform(40).replace(right_wall=Wall.rigid())
    run = simulate(chain, times=1000)
    pulse, *_ = run.waves()
    ratio = run.wall_force().impulse / pulse.momentum
    return Erratum(
        place="End of Sec. 3: a chain that ends at a wall",
        printed="“If the interaction of the last particle of the chain with the wall is perfectly "
        "elastic, then the momentum traveling down the chain would be transferred to the wall.”",
        follows="an elastic wall reverses the momentum of the pulse, and receives about twice as "
        "much; the momentum itself is transferred if nothing rebounds.",
        evidence=(
            ("impulse on a rigid wall / momentum of the pulse, 40 equal beads", f"{ratio:.2f}"),
        ),
    )


def _slips() -> list[Erratum]:
    return [
        Erratum(
            place="Caption of Fig. 14",
            concerns=("figure14",),
            printed="“the modified BCA, Eq. (39)”",
            follows="Eq. (44), because Eq. (39) has the constants of the backward taper.",
            evidence=(),
        ),
        Erratum(
            place="Sec. 5.3.1",
            concerns=("figure13",),
            printed="“the simulation data can be described by v^u_fl”",
            follows="v_fl, because the superscript u denotes the BCA.",
            evidence=(),
        ),
        Erratum(
            place="Eq. (3)",
            printed="$R_k = R′_k / R_1$",
            follows="$R_k = R′_k / R′_1$, with the unscaled first radius; otherwise the equation "
            "is circular.",
            evidence=(),
        ),
        Erratum(
            place="Below Eq. (3): the constant α",
            printed="$α = M_1 V_1^2 / [a R′_1^(n+1/2)]$, where n is not defined",
            follows="$n = 5/2$, the exponent of the Hertz potential: only then does the unit of "
            "length $R′_1 α^(2/5)$ remove all constants from Eq. (4).",
            evidence=(),
        ),
    ]
