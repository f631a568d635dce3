"""Chi-squared of residuals, and the effective number of samples."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ..collision import Array
from ..traces.noise import (
    MIN_INDEPENDENT,
    SIGNIFICANT,
    autocorrelation,
    independent_samples,
    level_runs,
)
from ..traces.signals import Signal
from ..traces.traces import Traces
from .autocorrelation import MIN_CORRELATED, correlation_length, first_lag

# The model describes the data if chi-squared exceeds its expectation by fewer standard deviations,
# and if the correlation of successive residuals is smaller, in standard deviations.
MAX_EXCESS, MAX_CORRELATION = 3.0, 4.0
# Standard deviations by which the noise may be more correlated than before the pulse.
ALLOWED: Final = 1.0
# A chi-squared that is larger than its expectation by this factor does not support the model,
# even if the noise is so uncertain that it does not exclude it either.
FAR: Final = 1.5
# Standard deviations from which a chi-squared is unlikely if the noise is known.
UNLIKELY: Final = 3.0
# Mean square of the residuals over the noise below which they are not those of noise of this size.
FAR_BELOW: Final = 0.01
# A model explains no more than noise if it reduces chi-squared by less than this value, the square
# of 5 standard deviations, and twice the number of parameters.
EXPLAINED: Final = 25.0
# Larger numbers of standard deviations are not stated, because they have no meaning.
MANY: Final = 10.0
# Values of chi-squared beyond this one are shown with two digits.
LARGE: Final = 1e7
# Ratio of a chi-squared to its expectation above which it is stated without an error, which is that
# of the residuals of a true model.
NO_ERROR: Final = 10.0
NO_ERRORS: Final = ". The errors above have no meaning"
NO_PULSE: Final = (
    ". The model explains no more of the data than noise would, so they contain no pulse"
)


@dataclass(frozen=True)
class Goodness:
    """Chi-squared of a fit.

    Attributes
    ----------
    chi2 : float
        Sum of the squared residuals of the data over their noise.  Of samples that are rounded to
        coarse steps, equal successive ones count as one.
    samples, counted, effective_samples : int, float, float
        Number of samples; of these if equal ones count once; and of independent ones: residuals of
        real sensors are correlated.
    skipped : int
        Number of valid samples that are not used, because they are next to a jump of the force.
    parameters : int
        Number of free parameters, also of those with a prior.
    uncertainty : float
        Standard deviation of `ratio`: chi-squared scatters, and the noise may have been estimated
        from a few samples.
    correlation : float
        Correlation of successive residuals beyond that of the noise before the pulse, in standard
        deviations, of the signals whose noise shows none there.  A model that misses something
        leaves residuals that change slowly, even where the size of the noise is hardly known.
    noise_error : float
        Relative standard deviation of chi-squared because the noise of signals was estimated from
        the samples before the pulse; 0 if it was given.
    noiseless : bool
        Whether no signal has noise: residuals are compared with the accuracy of the simulation.
    explained : float
        Reduction of chi-squared, of independent samples, from that of constant signals.
    independent : mapping
        Number of independent samples of the noise among the residuals of each sensor.
    """

    chi2: float
    samples: int
    counted: float
    effective_samples: float
    skipped: int
    parameters: int
    uncertainty: float
    correlation: float
    noise_error: float
    noiseless: bool = False
    explained: float = np.inf
    independent: Mapping[str, float] = field(default_factory=dict)

    @property
    def freedom(self) -> int:
        """Degrees of freedom: counted samples minus free parameters."""
        return round(self.counted) - self.parameters

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
        """Whether the residuals are consistent with the noise, and the data with a pulse."""
        return self._consistent and self.explains

    @property
    def undecided(self) -> bool:
        """Whether the noise is too uncertain to accept or to reject the model."""
        return self._possible and self.explains

    @property
    def accepted(self) -> bool:
        """Whether the model describes the data, or may do so."""
        return self.describes or self.undecided

    @property
    def explains(self) -> bool:
        """Whether the model explains more of the data than noise would."""
        return self.explained > EXPLAINED + 2.0 * self.parameters

    @property
    def only_noise(self) -> bool:
        """Whether the data may be noise: so are the residuals, and the model explains no more."""
        return not self.explains and (self._consistent or self._possible)

    @property
    def _consistent(self) -> bool:
        return self.excess < MAX_EXCESS and self.ratio <= FAR and self._random

    @property
    def _possible(self) -> bool:
        # The logarithm of a ratio of two estimated variances is nearly normally distributed
        # (Fisher's z); the ratio itself is not, if one of them has few independent samples.
        possible = self.ratio < np.exp(MAX_EXCESS * self.uncertainty)
        return bool(possible) and self._random and not self._consistent

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
        known = 2.0 / max(self.effective_samples - self.parameters, 1.0)
        far = abs(self.ratio - 1.0) > UNLIKELY * known**0.5
        return self._consistent and self.noise_error > 0.0 and bool(far)

    @property
    def reservation(self) -> str:
        """Addition to the verdict that the model describes the data, if it depends on the noise."""
        if self.noiseless:
            return " to the accuracy of the simulation"
        if self.excess < -UNLIKELY:
            text = ". The residuals are smaller than their noise: check it"
            return text if self.ratio < FAR_BELOW else f"{text}. {self.if_measured}"
        if not self.noise_uncertain:
            return ""
        return (
            " within the uncertainty of their noise, which is estimated from the samples before "
            f"the pulse. {self.if_measured}"
        )

    @property
    def if_measured(self) -> str:
        """Advice on the errors, for the case that the residuals measure the noise."""
        return f"If the residuals measure the noise, multiply all errors by {self.scale:.2f}"

    @property
    def verdict(self) -> str:
        """End of a sentence: whether the model describes the data."""
        if self.only_noise:
            return NO_PULSE
        if not self.explains:
            return ". The model explains nothing of the data, so the fit is meaningless"
        if self.describes:
            return f": the model describes the data{self.reservation}"
        if self.undecided:
            return (
                ": whether the model describes the data cannot be decided, because chi2 is known "
                f"only to +-{self.uncertainty:.0%}. {self._more}. {self.if_measured}"
            )
        if self.excess < self.correlation:
            size = f" ({self.correlation:.0f} standard deviations)"
            reason = (
                f". Successive residuals are correlated{size * (self.correlation < MANY)}, the "
                "noise before the pulse is not"
            )
        elif self.excess < MANY:
            reason = f", {self.excess:.0f} standard deviations more than expected"
        else:
            reason = ", far more than expected"
        return f"{reason}: the model does not describe the data{NO_ERRORS}"

    @property
    def _more(self) -> str:
        if self.noise_error == 0.0:
            return "Record more samples"
        return "Give the noise, or record more samples before the pulse"

    def __str__(self) -> str:
        digits = max(1 - math.floor(math.log10(self.uncertainty)), 0)
        samples = f"{self.effective_samples:.0f} independent samples"
        if self.effective_samples < self.freedom:
            samples = (
                f"{self.counted:.0f} samples, correlated as {self.effective_samples:.0f} "
                "independent ones"
            )
        ratio = f"{self.ratio:.{digits}f} +- {self.uncertainty:.{digits}f}"
        if self.ratio > NO_ERROR and self.excess > MANY:
            ratio = rounded_chi2(self.ratio)
        return (
            f"chi2 {rounded_chi2(self.chi2, 1)} for {self.freedom} degrees of freedom ({samples}), "
            f"{ratio} times the expectation"
        )

    @property
    def inflation(self) -> float:
        """Counted samples per independent sample."""
        return self.counted / self.effective_samples


def rounded_chi2(chi2: float, decimals: int = 0) -> str:
    """A value of chi-squared; large ones, which have no meaning, have two digits."""
    if not chi2 >= LARGE:
        return f"{chi2:.{decimals}f}"
    digits, _, power = f"{chi2:.1e}".partition("e")
    return f"{digits}e{int(power)}"


@dataclass(frozen=True, eq=False)
class _Part:
    """The residuals of a signal that are used, and the number of samples that each stands for."""

    signal: Signal
    residuals: Array
    counts: Array
    values: Array
    before: int

    @property
    def counted(self) -> float:
        """Number of samples if equal ones count once."""
        return float(np.sum(1.0 / self.counts))

    @property
    def later(self) -> Array:
        """Residuals after the samples before the pulse."""
        return self.residuals[self.before :]

    @property
    def far_below_noise(self) -> bool:
        """Whether the residuals are not those of the noise, as in simulated data without any.

        Their correlation is then that of small errors of the simulation or of the model.
        """
        squares = float(self.residuals @ self.residuals)
        return not self.signal.noiseless and squares < FAR_BELOW * self.counted

    @property
    def independent(self) -> float:
        """Number of independent residuals."""
        return self.counted / (1.0 if self.far_below_noise else correlation_length(self._series))

    @property
    def _series(self) -> Array:
        """The residuals; of coarse samples, the mean of those with equal successive values."""
        if not self.signal.coarse or not len(self.values):
            return self.residuals
        first = level_runs(self.values)
        lengths = np.diff(np.append(first, len(self.values)))
        return np.asarray(np.add.reduceat(self.residuals * self.counts**0.5, first) / lengths)


def _parts(traces: Traces, residuals: Array, used: Array) -> list[_Part]:
    parts, begin = [], 0
    for _, signal in traces:
        counts = signal.counted
        own = slice(begin, begin + len(counts))
        mask = used[own]
        values = signal.values[signal.valid][mask]
        before = int(mask[: len(signal.quiet_values)].sum())
        parts.append(_Part(signal, residuals[own][mask], counts[mask], values, before))
        begin += len(counts)
    return parts


def correlated_samples(traces: Traces, residuals: Array, used: Array) -> Array:
    """Number of samples per independent one of each signal, for each of its valid samples."""
    return np.concatenate([
        np.full(int(part.signal.valid.sum()), part.counted / part.independent)
        for part in _parts(traces, residuals, used)
    ])  # fmt: skip


def far_below_noise(traces: Traces, residuals: Array, used: Array) -> list[str]:
    """Sensors whose residuals are far smaller than their noise."""
    parts = _parts(traces, residuals, used)
    return list(dict.fromkeys(part.signal.name for part in parts if part.far_below_noise))


def goodness_of(traces: Traces, residuals: Array, used: Array, parameters: int) -> Goodness:
    """Chi-squared of the weighted residuals that are used, signal after signal."""
    parts = _parts(traces, residuals, used)
    residuals = residuals[used]
    chi2, counted = float(residuals @ residuals), sum(part.counted for part in parts)
    # The noise of each signal has a separate error.
    noise = sum((part.counted / counted * _noise_error(part)) ** 2 for part in parts)
    independent: dict[str, float] = {}
    for part in parts:
        name = part.signal.name
        independent[name] = independent.get(name, 0.0) + _independent_noise(part)
    variance = 2.0 / max(sum(independent.values()) - parameters, 1.0) + noise
    return Goodness(
        chi2=chi2,
        samples=len(residuals),
        counted=counted,
        effective_samples=sum(part.independent for part in parts),
        skipped=int(np.sum(~used)),
        parameters=parameters,
        uncertainty=float(variance**0.5),
        correlation=_correlation(parts),
        noise_error=float(noise**0.5),
        noiseless=all(part.signal.noiseless for part in parts),
        independent=independent,
    )


def _noise_error(part: _Part) -> float:
    """Relative standard deviation of the variance of a sample, if its noise was estimated."""
    if not part.signal.quiet or not part.signal.noise:
        return 0.0
    # Errors of rounding are known, but they make the noise less certain; so does the mean.
    return float((2.0 / (_independent_before(part) - 1.0)) ** 0.5)


def _independent_before(part: _Part) -> float:
    """Number of independent samples before the pulse.

    A few samples may show no correlation although the noise is correlated.  Later residuals then
    show more, but not more than these samples allow: those of an incomplete model are slow.
    """
    quiet, later = part.signal.quiet_values, part.later
    found, count = independent_samples(quiet), len(quiet)
    if found < count or not _has_white_noise(part.signal) or len(later) < MIN_CORRELATED:
        return found
    rho = first_lag(later)
    if rho < SIGNIFICANT / len(later) ** 0.5:
        return found
    rho = min(rho, float(np.tanh(np.arctanh(first_lag(quiet)) + ALLOWED / count**0.5)))
    return max(min(found, count * (1.0 - rho) / (1.0 + rho)), MIN_INDEPENDENT)


def _independent_noise(part: _Part) -> float:
    """Number of independent samples of the noise among the residuals.

    An incomplete model has slow residuals, and their own number is then too small: used alone, it
    would excuse them.
    """
    found = part.independent
    if part.signal.coarse or not part.signal.quiet:
        return found
    count = len(part.signal.quiet_values)
    return max(found, len(part.residuals) * _independent_before(part) / count)


def _correlation(parts: Sequence[_Part]) -> float:
    """Correlation of successive residuals beyond that of the noise, in standard deviations.

    A few samples before the pulse do not exclude that the noise is correlated.  The inverse
    hyperbolic tangent of a correlation of n samples has the variance 1/(n - 3) (Fisher's z).
    """
    total, weight = 0.0, 0.0
    for part in parts:
        later, noise = part.later, part.signal.quiet_values
        if _has_white_noise(part.signal) and len(later) >= MIN_CORRELATED:
            own = 1.0 / (1.0 / (len(later) - 3) + 1.0 / (len(noise) - 3))
            total += own * float(np.arctanh(first_lag(later)) - np.arctanh(first_lag(noise)))
            weight += own
    return float(total / weight**0.5) if weight else 0.0


def _has_white_noise(signal: Signal) -> bool:
    """Whether the samples before the pulse do not show a correlation of the noise."""
    quiet = signal.quiet_values if signal.quiet else np.zeros(0)
    if not len(quiet) or np.ptp(quiet) == 0.0 or signal.coarse:
        return False
    return float(autocorrelation(quiet)[1]) < SIGNIFICANT / len(quiet) ** 0.5
