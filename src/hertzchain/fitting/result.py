"""The result of a fit: values, errors, correlations, weak directions and quality."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from ..chain.chain import Chain
from ..collision import Array
from ..errors import InputError
from ..representation import SUMMARY_WIDTH, counted, short
from ..traces.traces import Traces
from ..validation.keywords import checked_methods
from ..validation.numbers import number
from ..validation.objects import Progress
from .constants import FixedConstant, Optimum, fixed_constants
from .fitted_file import fitted_toml
from .fitted_restitution import WithRestitution
from .goodness import Goodness
from .loss_laws import ONE_LAW
from .model import Model
from .plausibility import implausible_values
from .prior_conflicts import conflict, deviations_from_priors
from .problem import Problem
from .shown_values import shown_size, shown_value
from .silent_sensors import undetermined
from .systematics import Effect
from .uncertainty import Estimates
from .weak_directions import WeakDirection
from .weights import chi2_by_sensor, residuals_by_sensor

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .posterior import Posterior
    from .without_priors import WithoutPriors


@checked_methods
@dataclass(frozen=True, eq=False)
class FitResult(Estimates, WithRestitution):
    """Parameters of chains and sensors that describe measured traces best.

    Attributes
    ----------
    names : tuple of str
        Names of the free parameters.
    estimates, sigmas : ndarray
        Their values and standard errors in SI units; factors have no unit.  The error is infinite
        at a bound, or if the data do not determine the parameter.
    covariance : ndarray
        Covariance of the values, which accounts for correlated residuals.
    goodness : Goodness
        Chi-squared, effective number of samples, and whether the model describes the data.
    converged, reason : bool, str
        Whether the search ended at a minimum, and why it ended.
    weak : tuple of WeakDirection
        Combinations of parameters that the data do not determine.
    held : tuple of HeldByPriors
        Parameters whose errors come from priors more than from the data.
    effects : tuple of Effect
        Effects of the sensors that the fit does not include, and their influence on the parameters.
    at_bounds : tuple of str
        Parameters at a bound, which have no error.
    chains : tuple of Chain
        The fitted chain of each shot.
    notes : tuple of str
        Further remarks, one sentence each.
    simulations, starts : int
        Number of simulations and of starts.
    advice : tuple of str
        A cause that another fit has confirmed, or what to consider, if the model does not describe
        the data; otherwise an effect of the sensors that the data show, from another fit.
    misread : bool
        Whether the data require another sign, unit or order of columns, or other times.
    explained : bool
        Whether ``advice`` names an error of the data or of the row that explains all, or columns
        in another order.
    scan : str
        Losses from which a poor fit was started again, in words; or empty.
    without_priors : tuple of WithoutPriors
        If the fit contradicts a prior: the fit without it, if the other priors suffice.
    """

    goodness: Goodness
    converged: bool
    reason: str
    weak: tuple[WeakDirection, ...]
    effects: tuple[Effect, ...]
    at_bounds: tuple[str, ...]
    chains: tuple[Chain, ...]
    notes: tuple[str, ...]
    simulations: int
    starts: int
    _penalty: float
    problem: Problem = field(repr=False)
    variables: Array = field(repr=False)
    jacobian: Array = field(repr=False)
    _residual_vector: Array = field(repr=False)
    advice: tuple[str, ...] = ()
    misread: bool = False
    explained: bool = False
    scan: str = ""
    without_priors: tuple[WithoutPriors, ...] = ()

    @property
    def chain(self) -> Chain:
        """The fitted chain, of the first shot."""
        return self.chains[0]

    @property
    def model(self) -> Model:
        """The model with which the traces are predicted."""
        return self.problem.model

    @property
    def traces(self) -> Traces:
        """The data."""
        return self.model.traces

    @property
    def chi2(self) -> float:
        """Sum of the squared residuals of the data over their noise."""
        return self.goodness.chi2

    @property
    def chi2_per_sample(self) -> dict[str, float]:
        """Mean of the squared residuals over their noise, by sensor; 1 is expected."""
        return chi2_by_sensor(self.problem, self._residual_vector)

    def bic(self, inflation: float | None = None) -> float:
        r"""Bayesian information criterion :math:`\chi^2/s + k \ln(n/s)`, priors included.

        G. Schwarz, Ann. Stat. 6, 461 (1978), doi:10.1214/aos/1176344136, for k parameters and n
        samples; s is the number of samples per independent sample.  Samples next to jumps of the
        force, which are not used, contribute 1 each, their expectation.

        Parameters
        ----------
        inflation : float, optional
            The number s; by default that of this fit.  Fits must be compared with the same
            number, because residuals of a wrong model are correlated.

        Returns
        -------
        float

        Examples
        --------
        >>> import hertzchain as hc
        >>> result = hc.fit(*hc.example_experiment())
        >>> result.bic(inflation=1.0) > result.chi2
        True
        """
        good = self.goodness
        s = good.inflation if inflation is None else number("inflation", inflation, above=0.0)
        total, chi2 = good.counted + good.skipped, self.chi2 + good.skipped
        return float(chi2 / s + self._penalty + len(self.names) * np.log(total / s))

    @property
    def describes(self) -> bool:
        """Whether the model describes the data within their noise."""
        return self.goodness.describes

    @cached_property
    def predicted(self) -> list[list[Array]]:
        """Fitted signals of each shot and sensor, at all times."""
        return self.model.predict(self.model.values(self.variables))

    @property
    def at_rest(self) -> list[list[float]]:
        """Fitted signals of each shot and sensor before any pulse arrives."""
        values = self.model.values(self.variables)
        return [self.model.at_rest(shot, values) for shot in range(len(self.chains))]

    @cached_property
    def constants(self) -> tuple[FixedConstant, ...]:
        """Constants of the chain, gains and sampling interval that are taken as exact."""
        return fixed_constants(Optimum(
            self.problem, self.variables, self.jacobian, self._residual_vector, self.estimates,
            self.sigmas, self.chains,
        ))  # fmt: skip

    @property
    def prior_deviations(self) -> dict[str, float]:
        """Values minus those of their priors, in standard deviations of the priors, by name."""
        values = dict(zip(self.model.names, self.estimates.tolist(), strict=True))
        return deviations_from_priors(self.model.parameters, values)

    @property
    def prior_conflict(self) -> str:
        """Priors that the fit contradicts, one by one or together, in words; empty without any."""
        return conflict(self.prior_deviations)

    def residuals(self) -> list[tuple[int, str, Array]]:
        """Shot, sensor, and data minus fit over the noise; NaN where a sample is not used.

        Examples
        --------
        >>> import hertzchain as hc
        >>> result = hc.fit(*hc.example_experiment())
        >>> [name for _, name, _ in result.residuals()]
        ['ball 6', 'ball 11', 'ball 16', 'wall']
        """
        return residuals_by_sensor(self.problem, self.predicted)

    def chain_toml(self) -> str:
        """The fitted chain, of the first shot, as a chain file with seven digits and ``[fit]``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> "[chain.loss]" in hc.fit(*hc.example_experiment()).chain_toml().splitlines()
        True
        """
        parts = self.rows(), self.verdict, self.model.parameters, self.values
        return fitted_toml(self.chain, *parts, self.traces)

    def summary(self, *, width: int | None = SUMMARY_WIDTH) -> str:
        """Values with errors, the verdict and all notes, as text.

        Parameters
        ----------
        width
            Number of columns at which lines are broken; None keeps each sentence on one line.

        Examples
        --------
        >>> import hertzchain as hc
        >>> print(hc.fit(*hc.example_experiment()).summary().splitlines()[0])
        11 parameters from 2560 samples of 4 sensors
        """
        from .result_text import summary_of

        return summary_of(self, width)

    @property
    def _loss_note(self) -> str:
        """A sentence if only one loss law was fitted, and the data do not exclude it."""
        possible = self.goodness.accepted and not self.meaningless
        return ONE_LAW if possible and any("loss." in name for name in self.names) else ""

    def rows(self) -> list[tuple[str, str]]:
        """Name, and value with error and unit, of each parameter.

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.fit(*hc.example_experiment()).rows()[0][0]
        'stiffness'
        """
        if self.meaningless:
            return [(name, "not determined") for name in self.names]
        triples = zip(self.model.parameters, self.estimates, self.sigmas, strict=True)
        unknown = self.undetermined
        return [
            (str(each), "not determined" if str(each) in unknown else shown_value(
                each, self.traces, value, sigma, at_bound=str(each) in self.at_bounds
            ) + shown_size(each, self.traces, self.model.chains, value, sigma))
            for each, value, sigma in triples
        ]  # fmt: skip

    @property
    def verdict(self) -> str:
        """Whether the model describes the data and agrees with the priors."""
        from .result_text import verdict_of

        return verdict_of(self)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Weak directions, effects of sensors or other causes, and notes, one sentence each."""
        from .result_text import warnings_of

        return warnings_of(self)

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Gains and delays of sensors whose data contain no pulse, so that they mean nothing."""
        return undetermined(self.model.parameters, self.traces, self.values, self.errors)

    @property
    def _implausible(self) -> str:
        """A clause on fitted moduli that no material has; empty without any."""
        parameters, known = self.model.parameters, self.model.values(self.variables)
        return implausible_values(parameters, self.model.chains[0], known)

    @property
    def meaningless(self) -> bool:
        """Whether values are not given: they are implausible, or of misread data or of noise."""
        return self.misread or bool(self._implausible) or not self.goodness.explains

    def to_xarray(self) -> xr.Dataset:
        """Labelled dataset: values, errors and correlations over ``parameter``; data and fit.

        Returns
        -------
        xarray.Dataset

        Examples
        --------
        >>> import hertzchain as hc
        >>> result = hc.fit(*hc.example_experiment())
        >>> sorted(result.to_xarray().data_vars)[:3]
        ['ball_11', 'ball_11_fit', 'ball_16']
        """
        from .result_document import result_dataset

        return result_dataset(self)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON: numbers that do not exist are `None`.

        Returns
        -------
        dict

        Examples
        --------
        >>> import hertzchain as hc
        >>> hc.fit(*hc.example_experiment()).as_dict()["converged"]
        True
        """
        from .result_document import result_document

        return result_document(self)

    @overload
    def plot(self) -> Figure: ...
    @overload
    def plot(
        self, sensor: str, *, shot: int = 1, legend: bool = True,
        ax: Axes | Sequence[Axes] | None = None,
    ) -> Axes: ...  # fmt: skip
    def plot(
        self, sensor: str | None = None, *, shot: int = 1, legend: bool = True,
        ax: Axes | Sequence[Axes] | None = None,
    ) -> Axes | Figure:  # fmt: skip
        """Plot data, fit and residuals of every sensor, or of one.

        Parameters
        ----------
        sensor : str, optional
            Name of a sensor; by default, the figure has three panels per sensor.
        shot : int
            Number of the shot of this sensor, from 1.
        legend : bool
            Whether the axes of this sensor have a legend, which one of several sensors needs.
        ax : matplotlib.axes.Axes or pair of them, optional
            Axes for data and fit and, in a pair, for the residuals, instead of a new figure.

        Examples
        --------
        >>> import hertzchain as hc
        >>> result = hc.fit(*hc.example_experiment())
        >>> len(result.plot().axes), len(result.plot("wall").figure.axes)
        (12, 2)
        """
        from ..plotting.fits import plot_fit, plot_fitted_sensor

        if sensor is not None:
            return plot_fitted_sensor(self, sensor, shot=shot, legend=legend, ax=ax)
        if ax is not None:
            raise InputError("ax takes one sensor; give it, such as 'wall'")
        return plot_fit(self)

    def plot_residuals(self) -> Figure:
        """Plot the distribution and the autocorrelation of the residuals.

        Examples
        --------
        >>> import hertzchain as hc
        >>> len(hc.fit(*hc.example_experiment()).plot_residuals().axes)
        2
        """
        from ..plotting.fits import plot_fit_residuals

        return plot_fit_residuals(self)

    def plot_correlations(self) -> Figure:
        """Plot the correlations of the parameters as a map, without its upper half.

        Examples
        --------
        >>> import hertzchain as hc
        >>> figure = hc.fit(*hc.example_experiment()).plot_correlations()
        >>> figure.axes[0].images[0].get_array().shape
        (11, 11)
        """
        from ..plotting.fits import plot_correlations

        return plot_correlations(self)

    def sample(
        self, steps: int = 500, *, seed: int = 0, progress: Progress | None = None
    ) -> Posterior:
        """Sample the posterior with emcee, as a check of the errors; requires the extra ``fit``.

        The density of a parameter without a prior is constant within its bounds: of stiffness,
        moduli, densities, radii, masses, velocities and gains in their logarithm, of others of the
        chain, such as times of losses and gaps, in units of the motion, which depend on the former.
        Priors multiply it.

        Parameters
        ----------
        steps : int
            Steps of each walker; the number of walkers is two more than twice the number of
            parameters, at least 16.  A Gaussian posterior of d parameters needs about 100 + 5 d.
        seed : int
            Seed of the random numbers, 0 .. 2^32 - 1.
        progress : callable, optional
            Called as ``progress(step, steps)``.

        Returns
        -------
        Posterior

        Raises
        ------
        InputError
            If emcee is not installed, the data do not determine all parameters, for fewer than 10
            steps, or a seed out of range.

        Examples
        --------
        >>> import hertzchain as hc
        >>> result = hc.fit(*hc.example_experiment())
        >>> posterior = result.sample(200)  # doctest: +SKIP
        """
        from .posterior import sample

        return sample(self, steps, seed, progress)

    __str__ = summary

    def _repr_html_(self) -> str:
        from ..notebook.fits import fit_html

        return fit_html(self)

    def __repr__(self) -> str:
        told = ", ".join(f"{name} = {row}" for name, row in self.rows())
        more = f"{counted(len(self.warnings), 'warning')}: print(result.summary())"
        return short("FitResult", told, self.verdict, more if self.warnings else "")
