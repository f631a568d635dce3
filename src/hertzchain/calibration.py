r"""Fit the constants of the modified BCA to the simulation, Sec. 5 of the paper.

The paper prints only the fitted constants.  `calibrate` repeats the fit for any tapering
parameters and any range of beads.
"""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from .chain.chain import Chain
from .chain.tapers import PAPER_TAPERS, check_taper, rate_symbol
from .collision import Array
from .errors import InputError, short_repr
from .propagation.propagate import propagate_many
from .representation import counted, short
from .theory.bca import bca
from .theory.modified_bca import (
    Correction,
    PowerLawCorrection,
    RatioCorrection,
    printed_correction,
)
from .validation.json_types import finite
from .validation.keywords import checked_arguments, checked_methods
from .validation.numbers import whole_number
from .validation.objects import Progress, callback, check_choice, check_list

Window = tuple[int, int]

# Tapering parameters of the paper's figures 9 to 14.
RATES: Final[dict[str, tuple[float, ...]]] = {
    "backward-linear": (0.1, 0.3, 0.5, 0.7, 0.9),
    "backward-exponential": (0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08),
    "forward-linear": (0.001, 0.003, 0.005, 0.007, 0.009),
    "forward-exponential": (0.01, 0.02, 0.03, 0.04, 0.05, 0.06),
}
# Beads 5 to 80: the window that reproduces the paper's tables 1 and 2.
WINDOW: Final[Window] = (5, 80)
BEADS: Final = 100


@checked_methods
@dataclass(frozen=True, eq=False)
class Calibration:
    """Fitted constants of one taper's correction, with their errors.

    Attributes
    ----------
    taper : str
        Name of the taper.
    rates : tuple of float
        Tapering parameters of the simulated chains.
    window : tuple of int
        First and last bead of the fit.
    beads : int
        Number of beads of each chain.
    correction : RatioCorrection or PowerLawCorrection
        The fitted correction, as accepted by `modified_bca`.
    standard_errors : dict of str to float
        Standard error of each constant, by name; NaN for one chain, whose error is not known.
    residuals : ndarray, shape (rates, beads in the window)
        Relative errors of the corrected velocity, compared with the simulation.

    Examples
    --------
    >>> import hertzchain as hc
    >>> result = hc.calibrate("forward-linear", rates=(0.001, 0.005), beads=60, window=(5, 50))
    >>> result.worst_error < 0.1
    True
    """

    taper: str
    rates: tuple[float, ...]
    window: Window
    beads: int
    correction: Correction
    standard_errors: dict[str, float]
    residuals: Array

    @property
    def constants(self) -> dict[str, float]:
        """Fitted constants, by name."""
        return {name: getattr(self.correction, name) for name in self.standard_errors}

    def _repr_html_(self) -> str:
        from .notebook.theories import calibration_html

        return calibration_html(self)

    def __repr__(self) -> str:
        first, last = self.window
        return short(
            "Calibration",
            f"{self.taper}, {counted(len(self.rates), 'rate')}, {self.beads} beads, fitted to "
            f"beads {first} to {last}",
            f"{self.correction}",
            f"largest error {self.worst_error:.2%}, rms {self.rms_error:.2%}",
        )

    @property
    def printed(self) -> dict[str, float]:
        """Values of the same constants as printed in the paper, including misprints."""
        correction = printed_correction(self.taper)
        return {name: getattr(correction, name) for name in self.standard_errors}

    @property
    def worst_error(self) -> float:
        """Largest absolute relative error of the velocity within the window."""
        return float(np.abs(self.residuals).max())

    @property
    def rms_error(self) -> float:
        """Root mean square of the relative velocity errors within the window."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def worst_by_rate(self) -> tuple[float, ...]:
        """Largest absolute relative velocity error for each rate."""
        return tuple(float(worst) for worst in np.abs(self.residuals).max(axis=1))

    def as_dict(self) -> dict[str, Any]:
        """Convert to a dictionary of JSON types.

        Returns
        -------
        dict
            Each entry of ``constants`` has a ``value``, a ``standard_error`` and the value
            ``printed`` in the paper.

        Examples
        --------
        >>> import hertzchain as hc
        >>> result = hc.calibrate("backward-linear", rates=(0.5,), beads=30, window=(5, 25))
        >>> list(result.as_dict()["constants"]["ratio"])
        ['value', 'standard_error', 'printed']
        """
        document: dict[str, Any] = {
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
        found: dict[str, Any] = finite(document)
        return found


@checked_arguments("calibrate")
def calibrate(
    taper: str,
    *,
    rates: Sequence[float] | None = None,
    window: Window = WINDOW,
    beads: int = BEADS,
    progress: Progress | None = None,
) -> Calibration:
    r"""Fit the correction of one taper to the simulation.

    For a linear taper the constant is :math:`\rho`, the mean of the ratio
    :math:`v_k/v_k^u` over rates and beads.  For an exponential taper, a straight line
    :math:`v_k^u/v_k = c + d k` is fitted by least squares for each q; then the lines
    :math:`\ln c = \ln c_0 + x \ln q` and :math:`\ln d = \ln d_0 + y \ln q` are fitted,
    Eqs. (36) and (37).

    Parameters
    ----------
    taper : str
        One of the four tapers of the paper.
    rates : sequence of float, optional
        Tapering parameters to simulate.  The default is those of the paper's figures.
    window : tuple of int
        First and last bead k of the fit.
    beads : int
        Number of beads of each chain.  It must exceed ``window[1]``, so that the free end
        does not influence the fit.
    progress : callable, optional
        Called as ``progress(chains_done, chains)``.

    Raises
    ------
    InputError
        If the taper is unknown, a rate is impossible for this number of beads, the window
        is not within the chain, or there are too few rates.
    SimulationError
        If the simulation of one of the chains fails.

    Examples
    --------
    >>> import hertzchain as hc
    >>> result = hc.calibrate("backward-linear", rates=(0.5,), beads=30, window=(5, 25))
    >>> round(result.correction.ratio, 1)
    0.7
    """
    check_choice("taper", taper, PAPER_TAPERS)
    callback("progress", progress)
    given = RATES[taper] if rates is None else check_list("rates", rates, "numbers")
    used = tuple(check_taper(taper, rate) for rate in given)
    needed = 1 if rate_symbol(taper) == "S" else 3
    if len(set(used)) < needed:
        raise InputError(
            f"calibrating {taper} needs at least {needed} different rates, got {_joined(used)}"
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
    """Numbers of the beads in a window, which must be within the chain."""
    beads = whole_number("beads", beads, least=2)
    try:
        first, last = (operator.index(bead) for bead in window)
    except (TypeError, ValueError):
        raise InputError(
            f"a window must be a first and a last bead, such as (5, 80), got {short_repr(window)}"
        ) from None
    if not (first >= 2 and first + 2 <= last < beads):
        raise InputError(
            f"window {first}..{last} must contain at least three beads from 2 to {beads - 1} "
            f"(the chain has {beads} beads, and the last one is a free end)"
        )
    return np.arange(first, last + 1)


def fit_line(x: Array, y: Array) -> tuple[Array, Array]:
    """Fit a line by least squares; return (intercept, slope) and their standard errors."""
    fit, covariance = np.polyfit(x, y, 1, cov=True)
    return fit[::-1], np.sqrt(np.diagonal(covariance))[::-1]


def _fit_ratio(ratios: Array) -> tuple[RatioCorrection, dict[str, float]]:
    # Differences between beads are systematic; only chains are independent samples.
    means = ratios.mean(axis=1)
    error = np.std(means, ddof=1) / np.sqrt(len(means)) if len(means) > 1 else np.nan
    return RatioCorrection(float(np.mean(means))), {"ratio": float(error)}


def _fit_power_laws(
    rates: Array, k: Array, inverse_ratios: Array
) -> tuple[PowerLawCorrection, dict[str, float]]:
    c, d = np.array([fit_line(k.astype(float), row)[0] for row in inverse_ratios]).T
    if np.any(c <= 0.0) or np.any(d <= 0.0):
        raise InputError(
            "c or d of the line c + d k is not positive for some rate and cannot follow a power "
            "law; use larger rates or another window"
        )
    (ln_c0, x), (ln_c0_error, x_error) = fit_line(np.log(rates), np.log(c))
    (ln_d0, y), (ln_d0_error, y_error) = fit_line(np.log(rates), np.log(d))
    c0, d0 = float(np.exp(ln_c0)), float(np.exp(ln_d0))
    errors = {"c0": c0 * ln_c0_error, "x": x_error, "d0": d0 * ln_d0_error, "y": y_error}
    return (
        PowerLawCorrection(c0, float(x), d0, float(y)),
        {name: float(error) for name, error in errors.items()},
    )


def calibrated_toml(calibrations: Sequence[Calibration]) -> str:
    """Write calibrations as TOML text that `calibrated_corrections` can read.

    Parameters
    ----------
    calibrations : sequence of Calibration
        Calibrations of any tapers; ``theory/calibrated.toml`` has all four.

    Returns
    -------
    str
        One table ``[corrections.TAPER]`` per calibration, with its settings and errors in
        comments.

    Examples
    --------
    >>> import hertzchain as hc
    >>> from hertzchain.calibration import calibrated_toml
    >>> result = hc.calibrate("backward-linear", rates=(0.5,), beads=30, window=(5, 25))
    >>> print(calibrated_toml([result]).splitlines()[3])
    [corrections.backward-linear]
    """
    lines = [
        "# Constants of the modified BCA, fitted to the simulation by: hertzchain calibrate",
        "# Each constant is followed by its standard error.",
    ]
    for result in calibrations:
        first, last = result.window
        lines += [
            "",
            f"[corrections.{result.taper}]",
            f"# {rate_symbol(result.taper)} = {_joined(result.rates)}; beads {first}..{last} of "
            f"{result.beads}",
        ]
        for name, error in result.standard_errors.items():
            lines.append(f"{name} = {result.constants[name]:.6g}  # +- {error_text(error)}")
        lines.append(
            f"# velocity error: largest {result.worst_error:.1%}, rms {result.rms_error:.1%}"
        )
    return "\n".join(lines) + "\n"


def error_text(error: float) -> str:
    """A standard error with two digits."""
    return "unknown" if np.isnan(error) else f"{error:.2g}"


def _joined(rates: Sequence[float]) -> str:
    return ", ".join(f"{rate:g}" for rate in rates)
