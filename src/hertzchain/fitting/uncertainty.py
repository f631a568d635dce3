"""Errors and correlations of parameters from the derivatives of the residuals."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from ..collision import Array
from ..errors import similar_names
from ..validation.entries import NoEntries
from ..validation.keywords import checked_methods
from .held_by_priors import HeldByPriors, held_by_priors
from .model import Model
from .names import TIME_OFFSET
from .problem import Problem, differences
from .shown_values import unit_of_parameter
from .symmetry import units_of
from .weak_directions import WeakDirection, weak_directions

if TYPE_CHECKING:
    import pandas as pd

# An error above this fraction of the value is reported.
LARGE_ERROR: Final = 1.0


@checked_methods
@dataclass(frozen=True, eq=False)
class Estimates(NoEntries):
    """Values of parameters with standard errors and their covariance, by name."""

    names: tuple[str, ...]
    estimates: Array
    sigmas: Array
    covariance: Array
    # Parameters whose errors come from priors more than from the data.
    held: tuple[HeldByPriors, ...] = field(default=(), kw_only=True)

    @property
    def values(self) -> dict[str, float]:
        """Values by name, in SI."""
        return dict(zip(self.names, self.estimates.tolist(), strict=True))

    @property
    def errors(self) -> dict[str, float]:
        """Standard errors by name, in SI; infinite at a bound or if not determined."""
        return dict(zip(self.names, self.sigmas.tolist(), strict=True))

    def _instead_of_entry(self, name: object) -> str:
        known = name if name in self.names else similar_names(name, self.names).strip("'")
        example = repr(known if known in self.names else self.names[0])
        return f"values[{example}] and errors[{example}] are the value and standard error"

    @property
    def model(self) -> Model:
        """The model whose parameters these are."""
        raise NotImplementedError

    def to_dataframe(self) -> pd.DataFrame:
        """Table with one row per parameter.

        Returns
        -------
        pandas.DataFrame
            Indexed by ``parameter``; columns ``value`` and ``error`` in SI, ``relative_error``,
            which is NaN for a value of zero, and ``unit``.

        Examples
        --------
        >>> import hertzchain as hc
        >>> chain = hc.Chain.from_materials("5 mm", "brass", beads=12).struck_by(velocity="0.1 m/s")
        >>> plan = hc.forecast(chain, ["ball 5"], noise=0.02, interval="1 us", free=["stiffness"])
        >>> f"{plan.to_dataframe().relative_error['stiffness']:.3%}"
        '0.019%'
        """
        import pandas as pd

        sizes = np.where(self.estimates != 0.0, np.abs(self.estimates), np.nan)
        model = self.model
        columns = {
            "value": self.estimates, "error": self.sigmas, "relative_error": self.sigmas / sizes,
            "unit": [unit_of_parameter(each, model.traces) for each in model.parameters],
        }  # fmt: skip
        return pd.DataFrame(columns, index=pd.Index(self.names, name="parameter"))

    @property
    def correlation(self) -> Array:
        """Correlations of the parameters; one without a variance has none."""
        scale = np.sqrt(np.diag(self.covariance))
        scale[scale == 0.0] = 1.0
        return np.asarray(self.covariance / np.outer(scale, scale))


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Values with errors and covariance, sizes, weak directions, and parameters held by priors."""

    estimates: Array
    sigmas: Array
    covariance: Array
    sizes: Array
    weak: tuple[WeakDirection, ...]
    held: tuple[HeldByPriors, ...]


def uncertainty(
    problem: Problem, variables: Array, jacobian: Array, bound: NDArray[np.bool_]
) -> Uncertainty:
    """Errors from the derivatives of all residuals; parameters at a bound are regarded as fixed."""
    model, free = problem.model, ~bound
    values = model.values(variables)
    estimates = np.array([values[name] for name in model.names])
    # No simulation is needed.
    change = differences(lambda u: np.array([*model.values(u).values()]), variables)
    covariance = _covariance(jacobian, change, free)
    sigmas = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    sigmas[bound] = np.inf
    sizes = _sizes(model, estimates)
    physical = jacobian[: len(problem.data)] @ np.linalg.inv(change)
    priors = {
        str(each): each.prior[1] / size
        for each, size in zip(model.parameters, sizes, strict=True)
        if each.prior is not None
    }
    names = [str(each) for each in model.names]
    factors = [each.kind.factor for each in model.parameters]
    weak = weak_directions(
        [name for name, ok in zip(names, free, strict=True) if ok],
        physical[:, free], estimates[free], np.where(factors, estimates, sizes)[free], priors,
    )  # fmt: skip
    free_directions = [each for each in weak if each.exact and not each.fixed_by]
    lost = {name for each in free_directions for name in each.weights}
    sigmas[[name in lost for name in names]] = np.inf
    weak = tuple(
        replace(each, undetermined=tuple(name for name in each.weights if name in lost))
        if each.fixed_by else each for each in weak
    )  # fmt: skip
    held = held_by_priors(names, jacobian[:, free], [*priors], change[:, free])
    # The variance of a parameter without an error means nothing.
    known = {name for name, sigma in zip(names, sigmas, strict=True) if np.isfinite(sigma)}
    held = tuple(each for each in held if each.name in known)
    return Uncertainty(estimates, sigmas, covariance, sizes, weak, held)


def large_error_notes(model: Model, found: Uncertainty) -> list[str]:
    """Notes on parameters whose error exceeds their size, unless a weak direction has them."""
    named = {name for each in found.weak for name in each.weights}
    triples = zip(map(str, model.names), found.sigmas, found.sizes, strict=True)
    return [
        f"the data hardly fix {name}, whose error exceeds its size: fix it, or give it a prior"
        for name, sigma, size in triples
        if np.isfinite(sigma) and sigma > LARGE_ERROR * size and name not in named
    ]


def _covariance(jacobian: Array, change: Array, free: Array) -> Array:
    """Covariance of the values; parameters at a bound are regarded as fixed."""
    inner = jacobian[:, free]
    scale = np.linalg.norm(inner, axis=0)
    scale[scale == 0.0] = 1.0
    _, singular, rows = np.linalg.svd(inner / scale, full_matrices=False)
    # If no parameter affects the data, all singular values vanish.
    least = 1e-12 * (singular[0] or 1.0)
    inverse = (rows.T / np.maximum(singular, least) ** 2) @ rows
    inverse /= np.outer(scale, scale)
    whole = np.zeros((len(free), len(free)))
    whole[np.ix_(free, free)] = inverse
    return np.asarray(change @ whole @ change.T)


def _sizes(model: Model, estimates: Array) -> Array:
    """Sizes to which changes of the parameters are relative."""
    found = []
    for each, value in zip(model.parameters, estimates, strict=True):
        typical = each.kind.typical
        if each.of_chain and each.kind.scale != "1" and "^" not in each.kind.scale:
            typical *= units_of(model.chains[each.shot or 0]).scales.unit(each.kind.scale)
            found.append(max(abs(value), typical))
        elif each.name.key == "offset":
            found.append(max(s.sigma for _, s in model.traces if each.name.item in ("", s.name)))
        elif each.name.key == TIME_OFFSET:
            # Its zero is arbitrary, so that its value may be smaller than any change that matters.
            motion = units_of(model.chains[each.shot or 0])
            found.append(max(abs(value), motion.time if motion.natural else typical))
        else:
            found.append(abs(value) if each.kind.factor else max(abs(value), typical))
    return np.array(found)
