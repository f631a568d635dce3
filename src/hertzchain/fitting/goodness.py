"""Chi-squared of residuals, and the effective number of samples."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..collision import Array
from .noise import SIGNIFICANT, independent_samples
from .signals import Signal
from .traces import Traces

# Correlations are summed up to this lag, and while they are significant.
MAX_LAG: Final = 200
# The model describes the data if chi-squared exceeds its expectation by fewer standard deviations,
# and if the correlation of successive residuals is smaller, in standard deviations.
MAX_EXCESS, MAX_CORRELATION = 3.0, 4.0
# A chi-squared that is larger than its expectation by this factor does not support the model,
# even if the noise is so uncertain that it does not exclude it either.
FAR: Final = 1.5
# Standard deviations from which a chi-squared is unlikely if the noise is known.
UNLIKELY: Final = 3.0
# Larger numbers of standard deviations are not stated, because they have no meaning.
MANY: Final = 10.0
NO_ERRORS: Final = "; the errors above have no meaning"


@dataclass(frozen=True)
class Goodness:
    """Chi-squared of a fit.

    Attributes
    ----------
    chi2 : float
        Sum of the squared residuals of the data over their noise.
    samples, effective_samples : int, float
        Number of samples, and of independent ones: residuals of real sensors are correlated.
    skipped : int
        Number of valid samples that are not used, because they are next to a jump of the force.
    freedom : int
        Samples minus free parameters.
    uncertainty : float
        Standard deviation of `ratio`: chi-squared scatters, and the noise may have been estimated
        from a few samples.
    correlation : float
        Correlation of successive residuals, in standard deviations, of the signals whose noise is
        not correlated before the pulse begins.  A model that misses something leaves residuals that
        change slowly, even where the noise is hardly known.
    noise_error : float
        Relative standard deviation of chi-squared because the noise of signals was estimated from
        the samples before the pulse; 0 if it was given.
    """

    chi2: float
    samples: int
    effective_samples: float
    skipped: int
    freedom: int
    uncertainty: float
    correlation: float
    noise_error: float = 0.0

    @property
    def ratio(self) -> float:
        """Chi-squared over its expectation."""
        return self.chi2 / max(self.freedom, 1)

    @property
    def excess(self) -> float:
        """Deviation of chi-squared from its expectation, in standard deviations."""
        return (self.ratio - 1.0) / self.uncertainty

    @property
    def describes(self) -> bool:
        """Whether the residuals are consistent with the noise."""
        return self.excess < MAX_EXCESS and self.ratio <= FAR and self._random

    @property
    def undecided(self) -> bool:
        """Whether the noise is too uncertain to accept or to reject the model."""
        # The logarithm of a ratio of two estimated variances is nearly normally distributed
        # (Fisher's z); the ratio itself is not, if one of them has few independent samples.
        possible = self.ratio < np.exp(MAX_EXCESS * self.uncertainty)
        return bool(possible) and self._random and not self.describes

    @property
    def _random(self) -> bool:
        return self.correlation < MAX_CORRELATION

    @property
    def scale(self) -> float:
        """Factor sqrt(chi2/freedom) of all errors if the residuals measure the noise."""
        return float(self.ratio**0.5)

    @property
    def noise_uncertain(self) -> bool:
        """Whether only the uncertainty of the noise makes the residuals consistent with it."""
        known = 2.0 / max(self.effective_samples - (self.samples - self.freedom), 1.0)
        far = abs(self.ratio - 1.0) > UNLIKELY * known**0.5
        return self.describes and self.noise_error > 0.0 and bool(far)

    @property
    def reservation(self) -> str:
        """Addition to the verdict that the model describes the data, if it depends on the noise."""
        if not self.noise_uncertain:
            return ""
        return (
            " within the uncertainty of their noise, which is estimated from the samples before "
            f"the pulse; {self.if_measured}"
        )

    @property
    def if_measured(self) -> str:
        """Advice on the errors, for the case that the residuals measure the noise."""
        return (
            "if you take the noise from the residuals instead, multiply all errors by "
            f"{self.scale:.2f}"
        )

    @property
    def verdict(self) -> str:
        """End of a sentence: whether the model describes the data."""
        if self.describes:
            return f": the model describes the data{self.reservation}"
        if self.undecided:
            return (
                ": whether the model describes the data cannot be decided, because chi2 is known "
                f"to +-{self.uncertainty:.0%} only; give the noise, or record more samples before "
                f"the pulse; {self.if_measured}"
            )
        if self.excess < self.correlation:
            size = f" ({self.correlation:.0f} standard deviations)"
            reason = (
                f"; successive residuals are correlated{size * (self.correlation < MANY)} although "
                "the noise before the pulse is not"
            )
        elif self.excess < MANY:
            reason = f", {self.excess:.0f} standard deviations more than expected"
        else:
            reason = ", far more than expected"
        return f"{reason}: the model does not describe the data{NO_ERRORS}"

    def __str__(self) -> str:
        digits = max(1 - math.floor(math.log10(self.uncertainty)), 0)
        return (
            f"chi2 {self.chi2:.1f} for {self.freedom} degrees of freedom "
            f"({self.effective_samples:.0f} independent samples), "
            f"{self.ratio:.{digits}f} +- {self.uncertainty:.{digits}f} times the expectation"
        )

    @property
    def inflation(self) -> float:
        """Samples per independent sample, the factor of all variances."""
        return self.samples / self.effective_samples


def goodness_of(traces: Traces, residuals: Array, used: Array, parameters: int) -> Goodness:
    """Chi-squared of the weighted residuals that are used, signal after signal."""
    parts, begin = [], 0
    for _, signal in traces:
        count = int(signal.valid.sum())
        own = slice(begin, begin + count)
        parts.append((residuals[own][used[own]], signal))
        begin += count
    effective = sum(_independent(part, signal) for part, signal in parts)
    residuals = residuals[used]
    chi2, count = float(residuals @ residuals), len(residuals)
    freedom = count - parameters
    # The noise of each signal has a separate error.
    noise = sum(
        (len(part) / count) ** 2 * 2.0 / independent_samples(_quiet(signal))
        for part, signal in parts if signal.quiet and not signal.coarse
    )  # fmt: skip
    independent = sum(_independent_noise(part, signal) for part, signal in parts)
    variance = 2.0 / max(independent - parameters, 1.0) + noise
    return Goodness(
        chi2, count, float(effective), int(np.sum(~used)), freedom, float(variance**0.5),
        _correlation(traces, [part for part, _ in parts]), float(noise**0.5),
    )  # fmt: skip


def _independent(residuals: Array, signal: Signal) -> float:
    """Number of independent residuals; of rounded samples, equal successive ones count once."""
    found = len(residuals) / correlation_length(residuals)
    if not signal.coarse:
        return found
    values = signal.values[signal.valid]
    return min(found, 1.0 + np.count_nonzero(np.diff(values)))


def _independent_noise(residuals: Array, signal: Signal) -> float:
    """Number of independent samples of the noise among the residuals.

    An incomplete model has slow residuals, and their own number is then too small: used alone, it
    would excuse them.
    """
    found = _independent(residuals, signal)
    if signal.coarse or not signal.quiet:
        return found
    quiet = _quiet(signal)
    return max(found, len(residuals) * independent_samples(quiet) / len(quiet))


def _quiet(signal: Signal) -> Array:
    quiet = signal.values[: signal.before]
    return quiet[np.isfinite(quiet)]


def _correlation(traces: Traces, residuals: list[Array]) -> float:
    """Correlation of successive residuals in standard deviations, where the noise has none."""
    total, count = 0.0, 0
    for (_, signal), part in zip(traces, residuals, strict=True):
        if _has_white_noise(signal) and len(part) > signal.quiet:
            total += len(part) * float(autocorrelation(part, 1)[-1])
            count += len(part)
    return float(total / count**0.5) if count else 0.0


def _has_white_noise(signal: Signal) -> bool:
    """Whether the samples before the pulse are known not to be correlated."""
    quiet = _quiet(signal) if signal.quiet else np.zeros(0)
    if not len(quiet) or np.ptp(quiet) == 0.0 or signal.coarse:
        return False
    return float(autocorrelation(quiet, 1)[-1]) < SIGNIFICANT / len(quiet) ** 0.5


def autocorrelation(residuals: Array, lags: int = MAX_LAG) -> Array:
    """Autocorrelation of residuals from lag 0."""
    centred = residuals - residuals.mean()
    size = float(centred @ centred)
    count = min(lags, len(residuals) - 1)
    if size == 0.0:
        return np.ones(1)
    full = np.correlate(centred, centred, "full")[len(centred) - 1 :]
    return np.asarray(full[: count + 1] / size)


def correlation_length(residuals: Array) -> float:
    """Samples per independent sample, :math:`1 + 2\\sum\\rho`, at least 1."""
    if len(residuals) < 8:
        return 1.0
    rho = autocorrelation(residuals)[1:]
    significant = rho > SIGNIFICANT / len(residuals) ** 0.5
    end = len(rho) if significant.all() else int(np.argmin(significant))
    return float(1.0 + 2.0 * rho[:end].sum())
