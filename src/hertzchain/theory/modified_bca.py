r"""The modified BCA: the paper's corrections of the velocity, Sec. 5.

For linear tapers, the velocity of the BCA is multiplied by a constant.  For exponential
tapers, it is divided by :math:`c(q) + d(q) k`, where c and d are power laws in q.  Two
sets of constants are available:

``"printed"``
    The four formulas exactly as printed in the paper's summary, Eqs. (41) to (44).  All
    four contain misprints (`hertzchain.paper.errata`); use them for comparison only.
``"calibrated"``
    The corrections applied to the exact product of the BCA, with constants that
    `hertzchain.calibration.calibrate` fits to the simulation.
"""

from __future__ import annotations

import functools
import math
import tomllib
from dataclasses import dataclass
from importlib import resources
from typing import ClassVar, Final, Literal

import numpy as np

from ..chain.chain import Chain
from ..chain.changed_tapers import taper_behind
from ..chain.tapers import PAPER_TAPERS, check_taper, rate_symbol
from ..collision import HERTZ_EXPONENT, Array
from ..errors import InputError, ModelRangeWarning, warn_user
from ..pulse.chain_units import for_any_units
from ..pulse.pulse import Pulse
from ..validation.keywords import checked_arguments
from ..validation.numbers import bounded_numbers, number
from ..validation.objects import check_choice
from .alternating_masses import MAX_LOSS, losses
from .bca import bca, exponential_rates
from .decoration import small_beads
from .strikers import other_method

# Where the errors are largest; the last bead moves freely.
ERRORS: Final = (
    "least accurate at the first beads and at bead N, which is about 30% too slow within the range "
    "of the fit"
)


@dataclass(frozen=True)
class RatioCorrection:
    r"""Correction of a linear taper: :math:`v_k = \rho\, v_k^u`.

    Attributes
    ----------
    ratio : float
        Velocity of the simulation over that of the BCA.

    Examples
    --------
    >>> import hertzchain as hc
    >>> import numpy as np
    >>> correction = hc.theory.RatioCorrection(2 / 3)
    >>> correction.velocity(np.array([1.0, 0.9]), None, np.array([1, 2])).round(2)
    array([0.67, 0.6 ])
    """

    ratio: float
    formula: ClassVar = "v = ratio * v_BCA"

    def velocity(self, unmodified: Array, rate: float | None, k: Array) -> Array:  # noqa: ARG002
        """Corrected velocity of beads k.

        Parameters
        ----------
        unmodified : ndarray, shape (M,)
            Velocities of the unmodified BCA [scaled].
        rate : float or None
            Rate of the taper; not used.
        k : ndarray of int, shape (M,)
            Bead numbers, counted from 1.

        Returns
        -------
        ndarray, shape (M,)
            Corrected velocities [scaled].

        Examples
        --------
        >>> import hertzchain as hc
        >>> import numpy as np
        >>> hc.theory.RatioCorrection(2 / 3).velocity(np.array([3.0]), None, np.array([1])).round(3)
        array([2.])
        """
        return self.ratio * unmodified


@dataclass(frozen=True)
class PowerLawCorrection:
    r"""Correction of an exponential taper: :math:`v_k = v_k^u / (c_0 q^x + d_0 q^y k)`.

    Eqs. (35) and (39) of the paper.  The text defines the inverse ratio, Eq. (34), but the
    formulas divide.

    Attributes
    ----------
    c0, x : float
        Prefactor and exponent of the constant term.
    d0, y : float
        Prefactor and exponent of the term linear in k.

    Examples
    --------
    >>> import hertzchain as hc
    >>> import numpy as np
    >>> correction = hc.theory.PowerLawCorrection(c0=1.64, x=0.0259, d0=0.211, y=1.83)
    >>> correction.velocity(np.array([1.0]), 0.05, np.array([20])).round(3)
    array([0.651])
    """

    c0: float
    x: float
    d0: float
    y: float
    formula: ClassVar = "v = v_BCA / (c0 q^x + d0 q^y k)"

    def velocity(self, unmodified: Array, rate: float | None, k: Array) -> Array:
        """Corrected velocity of beads k.

        Parameters
        ----------
        unmodified : ndarray, shape (M,)
            Velocities of the unmodified BCA [scaled].
        rate : float or None
            Rate q of the taper.
        k : ndarray of int, shape (M,)
            Bead numbers, counted from 1.

        Returns
        -------
        ndarray, shape (M,)
            Corrected velocities [scaled].

        Raises
        ------
        InputError
            If ``rate`` is None.

        Examples
        --------
        >>> import hertzchain as hc
        >>> import numpy as np
        >>> correction = hc.theory.PowerLawCorrection(c0=1.0, x=0.0, d0=0.5, y=0.0)
        >>> correction.velocity(np.array([3.0]), 0.05, np.array([1])).round(3)
        array([2.])
        """
        if rate is None:
            raise InputError("this correction requires the rate q of an exponential taper")
        return np.asarray(unmodified / (self.c0 * rate**self.x + self.d0 * rate**self.y * k))


Correction = RatioCorrection | PowerLawCorrection

# Constants of the two exponential formulas as printed, Eqs. (38) and (40).
PRINTED_EXPONENTIAL: dict[str, PowerLawCorrection] = {
    "backward-exponential": PowerLawCorrection(c0=1.64, x=0.0259, d0=0.211, y=1.83),
    "forward-exponential": PowerLawCorrection(c0=1.32, x=0.0252, d0=11.1, y=2.57),
}
# Rates of the paper's figures, to which both sets of constants were fitted.
FITTED_RATES: dict[str, tuple[float, float]] = {
    "backward-linear": (0.1, 0.9),
    "backward-exponential": (0.01, 0.08),
    "forward-linear": (0.001, 0.009),
    "forward-exponential": (0.01, 0.06),
}
PRINTED_RATIO: dict[str, float] = {"backward-linear": 2.0 / 3.0, "forward-linear": 0.680}


@checked_arguments("modified_bca")
@for_any_units("modified_bca", alternative=other_method)
def modified_bca(
    chain: Chain,
    coefficients: Literal["calibrated", "printed"] | Correction = "calibrated",
) -> Pulse:
    r"""Leading pulse by the modified BCA of the paper.

    Section 5 of the paper determines these corrections.

    ====================  ================================================
    taper                 as printed, Eqs. (41) to (44)
    ====================  ================================================
    backward-linear       :math:`\frac23 k^{-3/2}`
    backward-exponential  :math:`v_k^u/(1.64 q^{0.0259} + 0.211 q^{1.83} k)`
    forward-linear        :math:`0.680\,[1 - k/(1+1/S)]^{3/2}`
    forward-exponential   :math:`v_k^u/(1.32 q^{0.0252} + 11.1 q^{2.57} k)`
    ====================  ================================================

    With ``"calibrated"`` constants, the velocity is :math:`v_k = \rho\,v_k^u` for linear tapers,
    where :math:`v_k^u` is the exact product of the BCA, and has the printed form for exponential
    tapers.  Only velocities are corrected; times and forces are not available.  The constants
    were fitted for k = 5..80, q = 0.01..0.08 (backward) or 0.01..0.06 (forward), and S =
    0.1..0.9 (backward) or 0.001..0.009 (forward); see `hertzchain.calibration.calibrate`.

    Parameters
    ----------
    chain : Chain
        A chain whose radii are those of one of the four tapers within rounding, in scaled variables
        or in SI units, such as ``Chain.tapered`` with a rate, ``first_diameter`` and a material.
    coefficients : str or RatioCorrection or PowerLawCorrection
        ``"calibrated"``, ``"printed"``, or a custom correction.

    Returns
    -------
    Pulse
        Velocity, momentum and energy; bead 1 keeps its impact velocity.

    Raises
    ------
    InputError
        If the chain is not one of the four tapers of the paper, or its contacts are not Hertz
        contacts.

    Warns
    -----
    ModelRangeWarning
        If the rate is outside the fitted range, unless the correction is a custom one.

    Notes
    -----
    The theory does not estimate its error (``velocity_error`` is `None`).  `scoreboard` measures
    it: within the fitted rates and from bead 10 on, errors of velocities reach 0.8% in backward
    exponential tapers and 14% in others.  At the first beads, where the pulse forms, they are
    larger (6 to 22% at bead 2), and at the last bead, which moves freely, the velocity is too small
    by about 30%.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain.tapered("backward-exponential", 0.05, beads=100)
    >>> errors = hc.modified_bca(chain).compare(hc.propagate(chain)).errors("velocity")
    >>> float(abs(errors[4:80]).max()) < 0.01
    True
    """
    taper, rate = chain.taper, chain.rate
    if taper is None:
        # A chain in SI units has sizes, and none of the names of tapers.
        taper, parameters = taper_behind(chain.radii)
        rate = dict(parameters).get("rate")
    if taper not in FITTED_RATES or rate is None:
        raise InputError(
            f"the modified BCA requires a tapered chain ({', '.join(FITTED_RATES)}), got "
            f"{chain.description}; {_advice(chain)}"
        )
    if chain.exponents != HERTZ_EXPONENT:
        raise InputError(
            f"the modified BCA has constants for Hertz contacts (exponent 1.5), got p = "
            f"{chain.exponents:g}; {_advice(chain)}"
        )
    if not isinstance(coefficients, Correction):
        check_choice("coefficients", coefficients, ("calibrated", "printed"))
    low, high = FITTED_RATES[taper]
    if isinstance(coefficients, str) and not low <= rate <= high:
        warn_user(
            f"the constants of the modified BCA were fitted to {taper} tapers with "
            f"{rate_symbol(taper)} = {low:g}..{high:g}, but this chain has {rate:g}",
            ModelRangeWarning,
        )
    k = np.arange(1, chain.beads + 1)
    if coefficients == "printed":
        velocity = printed_velocity(taper, rate, k)
        method = "modified BCA, printed"
    else:
        if isinstance(coefficients, Correction):
            correction, method = coefficients, "modified BCA"
        else:
            correction = calibrated_corrections()[taper]
            method = "modified BCA"
        velocity = correction.velocity(bca(chain).velocity, rate, k)
    velocity[0] = 1.0
    notes = {"velocity": ERRORS} if coefficients == "calibrated" else {}
    return Pulse(chain=chain, method=method, velocity=velocity, notes=notes)


def _advice(chain: Chain) -> str:
    """Another method for a chain; no theory of single collisions if the masses alternate."""
    if small_beads(chain.radii).any() or (losses(chain.masses) > MAX_LOSS).any():
        return "use propagate or simulate"
    return "use bca or theory.two_thirds_bca for other chains"


@checked_arguments("two_thirds_bca")
@for_any_units("the BCA", supported=("masses", "stiffness"), alternative="use simulate")
def two_thirds_bca(chain: Chain) -> Pulse:
    r"""Leading pulse of any chain with two thirds of the velocity of the BCA.

    .. math:: v_k = \tfrac23 v_k^u, \qquad k \ge 2

    The paper uses 2/3 as the ratio :math:`v_k/v_k^u` in backward linear tapers (Sec. 5, below
    Eq. (30)).  It is a good estimate for any taper, because the ratio for equal beads is
    0.6816.  Times and forces are not available, because those of the BCA depend on its
    unmodified velocity.

    Parameters
    ----------
    chain : Chain
        Any chain.

    Returns
    -------
    Pulse
        Velocity, momentum and energy; bead 1 keeps its impact velocity.

    Warns
    -----
    ModelRangeWarning
        As for `bca`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.theory.two_thirds_bca(hc.Chain.uniform(3)).velocity.round(4)
    array([1.    , 0.6667, 0.6667])
    """
    ratio = RatioCorrection(PRINTED_RATIO["backward-linear"])
    velocity = ratio.velocity(bca(chain).velocity, None, np.arange(1, chain.beads + 1))
    velocity[0] = 1.0
    return Pulse(chain=chain, method="2/3 BCA", velocity=velocity)


@checked_arguments("printed_velocity")
def printed_velocity(taper: str, rate: float, k: Array) -> Array:
    """Velocity by the four formulas of the paper's summary, including their misprints.

    Parameters
    ----------
    taper : str
        Name of the taper.
    rate : float
        Tapering parameter S or q.
    k : ndarray
        Bead numbers, counted from 1.

    Returns
    -------
    ndarray
        Velocities [scaled].

    Raises
    ------
    InputError
        If the taper is unknown, a bead number is below 1, or the rate is impossible for the
        largest of them.

    Examples
    --------
    >>> import hertzchain as hc
    >>> import numpy as np
    >>> hc.theory.printed_velocity("backward-linear", 0.5, np.array([4.0])).round(6)
    array([0.083333])
    """
    check_choice("taper", taper, PAPER_TAPERS)
    k = bounded_numbers("bead", k, least=1.0)
    rate = check_taper(taper, number("rate", rate), math.ceil(k.max(initial=2.0)))
    if taper == "backward-linear":
        return PRINTED_RATIO[taper] * k**-1.5
    if taper == "forward-linear":
        return np.asarray(PRINTED_RATIO[taper] * (1.0 - k / (1.0 + 1.0 / rate)) ** 1.5)
    unmodified = np.exp((k - 1.0) * exponential_rates(taper, rate)["velocity"])
    return PRINTED_EXPONENTIAL[taper].velocity(unmodified, rate, k)


@checked_arguments("printed_correction")
def printed_correction(taper: str) -> Correction:
    """Correction of a taper with the constants printed in the paper.

    The ratios of linear tapers, 2/3 and 0.680, are in the text; the constants of exponential
    tapers are in Eqs. (38) and (40).  The correction applies to the product of the BCA.  For
    linear tapers, the paper's summary does not use this product (see `printed_velocity`).

    Parameters
    ----------
    taper : str
        Name of the taper.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.theory.printed_correction("forward-linear")
    RatioCorrection(ratio=0.68)
    """
    if rate_symbol(taper) == "S":
        return RatioCorrection(PRINTED_RATIO[taper])
    return PRINTED_EXPONENTIAL[taper]


@functools.cache
def calibrated_corrections() -> dict[str, Correction]:
    """Corrections found by `hertzchain.calibration.calibrate`, by taper."""
    text = resources.files("hertzchain.theory").joinpath("calibrated.toml").read_text("utf-8")
    constants = tomllib.loads(text)["corrections"]
    return {
        taper: (
            RatioCorrection(constants[taper]["ratio"])
            if taper.endswith("linear")
            else PowerLawCorrection(**constants[taper])
        )
        for taper in PAPER_TAPERS
    }
