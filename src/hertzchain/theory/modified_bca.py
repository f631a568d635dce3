r"""The modified BCA: the paper's corrections of the velocity, Sec. 5.

Linear tapers: the velocity of the BCA times one constant ratio.  Exponential
tapers: divided by :math:`c(q) + d(q) k` with power laws in q.  Two sets of
constants come with the package:

``"printed"``
    The four formulas exactly as the paper's summary prints them, Eqs. (41) to
    (44).  All four are misprinted (`hertzchain.paper.errata`); they are here to be
    compared with, not to be used.
``"calibrated"``
    The corrections applied to the exact product of the BCA, with constants that
    `hertzchain.calibration.calibrate` finds from the integration.
"""

from __future__ import annotations

import functools
import tomllib
import warnings
from dataclasses import dataclass
from importlib import resources
from typing import ClassVar, Literal

import numpy as np

from hertzchain.arguments import one_of
from hertzchain.chain.chain import TAPERS, Chain, Taper, rate_symbol
from hertzchain.chain.coverage import check_chain, require
from hertzchain.checks import number, real_numbers
from hertzchain.contacts import Array
from hertzchain.errors import InputError, ModelRangeWarning
from hertzchain.pulse.pulse import Pulse
from hertzchain.theory.bca import bca


@dataclass(frozen=True)
class RatioCorrection:
    r"""Correction of a linear taper: :math:`v_k = \rho\, v_k^u`.

    Attributes
    ----------
    ratio : float
        Velocity of the integration over that of the BCA.

    Examples
    --------
    >>> RatioCorrection(2 / 3).velocity(np.array([1.0, 0.9]), None, np.array([1, 2])).round(2)
    array([0.67, 0.6 ])
    """

    ratio: float
    formula: ClassVar = "v = ratio * v_BCA"

    def velocity(self, unmodified: Array, rate: float | None, k: Array) -> Array:  # noqa: ARG002
        """Corrected velocity of beads k; the rate plays no part."""
        return self.ratio * unmodified


@dataclass(frozen=True)
class PowerLawCorrection:
    r"""Correction of an exponential taper: :math:`v_k = v_k^u / (c_0 q^x + d_0 q^y k)`.

    Eqs. (35) and (39) of the paper; its text defines the inverse ratio, Eq. (34),
    but its formulas divide.

    Attributes
    ----------
    c0, x : float
        Prefactor and exponent of the constant term.
    d0, y : float
        Prefactor and exponent of the term linear in k.

    Examples
    --------
    >>> correction = PowerLawCorrection(c0=1.64, x=0.0259, d0=0.211, y=1.83)
    >>> correction.velocity(np.array([1.0]), 0.05, np.array([20])).round(3)
    array([0.65])
    """

    c0: float
    x: float
    d0: float
    y: float
    formula: ClassVar = "v = v_BCA / (c0 q^x + d0 q^y k)"

    def velocity(self, unmodified: Array, rate: float | None, k: Array) -> Array:
        """Corrected velocity of beads k of a taper with the given q."""
        if rate is None:
            raise InputError("this correction needs the rate q of an exponential taper")
        return np.asarray(unmodified / (self.c0 * rate**self.x + self.d0 * rate**self.y * k))


Correction = RatioCorrection | PowerLawCorrection

# Eqs. (38) and (40): the constants of the two exponential formulas as printed.
PRINTED_EXPONENTIAL: dict[Taper, PowerLawCorrection] = {
    "backward-exponential": PowerLawCorrection(c0=1.64, x=0.0259, d0=0.211, y=1.83),
    "forward-exponential": PowerLawCorrection(c0=1.32, x=0.0252, d0=11.1, y=2.57),
}
# Rates of the paper's figures, for which both sets of constants were found.
FITTED_RATES: dict[Taper, tuple[float, float]] = {
    "backward-linear": (0.1, 0.9),
    "backward-exponential": (0.01, 0.08),
    "forward-linear": (0.001, 0.009),
    "forward-exponential": (0.01, 0.06),
}
PRINTED_RATIO: dict[Taper, float] = {"backward-linear": 2.0 / 3.0, "forward-linear": 0.680}


def modified_bca(
    chain: Chain,
    coefficients: Literal["calibrated", "printed"] | Correction = "calibrated",
) -> Pulse:
    r"""Leading pulse by the modified BCA, Sec. 5 of the paper.

    ====================  ================================================
    taper                 as printed, Eqs. (41) to (44)
    ====================  ================================================
    backward-linear       :math:`\frac23 k^{-3/2}`
    backward-exponential  :math:`v_k^u/(1.64 q^{0.0259} + 0.211 q^{1.83} k)`
    forward-linear        :math:`0.680\,[1 - k/(1+1/S)]^{3/2}`
    forward-exponential   :math:`v_k^u/(1.32 q^{0.0252} + 11.1 q^{2.57} k)`
    ====================  ================================================

    With ``"calibrated"`` constants, linear tapers have :math:`v_k = \rho\,v_k^u` with
    the exact product :math:`v_k^u` of the BCA, and exponential ones the same form as
    printed.  The correction is one of velocity alone: no times, no forces.  The
    constants hold for k = 5..80, q = 0.01..0.08 (backward) or 0.01..0.06 (forward),
    S = 0.1..0.9 (backward) or 0.001..0.009 (forward); see
    `hertzchain.calibration.calibrate`.  Rates outside bring a `ModelRangeWarning`,
    unless the correction is your own.

    Parameters
    ----------
    chain : Chain
        A chain made by `Chain.tapered`.
    coefficients : str or RatioCorrection or PowerLawCorrection
        ``"calibrated"``, ``"printed"``, or a correction of your own.

    Returns
    -------
    Pulse
        Velocity, momentum and energy; bead 1 keeps its strike velocity.

    Raises
    ------
    InputError
        If the chain is not one of the four tapers, or its force is not Hertz',
        for which the constants were found.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.tapered("backward-exponential", 0.05, beads=100)
    >>> errors = hc.modified_bca(chain).compare(hc.propagate(chain)).errors("velocity")
    >>> float(abs(errors[4:80]).max()) < 0.01
    True
    """
    check_chain("modified_bca", chain)
    if chain.taper is None or chain.rate is None:
        raise InputError(
            f"modified_bca needs a tapered chain ({', '.join(TAPERS)}), got {chain.description}; "
            "use bca for any other"
        )
    require(chain, "modified_bca", instead="use simulate")
    if chain.exponent != 1.5:
        raise InputError(
            f"modified_bca has constants for Hertz contacts (exponent 1.5), got p = "
            f"{chain.exponent:g}; use bca"
        )
    if not isinstance(coefficients, Correction):
        one_of("coefficients", coefficients, ("calibrated", "printed"))
    low, high = FITTED_RATES[chain.taper]
    if isinstance(coefficients, str) and not low <= chain.rate <= high:
        warnings.warn(
            f"the constants of the modified BCA were found for {chain.taper} tapers with "
            f"{rate_symbol(chain.taper)} = {low:g}..{high:g}, not {chain.rate:g}",
            ModelRangeWarning,
            stacklevel=2,
        )
    k = np.arange(1, chain.beads + 1)
    if coefficients == "printed":
        velocity = printed_velocity(chain.taper, chain.rate, k)
        method = "modified BCA, printed"
    else:
        if isinstance(coefficients, Correction):
            correction, method = coefficients, "modified BCA"
        else:
            correction = calibrated_corrections()[chain.taper]
            method = "modified BCA, calibrated"
        velocity = correction.velocity(bca(chain).velocity, chain.rate, k)
    velocity[0] = 1.0
    return Pulse(chain=chain, method=method, velocity=velocity)


def two_thirds_bca(chain: Chain) -> Pulse:
    r"""Leading pulse with two thirds of the velocity of the BCA, for any chain.

    .. math:: v_k = \tfrac23 v_k^u, \qquad k \ge 2

    The paper takes 2/3 as its working value of the ratio :math:`v_k/v_k^u` in backward
    linear tapers (Sec. 5, below Eq. (30)).  It is a good guess for any taper, because equal
    beads have 0.6816.  Momentum and energy follow; times and forces it has none, as those
    of the BCA need its unmodified velocity.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    Pulse
        Velocity, momentum and energy; bead 1 keeps its strike velocity.

    Warns
    -----
    ModelRangeWarning
        As `bca`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> two_thirds_bca(hc.Chain.uniform(3)).velocity.round(4)
    array([1.    , 0.6667, 0.6667])
    """
    ratio = RatioCorrection(PRINTED_RATIO["backward-linear"])
    velocity = ratio.velocity(bca(chain).velocity, None, np.arange(1, chain.beads + 1))
    velocity[0] = 1.0
    return Pulse(chain=chain, method="2/3 BCA", velocity=velocity)


def printed_velocity(taper: Taper, rate: float, k: Array) -> Array:
    """The four formulas of the paper's summary to the letter, misprints included.

    Parameters
    ----------
    taper : str
        Name of the taper.
    rate : float
        Its S or q.
    k : ndarray
        Bead numbers, counted from 1.

    Returns
    -------
    ndarray
        Velocities [scaled].

    Examples
    --------
    >>> printed_velocity("backward-linear", 0.5, np.array([4.0])).round(6)
    array([0.083333])
    """
    one_of("taper", taper, TAPERS)
    rate, k = number("rate", rate), real_numbers("bead", k)
    if taper == "backward-linear":
        return PRINTED_RATIO[taper] * k**-1.5
    if taper == "forward-linear":
        return np.asarray(PRINTED_RATIO[taper] * (1.0 - k / (1.0 + 1.0 / rate)) ** 1.5)
    q = rate if taper == "backward-exponential" else -rate
    unmodified = (0.5 * (1.0 + (1.0 - q) ** -3)) ** (1.0 - k)
    return PRINTED_EXPONENTIAL[taper].velocity(unmodified, rate, k)


def printed_correction(taper: Taper) -> Correction:
    """The correction of a taper with the constants that the paper prints.

    Linear tapers have the ratios of its text, 2/3 and 0.680; exponential ones Eqs. (38)
    and (40).  To be applied to the product of the BCA, which the paper's summary does not
    do for linear tapers; that is `printed_velocity`.

    Parameters
    ----------
    taper : str
        Name of the taper.

    Returns
    -------
    RatioCorrection or PowerLawCorrection

    Examples
    --------
    >>> printed_correction("forward-linear")
    RatioCorrection(ratio=0.68)
    """
    if rate_symbol(taper) == "S":
        return RatioCorrection(PRINTED_RATIO[taper])
    return PRINTED_EXPONENTIAL[taper]


@functools.cache
def calibrated_corrections() -> dict[Taper, Correction]:
    """The corrections that our own calibration found, by taper.

    Returns
    -------
    dict
        From ``calibrated.toml`` beside this module, which
        ``hertzchain calibrate`` writes.

    Examples
    --------
    >>> round(calibrated_corrections()["forward-linear"].ratio, 2)
    0.67
    """
    text = resources.files("hertzchain.theory").joinpath("calibrated.toml").read_text("utf-8")
    constants = tomllib.loads(text)["corrections"]
    return {
        taper: (
            RatioCorrection(constants[taper]["ratio"])
            if taper.endswith("linear")
            else PowerLawCorrection(**constants[taper])
        )
        for taper in TAPERS
    }
