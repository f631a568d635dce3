r"""Find the constants of the modified BCA from the integration, Sec. 5 of the paper.

The paper fits its corrections "once and for all" and prints the result; here the
fit is a function, with its windows as arguments, so that anyone can repeat it.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from hertzchain.chain.chain import TAPERS, Chain, Taper, check_taper, rate_symbol
from hertzchain.contacts import Array
from hertzchain.errors import InputError, unknown_name
from hertzchain.propagation.propagate import propagate_many
from hertzchain.theory.bca import bca
from hertzchain.theory.modified_bca import (
    Correction,
    PowerLawCorrection,
    RatioCorrection,
    printed_correction,
)

Window = tuple[int, int]

# The tapering parameters of the paper's figures 9 to 14.
RATES: Final[dict[Taper, tuple[float, ...]]] = {
    "backward-linear": (0.1, 0.3, 0.5, 0.7, 0.9),
    "backward-exponential": (0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08),
    "forward-linear": (0.001, 0.003, 0.005, 0.007, 0.009),
    "forward-exponential": (0.01, 0.02, 0.03, 0.04, 0.05, 0.06),
}
# Beads 5..80, the window that brings back the paper's tables 1 and 2.
WINDOW: Final[Window] = (5, 80)
BEADS: Final = 100


@dataclass(frozen=True, eq=False)
class Calibration:
    """Constants of one taper's correction and how well they fit.

    Attributes
    ----------
    taper : str
        The taper calibrated.
    rates : tuple of float
        Tapering parameters used.
    window : tuple of int
        First and last bead used.
    beads : int
        Beads of each chain.
    correction : RatioCorrection or PowerLawCorrection
        The constants, to be passed to `modified_bca`.
    standard_errors : dict of str to float
        Standard error of each constant, by name.
    residuals : ndarray, shape (rates, beads in the window)
        Relative errors of the corrected velocity against the integration.

    Examples
    --------
    >>> result = calibrate("forward-linear", rates=(0.001, 0.005), beads=60, window=(5, 50))
    >>> result.worst_error < 0.1
    True
    """

    taper: Taper
    rates: tuple[float, ...]
    window: Window
    beads: int
    correction: Correction
    standard_errors: dict[str, float]
    residuals: Array

    @property
    def constants(self) -> dict[str, float]:
        """The constants found, by name."""
        return {name: getattr(self.correction, name) for name in self.standard_errors}

    @property
    def printed(self) -> dict[str, float]:
        """What the paper prints for the same constants, misprints included."""
        correction = printed_correction(self.taper)
        return {name: getattr(correction, name) for name in self.standard_errors}

    @property
    def worst_error(self) -> float:
        """Largest absolute relative error of velocity within the window."""
        return float(np.abs(self.residuals).max())

    @property
    def rms_error(self) -> float:
        """Root mean square of the relative errors of velocity within the window."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def worst_by_rate(self) -> tuple[float, ...]:
        """Largest absolute relative error of velocity of each rate."""
        return tuple(float(worst) for worst in np.abs(self.residuals).max(axis=1))

    def as_dict(self) -> dict[str, Any]:
        """The calibration as plain data, for JSON.

        Returns
        -------
        dict
            ``constants`` have a ``value``, a ``standard_error`` and what is ``printed``.

        Examples
        --------
        >>> result = calibrate("backward-linear", rates=(0.5,), beads=30, window=(5, 25))
        >>> list(result.as_dict()["constants"]["ratio"])
        ['value', 'standard_error', 'printed']
        """
        return {
            "taper": self.taper,
            "rates": list(self.rates),
            "window": list(self.window),
            "beads": self.beads,
            "constants": {
                name: {
                    "value": value,
                    "standard_error": self.standard_errors[name],
                    "printed": self.printed[name],
                }
                for name, value in self.constants.items()
            },
            "worst_error": self.worst_error,
            "rms_error": self.rms_error,
            "worst_error_by_rate": list(self.worst_by_rate),
        }


def calibrate(
    taper: Taper,
    *,
    rates: Sequence[float] | None = None,
    window: Window = WINDOW,
    beads: int = BEADS,
    progress: Callable[[int, int], None] | None = None,
) -> Calibration:
    r"""Fit the correction of one taper to the integration.

    Linear tapers: :math:`\rho`, the mean over rates and beads of the ratio
    :math:`v_k/v_k^u`.  Exponential tapers: for each q a least-squares line
    :math:`v_k^u/v_k = c + d k`, then lines :math:`\ln c = \ln c_0 + x \ln q` and
    :math:`\ln d = \ln d_0 + y \ln q`, Eqs. (36) and (37).

    Parameters
    ----------
    taper : str
        One of the four tapers.
    rates : sequence of float, optional
        Tapering parameters to integrate; by default those of the paper's figures.
    window : tuple of int
        First and last bead k of the fit in k.
    beads : int
        Beads of each chain, more than ``window[1]`` so that its end is not felt.
    progress : callable, optional
        Called as ``progress(chains_done, chains)``.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        For an unknown taper, a rate that has no chain of so many beads, a window outside
        the chain, or too few rates.
    SimulationError
        If the pulse of one of the chains cannot be followed.

    Examples
    --------
    >>> result = calibrate("backward-linear", rates=(0.5,), beads=30, window=(5, 25))
    >>> round(result.correction.ratio, 1)
    0.7
    """
    if taper not in TAPERS:
        raise unknown_name("taper", taper, TAPERS)
    used = RATES[taper] if rates is None else tuple(check_taper(taper, rate) for rate in rates)
    needed = 1 if rate_symbol(taper) == "S" else 3
    if len(set(used)) < needed:
        raise InputError(
            f"calibrating {taper} needs at least {needed} different rates, got {_listed(used)}"
        )
    k = beads_in_window(window, beads)
    chains = [Chain.tapered(taper, rate, beads=beads) for rate in used]
    pulses = list(propagate_many(chains, progress=progress))
    exact = np.array([pulse.velocity[k - 1] for pulse in pulses])
    unmodified = np.array([bca(pulse.chain).velocity[k - 1] for pulse in pulses])
    correction: Correction
    if rate_symbol(taper) == "S":
        correction, errors = _fit_ratio(exact / unmodified)
    else:
        correction, errors = _fit_power_laws(np.array(used), k, unmodified / exact)
    modified = [correction.velocity(u, q, k) for u, q in zip(unmodified, used, strict=True)]
    residuals = np.array(modified) / exact - 1.0
    return Calibration(taper, used, window, beads, correction, errors, residuals)


def beads_in_window(window: Window, beads: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Bead numbers first..last of a window, checked against the chain.

    Parameters
    ----------
    window : tuple of int
        First and last bead.
    beads : int
        Beads of the chain.

    Returns
    -------
    ndarray

    Raises
    ------
    InputError
        If the window leaves the chain or holds fewer than three beads.

    Examples
    --------
    >>> beads_in_window((5, 8), 100)
    array([5, 6, 7, 8])
    """
    try:
        first, last = (operator.index(bead) for bead in window)
    except (TypeError, ValueError):
        raise InputError(
            f"a window is a first and a last bead, such as (5, 80), got {window!r}"
        ) from None
    if not (first >= 2 and first + 2 <= last < beads):
        raise InputError(
            f"window {first}..{last} must hold at least three beads between 2 and "
            f"{beads - 1}, the last bead before the free end of {beads} beads"
        )
    return np.arange(first, last + 1)


def line(x: Array, y: Array) -> tuple[Array, Array]:
    """Least-squares line: (intercept, slope) and their standard errors.

    Parameters
    ----------
    x, y : ndarray
        At least three points.

    Returns
    -------
    tuple of ndarray
        Both of shape (2,).

    Examples
    --------
    >>> coefficients, errors = line(np.arange(4.0), 1.0 + 2.0 * np.arange(4.0))
    >>> coefficients.round(12)
    array([1., 2.])
    """
    fit = np.polynomial.Polynomial.fit(x, y, 1).convert().coef
    spread = np.sum((x - x.mean()) ** 2)
    variance = np.sum((y - fit[0] - fit[1] * x) ** 2) / (len(x) - 2)
    errors = np.sqrt(variance * np.array([1.0 / len(x) + x.mean() ** 2 / spread, 1.0 / spread]))
    return fit, errors


def _fit_ratio(ratios: Array) -> tuple[RatioCorrection, dict[str, float]]:
    # The spread between beads is systematic, so what counts is the number of chains.
    error = float(np.std(ratios) / np.sqrt(len(ratios)))
    return RatioCorrection(float(np.mean(ratios))), {"ratio": error}


def _fit_power_laws(
    rates: Array, k: Array, inverse_ratios: Array
) -> tuple[PowerLawCorrection, dict[str, float]]:
    c, d = np.array([line(k.astype(float), row)[0] for row in inverse_ratios]).T
    if np.any(c <= 0.0) or np.any(d <= 0.0):
        raise InputError(
            "c + d k has a term that is not positive for some rate, so it follows no power "
            "law; use larger rates or another window"
        )
    (ln_c0, x), (ln_c0_error, x_error) = line(np.log(rates), np.log(c))
    (ln_d0, y), (ln_d0_error, y_error) = line(np.log(rates), np.log(d))
    c0, d0 = float(np.exp(ln_c0)), float(np.exp(ln_d0))
    errors = {"c0": c0 * ln_c0_error, "x": x_error, "d0": d0 * ln_d0_error, "y": y_error}
    return (
        PowerLawCorrection(c0, float(x), d0, float(y)),
        {name: float(error) for name, error in errors.items()},
    )


def calibrated_toml(calibrations: Sequence[Calibration]) -> str:
    """Calibrations as the TOML text that `calibrated_corrections` reads.

    Parameters
    ----------
    calibrations : sequence of Calibration
        Any tapers; the package's own ``theory/calibrated.toml`` has all four.

    Returns
    -------
    str
        A table ``[corrections.TAPER]`` each; how it was found stands in comments.

    Examples
    --------
    >>> result = calibrate("backward-linear", rates=(0.5,), beads=30, window=(5, 25))
    >>> print(calibrated_toml([result]).splitlines()[3])
    [corrections.backward-linear]
    """
    lines = [
        "# Constants of the modified BCA, found from the integration by: hertzchain calibrate",
        "# After each constant follows its standard error.",
    ]
    for result in calibrations:
        first, last = result.window
        lines += [
            "",
            f"[corrections.{result.taper}]",
            f"# {rate_symbol(result.taper)} = {_listed(result.rates)}; beads {first}..{last} of "
            f"{result.beads}",
        ]
        for name, error in result.standard_errors.items():
            lines.append(f"{name} = {result.constants[name]:.6g}  # +- {error:.2g}")
        lines.append(
            f"# error of velocity: worst {result.worst_error:.1%}, rms {result.rms_error:.1%}"
        )
    return "\n".join(lines) + "\n"


def _listed(rates: Sequence[float]) -> str:
    return ", ".join(f"{rate:g}" for rate in rates)
