"""The posterior of a fit, sampled with emcee as a check of the errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..collision import Array
from ..errors import InputError, SimulationError
from ..representation import SUMMARY_WIDTH, counted, folded, short
from ..validation.entries import NoEntries
from ..validation.keywords import checked_methods
from ..validation.memory import check_memory
from ..validation.numbers import whole_number
from ..validation.objects import Progress, callback
from .shown_values import shown_with_error, unit_of_parameter
from .summary_width import summary_width
from .weights import remaining_weights

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from .result import FitResult

MIN_WALKERS: Final = 16
# Smallest number of steps for reliable errors, in autocorrelation times.
LONG_ENOUGH: Final = 50
# Fraction of the steps in which walkers move to points drawn from the distribution of the fit; in
# the others they stretch, which reaches all parts of a posterior that differs from it.
DRAWN: Final = 0.75
# Degrees of freedom of Student's t distribution from which they are drawn: tails that are wider
# than those of the posterior keep the acceptance from falling far from the optimum.
TAILS: Final = 10.0
# Autocorrelation time of the walkers in a Gaussian posterior, and its increase per parameter, in
# steps.  It does not depend on the errors and correlations, because the moves are affine-invariant.
AUTOCORRELATION, PER_PARAMETER = 2.0, 0.1
# Fraction of the steps that is discarded.
BURN_IN: Final = 0.25


@checked_methods
@dataclass(frozen=True, eq=False)
class Posterior(NoEntries):
    """Samples of the posterior of a fit.

    Attributes
    ----------
    names : tuple of str
        Names of the parameters.
    samples : ndarray, shape (n, parameters)
        Values in SI, without the first quarter.
    acceptance : float
        Fraction of the proposals that was accepted.
    autocorrelation : float
        Longest autocorrelation time of the walkers, in steps; NaN if it cannot be estimated.
    steps : int
        Steps of each walker, including those that are discarded.
    estimates : ndarray, shape (parameters,)
        Values of the fit in SI.
    units : tuple of str
        Unit of each parameter, empty for a factor.
    """

    names: tuple[str, ...]
    samples: Array = field(repr=False)
    acceptance: float
    autocorrelation: float
    steps: int
    estimates: Array = field(repr=False)
    units: tuple[str, ...]

    @property
    def means(self) -> dict[str, float]:
        """Mean of each parameter."""
        return dict(zip(self.names, self.samples.mean(axis=0).tolist(), strict=True))

    @property
    def errors(self) -> dict[str, float]:
        """Standard deviation of each parameter."""
        return dict(zip(self.names, self.samples.std(axis=0).tolist(), strict=True))

    @property
    def long_enough(self) -> bool:
        """Whether the walkers took more than 50 autocorrelation times."""
        return bool(self.steps > LONG_ENOUGH * self.autocorrelation)

    def to_xarray(self) -> xr.Dataset:
        """Samples as a dataset over ``sample`` and ``parameter``.

        Returns
        -------
        xarray.Dataset

        Examples
        --------
        >>> import hertzchain as hc
        >>> import numpy as np
        >>> posterior = hc.Posterior(("a",), np.zeros((4, 1)), 0.5, 1.0, 100, np.zeros(1), ("s",))
        >>> dict(posterior.to_xarray().sizes)
        {'sample': 4, 'parameter': 1}
        """
        import xarray as xr

        variables = {"value": (("sample", "parameter"), self.samples)}
        return xr.Dataset(variables, coords={"parameter": list(self.names)})

    def plot(self) -> Figure:
        """Corner plot: histogram of each parameter and scatter of each pair.

        Returns
        -------
        matplotlib.figure.Figure

        Examples
        --------
        >>> import hertzchain as hc
        >>> import numpy as np
        >>> rng = np.random.default_rng(0)
        >>> samples = rng.normal(size=(100, 2))
        >>> names, units, estimates = ("a", "b"), ("s", ""), np.zeros(2)
        >>> len(hc.Posterior(names, samples, 0.5, 1.0, 100, estimates, units).plot().axes)
        3
        """
        from ..plotting.fits import plot_corner

        return plot_corner(self)

    def summary(self, *, width: int | None = SUMMARY_WIDTH) -> str:
        """Mean and standard deviation of each parameter, with the units of the fit, as text.

        Parameters
        ----------
        width
            Number of columns at which lines are broken; None keeps each sentence on one line.

        Returns
        -------
        str

        Examples
        --------
        >>> import hertzchain as hc
        >>> import numpy as np
        >>> samples = np.array([[1e-6], [3e-6]])
        >>> units = ("s",)
        >>> posterior = hc.Posterior(("lag",), samples, 0.5, 1.0, 100, np.zeros(1), units)
        >>> print(posterior.summary())
        posterior: 2 samples of 1 parameter
          lag  2.0 +- 1.0 us
        """
        longest = max(map(len, self.names))
        size = f"{counted(len(self.samples), 'sample')} of {counted(len(self.names), 'parameter')}"
        lines = [
            f"posterior: {size}",
            *(f"  {name:<{longest}}  {row}" for name, row in self._rows()),
        ]
        lines += filter(None, [self._too_short()])
        return folded("\n".join(lines), summary_width(width))

    def __str__(self) -> str:
        return self.summary()

    def __repr__(self) -> str:
        rows = ", ".join(f"{name} = {row}" for name, row in self._rows())
        return short("Posterior", f"{len(self.samples)} samples", self._too_short(), rows)

    def _repr_html_(self) -> str:
        from ..notebook.fits import posterior_html

        return posterior_html(self)

    def _rows(self) -> list[tuple[str, str]]:
        """Name, and mean with error and unit, of each parameter."""
        means, errors = self.means, self.errors
        return [
            (name, shown_with_error(means[name], errors[name], unit))
            for name, unit in zip(self.names, self.units, strict=True)
        ]

    def _too_short(self) -> str:
        """A sentence if there are too few steps for reliable errors."""
        if self.long_enough:
            return ""
        if np.isnan(self.autocorrelation):
            return (
                f"{self.steps} steps are too few to estimate their autocorrelation: take about "
                f"{steps_needed(len(self.names))}"
            )
        least = int(LONG_ENOUGH * self.autocorrelation) + 1
        return (
            f"only {self.steps} steps, too few for an autocorrelation of "
            f"{self.autocorrelation:.0f} steps: take at least {least}"
        )


def steps_needed(parameters: int) -> int:
    """Steps that a Gaussian posterior of this number of parameters usually needs."""
    return round(LONG_ENOUGH * (AUTOCORRELATION + PER_PARAMETER * parameters))


def moves_from(centre: Array, root: Array) -> list[tuple[Any, float]]:
    """Moves of walkers, and their shares, for a posterior near a normal distribution.

    ``root`` times its transpose is the covariance of this distribution.
    """
    from emcee.moves import MHMove, StretchMove

    return [(MHMove(_drawn(centre, root)), DRAWN), (StretchMove(), 1.0 - DRAWN)]


def _drawn(centre: Array, root: Array) -> Callable[..., tuple[Array, Array]]:
    """Proposals of an independence sampler from Student's t distribution.

    The second value is the logarithm of the ratio of the densities of the proposal at the old and
    the new points.
    """
    inverse, count = np.linalg.pinv(root), len(centre)

    def log_density(points: Array) -> Array:
        distance = ((points - centre) @ inverse.T) ** 2
        return np.asarray(-0.5 * (TAILS + count) * np.log1p(distance.sum(axis=1) / TAILS))

    def proposed(points: Array, random: Any) -> tuple[Array, Array]:
        shape = random.normal(size=points.shape)
        widths = np.sqrt(TAILS / random.chisquare(TAILS, size=(len(points), 1)))
        new = centre + (widths * shape) @ root.T
        return new, log_density(points) - log_density(new)

    return proposed


def _root_of_covariance(jacobian: Array) -> Array:
    """Matrix whose product with its transpose is the covariance of the variables."""
    inverse = np.linalg.pinv(jacobian, rcond=1e-10)
    vectors, values, _ = np.linalg.svd(inverse @ inverse.T)
    return np.asarray(vectors * np.sqrt(values))


def sample(result: FitResult, steps: int, seed: int, progress: Progress | None) -> Posterior:
    """Sample the posterior from the optimum of a fit; `FitResult.sample` documents it."""
    steps = whole_number("steps", steps, least=10)
    seed = whole_number("seed", seed, least=0, most=2**32 - 1)
    callback("progress", progress)
    try:
        import emcee
    except ImportError:
        raise InputError(
            "sampling requires emcee, which is not installed: pip install '.[fit]' in the folder "
            "of the source code"
        ) from None
    problem = result.problem
    low, high = problem.bounds()
    weights = remaining_weights(problem, result._residual_vector)

    def log_probability(variables: Array) -> float:
        if np.any(variables < low) or np.any(variables > high):
            return -np.inf
        try:
            residuals = weights * problem.residuals(variables)
        except (SimulationError, InputError):
            return -np.inf
        squares = float(residuals @ residuals)
        return -0.5 * squares if np.isfinite(squares) else -np.inf

    count = len(result.variables)
    walkers = max(MIN_WALKERS, 2 * count + 2)
    needed = 8 * steps * walkers * (count + 1)
    check_memory(f"{steps} steps of {walkers} walkers", needed, "use fewer steps")
    random = np.random.default_rng(seed)
    root = _root_of_covariance(weights[:, None] * result.jacobian)
    begin = result.variables + random.normal(size=(walkers, count)) @ root.T
    begin = np.clip(begin, low + 1e-9, high - 1e-9)
    moves = moves_from(result.variables, root)
    sampler: Any = emcee.EnsembleSampler(walkers, count, log_probability, moves=moves)
    # The wrapper of emcee prints all interruptions to stdout, among the results of commands.
    sampler.log_prob_fn = log_probability
    sampler.random_state = np.random.RandomState(seed).get_state()
    try:
        for done, _ in enumerate(sampler.sample(begin, iterations=steps), start=1):
            if progress is not None:
                progress(done, steps)
    except ValueError as error:
        # Walkers that differ in fewer directions than there are parameters.
        reasons = "; ".join(str(each) for each in result.weak) or str(error)
        raise InputError(
            "the posterior cannot be sampled, because the data do not determine all parameters: "
            f"{reasons}; fix one of them, or give it a prior"
        ) from None
    kept = sampler.get_chain(discard=int(BURN_IN * steps), flat=True)
    model = problem.model
    values = np.array([[*model.values(each).values()] for each in kept])
    try:
        length = float(np.max(sampler.get_autocorr_time(tol=0)))
    except (ValueError, FloatingPointError):
        length = np.nan
    accepted = float(np.mean(sampler.acceptance_fraction))
    units = tuple(unit_of_parameter(each, result.traces) for each in model.parameters)
    return Posterior(result.names, values, accepted, length, steps, result.estimates, units)
